"""The list of sources, found or added by the user, and a tile with a small live image of each open one."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from urllib.parse import unquote
from weakref import WeakSet

from psygnal import Signal

from grabbergui import sources
from grabbergui.core.errors import UsageError
from grabbergui.core.identity import DeviceInfo, differs
from grabbergui.core.uri import DescriptionOption, SourceUri, proposals
from grabbergui.models.image.live_image import ImageModel
from grabbergui.models.language import driver_text, translate
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.open_sources import OpenSources

log = logging.getLogger(__name__)

REFRESH_INTERVAL = 3.0
"Seconds between the end of one search and the next."
SEARCH_TIME = 0.6
"Seconds that a search waits for answers; closing the window may have to wait for it."
SIMULATED_SCHEME = "sim"
KEEP_MISSES = 2
"Searches that may miss a source before its line is removed: a broadcast or its answer may get lost."
FEWEST = 2
"Fewest open sources for which tiles are shown."


@dataclass(frozen=True)
class ListedSource:
    """One line of the list."""

    info: DeviceInfo
    manual: bool = False
    "Whether the user added it."
    connected: bool = False
    "Whether it is open, as the current source or in the background."
    lost: bool = False
    "Whether it is open but does not answer."
    problem: str = ""
    "Why the last attempt to open it failed, as display text; empty if it did not."

    @property
    def note(self) -> str:
        """What the driver notes about it, such as the program that uses it, as display text."""
        return driver_text(self.info.note)

    @property
    def detail(self) -> str:
        """The line below the title as display text: a state worth mentioning, place, options, serial number.

        One line in any state, so that the card keeps its height.
        """
        info, state = self.info, ""
        if self.lost:
            state = translate("Sources", "lost, reconnecting")
        elif self.connected:
            state = translate("Sources", "connected")
        elif self.problem:
            state = translate("Sources", "did not open")
        elif self.manual:
            state = translate("Sources", "added by hand")
        options = unquote(info.uri.partition("?")[2])
        shown_above = not info.serial or info.serial in info.short_title
        serial = "" if shown_above else translate("Sources", "serial {0}").format(info.serial)
        address = "" if info.address == info.short_title else info.address
        return " · ".join(part for part in (state, _bus_text(info.bus), address, options, serial) if part)


def _bus_text(name: str) -> str:
    """Translate words; names of standards stay."""
    words = {
        "Simulated": translate("Sources", "Simulated"),
        "File": translate("Sources", "File"),
    }
    return words.get(name, name)


class SourceListModel:
    """The sources found, in a steady order, followed by those that the user added.

    A thread of its own searches between `start` and `stop`.
    """

    changed = Signal(tuple)
    """All lines (tuple[ListedSource, ...]) after a change. Emitted on any thread."""
    searching = Signal(bool)
    """Whether a search is in progress."""

    def __init__(
        self,
        discover: Callable[[float], list[DeviceInfo]] = sources.discover,
        interval: float = REFRESH_INTERVAL,
    ) -> None:
        self._discover = discover
        self._interval = interval
        self._found: dict[str, DeviceInfo] = {}
        self._missed: dict[str, int] = {}
        self._manual: dict[str, DeviceInfo] = {}
        "Sources added by the user, by the typed URI; with their own description once they have been open."
        self._open: dict[str, DeviceInfo] = {}
        "By the requested URI, as those in `_lost`."
        self._lost: frozenset[str] = frozenset()
        self._problems: dict[str, str] = {}
        "Why the last attempt to open a source failed, by the requested URI."
        self._shown: tuple[ListedSource, ...] = ()
        self._lock = threading.Lock()
        self._wakeup = threading.Event()
        self._stopping = False
        self._thread: threading.Thread | None = None

    @property
    def sources(self) -> tuple[ListedSource, ...]:
        """The current lines. Any thread."""
        with self._lock:
            return self._shown

    def start(self) -> None:
        """Begin to search; does nothing while a search is running."""
        if self._thread is None:
            self._stopping = False
            self._thread = threading.Thread(target=self._search, name="discovery", daemon=True)
            self._thread.start()

    def stop(self, timeout: float = 2.0) -> bool:
        """Stop searching; return whether the thread ended within `timeout` seconds. May be called again."""
        self._stopping = True
        self._wakeup.set()
        if self._thread is None:
            return True
        self._thread.join(timeout)
        if self._thread.is_alive():
            return False
        self._thread = None
        return True

    def refresh(self) -> None:
        """Search now instead of after the interval. Never waits."""
        self._wakeup.set()

    def add(self, text: str) -> SourceUri:
        """Add a source that the user typed: a URI, or a GigE camera's IP address alone.

        Raises UsageError for a malformed URI or an unknown kind.
        """
        parsed = sources.parse(typed_uri(text))
        with self._lock:
            self._manual[str(parsed)] = DeviceInfo(str(parsed), address=parsed.name)
        self._publish()
        return parsed

    def note_problem(self, uri: str, problem: str) -> None:
        """Note why a source did not open; empty once it has."""
        with self._lock:
            self._problems.pop(uri, None)
            if problem:
                self._problems[uri] = problem
        self._publish()

    def remove(self, uri: str) -> None:
        """Remove a source that the user added, by its typed URI or its own."""
        with self._lock:
            self._problems.pop(uri, None)
            known = [line.info for line in self._shown if line.info.uri == uri]
            for typed, info in list(self._manual.items()):
                if uri in (typed, info.uri) or any(_is_one(info, line) for line in known):
                    del self._manual[typed]
        self._publish()

    @property
    def added_by_user(self) -> list[str]:
        """The addresses that the user typed, unchanged."""
        with self._lock:
            return list(self._manual)

    def set_open(self, opened: Mapping[str, DeviceInfo], lost: Collection[str] = ()) -> None:
        """Set the open sources: their descriptions by the requested URIs.

        The sources in `lost` do not answer; they stay listed although no search finds them.
        """
        with self._lock:
            self._open, self._lost = dict(opened), frozenset(lost)
            self._manual.update((uri, info) for uri, info in opened.items() if uri in self._manual)
        self._publish()

    def _search(self) -> None:
        while not self._stopping:
            self.searching.emit(True)
            try:
                self.note_found(self._discover(SEARCH_TIME))
            except Exception:
                # A faulty finder must not end the search for good.
                log.exception("searching for sources failed")
            self.searching.emit(False)
            self._wakeup.wait(0 if self._stopping else self._interval)
            self._wakeup.clear()

    def note_found(self, found: list[DeviceInfo]) -> None:
        """List what a search has found. Any thread."""
        with self._lock:
            seen = {info.uri: info for info in found if _is_usable(info.uri)}
            for uri in [uri for uri in self._found if uri not in seen]:
                if any(_is_one(self._found[uri], info) for info in self._open.values()):
                    continue  # a lost camera keeps its place
                self._missed[uri] = self._missed.get(uri, 0) + 1
                if self._missed[uri] > KEEP_MISSES:
                    del self._found[uri], self._missed[uri]
            for uri, info in seen.items():
                self._found[uri] = info
                self._missed.pop(uri, None)
        self._publish()

    def _publish(self) -> None:
        with self._lock:
            lines = self._lines()
            if tuple(lines) == self._shown:
                return
            self._shown = tuple(lines)
            shown = self._shown
        self.changed.emit(shown)

    def _lines(self) -> list[ListedSource]:
        """Return one line for each source: those found, then those added by the user, then the open ones.

        A line has the URI by which its source is open; else the typed one if that has options; else the one
        found.
        """
        lines = [ListedSource(info) for info in self._found.values()]
        for typed in self._manual.values():
            index, line = _line_of(lines, typed)
            if line is None:
                lines.append(ListedSource(typed, manual=True))
            elif line.manual or SourceUri.parse(typed.uri).options:
                lines[index] = ListedSource(replace(line.info, uri=typed.uri), manual=True)
        for requested, info in self._open.items():
            index, line = _line_of(lines, info)
            manual = line is not None and line.manual
            opened = ListedSource(info, manual, connected=True, lost=requested in self._lost)
            lines[index : index + 1] = [opened]
        return [
            replace(line, problem=self._problems[line.info.uri])
            if line.info.uri in self._problems and not line.connected
            else line
            for line in lines
        ]


def typed_uri(text: str) -> str:
    """Return the URI that a typed text means.

    The kind may be left out if the text has the form of only one: an IP address is that of a GigE Vision
    camera. A file may be typed as it is called.
    """
    kind, colon, _ = text.strip().partition(":")
    meant = [] if colon and kind.lower() in sources.schemes() else proposals(text.strip())
    uri = meant[0] if len(meant) == 1 else text
    return str(sources.literal_file(uri) or uri)


def _is_usable(uri: str) -> bool:
    """Return whether a URI can be parsed; a finder may make it of a name with characters of its own."""
    try:
        SourceUri.parse(uri)
    except UsageError as error:
        log.debug("not listed: %s", error)
        return False
    return True


def _line_of(lines: list[ListedSource], info: DeviceInfo) -> tuple[int, ListedSource | None]:
    """Return the index and the line of a source; the end of the list and None if it has no line."""
    for index, line in enumerate(lines):
        if _is_one(info, line.info):
            return index, line
    return len(lines), None


def _is_one(named: DeviceInfo, listed: DeviceInfo) -> bool:
    """Return whether a requested URI means the listed source, by its URI or by a name of the camera."""
    uri, known = SourceUri.parse(named.uri), SourceUri.parse(listed.uri)
    if uri == known:
        return True
    # A simulated camera with other options is another camera.
    if uri.scheme != known.scheme or uri.scheme == SIMULATED_SCHEME or differs(named, listed):
        return False
    names = (known.name, listed.address, listed.serial, listed.hardware_id, listed.user_name)
    wanted = {name.lower() for name in (uri.name, named.address) if name}
    return not wanted.isdisjoint(name.lower() for name in names)


def takes_description(uri: str) -> bool:
    """Return whether a source's description may come from a file."""
    try:
        return issubclass(sources.SourceKind(SourceUri.parse(uri).scheme).options, DescriptionOption)
    except (UsageError, ValueError):
        return False


