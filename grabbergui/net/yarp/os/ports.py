"""Ports by what they are for: output of a stream, input of one, answering requests."""

from __future__ import annotations

import logging
import socket
import threading
import time
from collections.abc import Callable, Iterable
from contextlib import ExitStack, suppress
from functools import partial
from queue import Empty, SimpleQueue

import numpy as np

from grabbergui.config.allowed_addresses import EVERYBODY, AllowedAddresses
from grabbergui.core.errors import FrameTimeoutError, GrabberError, RemoteProtocolError, TransportError
from grabbergui.core.frame import BufferPool
from grabbergui.net.yarp.image import BAYER, BAYER_ORDER, as_bayer
from grabbergui.net.yarp.mjpeg import JpegStreamReader, decode_jpeg
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os import sockets
from grabbergui.net.yarp.os.binary import MESSAGE_LIMIT
from grabbergui.net.yarp.os.bottle import Bottle, Buffer
from grabbergui.net.yarp.os.events import Header
from grabbergui.net.yarp.os.inputs import Input, Reply, Request
from grabbergui.net.yarp.os.link import administer, greet, run_all
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.outputs import Outgoing
from grabbergui.net.yarp.os.port import NO_OUTPUT, Handler, Port
from grabbergui.net.yarp.os.target import Target
from grabbergui.net.yarp.os.values import Vocab

log = logging.getLogger(__name__)

_POOLED = 1 << 16
"""Size in bytes from which the memory of messages is reused."""
PARTING_SECONDS = 0.3
"""Seconds that a port waits at its end for its sources to disconnect; one that hangs must not hold it up."""


class OutputPort(Port):
    """Sends a stream to any number of readers; may answer requests, too, as a frame grabber's image port."""

    @property
    def dropped(self) -> int:
        """Messages for which connected readers were too slow, in total."""
        return sum(output.dropped for output in self._registry.outputs)

    def asked_for(self, modifier: str) -> frozenset[str]:
        """Return the values that readers' carriers give to a modifier; an empty one of those without it."""
        return frozenset(output.modifiers.get(modifier, "") for output in self._registry.outputs)

    def write(
        self,
        header: Buffer,
        payload: Buffer = b"",
        envelope: str = "",
        *,
        only: tuple[str, str] | None = None,
    ) -> None:
        """Send one message, which is not copied: leave its memory alone until all readers have it.

        `only` is a modifier and its value: readers whose carrier gives it another one get nothing.
        Never waits. A reader that is still busy gets the newest message when it is ready.
        """
        outputs = self._registry.outputs
        if only is not None:
            modifier, value = only
            outputs = [output for output in outputs if output.modifiers.get(modifier, "") == value]
        if outputs:
            message = Outgoing([header, payload] if len(payload) else [header], envelope)
            for output in outputs:
                output.put(message)

    def write_bottle(self, bottle: Bottle, envelope: str = "") -> None:
        """Send a Bottle."""
        self.write(bottle.encode(), envelope=envelope)

    def wait_sent(self, timeout: float) -> bool:
        """Wait until no message waits for a reader; return whether that was so within `timeout` seconds."""
        deadline = time.monotonic() + timeout
        return all(output.wait_taken(deadline - time.monotonic()) for output in self._registry.outputs)


class RpcServer(Port):
    """Answers requests."""

    sends = False

    def __init__(
        self,
        name: str,
        handler: Handler,
        names: NameClient | None = None,
        *,
        bind: str = "",
        port: int = 0,
        allowed: AllowedAddresses = EVERYBODY,
    ) -> None:
        super().__init__(name, names, handler=handler, bind=bind, port=port, allowed=allowed)


