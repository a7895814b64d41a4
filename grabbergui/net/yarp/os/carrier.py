"""Carriers, targets, the events of a connection, and their binary form. No I/O.

A connection begins with a header, eight bytes that name its carrier and the sender's name, and the receiver's
header reply. Messages follow: an index of block lengths, a port command, the body. All integers are little
endian. `connection` defines which event may follow which.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError, UsageError
from grabbergui.net.yarp.os.bottle import Bottle, Buffer

MAGIC_BASE: Final = 7777
INDEX_MAGIC: Final = 10
NAME_LIMIT: Final = 1000
"""Size of a sender's name in bytes, its NUL included."""

MESSAGE_LIMIT: Final = 1 << 28
"""Size of a message that we receive, in bytes: a 64-megapixel RGB image fits."""

COMMAND_LIMIT: Final = 4000
"""Size of a textual port command in bytes, its NUL included."""

_MAGIC = struct.Struct("<2si2s")
_I32 = struct.Struct("<i")
_COMMAND = struct.Struct("<icccc")
_INDEX_START: Final = 18
_MANY_BLOCKS: Final = 255

INDEX_LIMIT: Final = _INDEX_START + _I32.size * (_MANY_BLOCKS + 1) + _COMMAND.size + COMMAND_LIMIT
"""Size of index and command in bytes."""

ACK: Final = _MAGIC.pack(b"YA", 0, b"RP")
"""Acknowledges one message on tcp."""


# -- carriers ------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Carrier:
    """One way to move messages."""

    name: str
    code: int | None = None
    "Added to 7777 in the header; None for carriers whose header is text."
    acknowledged: bool = False
    datagrams: bool = False
    text: bool = False
    pull: bool = False
    "The reader connects to the source."

    @property
    def switches(self) -> bool:
        """Whether another protocol follows the header reply: datagrams, HTTP."""
        return self.datagrams or self.pull


TCP = Carrier("tcp", 3 + 128, acknowledged=True)
FAST_TCP = Carrier("fast_tcp", 3)
UDP = Carrier("udp", 0, datagrams=True)
TEXT = Carrier("text", text=True)
TEXT_ACK = Carrier("text_ack", text=True, acknowledged=True)
MJPEG = Carrier("mjpeg", pull=True)

CARRIERS: Final = {carrier.name: carrier for carrier in (TCP, FAST_TCP, UDP, TEXT, TEXT_ACK, MJPEG)}
"""Those that we offer, by name."""

HTTP = Carrier("http", pull=True)
"""A browser's request for the port's page. It carries no messages, so it is not offered."""

STREAM_PATH: Final = "/?action=stream"
"""Path of a port's mjpeg stream."""

STREAM_REQUEST: Final = b"GET /?action=stream\n\n HTTP/1.1\nHost: %s\r\n\n"
"""As YARP's readers of mjpeg send it, odd line ends included; `%s` is the source's address."""

BOUNDARY: Final = b"--boundarydonotcross\r\n"
"""Between two JPEG images over mjpeg."""

STREAM_RESPONSE: Final = (
    b"HTTP/1.0 200 OK\r\nConnection: close\r\nServer: yarp/mjpeg_carrier/0.1\r\n"
    b"Cache-Control: no-store, no-cache, must-revalidate, pre-check=0, post-check=0, max-age=0\r\n"
    b"Pragma: no-cache\r\nExpires: Mon, 3 Jan 2000 12:34:56 GMT\r\n"
    b"Content-Type: multipart/x-mixed-replace;boundary=boundarydonotcross\r\n\r\n" + BOUNDARY
)
"""As YARP's sources of mjpeg answer."""

REQUEST_LINES: Final = 100
REQUEST_LINE_LIMIT: Final = 8192
"""Largest request of a browser: its lines, and the bytes of each."""

NAME_SER = Carrier("name_ser", text=True)
"""A name server's line protocol: neither header nor header reply, one line a request."""

_FOREIGN: Final = {1: "mcast", 14: "shmem"}


def by_name(name: str) -> Carrier:
    """Return the carrier of ``fast_tcp`` or ``udp+recv.bayer``. Raises LocalProtocolError if we lack it."""
    base = name.partition("+")[0]
    if base not in CARRIERS:
        raise LocalProtocolError(f"carrier {base} is not supported, use one of {', '.join(CARRIERS)}")
    return CARRIERS[base]


def identify(header: Buffer) -> Carrier:
    """Return the carrier that the first eight bytes of a connection name. Raises RemoteProtocolError."""
    first = bytes(header[:8])
    texts = {b"CONNECT ": TEXT, b"CONNACK ": TEXT_ACK, b"GET /?ac": MJPEG, b"NAME_SER": NAME_SER}
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


def modifiers_of(carrier: str) -> dict[str, str]:
    """Return the modifiers of a carrier: {"recv": "bayer"} of `tcp+recv.bayer`."""
    return {key: value for key, _, value in (part.partition(".") for part in carrier.split("+")[1:])}


