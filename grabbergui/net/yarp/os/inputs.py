"""Connections that others opened to a port: one thread each, from the greeting to the last byte."""

from __future__ import annotations

import logging
import socket
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Protocol

from grabbergui.core.errors import (
    AckTimeoutError,
    GrabberError,
    ProtocolError,
    RemoteProtocolError,
    TransportError,
)
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os import mjpeg, sockets, web_page
from grabbergui.net.yarp.os.bottle import Bottle, Buffer
from grabbergui.net.yarp.os.carrier import Carrier, Message
from grabbergui.net.yarp.os.datagrams import Joiner
from grabbergui.net.yarp.os.receiver import Receiver
from grabbergui.net.yarp.os.request import ConnectionInfo, Reply, Request, encode_reply, reply_text
from grabbergui.net.yarp.os.text_lines import LineReader

log = logging.getLogger(__name__)

STALL_SECONDS = 10.0
"""How long a peer may stand still within a message, or before it has said who it is."""

DATAGRAM_POLL = 0.5
NAME_SERVER_GREETING = b"NAME_SER"


class Host(Protocol):
    """The port as its inputs see it."""

    name: str
    limit: int
    "Bytes of the longest message taken."
    key: bytes | None

    @property
    def port_number(self) -> int:
        """The TCP port it listens at."""

    def admit(self, connection: Input) -> None:
        """Take the connection into the books. Raises GrabberError to refuse it."""

    def leave(self, connection: Input) -> None:
        """Strike it off."""

    def allocate(self, size: int) -> memoryview:
        """Memory for a message's body."""

    def deliver(self, request: Request) -> Reply:
        """Hand a message to the owner."""

    def administer(self, request: Bottle) -> Bottle:
        """Answer an administrative Bottle."""

    def line(self, command: str) -> list[str]:
        """Carry out a command of one line."""

    def page(self) -> bytes:
        """What a browser gets."""

    def legacy(self, connection: Input, greeting: bytes) -> None:
        """Serve a question to a name server. Raises RemoteProtocolError where the port is none."""

    def attach(self, reader: str, carrier: Carrier, sock: socket.socket) -> Callable[[], None]:
        """Send the port's output on this socket; gives what ends that. Raises GrabberError."""


