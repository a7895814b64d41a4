"""How bytes travel between two ports: greetings, message framing, commands, acknowledgements; no I/O.

A connection begins with eight bytes that name its carrier, the sender's name and the receiver's answer.
Messages follow: an index of block lengths, a port command, the body. All integers are little endian.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Final

from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError
from grabbergui.net.yarp.os.bottle import Buffer

MAGIC_BASE: Final = 7777
INDEX_MAGIC: Final = 10
NAME_LIMIT: Final = 1000
"""Bytes of a sender's name, its NUL included."""

MESSAGE_LIMIT: Final = 1 << 28
"""Bytes of one message that we receive: a 64-megapixel RGB picture fits."""

_MAGIC = struct.Struct("<2si2s")
_I32 = struct.Struct("<i")
_COMMAND = struct.Struct("<icccc")
_INDEX_HEAD: Final = 18

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
    if first[:4] == b"GET " or first == b"UNIX_STR":
        name = "http" if first[:3] == b"GET" else "unix_stream"
        raise RemoteProtocolError(f"carrier {name} is not supported, use one of {', '.join(CARRIERS)}")
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
    if len(lengths) > 255:
        body = [b"".join(body)]
        lengths = [len(head), len(body[0])]
    index = encode_number(INDEX_MAGIC) + bytes((len(lengths), 1)) + b"\xff" * 8
    return [index + struct.pack(f"<{len(lengths) + 1}i", *lengths, 0) + head, *body]


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


class _Phase(Enum):
    NAME_LENGTH = auto()
    NAME = auto()
    INDEX = auto()
    LENGTHS = auto()
    COMMAND = auto()
    COMMAND_TEXT = auto()
    BODY = auto()


def _fresh(size: int) -> memoryview:
    return memoryview(bytearray(size))


class Receiver:
    """The receiving end of a binary connection, after the greeting's first eight bytes.

    The caller fills `wanted` (never more), calls `received`, and gets a message or None. Bodies are read
    straight into the memory that `allocate` gives. `name` is set once the sender has told it.
    """

    def __init__(
        self,
        *,
        named: bool = True,
        allocate: Callable[[int], memoryview] = _fresh,
        limit: int = MESSAGE_LIMIT,
    ) -> None:
        self.name = ""
        "The sender's, modifiers included: `/grabber (recv bayer)`."
        self._allocate = allocate
        self._limit = limit
        self._filled = 0
        self._body_size = 0
        self._command = ""
        self._phase = _Phase.INDEX
        self._buffer = memoryview(b"")
        if named:
            self._expect(_Phase.NAME_LENGTH, 4)
        else:
            self._expect(_Phase.INDEX, _INDEX_HEAD)

    @property
    def wanted(self) -> memoryview:
        """Where the next bytes go; as long as may be read."""
        return self._buffer[self._filled :]

    @property
    def idle(self) -> bool:
        """Whether the stream stands between two messages."""
        return self._phase is _Phase.INDEX and not self._filled

    @property
    def greeted(self) -> bool:
        """Whether the sender's name has come."""
        return self._phase not in (_Phase.NAME_LENGTH, _Phase.NAME)

    def received(self, count: int) -> Message | None:
        """Note `count` bytes more in `wanted`. Raises RemoteProtocolError; nothing can follow it."""
        self._filled += count
        if self._filled < len(self._buffer):
            return None
        return self._complete()

    def _expect(self, phase: _Phase, size: int, buffer: memoryview | None = None) -> None:
        self._phase = phase
        self._buffer = memoryview(bytearray(size)) if buffer is None else buffer
        self._filled = 0

    def _complete(self) -> Message | None:
        data = self._buffer
        if self._phase is _Phase.NAME_LENGTH:
            length = _I32.unpack(data)[0]
            if not 1 <= length <= NAME_LIMIT:
                raise RemoteProtocolError(f"sender's name of {length} bytes, allowed are 1 to {NAME_LIMIT}")
            self._expect(_Phase.NAME, length)
        elif self._phase is _Phase.NAME:
            self.name = str(data, "utf-8", "surrogateescape").rstrip("\0")
            self._expect(_Phase.INDEX, _INDEX_HEAD)
        elif self._phase is _Phase.INDEX:
            self._begin_lengths(data)
        elif self._phase is _Phase.LENGTHS:
            self._begin_command(data)
        elif self._phase is _Phase.COMMAND:
            return self._end_command(data)
        elif self._phase is _Phase.COMMAND_TEXT:
            self._command = str(data, "utf-8", "surrogateescape").rstrip("\0")
            return self._begin_body()
        else:
            return self._message(data)
        return None

    def _begin_lengths(self, data: memoryview) -> None:
        if decode_number(data) != INDEX_MAGIC:
            raise RemoteProtocolError(
                f"message index {bytes(data[:8])!r}, must begin with number {INDEX_MAGIC}"
            )
        blocks = data[8]
        if not blocks:
            raise RemoteProtocolError("message of no blocks")
        self._expect(_Phase.LENGTHS, 4 * blocks + 4)

    def _begin_command(self, data: memoryview) -> None:
        lengths = struct.unpack(f"<{len(data) // 4 - 1}i", data[:-4])
        total = sum(lengths)
        if min(lengths) < 0 or not _COMMAND.size <= total <= self._limit:
            raise RemoteProtocolError(f"message of {total} bytes, allowed are 8 to {self._limit}")
        self._body_size = total - _COMMAND.size
        self._expect(_Phase.COMMAND, _COMMAND.size)

    def _end_command(self, data: memoryview) -> Message | None:
        length, tilde, letter, zero, one = _COMMAND.unpack(data)
        if (tilde, zero, one) != (b"~", b"\0", b"\1"):
            raise RemoteProtocolError(f"port command {bytes(data)!r}, must be ....~.01")
        if letter != b"\0":
            self._command = letter.decode("latin-1")
            return self._begin_body()
        if not 1 <= length <= min(self._body_size, NAME_LIMIT * 4):
            raise RemoteProtocolError(f"port command of {length} bytes, in a message of {self._body_size}")
        self._body_size -= length
        self._expect(_Phase.COMMAND_TEXT, length)
        return None

    def _begin_body(self) -> Message | None:
        if not self._body_size:
            return self._message(memoryview(b""))
        self._expect(_Phase.BODY, 0, self._allocate(self._body_size))
        return None

    def _message(self, body: memoryview) -> Message:
        self._expect(_Phase.INDEX, _INDEX_HEAD)
        return Message(self._command, body)