# -- targets -------------------------------------------------------------------------------------
PORT_NAME_LIMIT: Final = 900
"""Characters of a port's name: with modifiers it still fits into a header."""

_PORT_NAME: Final = re.compile(r"/[^\s/]\S*")
_ADDRESS: Final = re.compile(r"/?(?:([\w+.]+):)?//?([\w.\-]+|\[[0-9a-fA-F:]+\]):(\d{1,5})/?", re.ASCII)


@dataclass(frozen=True)
class Target:
    """The target of a connection: `/reader`, `udp://reader`, `fast_tcp+recv.bayer://reader`."""

    name: str
    "The port's name, or `//HOST:PORT` for one reached without a name server."
    carrier: str = "tcp"
    "With its modifiers."

    @classmethod
    def parse(cls, text: str, carrier: str = "") -> Target:
        """Parse YARP's spellings; an explicit `carrier` takes precedence. Raises LocalProtocolError."""
        literal = literal_address(text)
        if literal:
            used, host, port = literal
            return cls(f"//{host}:{port}", carrier or used)
        prefix, found, rest = text.removeprefix("/").partition(":/")
        if found and "/" not in prefix:
            # The second of the two slashes begins the name; some users type three.
            return cls("/" + rest.lstrip("/"), carrier or prefix)
        if not _PORT_NAME.fullmatch(text):
            raise LocalProtocolError(f"'{text}' names no port; names begin with / and have no blanks")
        return cls(text, carrier or "tcp")

    @property
    def modifiers(self) -> dict[str, str]:
        """Those of the carrier."""
        return modifiers_of(self.carrier)

    def sender(self, name: str) -> str:
        """Return the sender's name with the modifiers, as the receiver wants to see them."""
        return " ".join((name, *(f"({key} {value or '1'})" for key, value in self.modifiers.items())))


def literal_address(text: str) -> tuple[str, str, int] | None:
    """Return carrier, host and port in `tcp://10.0.0.2:10003/`, which needs no name server; else None."""
    match = _ADDRESS.fullmatch(text)
    if not match or not 0 < int(match[3]) < 65536:
        return None
    return match[1] or "tcp", match[2].strip("[]"), int(match[3])


def check_port_name(name: str) -> str:
    """Return the name, if a port may have it. Raises UsageError."""
    if not _PORT_NAME.fullmatch(name) or len(name) > PORT_NAME_LIMIT or '"' in name:
        raise UsageError(f"'{name}' cannot name a port; names begin with / and have no blanks")
    return name


# -- binary form ---------------------------------------------------------------------------------
def encode_number(number: int) -> bytes:
    """Return the eight bytes that hold a number: in headers, header replies and acknowledgements."""
    return _MAGIC.pack(b"YA", number, b"RP")


def decode_number(data: Buffer) -> int:
    """Return the number in eight such bytes. Raises RemoteProtocolError."""
    if len(data) < _MAGIC.size:
        raise RemoteProtocolError(f"{len(data)} bytes where YA....RP was expected")
    start, number, end = _MAGIC.unpack_from(data)
    if (start, end) != (b"YA", b"RP"):
        raise RemoteProtocolError(f"{bytes(data[:8])!r} where YA....RP was expected")
    return int(number)


def encode_header(carrier: Carrier, sender: str) -> bytes:
    """Return the first bytes from the side that opens a connection. Raises LocalProtocolError."""
    if carrier.code is None:
        word = "CONNACK" if carrier.acknowledged else "CONNECT"
        return f"{word} {sender}\r\n".encode("utf-8", "surrogateescape")
    name = sender.encode("utf-8", "surrogateescape") + b"\0"
    if len(name) > NAME_LIMIT:
        raise LocalProtocolError(f"port name of {len(name)} bytes, at most {NAME_LIMIT}")
    return encode_number(MAGIC_BASE + carrier.code) + _I32.pack(len(name)) + name


def decode_name_size(data: Buffer) -> int:
    """Return the size of the sender's name from the four bytes before it. Raises RemoteProtocolError."""
    (size,) = _I32.unpack(data)
    if not 1 <= size <= NAME_LIMIT:
        raise RemoteProtocolError(f"sender's name of {size} bytes, allowed: 1 to {NAME_LIMIT}")
    return int(size)


def decode_name(data: Buffer) -> str:
    """Return the sender's name, modifiers included: `/grabber (recv bayer)`."""
    return str(data, "utf-8", "surrogateescape").rstrip("\0")


def encode_command(command: str) -> bytes:
    """Encode a port command: one letter, or text as in ``D 3 1795228516.98942``."""
    if len(command) == 1 and command != "q":
        return _COMMAND.pack(0, b"~", command.encode(), b"\0", b"\1")
    text = command.encode("utf-8", "surrogateescape") + b"\0"
    return _COMMAND.pack(len(text), b"~", b"\0", b"\0", b"\1") + text


_INDEX_MARK: Final = encode_number(INDEX_MAGIC)
_INDEX_FILLER: Final = b"\1" + b"\xff" * 8