class Input:
    """One accepted connection."""

    def __init__(self, host: Host, sock: socket.socket) -> None:
        self.info = ConnectionInfo("", "", sock.getpeername()[:2])
        "Who is at the other end; the name and the carrier are known after the greeting."
        self.received = 0
        "Messages."
        self._host = host
        self._sock = sock
        self._closed = False
        self._thread = threading.Thread(target=self._run, name=f"yarp {host.name} input", daemon=True)

    def start(self) -> None:
        """Begin to listen to it."""
        self._thread.start()

    def close(self) -> None:
        """Hang up. Any thread; may be called twice; does not wait."""
        self._closed = True
        with suppress(OSError):
            self._sock.shutdown(socket.SHUT_RDWR)

    def join(self) -> None:
        """Wait until its thread has ended."""
        if self._thread is not threading.current_thread() and self._thread.ident is not None:
            self._thread.join(5)

    @property
    def peer(self) -> str:
        """The sender's name, empty before the greeting."""
        return self.info.peer

    def answer_lines(self, greeting: bytes, answer: Callable[[str], str]) -> None:
        """Answer line by line until the peer leaves, as a name server does."""
        reader = LineReader()
        reader.feed(greeting)
        with suppress(TransportError):  # YARP resets the connection once it has its answer
            while (line := self._line(reader, idle=False)) is not None:
                sockets.send(self._sock, [answer(line).encode("utf-8", "surrogateescape")])

    def _run(self) -> None:
        try:
            self._serve()
        except GrabberError as error:
            if not self._closed:
                # Whoever leaves without a word only looked whether the port is there: `yarp exists` does.
                usual = logging.INFO if self.peer else logging.DEBUG
                level = logging.WARNING if isinstance(error, ProtocolError) else usual
                log.log(level, "%s: connection from %s closed: %s", self._host.name, self.info.title, error)
        except Exception:
            log.exception("%s: connection from %s failed", self._host.name, self.info.title)
        finally:
            self._host.leave(self)
            sockets.hang_up(self._sock)

    def _serve(self) -> None:
        sockets.prepare(self._sock)
        sockets.set_deadline(self._sock, STALL_SECONDS)
        if self._host.key:
            sockets.authenticate(self._sock, self._host.key, accepting=True)
        greeting = sockets.receive_exactly(self._sock, 8)
        if greeting == NAME_SERVER_GREETING:
            self.info = replace(self.info, peer="name client")
            self._host.legacy(self, greeting)
            return
        carrier = wire.identify(greeting)
        if carrier.pull:
            self._serve_pictures(greeting)
        elif carrier is wire.HTTP:
            self._serve_page(greeting)
        elif carrier.text:
            self._serve_lines(carrier)
        else:
            self._serve_messages(carrier)

    def _enter(self, sender: str, carrier: Carrier) -> None:
        name, _, modifiers = sender.partition(" ")
        options = Bottle.from_text(modifiers) if modifiers and name.startswith("/") else Bottle()
        pairs = [option for option in options if isinstance(option, list) and len(option) > 1]
        text = "+".join((carrier.name, *(f"{pair[0]!s}.{pair[1]!s}" for pair in pairs)))
        self.info = replace(self.info, peer=name if name.startswith("/") else sender, carrier=text)
        plug_in = options.find("recv")
        if plug_in:
            raise RemoteProtocolError(f"plug-in {plug_in!s} is not supported, connect without +recv")
        self._host.admit(self)

    # -- binary ----------------------------------------------------------------------------------
    def _serve_messages(self, carrier: Carrier) -> None:
        size = wire.decode_name_size(sockets.receive_exactly(self._sock, 4))
        self._enter(wire.decode_name(sockets.receive_exactly(self._sock, size)), carrier)
        if carrier.datagrams:
            self._serve_datagrams()
            return
        sockets.send(self._sock, [wire.encode_number(self._host.port_number)])
        receiver = Receiver(allocate=self._host.allocate, limit=self._host.limit)
        while (message := self._next(receiver)) is not None:
            if not self._handle(message, carrier):
                return

    def _next(self, receiver: Receiver) -> Message | None:
        """The next message; None where the peer has closed the connection."""
        while (message := receiver.take()) is None:
            try:
                count = sockets.receive_some(self._sock, receiver.wanted, all_of_it=receiver.in_body)
            except AckTimeoutError:
                if receiver.idle and not self._closed:
                    continue
                raise
            if not count:
                if receiver.idle:
                    return None
                raise TransportError("the peer closed it within a message")
            receiver.received(count)
        return message

    def _handle(self, message: Message, carrier: Carrier) -> bool:
        """Act on a message and acknowledge it; whether the connection goes on."""
        self.received += 1
        reply: list[Buffer] = []
        match message.letter:
            case "d" | "D":
                reply = encode_reply(self._ask(message))
            case "a":
                reply = encode_reply(self._host.administer(Bottle.decode(message.body)))
            case "r":
                return self._reverse(carrier)
            case "q":
                if carrier.acknowledged:
                    sockets.send(self._sock, [wire.ACK])
                return False
            case _:
                self._host.line(message.command)
        if carrier.acknowledged:
            reply.append(wire.ACK)
        if reply and not carrier.datagrams:
            sockets.send(self._sock, reply)
        return True

    def _ask(self, message: Message) -> Reply:
        request = Request(message, self.info)
        reply = self._host.deliver(request)
        if not request.wants_reply:
            return None
        if isinstance(reply, Bottle) and not request.message.text:
            return reply.encode_parts(request.dialect)
        return reply

    def _reverse(self, carrier: Carrier) -> bool:
        if carrier.acknowledged:
            sockets.send(self._sock, [wire.ACK])
        sockets.set_deadline(self._sock, None)
        # From here on the output's thread owns the connection; it reads the acknowledgements too. Our hold
        # on it is let go first: hanging up when this thread ends would end it for both.
        connection = self._sock.dup()
        self._sock.close()
        self._host.attach(self.peer, carrier, connection)
        return False

    def _serve_datagrams(self) -> None:
        with socket.socket(self._sock.family, socket.SOCK_DGRAM) as datagrams:
            datagrams.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, sockets.BUFFER_BYTES)
            datagrams.bind((self._sock.getsockname()[0], 0))
            sockets.set_deadline(datagrams, DATAGRAM_POLL)
            sockets.send(self._sock, [wire.encode_number(datagrams.getsockname()[1])])
            self._sock.close()
            joiner = Joiner(self._host.allocate, self._host.limit)
            buffer = memoryview(bytearray(65536))
            while not self._closed:
                try:
                    size, sender = datagrams.recvfrom_into(buffer)
                except (BlockingIOError, ConnectionError):
                    continue
                # Not its port: a YARP built without ACE sends from another one than it dialled with.
                if sender[0] != self.info.address[0]:
                    continue
                message = joiner.datagram(buffer[:size])
                if message is not None and not self._handle(message, wire.UDP):
                    return

    # -- text ------------------------------------------------------------------------------------
    def _serve_lines(self, carrier: Carrier) -> None:
        reader = LineReader()
        sender = self._line(reader, idle=False)
        if sender is None:
            raise TransportError("the peer closed it before its name came")
        self._enter(sender.strip(), carrier)
        self._write_lines([f"Welcome {sender.strip()}"])
        while (command := self._line(reader)) is not None:
            if command == "q":
                return
            if not command:
                continue
            self._write_lines(self._answer_line(command, reader), acknowledge=carrier.acknowledged)

    def _answer_line(self, command: str, reader: LineReader) -> list[str]:
        self.received += 1
        if command[0] == "a" or command[0] in "dD":
            body = self._bottle_text(reader)
            if command[0] == "a":
                return [self._host.administer(Bottle.from_text(body)).to_text()]
            reply = self._ask(Message(command if command != "do" else "d", text=body))
            return [] if reply is None else [reply_text(reply)]
        return self._host.line(command)

    def _bottle_text(self, reader: LineReader) -> str:
        """A Bottle's line, and those that continue it."""
        text = reader.bottle(lambda: self._line(reader, idle=False))
        if text is None:
            raise TransportError("the peer closed it within a message")
        return text

    def _line(self, reader: LineReader, *, idle: bool = True) -> str | None:
        while (line := reader.line()) is None:
            try:
                data = self._sock.recv(65536)
            except BlockingIOError as error:
                if idle and reader.empty and not self._closed:
                    continue
                raise AckTimeoutError("the peer stopped within a line") from error
            except OSError as error:
                raise TransportError(f"the connection broke: {sockets.reason(error)}") from error
            if not data:
                return None
            reader.feed(data)
        return line

    def _write_lines(self, lines: list[str], *, acknowledge: bool = False) -> None:
        text = "".join(line + "\r\n" for line in (*lines, *(["<ACK>"] if acknowledge else [])))
        if text:
            sockets.send(self._sock, [text.encode("utf-8", "surrogateescape")])

    # -- http ------------------------------------------------------------------------------------
    def _read_request(self, greeting: bytes) -> str:
        """The first line of a request over HTTP, once the blank line has come that ends it."""
        reader = LineReader(web_page.LINE_LIMIT)
        reader.feed(greeting)
        request = self._line(reader, idle=False)
        for _ in range(web_page.REQUEST_LINES):
            if not self._line(reader, idle=False):
                return request or ""
        raise RemoteProtocolError("HTTP request without an end")

    def _serve_page(self, greeting: bytes) -> None:
        request = self._read_request(greeting)
        self._enter("browser", wire.HTTP)
        page = self._host.page() if web_page.wanted(request) else web_page.NOT_FOUND
        sockets.send(self._sock, [page])

    def _serve_pictures(self, greeting: bytes) -> None:
        self._read_request(greeting)
        self._enter("mjpeg reader", wire.MJPEG)
        sockets.send(self._sock, [mjpeg.RESPONSE])
        sockets.set_deadline(self._sock, None)
        end = self._host.attach(self.info.place, wire.MJPEG, self._sock.dup())
        try:
            while self._sock.recv(4096):
                pass
        except OSError:
            pass
        finally:
            end()
