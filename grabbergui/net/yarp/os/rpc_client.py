"""A connection for requests to a server's port."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence

from grabbergui.core.errors import (
    AckTimeoutError,
    RemoteProtocolError,
    ResourceExhaustedError,
    TransportError,
)
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os import sockets
from grabbergui.net.yarp.os.bottle import Bottle, Buffer
from grabbergui.net.yarp.os.events import Header, Message, Reply
from grabbergui.net.yarp.os.link import Link, greet
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.target import literal_address
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
        "Dialect of requests and replies."
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
            listed = self._names is not None and not literal_address(self.target)
            stale = listed and isinstance(error.__cause__, ConnectionRefusedError)
            hint = "; the name server lists it, but its program has ended or lies behind a firewall"
            raise TransportError(f"{self.target}: {error}{hint if stale else ''}") from error

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