class InputPort(Port):
    """Receives a stream; keeps the newest messages, so a slow reader never holds up a source."""

    sends = False
    plug_ins = frozenset({"bayer"})
    limit = MESSAGE_LIMIT

    def __init__(
        self, name: str, names: NameClient | None = None, *, depth: int = 1, bind: str = "", port: int = 0
    ) -> None:
        super().__init__(name, names, bind=bind, port=port)
        self.overwritten = 0
        "Messages that newer ones replaced before they were read."
        self._depth = depth
        # Not a Condition: waiting in C costs the reading thread far less.
        self._arrived: SimpleQueue[tuple[memoryview | bytes, str] | None] = SimpleQueue()
        "Messages and envelopes; a JPEG image as bytes; None once the port is closed."
        self._putting = threading.Lock()
        self._pulling = threading.Lock()
        self._pulled: dict[str, _Puller] = {}
        self._pool: BufferPool | None = None

    @property
    def sources(self) -> list[str]:
        """Names of the connected sources."""
        return list(self.carriers(outgoing=False))

    def read(self, timeout: float) -> tuple[memoryview, str]:
        """Return the oldest message kept and its envelope's text. Raises FrameTimeoutError."""
        deadline = time.monotonic() + timeout
        while True:
            try:
                arrived = self._arrived.get(timeout=max(0.0, deadline - time.monotonic()))
            except Empty:
                raise FrameTimeoutError(f"{self.name}: no message arrived within {timeout:g} s") from None
            if arrived is None:
                self._arrived.put(None)  # for the next reader
                raise FrameTimeoutError(f"{self.name} was closed")
            message, envelope = arrived
            if isinstance(message, memoryview):
                return message, envelope
            try:
                # On the reading thread, so that an image that nobody reads is not decoded.
                header, pixels, envelope = decode_jpeg(message)
            except RemoteProtocolError as error:
                log.info("%s: %s", self.name, error)
                continue
            return memoryview(header + bytes(pixels)), envelope

    def connect(self, source: str, carrier: str = "fast_tcp") -> None:
        """Ask a source to connect to this port, which must be registered; over mjpeg, connect to the source.

        Raises SourceNotFoundError, SourceUnavailableError, TransportError where the source refuses.
        """
        if wire.by_name(carrier).pull:
            self.add(Target.parse(source, carrier))
            return
        request = Bottle([Vocab("add"), f"{carrier}:/{self.name}"])
        reply = administer(self.locate(Target.parse(source).name), request, self.key)
        if not reply or reply[0] != 0:
            text = str(reply[1]).strip() if len(reply) > 1 else "no reason given"
            if text.endswith(NO_OUTPUT):
                raise TransportError(f"{source} is no port of images: it sends nothing")
            raise TransportError(f"{source} does not connect to {self.name} over {carrier}: {text}")

    def disconnect(self, source: str) -> None:
        """Stop receiving from a source. Never raises."""
        self.remove_input(source)
        try:
            administer(self.locate(source), Bottle([Vocab("del"), self.name]), self.key)
        except GrabberError as error:
            log.debug("%s: %s", self.name, error)

    def allocate(self, size: int) -> memoryview:
        """Return memory for a body; that of images is reused."""
        if size < _POOLED:
            return super().allocate(size)
        pool = self._pool
        if pool is None or pool.size != size:
            pool = self._pool = BufferPool(size, limit=8)
        buffer = pool.take()
        return memoryview((np.empty(size, np.uint8) if buffer is None else buffer).data)

    def register(self, connection: Input) -> None:
        """Accept a connection. Raises RemoteProtocolError if it is of Bayer patterns in an unknown order."""
        order = _bayer_order(connection.carrier)
        if order and order not in BAYER:
            raise RemoteProtocolError(
                f"{connection.carrier}: there is no order {order}, only {', '.join(BAYER)}"
            )
        super().register(connection)

    def deliver(self, request: Request) -> Reply:
        """Keep the message for `read`; over `+recv.bayer`, its mono image as a Bayer pattern."""
        data, order = request.data, _bayer_order(request.info.carrier)
        self._put(as_bayer(data, order) if order else data, request.message.envelope)
        return None

    def carriers(self, *, outgoing: bool) -> dict[str, str]:
        """Return the carrier of each connection, by the name at its other end."""
        found = super().carriers(outgoing=outgoing)
        return found if outgoing else found | dict.fromkeys(self._pulled, wire.MJPEG.name)

    def remove_input(self, name: str) -> bool:
        """Close the connections from `name`; return whether there were any."""
        with self._pulling:
            puller = self._pulled.pop(name, None)
        if puller:
            puller.close()
        return super().remove_input(name) or puller is not None

    def close(self) -> None:
        """Disconnect all sources, unregister the name and wake waiting readers."""
        self.give_up_name()
        for name in list(self._pulled):
            self.remove_input(name)
        self._leave_sources(PARTING_SECONDS)
        super().close()
        with self._putting:
            self._keep(0)
            self._arrived.put(None)

    def _leave_sources(self, seconds: float) -> None:
        """Disconnect all sources at once; a source that hangs notices the end by itself."""
        sources = [name for name in self.sources if name.startswith("/")]
        run_all(
            {f"yarp {self.name} leaves {name}": partial(self.disconnect, name) for name in sources}, seconds
        )

    def _put(self, payload: memoryview | bytes, envelope: str = "") -> None:
        with self._putting:
            if self._listener.is_open:
                self.overwritten += self._keep(self._depth - 1)
                self._arrived.put((payload, envelope))

    def _prepare(self) -> None:
        self._keep(0)  # what arrived before the last `close`
        super()._prepare()

    def _keep(self, count: int) -> int:
        """Drop all but the newest `count` messages; return how many were dropped."""
        dropped = 0
        with suppress(Empty):  # somebody reads at the moment
            while self._arrived.qsize() > count:
                self._arrived.get_nowait()
                dropped += 1
        return dropped

    def _pull(self, target: Target) -> None:
        address = self.locate(target.name)
        self.remove_input(target.name)
        puller = _Puller(self.name, target.name, address, self.key, self._put, self._pull_ended)
        with self._pulling:
            self._pulled[target.name] = puller
        puller.start()

    def _pull_ended(self, puller: _Puller) -> None:
        with self._pulling:
            if self._pulled.get(puller.source) is puller:
                del self._pulled[puller.source]


