"""What is registered for a port: connections, whose number is limited, and its name at the name server."""

from __future__ import annotations

import logging
import os
import threading
import time
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Final

from grabbergui.core.errors import GrabberError, SourceNotFoundError, TransportError
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os.inputs import Input
from grabbergui.net.yarp.os.link import describes_itself
from grabbergui.net.yarp.os.name_client import Contact, NameClient
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
    """Lines about strangers, a few a minute however many come. Any thread.

    The rest is logged one level below.
    """

    def __init__(
        self, port: str, clock: Callable[[], float] = time.monotonic, *, level: int = logging.WARNING
    ) -> None:
        self._port = port
        self._clock = clock
        self._level = level
        self._next = 0.0
        self._suppressed = 0

    def warn(self, text: str) -> None:
        """Log it; a level below if another line was logged shortly before."""
        now = self._clock()
        if now < self._next:
            self._suppressed += 1
            log.log(self._level - 10, "%s: %s", self._port, text)
            return
        more = f" ({self._suppressed} more since the last such line)" if self._suppressed else ""
        self._next, self._suppressed = now + _QUIET_SECONDS, 0
        log.log(self._level, "%s: %s%s", self._port, text, more)


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


# -- the name ------------------------------------------------------------------------------------
KEEP_SECONDS: Final = 5.0
"""Seconds between two checks whether the name server still knows a port."""

HOLDER_SECONDS: Final = 1.0
"""Longest wait for the port that has our name already: one that does not answer loses it."""

LONGEST_PAUSE: Final = 300.0
"""Longest pause in seconds between two registrations of a disputed name."""


GIVE_UP_SECONDS: Final = 2.0
"""Longest wait for a name server when a port closes; one that hangs must not hold up the end of a program."""


class Registration:
    """The name of one port, from when it opens until it closes."""

    def __init__(
        self, contact: Contact, names: NameClient, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._contact = contact
        self._names = names
        self._clock = clock
        self._closing = threading.Event()
        self._given_up = 0.0
        self._thread = threading.Thread(target=self._run, name=f"yarp {contact.name} name", daemon=True)

    def open(self) -> None:
        """Register, and keep it so; if it fails, nothing is registered.

        Raises SourceUnavailableError, TransportError if another port has the name and answers.
        """
        try:
            self._require_free()
            self._register()
        except GrabberError:
            self.give_up()
            self._thread.start()
            self.close()
            raise
        self._thread.start()

    def announce(self) -> None:
        """Register the port as listening. Never raises."""
        self._quietly(self._names.announce, self._contact.name)

    def give_up(self) -> None:
        """Begin to give the name up. Never waits."""
        if not self._closing.is_set():
            self._given_up = time.monotonic()
            self._closing.set()

    def close(self) -> None:
        """Give the name up, unless another port has it by now. Never raises.

        If the name server hangs, waits no longer than `GIVE_UP_SECONDS` after `give_up`.
        """
        self.give_up()
        self._thread.join(max(0.0, self._given_up + GIVE_UP_SECONDS - time.monotonic()))

    def _run(self) -> None:
        self._keep()
        self._quietly(self._unregister)

    def _unregister(self) -> None:
        if self._names.query(self._contact.name).address == self._contact.address:
            self._names.unregister(self._contact.name)

    def _require_free(self) -> None:
        """Raise TransportError if another port has this name. One that is gone left it behind."""
        try:
            holder = self._names.query(self._contact.name)
        except SourceNotFoundError:
            return
        if holder.address == self._contact.address:
            return
        if not describes_itself(holder.name, holder.address, self._names.key, HOLDER_SECONDS):
            log.info("%s: taken over from %s:%d, where it does not answer", holder.name, *holder.address)
            return
        process = self._names.property_of(holder.name, "process")
        raise TransportError(
            f"{holder.name} is taken by the port at {holder.host}:{holder.port}"
            f"{f', of process {process}' if process else ''}; end that program, or choose another name"
        )

    def _register(self) -> None:
        contact = self._contact
        self._names.register(contact.name, "tcp", contact.host, contact.port)
        for key in ("offers", "accepts"):
            self._names.set_property(contact.name, key, *wire.CARRIERS)
        self._names.set_property(contact.name, "ips", contact.host)
        self._names.set_property(contact.name, "process", str(os.getpid()))

    def _keep(self) -> None:
        """Register the name again when the name server forgot it or another port took it."""
        name, unreachable = self._contact.name, False
        pause, since = KEEP_SECONDS, self._clock()
        while not self._closing.wait(KEEP_SECONDS):
            try:
                known = self._names.query(name)
                unreachable = False
                if self._clock() - since < pause:
                    continue
                since = self._clock()
                if known.address == self._contact.address:
                    pause = max(KEEP_SECONDS, pause / 2)
                    continue
                # Back off: two ports with one name must not load the name server.
                pause = min(2 * pause, LONGEST_PAUSE)
                log.warning(
                    "%s: %s:%d took this name at the name server; it is registered again, and if it is taken "
                    "again, in %g s",
                    *(name, *known.address, pause),
                )
                self._register()
            except SourceNotFoundError:
                if self._quietly(self._register):
                    log.info("%s: registered again", name)
            except GrabberError as error:
                if not unreachable:
                    log.warning("%s: %s", name, error)
                unreachable = True

    def _quietly(self, action: Callable[..., object], *arguments: str) -> bool:
        """Do something that may fail; return whether it succeeded."""
        try:
            action(*arguments)
        except GrabberError as error:
            log.debug("%s: %s", self._contact.name, error)
            return False
        return True
