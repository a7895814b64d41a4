"""Accepts connections of a port, lists them, and limits what strangers may use: connections and log lines."""

from __future__ import annotations

import logging
import selectors
import socket
import threading
import time
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Final

from grabbergui.core.errors import ResourceExhaustedError, TransportError
from grabbergui.net.yarp.os import sockets
from grabbergui.net.yarp.os.inputs import Input
from grabbergui.net.yarp.os.outputs import Output

log = logging.getLogger(__name__)
Connection = Input | Output

# -- limits --------------------------------------------------------------------------------------
PORT_LIMIT: Final = 200
"""Connections of one port at a time, in both directions together. Each costs a thread and a descriptor."""

ADDRESS_LIMIT: Final = 64
"""Those of them that lead to one address."""

_CROWD: Final = 8
"""Connections to one address of which one is closed when this process runs out of descriptors."""

_QUIET_SECONDS: Final = 10.0
"""Between two log entries of one port about strangers, so that a flood does not fill the log."""


def _displaced(connections: Sequence[Connection], address: str) -> Connection | None:
    """Return the connection to close for a new one from `address`; None while there is room.

    An address at its limit loses its longest idle connection. A full port closes the longest idle connection
    of the address that has the most.
    """
    own = [connection for connection in connections if connection.address == address]
    if len(own) >= ADDRESS_LIMIT:
        return _idlest(own)
    if len(connections) < PORT_LIMIT:
        return None
    return _idlest(_largest_group(connections))


def _expendable(connections: Sequence[Connection]) -> Connection | None:
    """Return one to close so that descriptors become free; None where no address has a crowd of them."""
    group = _largest_group(connections)
    return _idlest(group) if len(group) > _CROWD else None


def _idlest(connections: Sequence[Connection]) -> Connection:
    """Return the one that never carried a message, else whose last message is longest ago."""
    return min(connections, key=lambda connection: (connection.messages > 0, connection.active))


def _largest_group(connections: Sequence[Connection]) -> list[Connection]:
    counts = Counter(connection.address for connection in connections)
    crowd = counts.most_common(1)[0][0] if counts else ""
    return [connection for connection in connections if connection.address == crowd]


# -- log about strangers -------------------------------------------------------------------------
class StrangerLog:
    """Warnings about strangers, a few a minute however many come; the rest is logged as info. Any thread."""

    def __init__(self, port: str, clock: Callable[[], float] = time.monotonic) -> None:
        self._port = port
        self._clock = clock
        self._next = 0.0
        self._suppressed = 0

    def warn(self, text: str) -> None:
        """Log it as a warning; as info if another was logged shortly before."""
        now = self._clock()
        if now < self._next:
            self._suppressed += 1
            log.info("%s: %s", self._port, text)
            return
        more = f" ({self._suppressed} more since the last such line)" if self._suppressed else ""
        self._next, self._suppressed = now + _QUIET_SECONDS, 0
        log.warning("%s: %s%s", self._port, text, more)


# -- the connections -----------------------------------------------------------------------------
class Registry:
    """The connections of one port in both directions. Any thread."""

    def __init__(self, strangers: StrangerLog) -> None:
        self.connections: list[Connection] = []
        "Replaced by every change, never changed, so that it can be read without the lock."
        self._strangers = strangers
        self._lock = threading.RLock()
        self._closed = False

    @property
    def inputs(self) -> list[Input]:
        """The connections that others opened."""
        return [connection for connection in self.connections if isinstance(connection, Input)]

    @property
    def outputs(self) -> list[Output]:
        """The connections to readers."""
        return [connection for connection in self.connections if isinstance(connection, Output)]

    def reopen(self) -> None:
        """Accept connections, again after `close`."""
        self._closed = False

    def close(self) -> list[Input]:
        """Accept no further connections; return the incoming ones, which the caller closes."""
        with self._lock:
            self._closed = True
            return self.inputs

    def add(self, connection: Connection, *, replaces: Input | None = None) -> None:
        """Add a connection that is not started yet, and close another if it is one too many.

        A connection that `replaces` another, because a reader reversed it, takes its place. Raises
        TransportError if the other connection or the port was closed.
        """
        with self._lock:
            if self._closed:
                raise TransportError("the port was closed")
            if replaces is None:
                self._make_room(connection.address)
            elif replaces not in self.connections:
                raise TransportError("the connection was closed for a newer one")
            else:
                self.remove(replaces)
            self.connections = [*self.connections, connection]

    def remove(self, connection: Connection) -> None:
        """Remove a connection, if it is there."""
        with self._lock:
            self.connections = [other for other in self.connections if other is not connection]

    def shut_down(self, connection: Connection) -> None:
        """Close a connection without waiting for its thread, and remove it."""
        connection.abort()
        self.remove(connection)

    def _make_room(self, address: str) -> None:
        """Close a connection if one more with `address` would be too many."""
        victim = _displaced(self.connections, address)
        if victim is not None:
            self._strangers.warn(
                f"a connection with {victim.address} was closed for a newer one with {address}: at most "
                f"{PORT_LIMIT} are open, {ADDRESS_LIMIT} with one address"
            )
            self.shut_down(victim)

    def free_resources(self, reason: str) -> None:
        """Close the idlest connection of a crowd from one address, so that another peer can connect."""
        victim = _expendable(self.connections)
        if victim is not None:
            self.shut_down(victim)
        closed = f"; the idlest connection with {victim.address} was closed" if victim else ""
        self._strangers.warn(f"nobody can connect: {reason}{closed}")


# -- accepting -----------------------------------------------------------------------------------
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
