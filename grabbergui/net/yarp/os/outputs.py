"""Connections on which a port sends: one thread each, the newest message wins."""

from __future__ import annotations

import logging
import socket
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress

from grabbergui.core.errors import GrabberError, LocalProtocolError, TransportError
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os import datagrams, mjpeg, sockets
from grabbergui.net.yarp.os.bottle import Bottle, Buffer
from grabbergui.net.yarp.os.carrier import Carrier

log = logging.getLogger(__name__)

_TEXT_LIMIT = 1 << 16
_LONG_DATAGRAM = 49_000
_DATAGRAM_GAP = 0.001
"""Seconds after a long datagram, as YARP waits: a reader's kernel holds three of them by default, and one
that is lost takes its whole picture with it."""


class Outgoing:
    """A message on its way to any number of connections; each form of it is made once. Thread-safe."""

    def __init__(self, parts: Sequence[Buffer], envelope: str = "") -> None:
        self.parts = parts
        self.command = f"D {envelope}" if envelope else "D"
        self._envelope = envelope
        self._lock = threading.Lock()
        self._jpeg: list[Buffer] | None = None

    def binary(self) -> list[Buffer]:
        """For tcp, fast_tcp and udp."""
        return wire.encode_message(self.command, self.parts)

    def jpeg(self) -> list[Buffer]:
        """For mjpeg. Raises GrabberError where it is no image."""
        with self._lock:
            if self._jpeg is None:
                self._jpeg = mjpeg.encode_part(b"".join(self.parts), self._envelope)
            return self._jpeg

    def text(self) -> bytes:
        """For text and text_ack. Raises LocalProtocolError for an image: YARP sends none as text either."""
        size = sum(len(part) for part in self.parts)
        if size > _TEXT_LIMIT:
            raise LocalProtocolError(
                f"a message of {size} bytes is too long for text; choose another carrier"
            )
        line = Bottle.decode(b"".join(self.parts)).to_text()
        return f"{self.command}\r\n{line}\r\n".encode("utf-8", "surrogateescape")


class Output:
    """One reader of a port. `put` never waits; a slow reader misses messages, and nobody else does."""

    def __init__(
        self,
        source: str,
        reader: str,
        carrier: Carrier,
        sock: socket.socket,
        *,
        carrier_text: str = "",
        on_close: Callable[[Output], None] = lambda output: None,
    ) -> None:
        self.source = source
        self.reader = reader
        self.carrier = carrier
        self.carrier_text = carrier_text or carrier.name
        "With its modifiers."
        self.sent = 0
        "Messages."
        self.dropped = 0
        "Messages that newer ones replaced."
        self._sock = sock
        self._on_close = on_close
        self._changed = threading.Condition()
        self._next: Outgoing | None = None
        self._closed = False
        self._thread = threading.Thread(target=self._run, name=f"yarp {source} to {reader}", daemon=True)

    def start(self) -> None:
        """Begin to send."""
        self._thread.start()

    def put(self, message: Outgoing) -> None:
        """Send this next, in place of one that still waits. Any thread; never waits."""
        with self._changed:
            self.dropped += self._next is not None
            self._next = message
            self._changed.notify_all()

    def wait_taken(self, timeout: float) -> bool:
        """Wait until no message is waiting to be sent; whether that was so within `timeout` seconds."""
        with self._changed:
            return self._changed.wait_for(lambda: self._next is None, timeout)

    def close(self) -> None:
        """Stop sending and hang up. Any thread; may be called twice."""
        with self._changed:
            self._closed = True
            self._next = None
            self._changed.notify_all()
        sockets.hang_up(self._sock)
        if self._thread is not threading.current_thread() and self._thread.ident is not None:
            self._thread.join(5)

    def _run(self) -> None:
        try:
            while message := self._take():
                self._send(message)
                self.sent += 1
        except GrabberError as error:
            if not self._closed:
                log.info(
                    "%s: connection to %s (%s) closed: %s", self.source, self.reader, self.carrier_text, error
                )
        except Exception:
            log.exception("%s: connection to %s failed", self.source, self.reader)
        finally:
            sockets.hang_up(self._sock)
            self._on_close(self)

    def _take(self) -> Outgoing | None:
        with self._changed:
            while not self._closed:
                if self._next is not None:
                    message, self._next = self._next, None
                    self._changed.notify_all()
                    return message
                # A reader that leaves says nothing; its end of the stream is seen between messages.
                if not self._changed.wait(1.0) and self._hung_up():
                    raise TransportError("the reader closed the connection")
            return None

    def _hung_up(self) -> bool:
        if self.carrier.datagrams:
            return False
        try:
            return not self._sock.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT)
        except BlockingIOError:
            return False
        except OSError:
            return True

    def _send(self, message: Outgoing) -> None:
        if self.carrier.pull:
            sockets.send(self._sock, message.jpeg())
        elif self.carrier.text:
            sockets.send(self._sock, [message.text()])
            if self.carrier.acknowledged:
                self._skip_line_acknowledgement()
        elif self.carrier.datagrams:
            for datagram in datagrams.split(message.binary()):
                if sockets.send(self._sock, datagram) > _LONG_DATAGRAM:
                    time.sleep(_DATAGRAM_GAP)
        else:
            sockets.send(self._sock, message.binary())
            if self.carrier.acknowledged:
                wire.decode_number(sockets.receive_exactly(self._sock, len(wire.ACK)))

    def _skip_line_acknowledgement(self) -> None:
        line = b""
        while not line.endswith(b"<ACK>\r\n"):
            line = line[-64:] + sockets.receive_exactly(self._sock, 1)


def dial(
    source: str,
    sender: str,
    reader: str,
    address: tuple[str, int],
    carrier: Carrier,
    key: bytes | None,
) -> socket.socket:
    """Open a connection to a reader, greetings included; the socket to send on. Raises GrabberError."""
    sock = sockets.connect(address, key=key)
    try:
        sockets.send(sock, [wire.encode_greeting(carrier, sender)])
        if carrier.text:
            while sockets.receive_exactly(sock, 1) != b"\n":
                pass
        else:
            answer = wire.decode_number(sockets.receive_exactly(sock, 8))
            if carrier.datagrams:
                return _datagram_socket(sock, address, answer)
        # A reader may take its time over a message for as long as it likes: it holds up nobody else.
        sockets.set_deadline(sock, None)
        return sock
    except BaseException as error:
        sock.close()
        if isinstance(error, TransportError):
            raise TransportError(
                f"{reader} does not take carrier {carrier.name} from {source}: {error}"
            ) from error
        raise


def _datagram_socket(sock: socket.socket, address: tuple[str, int], port: int) -> socket.socket:
    # The receiver knows us by the address and port that the TCP connection had.
    local, remote = sock.getsockname(), sock.getpeername()
    sock.close()
    if not 0 < port < 65536:
        raise TransportError(f"it offers UDP port {port}")
    datagram = socket.socket(sock.family, socket.SOCK_DGRAM)
    try:
        datagram.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        datagram.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, sockets.BUFFER_BYTES)
        # A YARP built without ACE takes that very port for itself; on one machine we must do with another.
        with suppress(OSError):
            datagram.bind(local[:2])
        datagram.connect((remote[0], port))
    except OSError as error:
        datagram.close()
        raise TransportError(f"no UDP to {address[0]}:{port}: {sockets.reason(error)}") from error
    return datagram
