"""A port: a name, a listening socket, connections in and out, and what is said about them.

Threads: one accepts, one keeps the name registered, each connection has its own. All public methods may be
called from any thread.
"""

from __future__ import annotations

import logging
import select
import socket
import threading
import time
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from grabbergui.core.buffers import BufferPool
from grabbergui.core.errors import (
    GrabberError,
    LocalProtocolError,
    RemoteProtocolError,
    SourceNotFoundError,
    TransportError,
)
from grabbergui.net.yarp.os import admin, sockets, web_page
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os.bottle import Bottle, Buffer
from grabbergui.net.yarp.os.carrier import Carrier
from grabbergui.net.yarp.os.inputs import Input
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.names import Contact, Target, check_port_name
from grabbergui.net.yarp.os.outputs import Outgoing, Output, dial
from grabbergui.net.yarp.os.registration import Registration
from grabbergui.net.yarp.os.request import Reply, Request
from grabbergui.net.yarp.os.values import Item

log = logging.getLogger(__name__)

INPUT_LIMIT: Final = 200
"""Connections to one port at a time."""

_POOLED: Final = 1 << 16


class Port:
    """A YARP port. `OutputPort`, `InputPort` and `RpcServer` say what it is for."""

    sends = True
    "Whether readers may be connected to it."
    pulls = False
    "Whether it may be told to fetch from a source (mjpeg)."

    def __init__(
        self,
        name: str,
        names: NameClient | None = None,
        *,
        bind: str = "",
        port: int = 0,
        limit: int = wire.MESSAGE_LIMIT,
    ) -> None:
        """Make a port; `open` starts it.

        Without `names` it is reached as `tcp://HOST:PORT/` only. `bind` is the address to listen at; by
        default the one from which the name server is reached, loopback without one.
        """
        self.name = check_port_name(name)
        self.limit = limit
        self.properties: dict[str, Item] = {}
        self.contact = Contact(self.name, "", 0)
        "Where it listens, once open."
        self.key = names.key if names else None
        self._names = names
        self._wish = (bind, port)
        self._lock = threading.RLock()
        self._inputs: list[Input] = []
        self._outputs: list[Output] = []
        self._listener: socket.socket | None = None
        self._wake: tuple[socket.socket, socket.socket] | None = None
        self._closing = threading.Event()
        self._acceptor: threading.Thread | None = None
        self._registration: Registration | None = None
        self._pool: BufferPool | None = None

    # -- life ------------------------------------------------------------------------------------
    def open(self) -> None:
        """Listen and register. Raises SourceUnavailableError, TransportError; nothing is left then."""
        bind, port = self._wish
        if not bind:
            bind = sockets.local_address_towards(*self._names.server.address) if self._names else "127.0.0.1"
        host = bind
        if self._names and _any(bind):
            host = sockets.local_address_towards(*self._names.server.address)
        try:
            listener = sockets.listen((bind, port))
        except TransportError as error:
            raise TransportError(f"{self.name} {error}") from error
        listener.setblocking(False)
        self.contact = Contact(self.name, host, listener.getsockname()[1])
        self._listener, self._wake = listener, socket.socketpair()
        self._closing.clear()
        try:
            self._prepare()
        except GrabberError:
            self._release()
            raise
        self._acceptor = threading.Thread(target=self._accept, name=f"yarp {self.name}", daemon=True)
        self._acceptor.start()
        if self._registration:
            self._registration.announce()

    def close(self) -> None:
        """Drop all connections and the name. May be called twice; never raises."""
        if self._listener is None:
            return
        self._closing.set()
        if self._wake:
            self._wake[1].send(b"x")
        if self._acceptor:
            self._acceptor.join(10)
        with self._lock:
            inputs, outputs = list(self._inputs), list(self._outputs)
        for output in outputs:
            self._drop(output)
        for connection in inputs:
            connection.close()
        for connection in inputs:
            connection.join()
        if self._registration:
            self._registration.close()
        self._release()

    def __enter__(self) -> Port:
        self.open()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _prepare(self) -> None:
        """What must be done while it listens and before anything is accepted. Raises GrabberError."""
        if self._names:
            self._registration = Registration(self.contact, self._names)
            self._registration.open()

    def _release(self) -> None:
        for sock in (self._listener, *(self._wake or ())):
            if sock is not None:
                sock.close()
        self._listener = self._wake = self._acceptor = self._registration = None

    # -- connections -----------------------------------------------------------------------------
    @property
    def port_number(self) -> int:
        """The TCP port it listens at; 0 before it is open."""
        return self.contact.port

    @property
    def connections(self) -> int:
        """Readers connected just now; while there are none, nothing need be prepared for them."""
        return len(self._outputs)

    @property
    def sources(self) -> list[str]:
        """Names of those connected to it just now."""
        return list(self.carriers(outgoing=False))

    @property
    def dropped(self) -> int:
        """Messages that present readers were too slow for, all together."""
        with self._lock:
            return sum(output.dropped for output in self._outputs)

    def place(self) -> str:
        """`tcp://HOST:PORT/`."""
        return f"tcp://{self.contact.host}:{self.contact.port}/"

    def carriers(self, *, outgoing: bool) -> dict[str, str]:
        """The carrier of each connection, by the name at its other end."""
        with self._lock:
            if outgoing:
                return {output.reader: output.carrier_text for output in self._outputs}
            known = [connection.info for connection in self._inputs if connection.peer]
            return {info.peer: info.carrier for info in known}

    def add(self, target: Target) -> None:
        """Connect to a reader; one connected already is dropped first.

        Raises SourceNotFoundError, LocalProtocolError for a carrier or plug-in that we lack, TransportError.
        """
        carrier = wire.by_name(target.carrier)
        plug_in = target.modifiers.get("recv" if carrier.pull else "send")
        if plug_in:
            raise LocalProtocolError(f"{self.name} runs no plug-ins, {plug_in} must run at the other end")
        if carrier.pull:
            self._pull(target)
            return
        if not self.sends:
            raise TransportError("Outputs not allowed")
        address = self.locate(target.name)
        self.remove_output(target.name)
        sock = dial(self.name, target.sender(self.name), target.name, address, carrier, self.key)
        self._start(
            Output(self.name, target.name, carrier, sock, carrier_text=target.carrier, on_close=self._gone)
        )

    def locate(self, name: str) -> tuple[str, int]:
        """Host and port of a name. Raises SourceNotFoundError, SourceUnavailableError."""
        if name.startswith("//"):
            host, _, number = name[2:].rpartition(":")
            return host, int(number)
        if name == self.name:
            return self.contact.address
        if self._names is None:
            raise SourceNotFoundError(
                f"{name} cannot be looked up without a name server; write tcp://HOST:PORT/"
            )
        return self._names.query(name).address

    def remove_output(self, name: str) -> bool:
        """Drop the connections to `name`; whether there were any."""
        with self._lock:
            found = [output for output in self._outputs if output.reader == name]
        for output in found:
            self._drop(output)
        return bool(found)

    def remove_input(self, name: str) -> bool:
        """Drop the connections from `name`; whether there were any."""
        with self._lock:
            found = [connection for connection in self._inputs if connection.peer == name]
        for connection in found:
            connection.close()
        return bool(found)

    def _pull(self, target: Target) -> None:
        raise TransportError(
            f"Cannot pull from {target.name}: this port takes no input over {target.carrier}"
        )

    def _start(self, output: Output) -> None:
        with self._lock:
            self._outputs = [*self._outputs, output]
        output.start()

    def _drop(self, output: Output) -> None:
        output.close()
        self._gone(output)
        if output.carrier.datagrams and output.reader.startswith("/"):
            # Nobody notices the end of a stream of datagrams: it must be told.
            self._tell(output.reader)

    def _gone(self, output: Output) -> None:
        with self._lock:
            self._outputs = [other for other in self._outputs if other is not output]

    def _tell(self, reader: str) -> None:
        try:
            sock = sockets.connect(self.locate(reader), 1.0, self.key)
            try:
                sockets.send(sock, [f"CONNECT admin\r\n~{self.name}\r\nq\r\n".encode()])
                sock.recv(1024)
            finally:
                sock.close()
        except (GrabberError, OSError) as error:
            log.debug("%s: %s was not told of the end: %s", self.name, reader, error)

    def send(self, parts: Sequence[Buffer], envelope: str = "") -> None:
        """Give a message to every reader; never waits, and holds `parts` until all have it."""
        outputs = self._outputs
        if outputs:
            message = Outgoing(parts, envelope)
            for output in outputs:
                output.put(message)

    def wait_sent(self, timeout: float) -> bool:
        """Wait until every reader has taken up the last message: for those who must not lose any."""
        deadline = time.monotonic() + timeout
        return all(output.wait_taken(deadline - time.monotonic()) for output in self._outputs)

    # -- what inputs call ------------------------------------------------------------------------
    def admit(self, connection: Input) -> None:
        """A connection that has told its name; an older one of the same port gives way."""
        if connection.peer.startswith("/"):
            with self._lock:
                older = [
                    other
                    for other in self._inputs
                    if other is not connection and other.peer == connection.peer
                ]
            for other in older:
                other.close()

    def leave(self, connection: Input) -> None:
        """A connection that has ended."""
        with self._lock:
            self._inputs = [other for other in self._inputs if other is not connection]

    def allocate(self, size: int) -> memoryview:
        """Memory for a body; that of pictures is used again and again."""
        if size < _POOLED:
            return memoryview(bytearray(size))
        pool = self._pool
        if pool is None or pool.size != size:
            pool = self._pool = BufferPool(size, limit=8)
        buffer = pool.take()
        return memoryview((np.empty(size, np.uint8) if buffer is None else buffer).data)

    def deliver(self, request: Request) -> Reply:
        """A message for the owner; nobody takes it here."""
        return None

    def administer(self, request: Bottle) -> Bottle:
        """Answer an administrative Bottle."""
        return admin.answer(self, request)

    def line(self, command: str) -> list[str]:
        """Carry out a command of one line."""
        return admin.answer_line(self, command)

    def page(self) -> bytes:
        """What a browser gets: who is connected, and the pictures where it sends some."""
        return web_page.encode_page(self.name, self.line("*"), pictures=self.sends)

    def legacy(self, connection: Input, greeting: bytes) -> None:
        """Questions to a name server, which this is not."""
        raise RemoteProtocolError(f"{self.name} is no name server")

    def attach(self, reader: str, carrier: Carrier, sock: socket.socket) -> Callable[[], None]:
        """Send the output on a socket that a reader opened."""
        if not self.sends:
            sock.close()
            raise TransportError(f"{self.name} sends nothing")
        output = Output(self.name, reader, carrier, sock, on_close=self._gone)
        self._start(output)
        return lambda: self._drop(output)

    # -- threads ---------------------------------------------------------------------------------
    def _accept(self) -> None:
        listener, wake = self._listener, self._wake
        assert listener and wake
        while not self._closing.is_set():
            select.select([listener, wake[0]], [], [])
            try:
                sock, address = listener.accept()
            except OSError:
                continue
            sock.setblocking(True)
            with self._lock:
                full = len(self._inputs) >= INPUT_LIMIT
            if full:
                log.warning(
                    "%s: connection from %s:%d refused, %d are open", self.name, *address[:2], INPUT_LIMIT
                )
                sockets.hang_up(sock)
                continue
            self._welcome(sock)

    def _welcome(self, sock: socket.socket) -> None:
        try:
            connection = Input(self, sock)
        except OSError:  # gone before we looked
            sock.close()
            return
        with self._lock:
            self._inputs = [*self._inputs, connection]
        connection.start()


def _any(address: str) -> bool:
    return address in ("0.0.0.0", "::")
