"""A port: a name, a listening socket, connections in and out, and what is said about them.

Threads: one accepts, one keeps the name registered, each connection has its own. All public methods may be
called from any thread.
"""

from __future__ import annotations

import logging
import selectors
import socket
import threading
import time
from collections.abc import Sequence
from typing import Final

import numpy as np

from grabbergui.config.allowed_addresses import EVERYBODY, AllowedAddresses
from grabbergui.core.buffers import BufferPool
from grabbergui.core.errors import (
    GrabberError,
    LocalProtocolError,
    RemoteProtocolError,
    ResourceExhaustedError,
    SourceNotFoundError,
    TransportError,
)
from grabbergui.net.yarp.os import admin, sockets, web_page
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os.bottle import Bottle, Buffer
from grabbergui.net.yarp.os.carrier import Carrier
from grabbergui.net.yarp.os.inputs import Input
from grabbergui.net.yarp.os.link import Link, report_end
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.names import Contact, Target, check_port_name
from grabbergui.net.yarp.os.outputs import Outgoing, Output, connect
from grabbergui.net.yarp.os.registration import Registration
from grabbergui.net.yarp.os.registry import Registry, StrangerLog
from grabbergui.net.yarp.os.request import Reply, Request
from grabbergui.net.yarp.os.values import Item

log = logging.getLogger(__name__)

_POOLED: Final = 1 << 16
_MOST_REFUSALS: Final = 32
"""Reasons to refuse a connection that are warned of."""
_PAUSE_SECONDS: Final = 0.2
"""Before the next connection is accepted when descriptors or threads were used up."""

