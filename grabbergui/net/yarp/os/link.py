"""Connections on sockets: accepted by a listener, their events read and written, requests to other ports."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import TypeVar

from grabbergui.core.errors import (
    AckTimeoutError,
    GrabberError,
    RemoteProtocolError,
    TransportError,
)
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os import sockets
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.connection import NEED_DATA, Wait, YarpConnection
from grabbergui.net.yarp.os.events import Acknowledgement, Closed, Event, Header, HeaderReply, Message, Reply

E = TypeVar("E", bound=Event)
_READ_BYTES = 4096
_LONG_READ_BYTES = 1 << 20


class Link:
    """A socket and the connection on it. One thread reads, one writes."""

    def __init__(self, sock: socket.socket, connection: YarpConnection) -> None:
        self.sock = sock
        self.connection = connection
        self._limit = 0.0
        "Timeout of a read in seconds, as set in the kernel; 0 if others set it."

    def send(self, *events: Event) -> None:
        """Write events in one go. Raises LocalProtocolError out of turn, AckTimeoutError, TransportError."""
        parts = self.connection.send(events[0])
        for event in events[1:]:
            parts += self.connection.send(event)
        sockets.send(self.sock, parts)

    def next_event(self, deadline: float | None = None) -> Event:
        """Read until the peer's next event is complete.

        `deadline` is a value of `time.monotonic`; without one the socket's own limit holds for each read.
        Raises AckTimeoutError (call again to go on), TransportError, RemoteProtocolError.
        """
        while isinstance(event := self.connection.next_event(), Wait):
            if event is not NEED_DATA:
                raise TransportError("the peer has nothing to send now")
            if deadline is not None:
                left = deadline - time.monotonic()
                if left <= 0:
                    raise AckTimeoutError("the peer did not answer in time")
                # It costs a system call, so a limit that is a little too long is kept.
                if not left <= self._limit <= 1.01 * left:
                    sockets.set_deadline(self.sock, left, sending=False)
                    self._limit = left
            self._read()
        return event

    def expect(self, kind: type[E], deadline: float | None = None) -> E:
        """Read the next event, which must be of one kind. Raises as `next_event`."""
        event = self.next_event(deadline)
        if isinstance(event, kind):
            return event
        if isinstance(event, Closed):
            raise TransportError("the peer closed the connection")
        raise RemoteProtocolError(f"{type(event).__name__} where {kind.__name__} was expected")

    def answer(self, deadline: float | None = None) -> Reply | None:
        """Read the reply to a message, None without one, and the acknowledgement. Raises as `next_event`."""
        event = self.next_event(deadline)
        if isinstance(event, Reply):
            reply, event = event, self.next_event(deadline)
        else:
            reply = None
        if isinstance(event, Acknowledgement):
            return reply
        raise TransportError("the peer closed the connection")

    def close(self) -> None:
        """Close the socket and wake the threads that wait for it. Never raises."""
        sockets.shut_down(self.sock)

    def _read(self) -> None:
        connection = self.connection
        wanted = connection.wanted
        if wanted is not None:
            receive = sockets.receive_body if connection.in_body else sockets.receive_some
            connection.received(receive(self.sock, wanted))
        else:
            size = min(max(_READ_BYTES, connection.missing), _LONG_READ_BYTES)
            connection.receive_data(sockets.receive(self.sock, size))


def greet(sock: socket.socket, header: Header) -> tuple[Link, HeaderReply]:
    """Exchange headers on a socket that we opened, and close it on failure.

    Raises TransportError, RemoteProtocolError, LocalProtocolError.
    """
    link = Link(sock, YarpConnection(opener=True))
    try:
        link.send(header)
        return link, link.expect(HeaderReply)
    except BaseException:
        sock.close()
        raise


def administer(
    address: tuple[str, int], request: Bottle, key: bytes | None = None, timeout: float = 5.0
) -> Bottle:
    """Send a port an administrative request over text_ack, as `yarp connect` does. Raises TransportError."""
    place = f"{address[0]}:{address[1]}"
    deadline = time.monotonic() + timeout
    sock = sockets.connect(address, timeout, key)
    try:
        link, _ = greet(sock, Header(wire.TEXT_ACK, "admin"))
        link.send(Message("a", text=request.to_text()))
        answer = link.answer(deadline)
    except (RemoteProtocolError, TransportError) as error:
        raise TransportError(f"the port at {place} did not answer: {error}") from error
    finally:
        sock.close()
    return Bottle.from_text(answer.text if answer else "")


def describes_itself(name: str, address: tuple[str, int], key: bytes | None, timeout: float) -> bool:
    """Return whether a port of this name answers at the address; False if something else does, or nothing."""
    try:
        sock = sockets.connect(address, timeout, key)
        with sock:
            link, _ = greet(sock, Header(wire.TEXT, "admin"))
            link.send(Message("*"))
            return link.expect(Reply, time.monotonic() + timeout).text.startswith(f"This is {name} at ")
    except GrabberError:
        return False


def report_end(source: str, address: tuple[str, int], key: bytes | None = None) -> None:
    """Notify a reader of udp or mcast of the end of `source`, which it cannot notice. Raises GrabberError."""
    sock = sockets.connect(address, 1.0, key)
    try:
        link, _ = greet(sock, Header(wire.TEXT, "admin"))
        link.send(Message(f"~{source}"))
        link.next_event()
        link.send(Message("q"))
    finally:
        sock.close()


def run_all(calls: Mapping[str, Callable[[], object]], seconds: float) -> None:
    """Run each function on a thread of that name, all at once, and wait `seconds` for them at most.

    Those that take longer go on in the background. None of them may raise.
    """
    deadline = time.monotonic() + seconds
    threads = []
    for name, call in calls.items():
        thread = threading.Thread(target=call, name=name, daemon=True)
        with suppress(RuntimeError):  # the program ends, or has no threads left
            thread.start()
            threads.append(thread)
    for thread in threads:
        thread.join(max(0.0, deadline - time.monotonic()))
