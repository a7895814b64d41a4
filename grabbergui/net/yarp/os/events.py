"""The events of a connection: what either side sends and receives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from grabbergui.net.yarp.os.bottle import Bottle, Buffer
from grabbergui.net.yarp.os.carrier import Carrier

# The two events that stream are not frozen: that would double the time it takes to make one.
_EMPTY: Final = memoryview(b"")


@dataclass(frozen=True)
class Header:
    """The opener's first event: how it speaks and who it is."""

    carrier: Carrier
    sender: str
    "A port's name with modifiers, or free text such as `admin`; over mjpeg the host that is asked."
    request: str = ""
    "The request line, over HTTP."
    group: tuple[str, int] | None = None
    "Address and port of the multicast group, over mcast."


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
class Acknowledgement:
    """Acknowledges a message on tcp and text_ack, after the reply."""


@dataclass(frozen=True)
class Closed:
    """The peer has closed the connection between two events."""


Event = Header | HeaderReply | Message | Reply | Acknowledgement | Closed
