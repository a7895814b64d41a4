"""A port: a name, a listening socket, and its connections in both directions.

Threads: one accepts, one keeps the name registered, each connection has its own. All public methods may be
called from any thread. `Listener` accepts, `Readers` sends, `Input` receives, `Registry` limits both, and
`PortCommands` answers administrative requests.
"""

from __future__ import annotations

import selectors
import socket
import threading
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final

from grabbergui.config import EVERYBODY, AllowedAddresses
from grabbergui.core.errors import (
    GrabberError,
    LocalProtocolError,
    ResourceExhaustedError,
    SourceNotFoundError,
    TransportError,
)
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os import sockets
from grabbergui.net.yarp.os.admin import PortCommands
from grabbergui.net.yarp.os.bottle import Buffer
from grabbergui.net.yarp.os.carrier import Carrier, Target, check_port_name, literal_address
from grabbergui.net.yarp.os.inputs import Input, Reply, Request
from grabbergui.net.yarp.os.link import Link
from grabbergui.net.yarp.os.name_client import Contact, NameClient, Registration
from grabbergui.net.yarp.os.outputs import Output
from grabbergui.net.yarp.os.registry import Readers, Registry, StrangerLog
from grabbergui.net.yarp.os.values import Item

if TYPE_CHECKING:
    from grabbergui.core.frame import BufferPool

NO_OUTPUT: Final = "Outputs not allowed"
"""YARP's answer of a port that sends nothing."""

END_SECONDS: Final = 5.0
"""Longest wait for requests in progress when a port closes, all of them together."""

_POOLED: Final = 1 << 16
"""Size in bytes from which the memory of bodies is reused."""