def with_description(uri: str, file: Path) -> str:
    """Return a source's URI with the option that takes its description from a file. Raises UsageError."""
    parsed = SourceUri.parse(uri)
    return str(replace(parsed, options={**parsed.options, "description": str(file)}))


@dataclass(eq=False)
class Tile:
    """One source and its small image."""

    source: OpenSource
    image: ImageModel = field(default_factory=ImageModel)
    attached: bool = False
    "Whether the image was attached to the source."


class GalleryModel:
    """A tile for each open source if there are several. Signals come from any thread.

    Each tile takes frames through a queue of its own, at the pace of its view: the tile converts no frame
    before the view has taken the previous image.
    """

    changed = Signal(tuple)
    """All tiles (tuple[Tile, ...]), in the order of the sources."""

    def __init__(self, open_sources: OpenSources) -> None:
        self._open_sources = open_sources
        self._tiles: tuple[Tile, ...] = ()
        # A display thread keeps its image alive; images whose threads have ended leave this set.
        self._ending: WeakSet[ImageModel] = WeakSet()
        self._lock = threading.RLock()
        open_sources.changed.connect(self._on_sources_changed)
        # Not through the GUI thread: the queue must be closed before the grabber.
        open_sources.ending.connect(self._on_ending)

    @property
    def tiles(self) -> tuple[Tile, ...]:
        """The current tiles. Any thread."""
        return self._tiles

    def image_of(self, source: OpenSource) -> ImageModel | None:
        """Return the small image of a source; None if it has no tile. Any thread."""
        return next((tile.image for tile in self._tiles if tile.source is source), None)

    def close(self, timeout: float) -> bool:
        """Remove all tiles; return whether every thread ended within `timeout` seconds. Can be repeated."""
        self._open_sources.changed.disconnect(self._on_sources_changed, missing_ok=True)
        with self._lock:
            self._ending.update(tile.image for tile in self._tiles)
            self._tiles = ()
            ending = list(self._ending)
        deadline = time.monotonic() + timeout
        ended = [image.detach(max(0.0, deadline - time.monotonic())) for image in ending]
        return all(ended)

    def _on_sources_changed(self, _: tuple[OpenSource, ...]) -> None:
        with self._lock:
            # Two threads may emit in the wrong order: only `open_sources` knows the present ones.
            sources = self._open_sources.all
            known = {tile.source: tile for tile in self._tiles}
            wanted = sources if len(sources) >= FEWEST else ()
            self._tiles = tuple(known.get(source) or Tile(source) for source in wanted)
            for source in known.keys() - set(wanted):
                image = known[source].image
                image.detach()
                self._ending.add(image)
            for tile in self._tiles:
                self._attach(tile)
        self.changed.emit(self._tiles)

    def _on_ending(self, source: OpenSource) -> None:
        with self._lock:
            for tile in self._tiles:
                if tile.source is source:
                    tile.image.detach()

    def _attach(self, tile: Tile) -> None:
        grabber = tile.source.grabber
        opened = tile.source.state.connected or tile.source.state is LinkState.LOST
        if grabber is not None and opened and not tile.attached:
            tile.attached = True
            tile.image.attach(grabber)
