"""One camera on one network: how it is shared, its readers and their rates, and the thread of its server."""

from __future__ import annotations

import logging
import re
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import TYPE_CHECKING, Any, Protocol

from grabbergui.core.errors import GrabberError, NoNameServerError
from grabbergui.models.error_text import error_text
from grabbergui.models.language import localized, translate

if TYPE_CHECKING:  # the networks are imported when they are used
    from grabbergui.net.readers import Reader

log = logging.getLogger(__name__)

LOOK_PERIOD = 0.5
"Seconds between two looks at a server's readers."
_COMMAND = re.compile(r"`([^`]* setup ros2)`")
"The command that installs ROS 2, in the error that names it."


class Network(Enum):
    """A network on which a camera can be shared."""

    YARP = "YARP"
    ROS2 = "ROS 2"


@dataclass(frozen=True)
class ShareOptions:
    """How a camera is shared."""

    name: str
    "The port's or node's name."
    nameserver: str = ""
    "HOST:PORT of the YARP name server; empty: the one that YARP's configuration names."
    own_nameserver: bool = False
    "Whether this window runs the name server, at `nameserver` or at NAME_SERVER."
    domain: int | None = None
    "The ROS domain; None: that of ROS_DOMAIN_ID."
    read_only: bool = False
    "Whether peers may change nothing."


DEFAULT_NAMES: Mapping[Network, str] = {Network.YARP: "/grabber", Network.ROS2: "/camera"}


class Server(Protocol):
    """A server as `YarpGrabberServer` and `Ros2GrabberServer` are."""

    name: str

    def start(self) -> None:
        """Join the network. Raises GrabberError."""

    def stop(self) -> None:
        """Leave it. May be called twice."""

    def places(self) -> list[str]:
        """Return where it is reached, as display text."""

    def connected(self) -> list[Reader]:
        """Return who is connected. Any thread."""


class ShareState(Enum):
    """The state of one camera on one network."""

    STARTING = "starting"
    ON = "on"
    STOPPING = "stopping"
    FAILED = "failed"
    OFF = "off"


class Remedy(Enum):
    """A remedy for a failed start that the window offers."""

    NAME_SERVER = "name server"
    "Run one here."
    COMMAND = "command"
    "Run the command that the error names, in a terminal."


@dataclass(frozen=True)
class ReaderRate:
    """A reader and its present rates."""

    reader: Reader
    images: float = 0.0
    "Images per second."
    bytes: float = 0.0
    "Bytes per second."

    @property
    def takes_images(self) -> bool:
        """Whether it has taken an image."""
        return self.reader.images > 0

    @property
    def rate_text(self) -> str:
        """The rates as display text; empty if it takes no images."""
        if not self.takes_images:
            return ""
        text = translate("Sharing", "{0:.1f} images/s · {1:.1f} MB/s")
        return localized(text.format(self.images, self.bytes / 1e6))


@dataclass(frozen=True)
class ShareStatus:
    """One camera on one network, as the window shows it."""

    network: Network
    options: ShareOptions
    state: ShareState = ShareState.STARTING
    places: tuple[str, ...] = ()
    "Addresses at which it is reached, as display text."
    readers: tuple[ReaderRate, ...] = ()
    problem: str = ""
    "Why it could not be started, as display text."
    remedy: Remedy | None = None
    command: str = ""
    "For Remedy.COMMAND."

    @property
    def running(self) -> bool:
        """Whether it is shared, or about to be."""
        return self.state in (ShareState.STARTING, ShareState.ON)

    @property
    def names(self) -> tuple[str, ...]:
        """The programs that take its images or talk to it, each once."""
        return tuple(dict.fromkeys(rate.reader.name for rate in self.readers))