class Port:
    """A YARP port. `OutputPort`, `InputPort` and `RpcServer` are the kinds to use."""

    sends = True
    "Whether readers may be connected to it."

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
        default the one from which the name server is reached, or loopback without a name server. Peers that
        are not `allowed` are neither answered nor sent to.
        """
        self.name = check_port_name(name)
        self.limit = limit
        self.properties: dict[str, Item] = {}
        self.contact = Contact(self.name, "", 0)
        "Address on which the port listens, once open."
        self.key = names.key if names else None
        self.commands = PortCommands(self, images=self.sends)
        "Answers administrative requests."
        self._names = names
        self._allowed = allowed
        self._strangers = StrangerLog(self.name)
        self._address = (bind, port)
        self._registry = Registry(self._strangers)
        self._readers = Readers(self.name, self._registry, self.locate, allowed, self.key)
        self._listener = Listener(self.name, self._welcome, self._registry.free_resources)
        self._registration: Registration | None = None
        self._pool: BufferPool | None = None

    # -- life ------------------------------------------------------------------------------------
    def open(self) -> None:
        """Listen and register. Leaves nothing open if it raises SourceUnavailableError or TransportError."""
        bind, port = self._address
        if not bind:
            bind = sockets.local_address_towards(*self._names.server.address) if self._names else "127.0.0.1"
        host = bind
        if self._names and bind in ("0.0.0.0", "::"):
            host = sockets.local_address_towards(*self._names.server.address)
        try:
            self.contact = Contact(self.name, host, self._listener.open((bind, port)))
        except TransportError as error:
            raise TransportError(f"{self.name} {error}") from error
        try:
            self._prepare()
        except GrabberError:
            self._listener.close()
            self._registration = None
            raise
        self._registry.reopen()
        self._listener.start()
        if self._registration:
            self._registration.announce()

    def give_up_name(self) -> None:
        """Start to unregister the name, so that a later `close` hardly waits. Returns immediately."""
        if self._registration:
            self._registration.give_up()

    def close(self) -> None:
        """Close all connections, and unregister the name. May be called twice; never raises."""
        if not self._listener.is_open:
            return
        self._listener.stop()
        inputs = self._registry.close()
        self._readers.close()
        for connection in inputs:
            connection.close()
        deadline = time.monotonic() + END_SECONDS
        for connection in inputs:
            connection.join(deadline)
        if self._registration:
            self._registration.close()
            self._registration = None
        self._listener.close()

    def __enter__(self) -> Port:
        self.open()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _prepare(self) -> None:
        """Register the name, after it listens and before anything is accepted. Raises GrabberError."""
        if self._names:
            self._registration = Registration(self.contact, self._names)
            self._registration.open()

    def _welcome(self, sock: socket.socket, address: str) -> None:
        """Serve an accepted connection. Raises ResourceExhaustedError if there is no thread left."""
        if not self._allowed.allows(address, sock.getsockname()[0]):
            self._strangers.warn(f"connection from {address} refused; allowed: {self._allowed}")
            sockets.shut_down(sock)
            return
        try:
            connection = Input(self, sock)
        except OSError:  # the peer has closed it already
            sock.close()
            return
        self._registry.add(connection)
        try:
            connection.start()
        except RuntimeError as error:
            self._registry.shut_down(connection)
            sock.close()
            raise ResourceExhaustedError(sockets.NO_MORE_THREADS) from error

    # -- connections -----------------------------------------------------------------------------
    @property
    def port_number(self) -> int:
        """The TCP port at which it listens; 0 before it is open."""
        return self.contact.port

    def place(self) -> str:
        """`tcp://HOST:PORT/`."""
        return f"tcp://{self.contact.host}:{self.contact.port}/"

    @property
    def connections(self) -> int:
        """Number of connected readers; without any, no message needs to be prepared."""
        return len(self._readers)

    @property
    def sources(self) -> list[str]:
        """Names of the connected sources."""
        return list(self.carriers(outgoing=False))

    @property
    def dropped(self) -> int:
        """Messages for which connected readers were too slow, in total."""
        return self._readers.dropped

    def carriers(self, *, outgoing: bool) -> dict[str, str]:
        """Return the carrier of each connection, by the name at its other end."""
        return self._registry.carriers(outgoing=outgoing)

    def locate(self, name: str) -> tuple[str, int]:
        """Return host and port of a name. Raises SourceNotFoundError, SourceUnavailableError."""
        if literal := literal_address(name):
            return literal[1:]
        if name == self.name:
            return self.contact.address
        if self._names is None:
            raise SourceNotFoundError(
                f"{name} cannot be looked up without a name server; write tcp://HOST:PORT/"
            )
        return self._names.query(name).address

    def add(self, target: Target) -> None:
        """Connect to a reader, replacing an existing connection to it.

        Raises SourceNotFoundError, LocalProtocolError for a carrier or plug-in that we lack, TransportError.
        """
        pull = wire.by_name(target.carrier).pull
        plug_in = target.modifiers.get("recv" if pull else "send")
        if plug_in:
            raise LocalProtocolError(f"{self.name} runs no plug-ins, {plug_in} must run at the other end")
        if pull:
            self._pull(target)
        elif self.sends:
            self._readers.connect(target, self.contact.host)
        else:
            raise TransportError(NO_OUTPUT)

    def _pull(self, target: Target) -> None:
        raise TransportError(
            f"Cannot pull from {target.name}: this port takes no input over {target.carrier}"
        )

    def remove_output(self, name: str) -> bool:
        """Close the connections to `name`; return whether there were any."""
        return self._readers.disconnect(name)

    def remove_input(self, name: str) -> bool:
        """Close the connections from `name`; return whether there were any."""
        found = self._registry.inputs_from(name)
        for connection in found:
            connection.close()
        return bool(found)

    def asked_for(self, modifier: str) -> frozenset[str]:
        """Return the values that readers' carriers give to a modifier; an empty one of those without it."""
        return self._readers.asked_for(modifier)

    def send(
        self, parts: Sequence[Buffer], envelope: str = "", *, only: tuple[str, str] | None = None
    ) -> None:
        """Pass a message to every reader, or `only` to those that give a modifier this value.

        Never waits, and holds `parts` until all readers have it.
        """
        self._readers.send(parts, envelope, only=only)

    def wait_sent(self, timeout: float) -> bool:
        """Wait until no message waits for a reader; return whether that was so within `timeout` seconds."""
        return self._readers.wait_sent(timeout)

    # -- owner of its inputs ---------------------------------------------------------------------
    def register(self, connection: Input) -> None:
        """Accept a connection whose sender is known, and close any older connection from the same port."""
        if connection.peer.startswith("/"):
            for other in self._registry.inputs_from(connection.peer):
                if other is not connection:
                    other.close()

    def unregister(self, connection: Input) -> None:
        """Forget a connection that has ended."""
        self._registry.remove(connection)

    def warn(self, text: str) -> None:
        """Log a peer's fault, at a limited rate."""
        self._strangers.warn(text)

    def allocate(self, size: int) -> memoryview:
        """Return memory for a body; that of images is reused."""
        if size < _POOLED:
            return memoryview(bytearray(size))
        import numpy as np  # a name server receives no images

        from grabbergui.core.frame import BufferPool

        pool = self._pool
        if pool is None or pool.size != size:
            pool = self._pool = BufferPool(size, limit=8)
        buffer = pool.take()
        return memoryview((np.empty(size, np.uint8) if buffer is None else buffer).data)

    def deliver(self, request: Request) -> Reply:
        """Pass a message to the port's user and return the reply; this port has no user."""
        return None

    def attach(
        self,
        reader: str,
        carrier: Carrier,
        link: Link,
        *,
        replaces: Input | None = None,
        on_made: Callable[[Output], None] | None = None,
    ) -> Output:
        """Send the output on a connection that a reader opened, and reversed if it `replaces` its input.

        `on_made` gets the output before it is listed and sends. Raises GrabberError.
        """
        if not self.sends:
            link.close()
            raise TransportError(f"{self.name} sends nothing")
        return self._readers.attach(reader, carrier, link, replaces=replaces, on_made=on_made)


