"""Asks a port over tcp: one request, one reply, and the acknowledgement that ends it."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence

from grabbergui.core.errors import AckTimeoutError, RemoteProtocolError, TransportError
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os import sockets
from grabbergui.net.yarp.os.bottle import Bottle, Buffer
from grabbergui.net.yarp.os.carrier import Header, Message, Reply
from grabbergui.net.yarp.os.link import Link, greet
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.names import literal_contact
from grabbergui.net.yarp.os.values import Dialect


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
        self._lock = threading.Lock()

    def call(self, request: Bottle | Buffer | Sequence[Buffer], timeout: float = 2.0) -> Bottle | None:
        """Send a request; return the reply, or None where the port acknowledged without one.

        Raises SourceNotFoundError and SourceUnavailableError from the name server, AckTimeoutError,
        TransportError, RemoteProtocolError. After any of them the next call connects again.
        """
        reply = self._exchange(request, timeout, raw=False)
        if reply is None:
            return None
        if reply.bottle is not None:
            return reply.bottle
        return Bottle.decode_from(reply.body, 0, self.dialect)[0]

    def call_raw(self, request: Bottle | Buffer | Sequence[Buffer], timeout: float = 2.0) -> bytes:
        """Send a request; return all bytes before the acknowledgement, for replies that are no Bottle."""
        reply = self._exchange(request, timeout, raw=True)
        return bytes(reply.body) if reply else b""

    def close(self) -> None:
        """Close the connection. May be called twice; never raises."""
        with self._lock:
            self._drop()

    def __enter__(self) -> RpcClient:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _exchange(
        self, request: Bottle | Buffer | Sequence[Buffer], timeout: float, *, raw: bool
    ) -> Reply | None:
        message = Message("d", parts=_parts(request, self.dialect))
        with self._lock:
            fresh = self._link is None
            try:
                return self._once(message, timeout, raw)
            except _NotAnsweredError:
                # A connection that lay idle while the port was restarted breaks before the first byte.
                if fresh:
                    raise
            return self._once(message, timeout, raw)

    def _once(self, message: Message, timeout: float, raw: bool) -> Reply | None:
        try:
            link = self._link = self._link or self._connect(timeout)
            deadline = time.monotonic() + timeout
            link.connection.expect_replies(self.dialect, raw=raw)
            try:
                link.send(message)
                reply = link.answer(deadline)
            except AckTimeoutError as error:
                raise AckTimeoutError(f"{self.target} did not answer in time") from error
            except TransportError as error:
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
        contact = self._names.query(self.target) if self._names else literal_contact(self.target)
        if contact is None:
            raise TransportError(
                f"{self.target} cannot be looked up without a name server; write tcp://HOST:PORT/"
            )
        sock = sockets.connect(contact.address, timeout, self._key)
        try:
            return greet(sock, Header(wire.TCP, self._sender))[0]
        except RemoteProtocolError as error:
            hint = "if it wants authentication, put its key into auth.conf"
            raise TransportError(f"{self.target} does not greet as a YARP port; {hint}") from error

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
