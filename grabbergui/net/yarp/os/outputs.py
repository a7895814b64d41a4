"""Connections on which a port sends: one thread each, which sends the newest message."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Sequence

from grabbergui.core.errors import GrabberError, LocalProtocolError, ResourceExhaustedError, TransportError
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os import sockets
from grabbergui.net.yarp.os.bottle import Bottle, Buffer
from grabbergui.net.yarp.os.carrier import Carrier, Header, Message, modifiers_of
from grabbergui.net.yarp.os.framing import LINE_LIMIT, split_datagrams
from grabbergui.net.yarp.os.link import Link, greet

log = logging.getLogger(__name__)


class Outgoing:
    """A message to any number of readers; the JPEG form is made once. Thread-safe."""

    def __init__(self, parts: Sequence[Buffer], envelope: str = "") -> None:
        self.parts = parts
        self.command = f"D {envelope}" if envelope else "D"
        self._envelope = envelope
        self._lock = threading.Lock()
        self._jpeg: list[Buffer] | None = None

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
        """Return the message for text and text_ack. Raises LocalProtocolError for an image, like YARP."""
        size = sum(len(part) for part in self.parts)
        if size > LINE_LIMIT:
            raise LocalProtocolError(
                f"a message of {size} bytes is too long for text; choose another carrier"
            )
        line = Bottle.decode(b"".join(self.parts)).to_text()
        if len(line) > LINE_LIMIT:
            raise LocalProtocolError(
                f"a message of {len(line)} characters is too long for text; choose another carrier"
            )
        return Message(self.command, text=line)


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
        on_close: Callable[[Output], None] = lambda output: None,
    ) -> None:
        self.source = source
        self.reader = reader
        self.carrier = carrier
        self.carrier_text = carrier_text or carrier.name
        "With its modifiers."
        self.modifiers = modifiers_of(self.carrier_text)
        self.sent = 0
        "Messages."
        self.dropped = 0
        "Messages that newer ones replaced before they were sent."
        self.active = time.monotonic()
        "Time of the last message, in seconds of `time.monotonic`."
        self.address = sockets.peer_address(link.sock)
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

    @property
    def messages(self) -> int:
        """Messages sent."""
        return self.sent

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
                self.sent += 1
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