class ReaderMeter:
    """Turns the readers' counters into rates over the last seconds. No clock of its own; one thread."""

    SECONDS = 2.0

    def __init__(self) -> None:
        self._seen: dict[tuple[str, str], list[tuple[float, int, int]]] = {}

    def rates(self, readers: Sequence[Reader], now: float) -> tuple[ReaderRate, ...]:
        """Return the readers with their rates, those that take most first; `now` is in seconds."""
        found = []
        seen: dict[tuple[str, str], list[tuple[float, int, int]]] = {}
        for reader in readers:
            history = [*self._seen.get(reader.key, ()), (now, reader.images, reader.bytes)]
            if reader.images < history[0][1]:  # it has connected again
                history = history[-1:]
            while len(history) > 2 and now - history[1][0] >= self.SECONDS:
                del history[0]
            seen[reader.key] = history
            begun, images, size = history[0]
            passed = now - begun
            if passed > 0:
                found.append(
                    ReaderRate(reader, (reader.images - images) / passed, (reader.bytes - size) / passed)
                )
            else:
                found.append(ReaderRate(reader))
        self._seen = seen
        return tuple(sorted(found, key=lambda rate: (-rate.bytes, rate.reader.key)))


class Share:
    """One camera on one network. Its thread makes every call of the server; other threads read `status`."""

    def __init__(
        self,
        key: object,
        network: Network,
        options: ShareOptions,
        make: Callable[[], Server],
        on_changed: Callable[[], None],
        *,
        started: bool = False,
    ) -> None:
        """`key` says whose it is; `make` returns the server, which may be `started` already."""
        self.key = key
        self.status = ShareStatus(network, options)
        "Replaced by every change, never changed."
        self._make = make
        self._on_changed = on_changed
        self._started = started
        self._ending = threading.Event()
        self._meter = ReaderMeter()
        self._thread = threading.Thread(
            target=self._run, name=f"share {network.value} {options.name}", daemon=True
        )

    def begin(self) -> None:
        """Start the thread."""
        self._thread.start()

    def end(self) -> None:
        """Let the server stop. Returns immediately."""
        if self.status.running:
            self._publish(state=ShareState.STOPPING)
        self._ending.set()

    def join(self, timeout: float) -> bool:
        """Wait until the server has stopped; return whether it has."""
        self._thread.join(timeout)
        return not self._thread.is_alive()

    def _run(self) -> None:
        server = None
        try:
            server = self._make()
            if not self._started:
                server.start()
            while not self._ending.is_set():
                self._look(server)
                self._ending.wait(LOOK_PERIOD)
        except (GrabberError, OSError) as error:
            self._fail(error)
        finally:
            if server is not None:
                server.stop()
        if self._ending.is_set():
            self._publish(state=ShareState.OFF, places=(), readers=(), problem="")

    def _look(self, server: Server) -> None:
        options = self.status.options
        if options.name != server.name:  # the environment may rename it
            options = replace(options, name=server.name)
        rates = self._meter.rates(server.connected(), time.monotonic())
        self._publish(state=ShareState.ON, options=options, places=tuple(server.places()), readers=rates)

    def _fail(self, error: GrabberError | OSError) -> None:
        log.warning("%s is not shared: %s", self.status.options.name, error)
        text, remedy, command = error_text(error), None, ""
        if isinstance(error, NoNameServerError):
            where = self.status.options.nameserver or error.where
            text = translate("Sharing", "no YARP name server answers at {0}").format(where)
            remedy = Remedy.NAME_SERVER
        elif (found := _COMMAND.search(str(error))) is not None:
            text = translate("Sharing", "ROS 2 is not installed; this command installs it: {0}")
            remedy, command = Remedy.COMMAND, found.group(1)
            text = text.format(command)
        self._publish(state=ShareState.FAILED, problem=text, remedy=remedy, command=command)

    def _publish(self, **changes: Any) -> None:
        status = replace(self.status, **changes)
        if self._ending.is_set() and status.running:
            return
        if status != self.status:
            self.status = status
            self._on_changed()