def encode_message(command: str, body: Sequence[Buffer] = ()) -> list[Buffer]:
    """Return a message in pieces for a gathering write. The body is not copied."""
    start = encode_command(command)
    if len(body) >= _MANY_BLOCKS:
        body = [b"".join(body)]
    lengths = struct.pack(f"<{len(body) + 2}i", len(start), *map(len, body), 0)
    return [_INDEX_MARK + bytes((len(body) + 1,)) + _INDEX_FILLER + lengths + start, *body]


class Index(NamedTuple):
    """A message's index and port command, which precede its body."""

    command: str
    size: int
    "Of index and command, in bytes."
    body_size: int


def decode_index(data: memoryview, limit: int = MESSAGE_LIMIT) -> Index | None:
    """Return the index and command at the start of `data`, None while they are incomplete.

    Raises RemoteProtocolError as soon as they are invalid or announce a message longer than `limit`.
    """
    if len(data) < _INDEX_START:
        return None
    if data[:8] != _INDEX_MARK:
        decode_number(data)
        raise RemoteProtocolError(f"message index {bytes(data[:8])!r}, must begin with number {INDEX_MAGIC}")
    blocks = data[8]
    if not blocks:
        raise RemoteProtocolError("message of no blocks")
    # The blocks' lengths are followed by that of a reply, which is always 0.
    start = _INDEX_START + _I32.size * (blocks + 1)
    if len(data) < start:
        return None
    lengths = struct.unpack_from(f"<{blocks}i", data, _INDEX_START)
    size = sum(lengths)
    if min(lengths) < 0 or not _COMMAND.size <= size <= limit:
        raise RemoteProtocolError(f"message of {size} bytes, allowed: {_COMMAND.size} to {limit}")
    if len(data) < start + _COMMAND.size:
        return None
    return _decode_command(data, start, size - _COMMAND.size)


def _decode_command(data: memoryview, start: int, rest: int) -> Index | None:
    """Decode a port command, which `rest` bytes of text and body follow."""
    length, tilde, letter, zero, one = _COMMAND.unpack_from(data, start)
    if (tilde, zero, one) != (b"~", b"\0", b"\1"):
        found = bytes(data[start : start + _COMMAND.size])
        raise RemoteProtocolError(f"port command {found!r}, must be ....~.01")
    start += _COMMAND.size
    if letter != b"\0":
        return Index(letter.decode("latin-1"), start, rest)
    if not 1 <= length <= min(rest, COMMAND_LIMIT):
        raise RemoteProtocolError(f"port command of {length} bytes, in a message of {rest}")
    if len(data) < start + length:
        return None
    command = str(data[start : start + length], "utf-8", "surrogateescape").rstrip("\0")
    return Index(command, start + length, rest - length)


# -- events --------------------------------------------------------------------------------------
# Of the events, the two that stream are not frozen: that would double the time it takes to make one.
_EMPTY: Final = memoryview(b"")


@dataclass(frozen=True)
class Header:
    """The opener's first event: how it speaks and who it is."""

    carrier: Carrier
    sender: str
    "A port's name with modifiers, or free text such as `admin`; over mjpeg the host that is asked."
    request: str = ""
    "The request line, over HTTP."


@dataclass(frozen=True)
class HeaderReply:
    """The acceptor's answer to a header."""

    number: int = 0
    "The acceptor's TCP port, which is ignored; over udp the UDP port that takes the messages."
    sender: str = ""
    "Repeated in text mode, as `Welcome SENDER`."


@dataclass(slots=True)
class Message:
    """A message to a port: a command, and for most of them a Bottle or an image."""

    command: str
    "The code or text of the port command: `d`, `D 3 1795228516.98942`, `/reader`."
    body: memoryview = _EMPTY
    "The Bottle or image of a received message in binary form; empty in text mode."
    text: str = ""
    "The Bottle's line in text mode."
    parts: Sequence[Buffer] = ()
    "The body of a message to send, in pieces that are not copied."

    @property
    def code(self) -> str:
        """The command code, which is the command's first character."""
        return self.command[:1]

    @property
    def envelope(self) -> str:
        """The envelope of a data message, empty without one."""
        return self.command.partition(" ")[2] if self.code in "dD" else ""


@dataclass(slots=True)
class Reply:
    """The answer to a message. It has no length of its own: a Bottle shows where it ends."""

    body: memoryview = _EMPTY
    "A received reply in binary form; empty in text mode."
    text: str = ""
    "Lines of a reply in text mode, without the last line end."
    parts: Sequence[Buffer] = ()
    "A reply to send in binary form, in pieces that are not copied."
    bottle: Bottle | None = None
    "A short received reply, which was decoded to find its end."


@dataclass(frozen=True)
class Ack:
    """Acknowledges a message on tcp and text_ack, after the reply."""


@dataclass(frozen=True)
class Closed:
    """The peer has closed the connection between two events."""


Event = Header | HeaderReply | Message | Reply | Ack | Closed