class _Puller:
    """Fetches images from one source over mjpeg."""

    def __init__(
        self,
        reader: str,
        source: str,
        address: tuple[str, int],
        key: bytes | None,
        put: Callable[[bytes], None],
        on_end: Callable[[_Puller], None],
    ) -> None:
        self.source = source
        self._reader = reader
        self._put = put
        self._on_end = on_end
        self._closed = False
        self._link, _ = greet(sockets.connect(address, key=key), Header(wire.MJPEG, address[0]))
        sockets.set_deadline(self._link.sock, None)
        self._thread = threading.Thread(target=self._run, name=f"yarp {reader} from {source}", daemon=True)

    def start(self) -> None:
        """Start to receive."""
        self._thread.start()

    def close(self) -> None:
        """Close the connection and wait for the thread."""
        self._closed = True
        with suppress(OSError):
            self._link.sock.shutdown(socket.SHUT_RDWR)
        if self._thread is not threading.current_thread() and self._thread.ident is not None:
            self._thread.join(5)

    def _run(self) -> None:
        stream = JpegStreamReader()
        try:
            data = self._link.connection.trailing_data
            while data:
                for jpeg in stream.feed(data)[-1:]:
                    self._put(jpeg)
                data = self._link.sock.recv(1 << 18)
            raise TransportError("the source closed the connection")
        except (GrabberError, OSError) as error:
            if not self._closed:
                log.info("%s: connection from %s (mjpeg) closed: %s", self._reader, self.source, error)
        finally:
            self._link.close()
            self._on_end(self)


def _bayer_order(carrier: str) -> str:
    """Return the order of the Bayer patterns that a carrier announces, in lower case; empty without any."""
    modifiers = wire.modifiers_of(carrier) if "+recv.bayer" in carrier else {}
    return modifiers.get("order", BAYER_ORDER).lower() if modifiers.get("recv") == "bayer" else ""


def open_all(ports: Iterable[Port]) -> None:
    """Open all ports, or none. Raises SourceUnavailableError, TransportError."""
    with ExitStack() as opened:
        for port in ports:
            opened.callback(port.close)
            port.open()
        opened.pop_all()
