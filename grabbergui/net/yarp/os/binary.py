"""Numbers, names, commands and indices in binary form. No I/O."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Final, NamedTuple

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.net.yarp.os.bottle import Buffer

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
_INDEX_MARK: Final = _MAGIC.pack(b"YA", INDEX_MAGIC, b"RP")
_INDEX_FILLER: Final = b"\1" + b"\xff" * 8


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
    "Size of index and command in bytes."
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


def decode_command(data: memoryview) -> Index | None:
    """Return the command at the start of `data`, None while it is incomplete; `body_size` is not known then.

    Messages over unix_stream have no index before it. Raises RemoteProtocolError.
    """
    return _decode_command(data, 0, COMMAND_LIMIT) if len(data) >= _COMMAND.size else None


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
