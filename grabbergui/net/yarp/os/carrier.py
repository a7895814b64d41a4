"""How bytes travel between two ports: greetings, message framing, commands, acknowledgements; no I/O.

A connection begins with eight bytes that name its carrier, the sender's name and the receiver's answer.
Messages follow: an index of block lengths, a port command, the body. All integers are little endian.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError
from grabbergui.net.yarp.os.bottle import Buffer

MAGIC_BASE: Final = 7777
INDEX_MAGIC: Final = 10
NAME_LIMIT: Final = 1000
"""Bytes of a sender's name, its NUL included."""

MESSAGE_LIMIT: Final = 1 << 28
"""Bytes of one message that we receive: a 64-megapixel RGB picture fits."""

COMMAND_LIMIT: Final = 4000
"""Bytes of a command in words, its NUL included."""

_MAGIC = struct.Struct("<2si2s")
_I32 = struct.Struct("<i")
_COMMAND = struct.Struct("<icccc")
_INDEX_HEAD: Final = 18
_MANY_BLOCKS: Final = 255

HEAD_LIMIT: Final = _INDEX_HEAD + _I32.size * (_MANY_BLOCKS + 1) + _COMMAND.size + COMMAND_LIMIT
"""Bytes before the body of a message."""

ACK: Final = _MAGIC.pack(b"YA", 0, b"RP")
"""Acknowledges one message on tcp."""

QUIT: Final = b"q\0"


@dataclass(frozen=True)
class Carrier:
    """One way to move messages."""

    name: str
    code: int | None = None
    "Added to 7777 in the greeting; None for carriers that greet with text."
    acknowledged: bool = False
    datagrams: bool = False
    text: bool = False
    pull: bool = False
    "The reader connects to the source."


TCP = Carrier("tcp", 3 + 128, acknowledged=True)
FAST_TCP = Carrier("fast_tcp", 3)
UDP = Carrier("udp", 0, datagrams=True)
TEXT = Carrier("text", text=True)
TEXT_ACK = Carrier("text_ack", text=True, acknowledged=True)
MJPEG = Carrier("mjpeg", pull=True)

CARRIERS: Final = {carrier.name: carrier for carrier in (TCP, FAST_TCP, UDP, TEXT, TEXT_ACK, MJPEG)}
"""Those we speak."""

HTTP = Carrier("http", text=True)
"""A browser's look at the port: no carrier of messages, so not among those offered."""

_FOREIGN: Final = {1: "mcast", 14: "shmem"}


def by_name(name: str) -> Carrier:
    """The carrier of ``fast_tcp`` or ``udp+recv.bayer``. Raises LocalProtocolError for one we lack."""
    base = name.partition("+")[0]
    if base not in CARRIERS:
        raise LocalProtocolError(f"carrier {base} is not supported, use one of {', '.join(CARRIERS)}")
    return CARRIERS[base]


def identify(greeting: Buffer) -> Carrier:
    """The carrier that a connection's first eight bytes announce. Raises RemoteProtocolError."""
    first = bytes(greeting[:8])
    texts = {b"CONNECT ": TEXT, b"CONNACK ": TEXT_ACK, b"GET /?ac": MJPEG}
    if first in texts:
        return texts[first]
    if first.startswith(b"GET /"):
        return HTTP
    if first == b"UNIX_STR":
        raise RemoteProtocolError(f"carrier unix_stream is not supported, use one of {', '.join(CARRIERS)}")
    number = decode_number(first)
    code = number - MAGIC_BASE
    for carrier in CARRIERS.values():
        if carrier.code == code:
            return carrier
    name = _FOREIGN.get(code & 15, f"with code {code}")
    raise RemoteProtocolError(f"carrier {name} is not supported, use one of {', '.join(CARRIERS)}")


def encode_number(number: int) -> bytes:
    """Eight bytes with a number in them: greetings, their answers, acknowledgements."""
    return _MAGIC.pack(b"YA", number, b"RP")


def decode_number(data: Buffer) -> int:
    """The number in eight such bytes. Raises RemoteProtocolError."""
    if len(data) < _MAGIC.size:
        raise RemoteProtocolError(f"{len(data)} bytes where YA....RP was expected")
    start, number, end = _MAGIC.unpack_from(data)
    if (start, end) != (b"YA", b"RP"):
        raise RemoteProtocolError(f"{bytes(data[:8])!r} where YA....RP was expected")
    return int(number)


def encode_greeting(carrier: Carrier, sender: str) -> bytes:
    """What the side that opens a connection says first."""
    if carrier.code is None:
        word = "CONNACK" if carrier.acknowledged else "CONNECT"
        return f"{word} {sender}\r\n".encode("utf-8", "surrogateescape")
    name = sender.encode("utf-8", "surrogateescape") + b"\0"
    if len(name) > NAME_LIMIT:
        raise LocalProtocolError(f"port name of {len(name)} bytes, allowed are {NAME_LIMIT}")
    return encode_number(MAGIC_BASE + carrier.code) + _I32.pack(len(name)) + name


