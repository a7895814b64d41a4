"""A connection on a socket: reads and writes its events. Also the requests that other ports answer.

`administer` and `report_end` connect for one request, an `RpcClient` for many.
"""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeVar

from grabbergui.core.errors import (
    AckTimeoutError,
    RemoteProtocolError,
    ResourceExhaustedError,
    TransportError,
)
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os import sockets
from grabbergui.net.yarp.os.bottle import Bottle, Buffer
from grabbergui.net.yarp.os.carrier import (
    Ack,
    Closed,
    Event,
    Header,
    HeaderReply,
    Message,
    Reply,
    literal_address,
)
from grabbergui.net.yarp.os.connection import NEED_DATA, Connection, Wait
from grabbergui.net.yarp.os.values import Dialect

if TYPE_CHECKING:
    from grabbergui.net.yarp.os.name_client import NameClient

E = TypeVar("E", bound=Event)
_READ_BYTES = 4096
_LONG_READ_BYTES = 1 << 20


class Link:
    """A socket and the connection on it. One thread reads, one writes."""

    def __init__(self, sock: socket.socket, connection: Connection) -> None:
        self.sock = sock
        self.connection = connection
        self._limit = 0.0
        "Of a read, as the kernel keeps it; 0 where others set it."

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
        if isinstance(event, Ack):
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
    link = Link(sock, Connection(opener=True))
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


def report_end(source: str, address: tuple[str, int], key: bytes | None = None) -> None:
    """Notify a udp reader of the end of `source`, which it cannot notice. Raises GrabberError."""
    sock = sockets.connect(address, 1.0, key)
    try:
        link, _ = greet(sock, Header(wire.TEXT, "admin"))
        link.send(Message(f"~{source}"))
        link.next_event()
        link.send(Message("q"))
    finally:
        sock.close()


class RpcClient:
    """Calls one port; connects when needed, and again after a loss. Any thread; calls take turns."""

    def __init__(
        self,
        target: str,
        names: NameClient | None = None,
        *,
        sender: str = "grabbergui",
        key: bytes | None = None,
    ) -> None:
        self.target = target
        "A port's name, or `tcp://HOST:PORT/`."
        self.dialect = Dialect.YARP3
        "Of requests and replies."
        self._names = names
        self._sender = sender
        self._key = names.key if names else key
        self._link: Link | None = None
        self._closings = 0
        "Calls of `close`, by which a call notices that it was to end."
        self._lock = threading.Lock()

    def call(self, request: Bottle | Buffer | Sequence[Buffer], timeout: float = 2.0) -> Bottle | None:
        """Send a request; return the reply, or None where the port acknowledged without one.

        Raises SourceNotFoundError and SourceUnavailableError from the name server, AckTimeoutError,
        TransportError, RemoteProtocolError. After any of them the next call connects again.
        """
        reply = self._exchange(request, timeout)
        if reply is None:
            return None
        if reply.bottle is not None:
            return reply.bottle
        return Bottle.decode_from(reply.body, 0, self.dialect)[0]

    def close(self) -> None:
        """Close the connection; a call that waits for its answer raises TransportError.

        Never waits, never raises. The next call connects again.
        """
        self._closings += 1
        if (link := self._link) is not None:
            link.close()

    def __enter__(self) -> RpcClient:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _exchange(self, request: Bottle | Buffer | Sequence[Buffer], timeout: float) -> Reply | None:
        message = Message("d", parts=_parts(request, self.dialect))
        with self._lock:
            fresh, closings = self._link is None, self._closings
            try:
                return self._once(message, timeout, closings)
            except _NotAnsweredError:
                # A connection that lay idle while the port was restarted breaks before the first byte.
                if fresh or self._closings != closings:
                    raise
            return self._once(message, timeout, closings)

    def _once(self, message: Message, timeout: float, closings: int) -> Reply | None:
        try:
            link = self._link = self._link or self._connect(timeout)
            self._check_open(closings)
            deadline = time.monotonic() + timeout
            link.connection.expect_replies(self.dialect)
            try:
                link.send(message)
                reply = link.answer(deadline)
            except AckTimeoutError as error:
                raise AckTimeoutError(f"{self.target} did not answer in time") from error
            except TransportError as error:
                self._check_open(closings)
                kind = TransportError if link.connection.trailing_data else _NotAnsweredError
                raise kind(f"{self.target}: {error}") from error
            except RemoteProtocolError as error:
                raise RemoteProtocolError(f"{self.target}: {error}") from error
            if rest := link.connection.trailing_data:
                raise RemoteProtocolError(f"{self.target} sent {len(rest)} bytes after its reply")
        except BaseException:
            self._drop()  # anything that still arrives would be taken for the next reply
            raise
        return reply

    def _connect(self, timeout: float) -> Link:
        if self._names:
            address = self._names.query(self.target).address
        elif literal := literal_address(self.target):
            address = literal[1:]
        else:
            raise TransportError(
                f"{self.target} cannot be looked up without a name server; write tcp://HOST:PORT/"
            )
        try:
            return greet(sockets.connect(address, timeout, self._key), Header(wire.TCP, self._sender))[0]
        except RemoteProtocolError as error:
            hint = "if it wants authentication, put its key into auth.conf"
            raise TransportError(f"{self.target} does not answer as a YARP port; {hint}") from error
        except AckTimeoutError as error:
            place = f"{address[0]}:{address[1]}"
            raise AckTimeoutError(
                f"{self.target} at {place} does not answer; its program may hang or be stopped"
            ) from error
        except ResourceExhaustedError:
            raise
        except TransportError as error:
            raise TransportError(f"{self.target}: {error}") from error

    def _check_open(self, closings: int) -> None:
        """Raise TransportError if `close` was called since there were that many calls of it."""
        if self._closings != closings:
            raise TransportError(f"{self.target}: the connection was closed here")

    def _drop(self) -> None:
        if self._link is not None:
            self._link.close()
            self._link = None


class _NotAnsweredError(TransportError):
    """The connection was lost before the first byte of the reply."""


def _parts(request: Bottle | Buffer | Sequence[Buffer], dialect: Dialect) -> Sequence[Buffer]:
    if isinstance(request, Bottle):
        return [request.encode(dialect, specialise=dialect is Dialect.YARP3)]
    return [request] if isinstance(request, (bytes, bytearray, memoryview)) else request
