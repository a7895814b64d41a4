"""The connections of a port, and limits on what peers may use: connections, log lines, processor time."""

from __future__ import annotations

import logging
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Final, Protocol, TypeVar

from grabbergui.config import AllowedAddresses
from grabbergui.core.errors import GrabberError, TransportError
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os.bottle import Buffer
from grabbergui.net.yarp.os.carrier import Carrier, Target
from grabbergui.net.yarp.os.link import Link, report_end, tell_all
from grabbergui.net.yarp.os.outputs import Outgoing, Output, connect

log = logging.getLogger(__name__)

# -- limits --------------------------------------------------------------------------------------
PORT_LIMIT: Final = 200
"""Connections of one port at a time, in both directions together. Each costs a thread and a descriptor."""

ADDRESS_LIMIT: Final = 64
"""Those of them that lead to one address."""

_CROWD: Final = 8
"""Connections to one address of which one is closed when this process runs out of descriptors."""

_QUIET_SECONDS: Final = 10.0
"""Between two log entries of one port about strangers, so that a flood does not fill the log."""


class _Judged(Protocol):
    """A connection as the limits see it."""

    @property
    def address(self) -> str:
        """The peer's IP address."""

    @property
    def messages(self) -> int:
        """Messages that it carried so far."""

    @property
    def active(self) -> float:
        """Time (`time.monotonic`) of the last message, or of the opening."""


class Incoming(_Judged, Protocol):
    """A connection that another opened."""

    @property
    def peer(self) -> str:
        """The sender's name, empty before the header."""

    @property
    def carrier(self) -> str:
        """The carrier with its modifiers, empty before the header."""

    def close(self) -> None:
        """Shut it down, without waiting for its thread."""

    def join(self, deadline: float) -> None:
        """Wait until its thread has ended, but not beyond a time of `time.monotonic`."""


_Connection = TypeVar("_Connection", bound=_Judged)


def _displaced(connections: Sequence[_Connection], address: str) -> _Connection | None:
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


def _expendable(connections: Sequence[_Connection]) -> _Connection | None:
    """Return one to close so that descriptors become free; None where no address has a crowd of them."""
    group = _largest_group(connections)
    return _idlest(group) if len(group) > _CROWD else None


def _idlest(connections: Sequence[_Connection]) -> _Connection:
    """Return the one that never carried a message, else whose last message is longest ago."""
    return min(connections, key=lambda connection: (connection.messages > 0, connection.active))


def _largest_group(connections: Sequence[_Connection]) -> list[_Connection]:
    counts = Counter(connection.address for connection in connections)
    crowd = counts.most_common(1)[0][0] if counts else ""
    return [connection for connection in connections if connection.address == crowd]


REPORT_SECONDS: Final = 1.0
"""Longest wait for udp readers when a port closes; one that hangs must not hold up the end of a program."""


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


# -- the processor -------------------------------------------------------------------------------
REST: Final = 3.0
"""Seconds of rest after each second of work: peers' computing takes a quarter of a core at most."""

_FREE_SECONDS: Final = 0.002
"""Work shorter than this needs no rest."""

_QUEUES: Final = 64