_PAUSE_SECONDS: Final = 0.2
"""Pause before the next connection is accepted after descriptors or threads ran out."""

# Neither needs a descriptor of its own, and poll has no highest one.
_Selector = getattr(selectors, "PollSelector", selectors.SelectSelector)


class Listener:
    """Accepts connections until closed.

    `on_connection` is called with a socket and the peer's IP address, on the listener's thread. If it raises
    ResourceExhaustedError, or there is no descriptor for a connection, `on_shortage` is called with the
    reason, and the listener pauses.
    """

    def __init__(
        self,
        name: str,
        on_connection: Callable[[socket.socket, str], None],
        on_shortage: Callable[[str], None],
    ) -> None:
        self._name = name
        self._on_connection = on_connection
        self._on_shortage = on_shortage
        self._closing = threading.Event()
        self._socket: socket.socket | None = None
        self._wake: tuple[socket.socket, socket.socket] | None = None
        self._thread: threading.Thread | None = None

    @property
    def is_open(self) -> bool:
        """Whether it listens."""
        return self._socket is not None

    def open(self, address: tuple[str, int]) -> int:
        """Listen, and return the port number. Connections wait until `start`. Raises TransportError."""
        self._socket = sockets.listen(address)
        self._socket.setblocking(False)
        try:
            self._wake = socket.socketpair()
        except OSError as error:
            self.close()
            raise ResourceExhaustedError.of(error) or TransportError(sockets.reason(error)) from error
        self._closing.clear()
        return int(self._socket.getsockname()[1])

    def start(self) -> None:
        """Accept connections from now on."""
        self._thread = threading.Thread(target=self._accept, name=f"yarp {self._name}", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Stop accepting connections, but keep the address. Waits for the thread."""
        self._closing.set()
        if self._wake:
            self._wake[1].send(b"x")
        if self._thread:
            self._thread.join(10)

    def close(self) -> None:
        """Give the address up. May be called twice."""
        for sock in (self._socket, *(self._wake or ())):
            if sock is not None:
                sock.close()
        self._socket = self._wake = self._thread = None

    def _accept(self) -> None:
        listener, wake = self._socket, self._wake
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
                        self._pause(str(failure))
                    continue
                sock.setblocking(True)
                try:
                    self._on_connection(sock, address[0])
                except ResourceExhaustedError as error:
                    self._pause(str(error))

    def _pause(self, reason: str) -> None:
        self._on_shortage(reason)
        self._closing.wait(_PAUSE_SECONDS)
