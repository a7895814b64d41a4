"""Connections that we open to other ports: to readers, on which a port sends, and to servers, for requests.

An `Output` has a thread, which sends the newest message. An `RpcClient` works on the threads of its callers.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Sequence
from typing import Final

from grabbergui.core.errors import (
    AckTimeoutError,
    GrabberError,
    LocalProtocolError,
    RemoteProtocolError,
    ResourceExhaustedError,
    TransportError,
)
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os import sockets
from grabbergui.net.yarp.os.bottle import Bottle, Buffer
from grabbergui.net.yarp.os.carrier import Carrier, Header, Message, Reply, literal_address, modifiers_of
from grabbergui.net.yarp.os.framing import split_datagrams
from grabbergui.net.yarp.os.link import Link, greet
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.values import Dialect

log = logging.getLogger(__name__)


# -- readers -------------------------------------------------------------------------------------
TEXT_LIMIT: Final = 1 << 26
"""Largest message in bytes that is sent as text, about four times as long. YARP, too, sends images so."""


class Outgoing:
    """A message to any number of readers; its text and JPEG are made once. Thread-safe."""

    def __init__(self, parts: Sequence[Buffer], envelope: str = "") -> None:
        self.parts = parts
        self.command = f"D {envelope}" if envelope else "D"
        self._envelope = envelope
        self._lock = threading.Lock()
        self._jpeg: list[Buffer] | None = None
        self._text: Message | None = None

    def binary(self) -> Message:
        """Return the message in binary form, for tcp, fast_tcp and udp."""
        return Message(self.command, parts=self.parts)

    def jpeg(self) -> list[Buffer]:
        """Return the part of an mjpeg stream. Raises GrabberError where the message is no image."""
        from grabbergui.net.yarp.image import encode_part  # a name server does without OpenCV

        with self._lock:
            if self._jpeg is None:
                self._jpeg = encode_part(b"".join(self.parts), self._envelope)
            return self._jpeg

    def text(self) -> Message:
        """Return the message for text and text_ack. Raises LocalProtocolError where it is too long."""
        with self._lock:
            if self._text is None:
                size = sum(len(part) for part in self.parts)
                if size > TEXT_LIMIT:
                    raise LocalProtocolError(
                        f"a message of {size} bytes is too long for text; choose another carrier"
                    )
                line = Bottle.decode(b"".join(self.parts)).to_text()
                self._text = Message(self.command, text=line)
            return self._text


class Output:
    """One reader of a port. `put` returns immediately; a slow reader misses messages and delays no other."""

    def __init__(
        self,
        source: str,
        reader: str,
        carrier: Carrier,
        link: Link,
        *,
        carrier_text: str = "",
        listens_at: tuple[str, int] | None = None,
        on_close: Callable[[Output], None] = lambda output: None,
    ) -> None:
        """`listens_at` is where the reader accepts connections, if we connected to it."""
        self.source = source
        self.reader = reader
        self.carrier = carrier
        self.carrier_text = carrier_text or carrier.name
        "With its modifiers."
        self.modifiers = modifiers_of(self.carrier_text)
        self.messages = 0
        "Messages sent."
        self.dropped = 0
        "Messages that newer ones replaced before they were sent."
        self.active = time.monotonic()
        "Time of the last message, in seconds of `time.monotonic`."
        self.address = sockets.peer_address(link.sock)
        self.listens_at = listens_at
        self._link = link
        self._on_close = on_close
        self._changed = threading.Condition()
        self._next: Outgoing | None = None
        self._closed = False
        self._thread = threading.Thread(target=self._run, name=f"yarp {source} to {reader}", daemon=True)

    def start(self) -> None:
        """Start to send. Raises ResourceExhaustedError if there is no thread left."""
        try:
            self._thread.start()
        except RuntimeError as error:
            self._link.close()
            raise ResourceExhaustedError(sockets.NO_MORE_THREADS) from error

    def put(self, message: Outgoing) -> None:
        """Send this message next, in place of one still waiting. Any thread; returns immediately."""
        with self._changed:
            self.dropped += self._next is not None
            self._next = message
            self._changed.notify_all()

    def wait_taken(self, timeout: float) -> bool:
        """Wait until no message is waiting; return whether that was so within `timeout` seconds."""
        with self._changed:
            return self._changed.wait_for(lambda: self._next is None, timeout)

    def abort(self) -> None:
        """Stop sending and shut down, without waiting for the thread. Any thread; may be called twice."""
        with self._changed:
            self._closed = True
            self._next = None
            self._changed.notify_all()
        self._link.close()

    def close(self) -> None:
        """Stop sending, shut down and wait for the thread. Any thread; may be called twice."""
        self.abort()
        if self._thread is not threading.current_thread() and self._thread.ident is not None:
            self._thread.join(5)

    def _run(self) -> None:
        try:
            while message := self._take():
                self._send(message)
                self.messages += 1
                self.active = time.monotonic()
        except GrabberError as error:
            if not self._closed:
                log.info(
                    "%s: connection to %s (%s) closed: %s", self.source, self.reader, self.carrier_text, error
                )
        except Exception:
            log.exception("%s: connection to %s failed", self.source, self.reader)
        finally:
            self._link.close()
            self._on_close(self)

    def _take(self) -> Outgoing | None:
        with self._changed:
            while not self._closed:
                if self._next is not None:
                    message, self._next = self._next, None
                    self._changed.notify_all()
                    return message
                # A reader sends nothing when it closes; between messages we look for the end of its stream.
                if not self._changed.wait(1.0) and self._reader_closed():
                    raise TransportError("the reader closed the connection")
            return None

    def _reader_closed(self) -> bool:
        return not self.carrier.datagrams and sockets.closed_by_peer(self._link.sock)

    def _send(self, message: Outgoing) -> None:
        if self.carrier.pull:
            sockets.send(self._link.sock, message.jpeg())
        elif self.carrier.datagrams:
            whole = wire.encode_message(message.command, message.parts)
            sockets.send_datagrams(self._link.sock, split_datagrams(whole))
        else:
            self._link.send(message.text() if self.carrier.text else message.binary())
            if self.carrier.acknowledged:
                self._link.answer()  # a reply is of no use here


def connect(
    source: str,
    sender: str,
    reader: str,
    address: tuple[str, int],
    carrier: Carrier,
    key: bytes | None,
) -> Link:
    """Open a connection to a reader, headers included, on which to send. Raises GrabberError."""
    sock = sockets.connect(address, key=key)
    try:
        link, reply = greet(sock, Header(carrier, sender))
        if carrier.datagrams:
            return Link(sockets.datagram_sender(sock, reply.number), link.connection)
        # A reader may take any time over a message, since it delays no other.
        sockets.set_deadline(sock, None)
        return link
    except BaseException as error:
        sock.close()
        if isinstance(error, TransportError):
            raise TransportError(
                f"{reader} does not take carrier {carrier.name} from {source}: {error}"
            ) from error
        raise


# -- requests ------------------------------------------------------------------------------------
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
