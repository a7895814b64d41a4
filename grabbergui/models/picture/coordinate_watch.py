"""The camera's Scan3d features, read again whenever one of them may have changed."""

from __future__ import annotations

from psygnal import Signal

from grabbergui.core import scan3d
from grabbergui.core.scan3d import Scan3d
from grabbergui.models.connection import Connection
from grabbergui.models.open_source import OpenSource


class CoordinateWatch:
    """Reads what the values of range images mean. No call waits; the signal comes from the source's thread.

    A camera without these features is asked for nothing.
    """

    changed = Signal(Scan3d)

    def __init__(self, connection: Connection) -> None:
        self._source: OpenSource | None = None
        connection.opened.connect(self._on_opened)
        connection.closing.connect(self._on_closing)

    def _on_opened(self, source: OpenSource) -> None:
        self._leave()
        if source.grabber is None:
            return
        self._source = source
        source.grabber.features_changed.connect(self._on_features_changed)
        self._read(source)

    def _on_closing(self, _: OpenSource) -> None:
        self._leave()

    def _leave(self) -> None:
        source, self._source = self._source, None
        if source is not None and source.grabber is not None:
            source.grabber.features_changed.disconnect(self._on_features_changed, missing_ok=True)

    def _on_features_changed(self, names: frozenset[str]) -> None:
        if (source := self._source) is not None and scan3d.may_change(names):
            self._read(source)

    def _read(self, source: OpenSource) -> None:
        grabber = source.grabber
        assert grabber is not None

        def publish(scan: Scan3d) -> None:
            if source is self._source:
                self.changed.emit(scan)

        source.worker.submit(lambda: Scan3d.read(grabber), key="Scan3d", done=publish)
