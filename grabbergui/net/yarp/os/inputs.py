"""Connections that others opened to a port: one thread each, from the header to the last byte.

Messages reach the owner of the port as a `Request` with the identity of the peer.
"""

from __future__ import annotations

import logging
import socket
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Final, Protocol

from grabbergui.core.costly_work import costly_work
from grabbergui.core.errors import (
    AckTimeoutError,
    GrabberError,
    ProtocolError,
    RemoteProtocolError,
    ResourceExhaustedError,
    TransportError,
)
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os import sockets
from grabbergui.net.yarp.os.admin import PortCommands
from grabbergui.net.yarp.os.bottle import Bottle, Buffer
from grabbergui.net.yarp.os.carrier import Carrier
from grabbergui.net.yarp.os.connection import YarpConnection
from grabbergui.net.yarp.os.datagram_sockets import (
    datagram_receiver,
    multicast_receiver,
    receive_datagrams,
)
from grabbergui.net.yarp.os.datagrams import Reassembler
from grabbergui.net.yarp.os.events import Acknowledgement, Event, Header, HeaderReply, Message
from grabbergui.net.yarp.os.events import Reply as ReplyEvent
from grabbergui.net.yarp.os.link import Link
from grabbergui.net.yarp.os.local_sockets import LocalReceiver, local_receiver
from grabbergui.net.yarp.os.outputs import Output
from grabbergui.net.yarp.os.values import Dialect
from grabbergui.net.yarp.os.web_page import PAGE_NOT_FOUND, page_wanted

log = logging.getLogger(__name__)

STALL_SECONDS = 10.0
"""Longest pause in seconds within a message, or before the header is complete."""

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
    "With its modifiers."
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


class Owner(Protocol):
    """The port as its inputs see it."""

    name: str
    limit: int
    "Size of the longest message accepted, in bytes."
    key: bytes | None
    commands: PortCommands
    plug_ins: frozenset[str]
    "Plug-ins whose work it does for senders that ask for it."

    @property
    def port_number(self) -> int:
        """The TCP port it listens at."""

    def register(self, connection: Input) -> None:
        """Accept a connection whose sender is known. Raises GrabberError to refuse it."""

    def unregister(self, connection: Input) -> None:
        """Forget a connection that has ended."""

    def warn(self, text: str) -> None:
        """Log a peer's fault, at a limited rate."""

    def allocate(self, size: int) -> memoryview:
        """Return memory for a message's body."""

    def deliver(self, request: Request) -> Reply:
        """Pass a message to the port's user and return the reply."""

    def attach(
        self,
        reader: str,
        carrier: Carrier,
        link: Link,
        *,
        replaces: Input | None = None,
        on_made: Callable[[Output], None] | None = None,
    ) -> Output:
        """Send the port's output on this connection, which may take the place of an input that it `replaces`.

        `on_made` gets the output before it is listed and sends. Raises GrabberError.
        """