def decode_name_size(data: Buffer) -> int:
    """Bytes of the sender's name, from the four after the greeting's number. Raises RemoteProtocolError."""
    (size,) = _I32.unpack(data)
    if not 1 <= size <= NAME_LIMIT:
        raise RemoteProtocolError(f"sender's name of {size} bytes, allowed are 1 to {NAME_LIMIT}")
    return int(size)


def decode_name(data: Buffer) -> str:
    """The sender's name that follows, modifiers included: `/grabber (recv bayer)`."""
    return str(data, "utf-8", "surrogateescape").rstrip("\0")


def encode_command(command: str) -> bytes:
    """A port command: one letter, or text as in ``D 3 1795228516.98942``."""
    if len(command) == 1 and command != "q":
        return _COMMAND.pack(0, b"~", command.encode(), b"\0", b"\1")
    text = command.encode("utf-8", "surrogateescape") + b"\0"
    return _COMMAND.pack(len(text), b"~", b"\0", b"\0", b"\1") + text


def encode_message(command: str, body: Sequence[Buffer] = ()) -> list[Buffer]:
    """A message in pieces, ready for a gathering write; the body is not copied."""
    head = encode_command(command)
    lengths = [len(head), *(len(part) for part in body)]
    if len(lengths) > _MANY_BLOCKS:
        body = [b"".join(body)]
        lengths = [len(head), len(body[0])]
    index = encode_number(INDEX_MAGIC) + bytes((len(lengths), 1)) + b"\xff" * 8
    return [index + struct.pack(f"<{len(lengths) + 1}i", *lengths, 0) + head, *body]


class Head(NamedTuple):
    """What stands before a message's body."""

    command: str
    size: int
    "Bytes of the head."
    body_size: int


def decode_head(data: memoryview, limit: int = MESSAGE_LIMIT) -> Head | None:
    """The head that `data` begins with, None while it is not complete.

    Raises RemoteProtocolError as soon as it can be none, or is that of a message longer than `limit`.
    """
    if len(data) < _INDEX_HEAD:
        return None
    if decode_number(data) != INDEX_MAGIC:
        raise RemoteProtocolError(f"message index {bytes(data[:8])!r}, must begin with number {INDEX_MAGIC}")
    blocks = data[8]
    if not blocks:
        raise RemoteProtocolError("message of no blocks")
    # After the blocks' lengths comes the number of those of a reply, always 0.
    start = _INDEX_HEAD + _I32.size * (blocks + 1)
    if len(data) < start:
        return None
    lengths = struct.unpack_from(f"<{blocks}i", data, _INDEX_HEAD)
    size = sum(lengths)
    if min(lengths) < 0 or not _COMMAND.size <= size <= limit:
        raise RemoteProtocolError(f"message of {size} bytes, allowed are {_COMMAND.size} to {limit}")
    if len(data) < start + _COMMAND.size:
        return None
    return _decode_command(data, start, size - _COMMAND.size)


def _decode_command(data: memoryview, start: int, rest: int) -> Head | None:
    """The end of a head: a port command, before `rest` bytes of its text and the body."""
    length, tilde, letter, zero, one = _COMMAND.unpack_from(data, start)
    if (tilde, zero, one) != (b"~", b"\0", b"\1"):
        found = bytes(data[start : start + _COMMAND.size])
        raise RemoteProtocolError(f"port command {found!r}, must be ....~.01")
    start += _COMMAND.size
    if letter != b"\0":
        return Head(letter.decode("latin-1"), start, rest)
    if not 1 <= length <= min(rest, COMMAND_LIMIT):
        raise RemoteProtocolError(f"port command of {length} bytes, in a message of {rest}")
    if len(data) < start + length:
        return None
    command = str(data[start : start + length], "utf-8", "surrogateescape").rstrip("\0")
    return Head(command, start + length, rest - length)


@dataclass
class Message:
    """What arrived on a connection."""

    command: str
    "The letter or text of the port command, `d`, `D 3 1795228516.98942`, `/reader`."
    body: memoryview = field(default_factory=lambda: memoryview(b""))
    "The Bottle or image in binary form; empty in text mode."
    text: str = ""
    "The line in text mode."

    @property
    def letter(self) -> str:
        """What decides: the command's first character."""
        return self.command[:1]

    @property
    def envelope(self) -> str:
        """What a data command carries beside its letter."""
        return self.command.partition(" ")[2] if self.letter in "dD" else ""
