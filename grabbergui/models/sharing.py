"""The open sources that this window shares on YARP and ROS 2.

Each `Share` has a thread, which starts the server, looks at its readers, and stops it. The server uses the
window's own grabber, so the camera is opened once. One name server serves all shares that want one.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, TypeAlias

from psygnal import Signal

from grabbergui.core.errors import GrabberError, SourceUnavailableError, TransportError, UsageError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.requester import requester
from grabbergui.core.settings import SettingKey, WriteResult
from grabbergui.core.shared import ReadOnlyGrabber
from grabbergui.models.change import Change, Origin
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.open_sources import OpenSources
from grabbergui.models.peer_grabber import PeerGrabber
from grabbergui.models.share import Network, Server, Share, ShareOptions, ShareState, ShareStatus
from grabbergui.models.stream_control import StreamControl

if TYPE_CHECKING:  # imported when the first camera is shared
    from grabbergui.net.tree import Terminal
    from grabbergui.net.yarp.os.name_client import NameClient
    from grabbergui.net.yarp.os.name_server import NameServer

END_SECONDS = 6.0
"Longest wait for a server to stop before its camera is closed."
NAME_SERVER = "127.0.0.1:10000"
"Default address of a name server of this window: reached from this computer only."
MOST_PORT = 0xFFFF
MakeServer: TypeAlias = "Callable[[FrameGrabber, ShareOptions, NameServersHere, Terminal], Server]"
"Makes a server, not yet started. Raises GrabberError."


class NameServersHere:
    """The YARP name servers that this window runs, from the first share that wants one until `close`."""

    def __init__(self) -> None:
        self._servers: dict[str, NameServer] = {}
        self._lock = threading.Lock()

    def client(self, address: str) -> NameClient:
        """Return a client of the server at HOST:PORT, which is started unless one answers there.

        Raises UsageError for a malformed address, TransportError if another program has it.
        """
        from grabbergui.net.yarp.os.name_client import NameClient
        from grabbergui.net.yarp.os.name_server import NameServer

        host, _, port = (address or NAME_SERVER).rpartition(":")
        if not host or not (port.isascii() and port.isdigit()) or int(port) > MOST_PORT:
            raise UsageError(f"name server {address}: write HOST:PORT, such as {NAME_SERVER}")
        with self._lock:
            if (running := self._servers.get(address)) is None:
                running = NameServer(host, int(port))
                try:
                    running.open()
                except TransportError:
                    client = NameClient.find(address or NAME_SERVER)
                    with suppress(SourceUnavailableError):
                        client.list()
                        return client  # somebody else runs one there
                    raise
                self._servers[address] = running
        return NameClient.find(f"{running.contact.host}:{running.contact.port}")

    def close(self) -> None:
        """Stop them. May be called twice."""
        with self._lock:
            servers, self._servers = list(self._servers.values()), {}
        for server in servers:
            server.close()


def _no_terminal(grabber: FeatureSource) -> Terminal:
    from grabbergui.net.tree import no_terminal

    return no_terminal


def _make_yarp(
    grabber: FrameGrabber, options: ShareOptions, here: NameServersHere, terminal: Terminal
) -> Server:
    from grabbergui.net.yarp.os.name_client import NameClient
    from grabbergui.net.yarp.server import YarpGrabberServer

    own = options.own_nameserver
    names = here.client(options.nameserver) if own else NameClient.find(options.nameserver)
    return YarpGrabberServer(grabber, options.name, names=names, terminal=terminal)


def _make_ros2(
    grabber: FrameGrabber, options: ShareOptions, here: NameServersHere, terminal: Terminal
) -> Server:
    from grabbergui.net.ros2.server import Ros2GrabberServer

    return Ros2GrabberServer(
        grabber, options.name, domain=options.domain, read_only=options.read_only, terminal=terminal
    )


def _load_networks() -> None:
    """Import the servers of both networks; ROS 2 takes half a second, and may be missing."""
    import grabbergui.net.yarp.server  # noqa: F401

    with suppress(GrabberError, ImportError):
        from grabbergui.net.ros2.preparation import prepare

        prepare()


MAKERS: Mapping[Network, MakeServer] = {Network.YARP: _make_yarp, Network.ROS2: _make_ros2}


@dataclass(frozen=True)
class Served:
    """A server that the program started before its window."""

    uri: str
    "URI of the source that it serves."
    network: Network
    options: ShareOptions
    server: Server


class Sharing:
    """All shares of a window. Any thread; no method waits but `close`."""

    changed = Signal()
    """The state of a share, or its readers; emitted on any thread."""

    def __init__(
        self,
        open_sources: OpenSources,
        stream: StreamControl,
        terminal: Callable[[FrameGrabber], Terminal] = _no_terminal,
        makers: Mapping[Network, MakeServer] = MAKERS,
        load: Callable[[], object] = _load_networks,
    ) -> None:
        """`terminal` returns what runs the typed commands that arrive for a grabber.

        `load` does once what a server's first start would take long for.
        """
        self._load = load
        self._loading: threading.Thread | None = None
        self._open_sources = open_sources
        self._stream = stream
        self._terminal = terminal
        self._makers = makers
        self._names = NameServersHere()
        self._shares: tuple[Share, ...] = ()
        self._ended: tuple[Share, ...] = ()
        self._lock = threading.RLock()
        open_sources.ending.connect(self._on_ending)

    def prepare(self) -> None:
        """Load what servers need, in the background: somebody may share a camera soon."""
        with self._lock:
            if self._loading is None:
                self._loading = threading.Thread(target=self._load, name="load networks", daemon=True)
                self._loading.start()

    def share(self, source: OpenSource, network: Network, options: ShareOptions) -> None:
        """Share an open source; start its stream if it is the current one and stopped."""
        grabber = source.grabber
        if grabber is None or source.tracked_grabber is None or self._running(source, network):
            return
        source.tracked_grabber.others_write = True
        if source is self._open_sources.current and source.state is LinkState.OPEN:
            self._stream.start()
        make = partial(self._make, source, grabber, network, options)
        self._add(Share(source, network, options, make, self.changed.emit))

    def adopt(self, served: Served) -> None:
        """Show a server that runs already, as if it had been started here; `stop` stops it."""
        make, network, options = lambda: served.server, served.network, served.options
        self._add(Share(served.uri, network, options, make, self.changed.emit, started=True))

    def stop(self, source: OpenSource, network: Network) -> None:
        """Stop sharing a source on one network."""
        for share in self._of(source):
            if share.status.network is network:
                share.end()

    def of(self, source: OpenSource | None) -> tuple[ShareStatus, ...]:
        """Return the shares of a source, one for each network, those that have ended left out."""
        if source is None:
            return ()
        return tuple(share.status for share in self._of(source) if share.status.state is not ShareState.OFF)

    def readers(self, sources: Iterable[OpenSource | None]) -> tuple[str, ...]:
        """Return the names of the programs that read these sources, each once."""
        found = (name for source in sources for status in self.of(source) for name in status.names)
        return tuple(dict.fromkeys(found))

    @property
    def all_readers(self) -> tuple[str, ...]:
        """The names of the programs that read any source, each once."""
        return tuple(dict.fromkeys(name for share in self._shares for name in share.status.names))

    def close(self, timeout: float) -> bool:
        """Stop all; return whether every thread ended within `timeout` seconds. Can be repeated."""
        self._open_sources.ending.disconnect(self._on_ending, missing_ok=True)
        with self._lock:
            shares = (*self._shares, *self._ended)
        deadline = time.monotonic() + timeout
        for share in shares:
            share.end()
        ended = all(share.join(max(0.0, deadline - time.monotonic())) for share in shares)
        if self._loading is not None:
            self._loading.join(max(0.0, deadline - time.monotonic()))
            ended = ended and not self._loading.is_alive()
        if ended:
            self._names.close()
        return ended

    def _make(
        self, source: OpenSource, grabber: FrameGrabber, network: Network, options: ShareOptions
    ) -> Server:
        if options.read_only:
            grabber = ReadOnlyGrabber(grabber)
            grabber.open()
        peers = PeerGrabber(grabber)
        peers.written.connect(partial(_on_written, source))
        peers.executed.connect(partial(_on_executed, source))
        return self._makers[network](peers, options, self._names, self._terminal(peers))

    def _add(self, share: Share) -> None:
        with self._lock:
            replaced = [
                s for s in self._shares if (s.key, s.status.network) == (share.key, share.status.network)
            ]
            self._shares = (*(s for s in self._shares if s not in replaced), share)
            self._ended = (*(s for s in self._ended if not s.join(0)), *replaced)
        share.begin()
        self.changed.emit()

    def _of(self, source: OpenSource) -> list[Share]:
        uris = {str(source.uri), source.grabber.info.uri if source.grabber is not None else ""}
        return [share for share in self._shares if share.key is source or share.key in uris]

    def _running(self, source: OpenSource, network: Network) -> bool:
        return any(s.status.running and s.status.network is network for s in self._of(source))

    def _on_ending(self, source: OpenSource) -> None:
        """Stop the servers before the grabber is closed, on the source's own thread."""
        shares = [share for share in self._shares if share.key is source]
        for share in shares:
            share.end()
        if shares:
            deadline = END_SECONDS / len(shares)
            source.worker.submit(lambda: [share.join(deadline) for share in shares])
        with self._lock:
            self._shares = tuple(share for share in self._shares if share not in shares)
            self._ended = (*(s for s in self._ended if not s.join(0)), *shares)
        if shares:
            self.changed.emit()


def peer_changes(source: OpenSource | None) -> tuple[Change, ...]:
    """Return what peers on a network changed since the source was opened, the newest first."""
    if source is None:
        return ()
    return tuple(change for change in reversed(source.journal.changes) if change.origin is Origin.NETWORK)


def _on_written(source: OpenSource, result: WriteResult) -> None:
    if source.tracked_grabber is not None:
        source.tracked_grabber.note_peer((*result.written, *result.consequences), requester())


def _on_executed(source: OpenSource, key: SettingKey) -> None:
    source.journal.ran(key, Origin.NETWORK, requester())