# Neither takes a descriptor of its own, and polling knows no highest one.
_Selector = getattr(selectors, "PollSelector", selectors.SelectSelector)


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
        allowed: AllowedAddresses = EVERYBODY,
    ) -> None:
        """Make a port; `open` starts it.

        Without `names` it is reached as `tcp://HOST:PORT/` only. `bind` is the address to listen at; by
        default the one from which the name server is reached, loopback without one. Peers that are not
        `allowed` are neither answered nor sent to.
        """
        self.name = check_port_name(name)
        self.limit = limit
        self.properties: dict[str, Item] = {}
        self.contact = Contact(self.name, "", 0)
        "Where it listens, once open."
        self.key = names.key if names else None
        self._names = names
        self._allowed = allowed
        self._strangers = StrangerLog(self.name)
        self._wish = (bind, port)
        self._registry = Registry(self._strangers)
        self._listener: socket.socket | None = None
        self._wake: tuple[socket.socket, socket.socket] | None = None
        self._closing = threading.Event()
        self._acceptor: threading.Thread | None = None
        self._registration: Registration | None = None
        self._pool: BufferPool | None = None
        self._refusals: set[str] = set()
        "Reasons that were warned of."

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
        inputs = self._registry.inputs
        for output in self._registry.outputs:
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
        return len(self._registry.outputs)

    @property
    def sources(self) -> list[str]:
        """Names of those connected to it just now."""
        return list(self.carriers(outgoing=False))

    @property
    def dropped(self) -> int:
        """Messages that present readers were too slow for, all together."""
        return sum(output.dropped for output in self._registry.outputs)

    def place(self) -> str:
        """`tcp://HOST:PORT/`."""
        return f"tcp://{self.contact.host}:{self.contact.port}/"

    def carriers(self, *, outgoing: bool) -> dict[str, str]:
        """The carrier of each connection, by the name at its other end."""
        return self._registry.carriers(outgoing=outgoing)

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
        if not self._allowed.allows(address[0], self.contact.host):
            raise TransportError(f"{address[0]} is not among the allowed addresses ({self._allowed})")
        self.remove_output(target.name)
        link = connect(self.name, target.sender(self.name), target.name, address, carrier, self.key)
        self._start(self._output(target.name, carrier, link, target.carrier))

    def note_refusal(self, name: str, error: GrabberError) -> None:
        """Log a connection that somebody asked for in vain; a carrier or plug-in that we lack as a warning.

        Each is warned of once, so that whoever tries again and again does not fill the log.
        """
        level, reason = logging.INFO, str(error)
        known = reason in self._refusals or len(self._refusals) >= _MOST_REFUSALS
        if isinstance(error, LocalProtocolError) and not known:
            self._refusals.add(reason)
            level = logging.WARNING
        log.log(level, "%s: no connection to %s: %s", self.name, name, error)

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
        found = self._registry.outputs_to(name)
        for output in found:
            self._drop(output)
        return bool(found)

    def remove_input(self, name: str) -> bool:
        """Drop the connections from `name`; whether there were any."""
        found = self._registry.inputs_from(name)
        for connection in found:
            connection.close()
        return bool(found)

    def _pull(self, target: Target) -> None:
        raise TransportError(
            f"Cannot pull from {target.name}: this port takes no input over {target.carrier}"
        )

    def _output(self, reader: str, carrier: Carrier, link: Link, carrier_text: str = "") -> Output:
        return Output(
            self.name, reader, carrier, link, carrier_text=carrier_text, on_close=self._registry.remove
        )

    def _start(self, output: Output, replaces: Input | None = None) -> None:
        try:
            self._registry.add(output, replaces=replaces)
            output.start()
        except GrabberError:
            output.abort()
            self._registry.remove(output)
            raise

    def _drop(self, output: Output) -> None:
        output.close()
        self._registry.remove(output)
        if output.carrier.datagrams and output.reader.startswith("/"):
            try:
                report_end(self.name, self.locate(output.reader), self.key)
            except GrabberError as error:
                log.debug("%s: %s does not know of the end: %s", self.name, output.reader, error)

    def send(self, parts: Sequence[Buffer], envelope: str = "") -> None:
        """Give a message to every reader; never waits, and holds `parts` until all have it."""
        outputs = self._registry.outputs
        if outputs:
            message = Outgoing(parts, envelope)
            for output in outputs:
                output.put(message)

    def wait_sent(self, timeout: float) -> bool:
        """Wait until every reader has taken up the last message: for those who must not lose any."""
        deadline = time.monotonic() + timeout
        return all(output.wait_taken(deadline - time.monotonic()) for output in self._registry.outputs)

    # -- what inputs call ------------------------------------------------------------------------
    def register(self, connection: Input) -> None:
        """Accept a connection whose sender is known, and close any older connection from the same port."""
        if connection.peer.startswith("/"):
            for other in self._registry.inputs_from(connection.peer):
                if other is not connection:
                    other.close()

    def unregister(self, connection: Input) -> None:
        """Forget a connection that has ended."""
        self._registry.remove(connection)

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

    def answer_name_query(self, line: str, asker: str) -> str:
        """Refuse a line to a name server, which this port is not."""
        raise RemoteProtocolError(f"{self.name} is no name server")

    def attach(self, reader: str, carrier: Carrier, link: Link, *, replaces: Input | None = None) -> Output:
        """Send the output on a connection that a reader opened, and reversed if it `replaces` its input.

        Raises GrabberError.
        """
        if not self.sends:
            link.sock.close()
            raise TransportError(f"{self.name} sends nothing")
        output = self._output(reader, carrier, link)
        self._start(output, replaces)
        return output

    # -- threads ---------------------------------------------------------------------------------
    def _accept(self) -> None:
        listener, wake = self._listener, self._wake
        assert listener and wake
        with _Selector() as selector:
            selector.register(listener, selectors.EVENT_READ)
            selector.register(wake[0], selectors.EVENT_READ)
            while not self._closing.is_set():
                selector.select()
                try:
                    sock, address = listener.accept()
                except OSError as error:
                    if failure := ResourceExhaustedError.of(error):
                        self._wait_for_resources(str(failure))
                    continue
                sock.setblocking(True)
                if self._allowed.allows(address[0], sock.getsockname()[0]):
                    self._welcome(sock, address[0])
                else:
                    self._strangers.warn(f"connection from {address[0]} refused, allowed are {self._allowed}")
                    sockets.shut_down(sock)

    def _welcome(self, sock: socket.socket, address: str) -> None:
        try:
            connection = Input(self, sock)
        except OSError:  # the peer has closed it already
            sock.close()
            return
        self._registry.add(connection)
        try:
            connection.start()
        except RuntimeError:
            self._registry.shut_down(connection)
            sock.close()
            self._wait_for_resources(sockets.NO_MORE_THREADS)

    def _wait_for_resources(self, reason: str) -> None:
        """Close a connection if possible, and pause before the next peer."""
        self._registry.free_resources(reason)
        self._closing.wait(_PAUSE_SECONDS)


def _any(address: str) -> bool:
    return address in ("0.0.0.0", "::")