class Input:
    """One accepted connection."""

    def __init__(self, owner: Owner, sock: socket.socket) -> None:
        self.info = ConnectionInfo("", "", sock.getpeername()[:2])
        "The peer; its name and carrier are known after the header."
        self.received = 0
        "Messages."
        self._owner = owner
        self._sock = sock
        self._carrier = wire.TCP
        self._active = time.monotonic()
        self._images: Output | None = None
        "The output to a reader over mjpeg."
        self._closed = False
        self._thread = threading.Thread(target=self._run, name=f"yarp {owner.name} input", daemon=True)

    def start(self) -> None:
        """Start to read. Raises ResourceExhaustedError if there is no thread left."""
        try:
            self._thread.start()
        except RuntimeError as error:
            sockets.shut_down(self._sock)
            raise ResourceExhaustedError(sockets.NO_MORE_THREADS) from error

    def abort(self) -> None:
        """Shut the connection down. Any thread; may be called twice; does not wait."""
        self._closed = True
        with suppress(OSError):
            self._sock.shutdown(socket.SHUT_RDWR)

    def join(self, deadline: float) -> None:
        """Wait until its thread has ended, but not beyond a time of `time.monotonic`."""
        if self._thread is not threading.current_thread() and self._thread.ident is not None:
            self._thread.join(max(0.0, deadline - time.monotonic()))

    @property
    def peer(self) -> str:
        """The sender's name, empty before the header."""
        return self.info.peer

    @property
    def carrier(self) -> str:
        """The carrier with its modifiers, empty before the header."""
        return self.info.carrier

    @property
    def address(self) -> str:
        """The peer's IP address."""
        return self.info.address[0]

    @property
    def sends(self) -> bool:
        """Whether its peer reads over mjpeg, so that an output serves it."""
        return self._images is not None

    @property
    def messages(self) -> int:
        """Messages received, or sent to a reader over mjpeg."""
        return self._images.messages if self._images else self.received

    @property
    def active(self) -> float:
        """Time of the last message, in seconds of `time.monotonic`."""
        return self._images.active if self._images else self._active

    def _run(self) -> None:
        try:
            self._serve()
        except GrabberError as error:
            # YARP resets the connection to a name server once it has its answer.
            answered = self._carrier is wire.NAME_SER and isinstance(error, TransportError)
            if not self._closed and not answered:
                # A peer that closes without a header only checked that the port exists: `yarp exists` does.
                text = f"connection from {self.info.title} closed: {error}"
                if isinstance(error, ProtocolError):
                    self._owner.warn(text)
                else:
                    level = logging.INFO if self.peer else logging.DEBUG
                    log.log(level, "%s: %s", self._owner.name, text)
        except Exception:
            log.exception("%s: connection from %s failed", self._owner.name, self.info.title)
        finally:
            self._owner.unregister(self)
            sockets.shut_down(self._sock)

    def _serve(self) -> None:
        sockets.prepare(self._sock)
        sockets.set_deadline(self._sock, STALL_SECONDS)
        if self._owner.key:
            sockets.authenticate(self._sock, self._owner.key, accepting=True)
        link = Link(
            self._sock, YarpConnection(opener=False, allocate=self._owner.allocate, limit=self._owner.limit)
        )
        going = True
        while going:
            match event := self._next(link):
                case Header():
                    self._accept(event)
                    going = self._reply_to_header(event, link)
                case Message():
                    going = self._handle(event, link)
                case _:  # nothing but the end can come from a sender
                    going = False

    def _next(self, link: Link) -> Event:
        """Return the next event. The sender may take any time between two messages, but not within one."""
        while True:
            try:
                return link.next_event()
            except AckTimeoutError:
                if not link.connection.idle or self._closed or self._carrier is wire.NAME_SER:
                    raise

    def _accept(self, header: Header) -> None:
        """Note who the sender is, and register the connection. Raises GrabberError."""
        self._carrier = header.carrier
        name, _, modifiers = header.sender.partition(" ")
        if header.carrier is wire.NAME_SER:
            self.info = replace(self.info, peer=header.sender)
            return
        options = Bottle.from_text(modifiers) if modifiers and name.startswith("/") else Bottle()
        pairs = [option for option in options if isinstance(option, list) and len(option) > 1]
        text = "+".join((header.carrier.name, *(f"{pair[0]!s}.{pair[1]!s}" for pair in pairs)))
        peer = name if name.startswith("/") else header.sender
        if header.group:
            # It listens before it is listed, since the sender does not wait for a reply.
            self._sock = multicast_receiver(self._sock, header.group)
        self.info = replace(self.info, peer=peer, carrier=text)
        plug_in = str(options.find("recv") or "")
        if plug_in and plug_in not in self._owner.plug_ins:
            raise RemoteProtocolError(f"plug-in {plug_in} is not supported, connect without +recv.{plug_in}")
        self._owner.register(self)

    def _reply_to_header(self, header: Header, link: Link) -> bool:
        """Send the header reply, serve carriers that switch the protocol; return whether messages follow."""
        if header.carrier is wire.NAME_SER:
            return True
        if header.carrier.datagrams:
            self._serve_datagrams(self._sock if header.group else self._datagram_socket(link))
            return False
        if header.carrier.local:
            self._serve_local()
            return False
        link.send(HeaderReply(self._owner.port_number, header.sender))
        if header.carrier is wire.MJPEG:
            self._serve_images(link)
        elif header.carrier is wire.HTTP:
            page = self._owner.commands.page() if page_wanted(header.request) else PAGE_NOT_FOUND
            sockets.send(self._sock, [page])
        return not header.carrier.pull

    def _handle(self, message: Message, link: Link) -> bool:
        """Handle a message, reply and acknowledge; return whether the connection continues."""
        answer = self._answer(message)
        if message.code == "q" and self._carrier.text:
            return False
        if self._carrier.acknowledged:
            answer.append(Acknowledgement())
        if answer:
            link.send(*answer)
        if message.code == "r":
            self._reverse(link)
        return message.code not in ("q", "r")

    def _answer(self, message: Message) -> list[Event]:
        """Execute a message and return its reply, in a list that is empty without one."""
        if message.code != "r":  # a reversed connection keeps its age until it carries a message
            self.received += 1
            self._active = time.monotonic()
        if self._carrier is wire.NAME_SER:
            return [
                ReplyEvent(text=self._owner.commands.answer_name_query(message.text, self.info.address[0]))
            ]
        match message.code:
            case "d" | "D":
                return self._encode(self._ask(message))
            case "a":
                return self._encode(self._owner.commands.administer(Request(message, self.info).bottle()))
            case "r" | "q":
                return []
        lines = self._owner.commands.line(message.command)
        return [ReplyEvent(text="\r\n".join(lines))] if self._carrier.text else []

    def _ask(self, message: Message) -> Reply:
        request = Request(message, self.info)
        reply = self._owner.deliver(request)
        if not request.wants_reply:
            return None
        if isinstance(reply, Bottle) and not self._carrier.text:
            return reply.encode_parts(request.dialect)
        return reply

    def _encode(self, reply: Reply) -> list[Event]:
        if reply is None:
            return []
        if self._carrier.text:
            return [ReplyEvent(text=reply_text(reply))]
        return [ReplyEvent(parts=encode_reply(reply))]

    def _reverse(self, link: Link) -> None:
        """Pass the connection to an output, whose thread reads the acknowledgements from now on."""
        sockets.set_deadline(self._sock, None)
        # Close our own socket first: this thread would shut the connection down for both at its end.
        passed_on = Link(self._sock.dup(), link.connection)
        self._sock.close()
        self._owner.attach(self.peer, self._carrier, passed_on, replaces=self)

    def _datagram_socket(self, link: Link) -> socket.socket:
        """Leave the TCP connection for a socket that receives the datagrams. Raises GrabberError."""
        sock = datagram_receiver(self._sock)
        try:
            link.send(HeaderReply(sock.getsockname()[1]))
        except GrabberError:
            sock.close()
            raise
        self._sock.close()
        return sock

    def _serve_datagrams(self, sock: socket.socket) -> None:
        # A port of this machine may send to a group from another of its addresses.
        own = sockets.local_addresses() if self._carrier.multicast else []
        senders = own if self.address in own else [self.address]
        with sock:
            messages = Reassembler(self._owner.allocate, self._owner.limit)
            for datagram in receive_datagrams(sock, senders, lambda: self._closed):
                message = messages.datagram(datagram)
                if message is not None:
                    self._answer(message)
                    if message.code in ("q", "r"):
                        return

    def _serve_local(self) -> None:
        self._sock = local_receiver(self._sock)
        if self._closed:
            return
        messages = LocalReceiver(self._owner.allocate, self._owner.limit)
        while (message := messages.next_message(self._sock)) is not None:
            for reply in self._answer(message):
                if isinstance(reply, ReplyEvent):
                    sockets.send(self._sock, list(reply.parts))
            if message.code in ("q", "r"):
                return

    def _serve_images(self, link: Link) -> None:
        def count_by(output: Output) -> None:
            self._images = output

        sockets.set_deadline(self._sock, None)
        # Once the output is listed, newcomers may displace the idlest connection, which this is until then.
        images = self._owner.attach(
            self.info.place, wire.MJPEG, Link(self._sock.dup(), link.connection), on_made=count_by
        )
        try:
            while self._sock.recv(4096):
                pass
        except OSError:
            pass
        finally:
            images.close()
