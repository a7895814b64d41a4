"""Asks a port over tcp: one request, one reply, and the acknowledgement that ends it."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable, Sequence
from typing import TypeVar

from grabbergui.core.errors import AckTimeoutError, RemoteProtocolError, TransportError
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os import sockets
from grabbergui.net.yarp.os.bottle import Bottle, Buffer
from grabbergui.net.yarp.os.bottle_scan import BottleScanner
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.names import literal_contact
from grabbergui.net.yarp.os.values import Dialect

REPLY_LIMIT = 1 << 28
T = TypeVar("T")


class RpcClient:
    """Calls one port; connects when needed, and again after a loss. Any thread; one call at a time."""

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
        "In which replies are read and Bottles written."
        self._names = names
        self._sender = sender
        self._key = names.key if names else key
        self._sock: socket.socket | None = None
        self._lock = threading.Lock()

    def call(self, request: Bottle | Buffer | Sequence[Buffer], timeout: float = 2.0) -> Bottle | None:
        """Send a request; the reply, or None where the port acknowledged without one.

        Raises SourceNotFoundError and SourceUnavailableError from the name server, AckTimeoutError,
        TransportError, RemoteProtocolError. After any of them the next call connects anew.
        """
        return self._exchange(request, timeout, self._read_bottle)

    def call_raw(self, request: Bottle | Buffer | Sequence[Buffer], timeout: float = 2.0) -> bytes:
        """Send a request; all bytes before the acknowledgement, for replies that are no Bottle."""
        return self._exchange(request, timeout, self._read_raw)

    def close(self) -> None:
        """Hang up. May be called twice; never raises."""
        with self._lock:
            self._drop()

    def __enter__(self) -> RpcClient:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _exchange(
        self, request: Bottle | Buffer | Sequence[Buffer], timeout: float, read: Callable[[_Stream], T]
    ) -> T:
        message = wire.encode_message("d", _parts(request, self.dialect))
        with self._lock:
            fresh = self._sock is None
            try:
                return self._once(message, timeout, read)
            except (AckTimeoutError, RemoteProtocolError):
                raise
            except _NotAnsweredError:
                # A connection that lay idle while the port was restarted breaks before the first byte.
                if fresh:
                    raise
            return self._once(message, timeout, read)

    def _once(self, message: list[Buffer], timeout: float, read: Callable[[_Stream], T]) -> T:
        try:
            if self._sock is None:
                self._sock = self._connect(timeout)
            stream = _Stream(self._sock, time.monotonic() + timeout, self.target)
            try:
                sockets.send(self._sock, message)
                stream.fill(1)
            except AckTimeoutError:
                raise
            except TransportError as error:
                raise _NotAnsweredError(f"{self.target}: {error}") from error
            return read(stream)
        except BaseException:
            self._drop()  # whatever still comes would be taken for the next reply
            raise

    def _connect(self, timeout: float) -> socket.socket:
        contact = self._names.query(self.target) if self._names else literal_contact(self.target)
        if contact is None:
            raise TransportError(
                f"{self.target} cannot be looked up without a name server; write tcp://HOST:PORT/"
            )
        sock = sockets.connect(contact.address, timeout, self._key)
        try:
            sockets.send(sock, [wire.encode_greeting(wire.TCP, self._sender)])
            wire.decode_number(sockets.receive_exactly(sock, 8))
        except RemoteProtocolError as error:
            sock.close()
            hint = "if it wants authentication, put its key into auth.conf"
            raise TransportError(f"{self.target} does not greet as a YARP port; {hint}") from error
        except BaseException:
            sock.close()
            raise
        return sock

    def _drop(self) -> None:
        if self._sock is not None:
            sockets.hang_up(self._sock)
            self._sock = None

    def _read_bottle(self, stream: _Stream) -> Bottle | None:
        stream.fill(len(wire.ACK))
        if stream.data[:8] == wire.ACK:
            stream.end(8)
            return None
        scanner = BottleScanner(self.dialect, REPLY_LIMIT)
        while (needed := scanner.scan(stream.data)) > len(stream.data):
            stream.fill(needed)
        reply, end = Bottle.decode_from(stream.data, 0, self.dialect)
        stream.fill(end + 8)
        if stream.data[end : end + 8] != wire.ACK:
            raise RemoteProtocolError(f"{self.target}: the reply is not followed by an acknowledgement")
        stream.end(end + 8)
        return reply

    def _read_raw(self, stream: _Stream) -> bytes:
        while not stream.data.endswith(wire.ACK):
            stream.fill(len(stream.data) + 1)
        return bytes(stream.data[: -len(wire.ACK)])


class _NotAnsweredError(TransportError):
    """The connection broke before a byte of the reply came."""


class _Stream:
    """What has come of one reply."""

    def __init__(self, sock: socket.socket, deadline: float, target: str) -> None:
        self.data = bytearray()
        self._sock = sock
        self._deadline = deadline
        self._target = target

    def fill(self, size: int) -> None:
        """Read until there are so many bytes. Raises AckTimeoutError, TransportError."""
        while len(self.data) < size:
            left = self._deadline - time.monotonic()
            if left <= 0:
                raise AckTimeoutError(f"{self._target} did not answer in time")
            sockets.set_deadline(self._sock, left, sending=False)
            try:
                more = self._sock.recv(min(1 << 20, max(65536, size - len(self.data))))
            except BlockingIOError as error:
                raise AckTimeoutError(f"{self._target} did not answer in time") from error
            except OSError as error:
                why = sockets.reason(error)
                raise TransportError(f"{self._target}: the connection broke: {why}") from error
            if not more:
                raise TransportError(f"{self._target} closed the connection")
            self.data += more

    def end(self, size: int) -> None:
        """Insist that nothing follows."""
        if len(self.data) != size:
            raise RemoteProtocolError(f"{self._target} sent {len(self.data) - size} bytes after its reply")


def _parts(request: Bottle | Buffer | Sequence[Buffer], dialect: Dialect) -> Sequence[Buffer]:
    if isinstance(request, Bottle):
        return [request.encode(dialect, specialise=dialect is Dialect.YARP3)]
    return [request] if isinstance(request, (bytes, bytearray, memoryview)) else request
