"""Tiles: a small live image of each open source."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass, field
from weakref import WeakSet

from psygnal import Signal

from grabbergui.models.connection import Connection
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.picture.picture import PictureModel

FEWEST = 2
"Sources from which on small pictures help."


@dataclass(eq=False)
class Tile:
    """One source and its small picture."""

    source: OpenSource
    picture: PictureModel = field(default_factory=PictureModel)
    attached: bool = False
    "Whether the picture takes the source's frames."


class GalleryModel:
    """A tile for each open source while there are several, none otherwise. Signals come from any thread.

    Each tile takes frames through a queue of its own, and its view sets the pace: no frame is converted
    before the view has taken the previous image.
    """

    changed = Signal(tuple)
    """All tiles (tuple[Tile, ...]), in the order in which their sources were opened."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._tiles: tuple[Tile, ...] = ()
        # A thread holds its picture as long as it runs, so that this set forgets those that have ended.
        self._ending: WeakSet[PictureModel] = WeakSet()
        self._lock = threading.RLock()
        connection.sources_changed.connect(self._on_sources_changed)
        # Immediately and on the current thread: the queue must be closed before the grabber.
        connection.ending.connect(self._on_ending)

    @property
    def tiles(self) -> tuple[Tile, ...]:
        """The tiles as they are now. Any thread."""
        return self._tiles

    def picture_of(self, source: OpenSource) -> PictureModel | None:
        """Return the small picture of a source; None where it has no tile. Any thread."""
        return next((tile.picture for tile in self._tiles if tile.source is source), None)

    def close(self, timeout: float) -> bool:
        """Show nothing more. Whether every thread ended within `timeout` seconds; may be asked again."""
        self._connection.sources_changed.disconnect(self._on_sources_changed, missing_ok=True)
        with self._lock:
            self._ending.update(tile.picture for tile in self._tiles)
            self._tiles = ()
            ending = list(self._ending)
        deadline = time.monotonic() + timeout
        ended = [picture.detach(max(0.0, deadline - time.monotonic())) for picture in ending]
        return all(ended)

    def _on_sources_changed(self, sources: tuple[OpenSource, ...]) -> None:
        with self._lock:
            known = {tile.source: tile for tile in self._tiles}
            wanted = sources if len(sources) >= FEWEST else ()
            self._tiles = tuple(known.get(source) or Tile(source) for source in wanted)
            for source in known.keys() - set(wanted):
                picture = known[source].picture
                picture.detach()
                self._ending.add(picture)
            for tile in self._tiles:
                self._attach(tile)
        self.changed.emit(self._tiles)

    def _on_ending(self, source: OpenSource) -> None:
        with self._lock:
            for tile in self._tiles:
                if tile.source is source:
                    tile.picture.detach()

    def _attach(self, tile: Tile) -> None:
        grabber = tile.source.grabber
        opened = tile.source.state.connected or tile.source.state is LinkState.LOST
        if grabber is not None and opened and not tile.attached and not tile.source.abandoned.is_set():
            tile.attached = True
            tile.picture.attach(grabber)
