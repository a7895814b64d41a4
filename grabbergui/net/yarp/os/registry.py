"""The registrations of a port: connections, whose number is limited, and its name at the name server."""

from __future__ import annotations

import logging
import threading

from grabbergui.core.errors import GrabberError, TransportError
from grabbergui.net.yarp.os.connection_limits import (
    ADDRESS_LIMIT,
    PORT_LIMIT,
    Connection,
    displaced,
    expendable,
)
from grabbergui.net.yarp.os.inputs import Input
from grabbergui.net.yarp.os.outputs import Output
from grabbergui.net.yarp.os.stranger_log import StrangerLog

log = logging.getLogger(__name__)


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
        """Add a connection and start it; close another if it is one too many.

        A connection that `replaces` another, because a reader reversed it, takes its place. Raises
        TransportError if the other connection or the port was closed, ResourceExhaustedError if there is no
        thread left; the connection is closed then.
        """
        try:
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
            connection.start()
        except GrabberError:
            self.shut_down(connection)
            raise

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
        victim = displaced(self.connections, address)
        if victim is not None:
            self._strangers.warn(
                f"a connection with {victim.address} was closed for a newer one with {address}: at most "
                f"{PORT_LIMIT} are open, {ADDRESS_LIMIT} with one address"
            )
            self.shut_down(victim)

    def free_resources(self, reason: str) -> None:
        """Close the idlest connection of a crowd from one address, so that another peer can connect."""
        victim = expendable(self.connections)
        if victim is not None:
            self.shut_down(victim)
        closed = f"; the idlest connection with {victim.address} was closed" if victim else ""
        self._strangers.warn(f"nobody can connect: {reason}{closed}")