class CostlyWork:
    """Lets peers' costly requests run one at a time, with rests: turns for the whole process.

    Python runs one thread at a time and changes between busy ones every 5 ms: eight peers whose requests only
    compute would leave the stream a ninth of the processor. No address has more than one place in the queue.
    Work that waits for the camera does not belong here.
    """

    def __init__(
        self,
        clock: Callable[[], float] = time.monotonic,
        work_clock: Callable[[], float] = time.thread_time,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._clock = clock
        self._work_clock = work_clock
        self._sleep = sleep
        self._turn = threading.Lock()
        self._next = 0.0
        "When the rest after the last turn is over."
        self._queues = [threading.Lock() for _ in range(_QUEUES)]
        "By address, so that one with many connections waits as long as one with a single connection."

    @contextmanager
    def turn(self, address: str) -> Iterator[None]:
        """Wait for a turn, and run the block in it. Any thread."""
        with self._queues[hash(address) % _QUEUES], self._turn:
            rest = self._next - self._clock()
            if rest > 0:
                self._sleep(rest)
            begun = self._work_clock()
            try:
                yield
            finally:
                spent = self._work_clock() - begun
                if spent > _FREE_SECONDS:
                    self._next = self._clock() + REST * spent


costly_work = CostlyWork()
"""The process's own."""


# -- the connections -----------------------------------------------------------------------------
class Registry:
    """The connections of one port in both directions. Any thread."""

    def __init__(self, strangers: StrangerLog) -> None:
        self.inputs: list[Incoming] = []
        "Replaced by every change, never changed, so that it can be read without the lock."
        self.outputs: list[Output] = []
        "Like `inputs`."
        self._strangers = strangers
        self._lock = threading.RLock()
        self._closed = False

    def reopen(self) -> None:
        """Accept connections, again after `close`."""
        self._closed = False

    def close(self) -> list[Incoming]:
        """Accept no further connections; return the incoming ones, which the caller closes."""
        with self._lock:
            self._closed = True
            return self.inputs

    def all(self) -> list[Incoming | Output]:
        """Return the connections in both directions."""
        with self._lock:
            return [*self.inputs, *self.outputs]

    def carriers(self, *, outgoing: bool) -> dict[str, str]:
        """Return the carrier of each connection, by the name at its other end."""
        if outgoing:
            return {output.reader: output.carrier_text for output in self.outputs}
        return {connection.peer: connection.carrier for connection in self.inputs if connection.peer}

    def outputs_to(self, reader: str) -> list[Output]:
        """Return the connections to a reader."""
        return [output for output in self.outputs if output.reader == reader]

    def inputs_from(self, sender: str) -> list[Incoming]:
        """Return the connections from a sender."""
        return [connection for connection in self.inputs if connection.peer == sender]

    def add(self, connection: Incoming | Output, *, replaces: Incoming | None = None) -> None:
        """Add a connection that is not started yet, and close another if it is one too many.

        A connection that `replaces` another, because a reader reversed it, takes its place and age. Raises
        TransportError if the other connection or the port was closed.
        """
        with self._lock:
            if self._closed:
                raise TransportError("the port was closed")
            if replaces is None:
                self._make_room(connection.address)
            elif replaces not in self.inputs:
                raise TransportError("the connection was closed for a newer one")
            else:
                self.remove(replaces)
            if isinstance(connection, Output):
                connection.active = replaces.active if replaces else connection.active
                self.outputs = [*self.outputs, connection]
            else:
                self.inputs = [*self.inputs, connection]

    def remove(self, connection: Incoming | Output) -> None:
        """Remove a connection, if it is there."""
        with self._lock:
            if isinstance(connection, Output):
                self.outputs = [other for other in self.outputs if other is not connection]
            else:
                self.inputs = [other for other in self.inputs if other is not connection]

    def shut_down(self, connection: Incoming | Output) -> None:
        """Close a connection without waiting for its thread, and remove it."""
        if isinstance(connection, Output):
            connection.abort()
        else:
            connection.close()
        self.remove(connection)

    def _make_room(self, address: str) -> None:
        """Close a connection if one more with `address` would be too many."""
        victim = _displaced(self.all(), address)
        if victim is not None:
            self._strangers.warn(
                f"a connection with {victim.address} was closed for a newer one with {address}: at most "
                f"{PORT_LIMIT} are open, {ADDRESS_LIMIT} with one address"
            )
            self.shut_down(victim)

    def free_resources(self, reason: str) -> None:
        """Close the idlest connection of a crowd from one address, so that another peer can connect."""
        victim = _expendable(self.all())
        if victim is not None:
            self.shut_down(victim)
        closed = f"; the idlest connection with {victim.address} was closed" if victim else ""
        self._strangers.warn(f"nobody can connect: {reason}{closed}")


class Readers:
    """The outgoing connections of one port. Any thread.

    `locate` returns the host and TCP port of a name. `key` is that of `auth.conf`.
    """

    def __init__(
        self,
        source: str,
        registry: Registry,
        locate: Callable[[str], tuple[str, int]],
        allowed: AllowedAddresses,
        key: bytes | None,
    ) -> None:
        self._source = source
        self._registry = registry
        self._locate = locate
        self._allowed = allowed
        self._key = key

    def __len__(self) -> int:
        return len(self._registry.outputs)

    @property
    def dropped(self) -> int:
        """Messages for which connected readers were too slow, in total."""
        return sum(output.dropped for output in self._registry.outputs)

    def connect(self, target: Target, own_host: str) -> None:
        """Connect to a reader, replacing an existing connection to it.

        Raises SourceNotFoundError, LocalProtocolError for a carrier that we lack, TransportError.
        """
        carrier = wire.by_name(target.carrier)
        address = self._locate(target.name)
        if not self._allowed.allows(address[0], own_host):
            raise TransportError(f"{address[0]} is not among the allowed addresses ({self._allowed})")
        self.disconnect(target.name)
        sender = target.sender(self._source)
        link = connect(self._source, sender, target.name, address, carrier, self._key)
        self._start(
            Output(
                self._source,
                target.name,
                carrier,
                link,
                carrier_text=target.carrier,
                listens_at=address,
                on_close=self._registry.remove,
            )
        )

    def attach(
        self,
        reader: str,
        carrier: Carrier,
        link: Link,
        *,
        replaces: Incoming | None = None,
        on_made: Callable[[Output], None] | None = None,
    ) -> Output:
        """Send on a connection that a reader opened, and reversed if it `replaces` its input.

        `on_made` gets the output before it is listed and sends. Raises GrabberError.
        """
        output = Output(self._source, reader, carrier, link, on_close=self._registry.remove)
        if on_made is not None:
            on_made(output)
        self._start(output, replaces)
        return output

    def disconnect(self, name: str) -> bool:
        """Close the connections to `name`; return whether there were any."""
        found = self._registry.outputs_to(name)
        for output in found:
            self._close(output)
        return bool(found)

    def close(self) -> None:
        """Close all connections. Waits for udp readers that hang, REPORT_SECONDS at most."""
        outputs = self._registry.outputs
        for output in outputs:
            output.abort()
        for output in outputs:
            output.close()
            self._registry.remove(output)
        ends = {
            f"yarp {self._source} leaves {output.reader}": partial(self._report_end, output)
            for output in outputs
        }
        tell_all(ends, REPORT_SECONDS)

    def asked_for(self, modifier: str) -> frozenset[str]:
        """Return the values that readers' carriers give to a modifier; an empty one of those without it."""
        return frozenset(output.modifiers.get(modifier, "") for output in self._registry.outputs)

    def send(
        self, parts: Sequence[Buffer], envelope: str = "", *, only: tuple[str, str] | None = None
    ) -> None:
        """Pass a message to every reader, or `only` to those that give a modifier this value.

        Never waits, and holds `parts` until all readers have it.
        """
        outputs = self._registry.outputs
        if only is not None:
            modifier, value = only
            outputs = [output for output in outputs if output.modifiers.get(modifier, "") == value]
        if outputs:
            message = Outgoing(parts, envelope)
            for output in outputs:
                output.put(message)

    def wait_sent(self, timeout: float) -> bool:
        """Wait until no message waits for a reader; return whether that was so within `timeout` seconds."""
        deadline = time.monotonic() + timeout
        return all(output.wait_taken(deadline - time.monotonic()) for output in self._registry.outputs)

    def _start(self, output: Output, replaces: Incoming | None = None) -> None:
        try:
            self._registry.add(output, replaces=replaces)
            output.start()
        except GrabberError:
            output.abort()
            self._registry.remove(output)
            raise

    def _close(self, output: Output) -> None:
        output.close()
        self._registry.remove(output)
        self._report_end(output)

    def _report_end(self, output: Output) -> None:
        """Notify a udp reader, which cannot notice the end. Never raises."""
        if not output.carrier.datagrams or output.listens_at is None:
            return
        try:
            report_end(self._source, output.listens_at, self._key)
        except GrabberError as error:
            log.debug("%s: %s does not know of the end: %s", self._source, output.reader, error)
