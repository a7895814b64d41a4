"""Connections that we open to other ports: to readers, on which a port sends, and to servers, for requests.

An `Output` has a thread, which sends the newest message. An `RpcClient` works on the threads of its callers.
"""

from __future__ import annotations

import logging
import socket
import threading
import time
from collections.abc import Callable, Sequence
from typing import Final

from grabbergui.core.errors import (
    GrabberError,
    LocalProtocolError,
    ResourceExhaustedError,
    TransportError,
)
from grabbergui.core.scheduling import RealtimeThread
from grabbergui.net.yarp.os import sockets
from grabbergui.net.yarp.os.binary import encode_command, encode_message
from grabbergui.net.yarp.os.bottle import Bottle, Buffer
from grabbergui.net.yarp.os.carrier import Carrier, modifiers_of
from grabbergui.net.yarp.os.connection import YarpConnection
from grabbergui.net.yarp.os.datagram_sockets import datagram_sender, multicast_sender, send_datagrams
from grabbergui.net.yarp.os.datagrams import split_datagrams
from grabbergui.net.yarp.os.events import Header, Message
from grabbergui.net.yarp.os.link import Link, greet
from grabbergui.net.yarp.os.local_sockets import local_sender
from grabbergui.net.yarp.os.multicast import Membership

log = logging.getLogger(__name__)


MOST_WORK: Final = 0.05
"Share of a core up to which a reader's thread has real-time priority, if permitted. There may be many."
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
        from grabbergui.net.yarp.mjpeg import encode_part

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
        membership: Membership | None = None,
        on_close: Callable[[Output], None] = lambda output: None,
    ) -> None:
        """`listens_at` is where the reader accepts connections, if we connected to it.

        `membership` is its share in a multicast group, over mcast.
        """
        self.source = source
        self.reader = reader
        self.carrier = carrier
        self.carrier_text = carrier_text or carrier.name
        "With its modifiers."
        self.modifiers = modifiers_of(self.carrier_text)
        self.messages = 0
        "Messages sent."
        self.bytes = 0
        "Their bytes, without headers and envelopes."
        self.dropped = 0
        "Messages that newer ones replaced before they were sent."
        self.active = time.monotonic()
        "Time of the last message, in seconds of `time.monotonic`."
        self.address = sockets.peer_address(link.sock)
        self.listens_at = listens_at
        self._link = link
        self._membership = membership
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
        self._release()

    def close(self) -> None:
        """Stop sending, shut down and wait for the thread. Any thread; may be called twice."""
        self.abort()
        if self._thread is not threading.current_thread() and self._thread.ident is not None:
            self._thread.join(5)

    def _run(self) -> None:
        thread = RealtimeThread(MOST_WORK)
        try:
            while message := self._take():
                thread.review(time.monotonic())
                self.bytes += self._send(message)
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
            self._release()
            self._on_close(self)

    def _release(self) -> None:
        self._link.close()
        if self._membership is not None:
            self._membership.leave()

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

    def _send(self, message: Outgoing) -> int:
        """Send a message; return its size in bytes."""
        if self.carrier.pull:
            jpeg = message.jpeg()
            sockets.send(self._link.sock, jpeg)
            return _size(jpeg)
        if self._membership is not None and not self._membership.sends:
            return _size(message.parts)
        if self.carrier.datagrams:
            whole = encode_message(message.command, message.parts)
            send_datagrams(self._link.sock, split_datagrams(whole))
            return _size(message.parts)
        if self.carrier.local:
            sockets.send(self._link.sock, [encode_command(message.command), *message.parts])
            return _size(message.parts)
        sent = message.text() if self.carrier.text else message.binary()
        self._link.send(sent)
        if self.carrier.acknowledged:
            self._link.answer()  # a reply is of no use here
        return len(sent.text) if self.carrier.text else _size(message.parts)


def _size(parts: Sequence[Buffer]) -> int:
    return sum(memoryview(part).nbytes for part in parts)


def connect(
    source: str,
    sender: str,
    reader: str,
    address: tuple[str, int],
    carrier: Carrier,
    key: bytes | None,
    join: Callable[[str], Membership],
) -> tuple[Link, Membership | None]:
    """Open a connection to a reader, headers included, on which to send. Raises GrabberError.

    `join` joins the multicast group for our address on the way to the reader, over mcast.
    """
    sock = sockets.connect(address, key=key)
    membership: Membership | None = None
    try:
        if not carrier.replies:
            if carrier.multicast and sock.family != socket.AF_INET:
                raise TransportError("multicast needs IPv4: choose another carrier")
            membership = join(sock.getsockname()[0]) if carrier.multicast else None
            group = membership.address if membership else None
            link = Link(sock, YarpConnection(opener=True))
            link.send(Header(carrier, sender, group=group))
            messages = multicast_sender(sock, group) if group else local_sender(sock)
            return Link(messages, link.connection), membership
        link, reply = greet(sock, Header(carrier, sender))
        if carrier.datagrams:
            return Link(datagram_sender(sock, reply.number), link.connection), None
        # A reader may take any time over a message, since it delays no other.
        sockets.set_deadline(sock, None)
        return link, None
    except BaseException as error:
        sock.close()
        if membership is not None:
            membership.leave()
        if isinstance(error, TransportError):
            raise TransportError(
                f"{reader} does not take carrier {carrier.name} from {source}: {error}"
            ) from error
        raise
