"""Requests to a port's owner, with the peer that sent them, and the owner's replies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.net.costly_work import costly_work
from grabbergui.net.yarp.os.bottle import Bottle, Buffer
from grabbergui.net.yarp.os.carrier import Message
from grabbergui.net.yarp.os.values import Dialect

_LIGHT: Final = 2048
"""Largest request in bytes that is read at once; longer ones are queued."""

Reply = Bottle | Buffer | Sequence[Buffer] | str | None
"""A Bottle, its binary form, or text that is sent unchanged; None means no reply."""


@dataclass(frozen=True)
class ConnectionInfo:
    """Identity of the other end."""

    peer: str
    "The name it gave: a port's, or free text such as `admin` and `anon_rpc`."
    carrier: str
    address: tuple[str, int]

    @property
    def title(self) -> str:
        """For messages: the name, or the address where none is known."""
        return self.peer or self.place

    @property
    def place(self) -> str:
        """`HOST:PORT`."""
        return f"{self.address[0]}:{self.address[1]}"


class Request:
    """A message for a port's owner. Used by the thread of its connection only."""

    __slots__ = ("_bottle", "info", "message")

    def __init__(self, message: Message, info: ConnectionInfo) -> None:
        self.message = message
        self.info = info
        "The sender."
        self._bottle: Bottle | None = None

    @property
    def wants_reply(self) -> bool:
        """Whether the peer waits for an answer."""
        return self.message.code == "d"

    @property
    def data(self) -> memoryview:
        """The binary form, as received or made from text. Raises RemoteProtocolError."""
        return memoryview(self.bottle().encode()) if self.message.text else self.message.body

    @property
    def dialect(self) -> Dialect:
        """The dialect of a reply: 3.x unless the message shows 4.0. Never raises."""
        try:
            return self.bottle().dialect or Dialect.YARP3
        except RemoteProtocolError:
            return Dialect.YARP3

    def bottle(self) -> Bottle:
        """Return the message as a Bottle, which is decoded once. Raises RemoteProtocolError."""
        if self._bottle is None:
            message = self.message
            if len(message.body) + len(message.text) <= _LIGHT:
                self._bottle = _read(message)
            else:
                with costly_work.turn(self.info.address[0]):
                    self._bottle = _read(message)
        return self._bottle


def _read(message: Message) -> Bottle:
    return Bottle.decode(message.body) if len(message.body) else Bottle.from_text(message.text)


def encode_reply(reply: Reply) -> list[Buffer]:
    """Return a reply's binary form in pieces."""
    if reply is None:
        return []
    if isinstance(reply, Bottle):
        return reply.encode_parts()
    if isinstance(reply, str):
        return [reply.encode("utf-8", "surrogateescape")]
    if isinstance(reply, (bytes, bytearray, memoryview)):
        return [reply]
    return list(reply)


def reply_text(reply: Reply) -> str:
    """Return a reply's text for carriers in text mode."""
    if isinstance(reply, Bottle):
        return reply.to_text()
    if isinstance(reply, str):
        return reply.removesuffix("\r\n")
    return Bottle.decode(b"".join(encode_reply(reply))).to_text()
