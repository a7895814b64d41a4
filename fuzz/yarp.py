"""YARP: Bottles in both forms and dialects, messages on a connection and in datagrams, images, requests."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fuzz._input import DATA, Input, erring, joined, refusing
from grabbergui.net.yarp import grabber_rpc, image
from grabbergui.net.yarp.mjpeg import JpegStreamReader, decode_jpeg, find_comment
from grabbergui.net.yarp.os import carrier
from grabbergui.net.yarp.os.binary import decode_name, decode_name_size, decode_number, encode_message
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.bottle_text import Nesting
from grabbergui.net.yarp.os.carrier import encode_header
from grabbergui.net.yarp.os.contact import Contact
from grabbergui.net.yarp.os.datagrams import Reassembler, split_datagrams
from grabbergui.net.yarp.os.framing import BottleScanner, Receiver
from grabbergui.net.yarp.os.stamp import Stamp
from grabbergui.net.yarp.os.target import Target
from grabbergui.net.yarp.os.values import Dialect

MOST_MEMORY = 1 << 20
REQUESTS = (
    "[fgc2] [get] [gain]",
    "[fgc2] [set] [expo] 0.5",
    "[get] [w]",
    "getFeature 3",
    "setFeature 3 0.5",
    "help",
)


def seeds() -> list[bytes]:
    """Return messages that our side writes, and captured conversations."""
    bottle = Bottle.from_text('(a 1 2.5) [vo] {1 2 3} "text \\" more" -7 (1 2 3) () 1e300')
    texts = ["[set] [gain] 0.5", "(a (b (c)))", '"\\n"', "0x7f -0 1.", "{1 2"]
    captures = [path.read_bytes()[:4096] for path in sorted((DATA / "yarp").rglob("*")) if path.is_file()]
    message = b"".join(bytes(part) for part in encode_message("d", [bottle.encode()]))
    return [
        *(b"\0" + form for form in (bottle.encode(), bottle.encode(Dialect.YARP4), *captures)),
        *(b"\1" + text.encode() for text in texts),
        b"\2" + message + message,
        b"\3" + image.encode_header("mono", 4, 2, 8) + bytes(16),
        b"\4" + encode_header(carrier.TCP, "/me"),
        *(b"\4" + capture for capture in captures),
        b"\5" + joined([b"".join(map(bytes, part)) for part in split_datagrams([message, bytes(3000)], 512)]),
        b"\6" + _stream_of(b".jpg"),
        b"\6" + _stream_of(b".png"),
        *(b"\7" + Bottle.from_text(text).encode() for text in REQUESTS),
    ]


def _stream_of(kind: bytes) -> bytes:
    """Return what an HTTP camera sends, with images of one and of two bytes per pixel if it has them."""
    images: list[NDArray[Any]] = [
        np.zeros((2, 2), np.uint8),
        np.zeros((2, 2, 3), np.uint8),
        np.zeros((2, 2), np.uint16),
    ]
    parts = []
    for pixels in images[: 3 if kind == b".png" else 2]:
        _, encoded = cv2.imencode(kind.decode(), pixels)
        head = b"--boundary\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(encoded)
        parts.append(head + encoded.tobytes())
    return b"".join(parts)


def one_input(data: bytes) -> None:
    """Feed the part that the first byte chooses."""
    source = Input(data)
    parts = (_binary, _text, _connection, _image, _greeting, _datagrams, _images, _requests)
    parts[source.number(1) % len(parts)](source)


def _binary(source: Input) -> None:
    data = source.rest()
    for dialect in Dialect:
        bottle = refusing(Bottle.decode, data, dialect)
        if bottle is not None:
            again = Bottle.decode(bottle.encode(dialect), dialect)
            if repr(again) != repr(bottle):
                raise AssertionError(f"{bottle!r} became {again!r}")
            bottle.to_text()
        scanner = BottleScanner(dialect, MOST_MEMORY)
        needed = refusing(scanner.scan, data)
        if bottle is not None and needed is not None and needed != len(data):
            raise AssertionError(f"{needed} bytes of {len(data)} in {bottle!r}")


def _text(source: Input) -> None:
    text = source.rest().decode("utf-8", "replace")
    Nesting().feed(text)
    bottle = refusing(Bottle.from_text, text)
    if bottle is not None:
        # Not the same again in every case: a vocab may hold brackets, quotes and zeros.
        refusing(Bottle.from_text, bottle.to_text())
        erring(bottle.encode)


def _connection(source: Input) -> None:
    messages = Receiver(limit=MOST_MEMORY)

    def receive() -> None:
        for message in messages.feed(source.rest()):
            refusing(Bottle.decode, message.body)
        if not messages.wanted:
            raise AssertionError("waits for nothing")

    refusing(receive)


def _image(source: Input) -> None:
    made = refusing(image.decode, source.rest())
    if made is not None:
        header, pixels = made
        pixels.sum()
        if pixels.shape[:2] != (header.height, header.width):
            raise AssertionError(header)


def _greeting(source: Input) -> None:
    data = source.rest()
    refusing(carrier.identify, data[:8])
    if len(data) >= 8:
        refusing(decode_number, data[:8])
    if len(data) >= 12:
        size = refusing(decode_name_size, data[8:12])
        decode_name(data[12 : 12 + (size or 0)])


def _datagrams(source: Input) -> None:
    joiner = Reassembler(lambda size: memoryview(bytearray(size)), MOST_MEMORY)
    for datagram in source.messages():
        message = refusing(joiner.datagram, datagram)
        if message is not None:
            refusing(Bottle.decode, message.body)


def _images(source: Input) -> None:
    reader = JpegStreamReader()
    data = source.rest()
    find_comment(data)
    for start in range(0, len(data), 100):
        for jpeg in refusing(reader.feed, data[start : start + 100]) or ():
            refusing(decode_jpeg, jpeg)


def _requests(source: Input) -> None:
    data = source.rest()
    call = refusing(grabber_rpc.decode_request, data)
    if isinstance(call, grabber_rpc.Call):
        grabber_rpc.encode_request(call)
    text = data.decode("utf-8", "replace")
    Contact.decode(text)
    erring(Target.parse, text)
    Stamp.decode(text)
