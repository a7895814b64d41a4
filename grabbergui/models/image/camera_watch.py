"""Facts about the current camera that the display of its image depends on."""

from __future__ import annotations

import re
from collections.abc import Callable

from psygnal import Signal

from grabbergui.core.errors import GrabberError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.grabber import FrameGrabber
from grabbergui.models.open_source import OpenSource
from grabbergui.models.open_sources import OpenSources

_POLARISED = re.compile(r"Polar(i[sz]|Mono|Angle)", re.IGNORECASE)
"""Vendors' names: `PolarizedAngles_0d_45d_90d_135d_Mono8`, `PolarizeMono12p`, `PolarizationMode`."""


def is_polarised(grabber: FeatureSource) -> bool:
    """Return whether a camera has polarised pixel formats or features of polarisation.

    Waits for the camera. PFNC 2.4 does not mark a polarised mosaic, so a camera may send it as plain Mono.
    """
    try:
        if any(_POLARISED.match(feature.name) for feature in grabber.feature_tree().descriptions()):
            return True
        if not grabber.has_feature("PixelFormat"):
            return False
        return any(_POLARISED.match(entry.name) for entry in grabber.feature("PixelFormat").entries)
    except GrabberError:
        return False


class CameraWatch:
    """Reads a fact about each camera that becomes current, and again after changes that may affect it.

    No call waits. `changed` is emitted with the fact, on the source's thread.
    """

    changed = Signal(object)

    def __init__(
        self,
        open_sources: OpenSources,
        read: Callable[[FrameGrabber], object],
        depends_on: Callable[[frozenset[str]], bool] = lambda _: False,
    ) -> None:
        """`depends_on` returns whether a change of these features may change the fact."""
        self._read_fact = read
        self._depends_on = depends_on
        self._source: OpenSource | None = None
        open_sources.opened.connect(self._on_opened)
        open_sources.closing.connect(self._on_closing)

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
        if (source := self._source) is not None and self._depends_on(names):
            self._read(source)

    def _read(self, source: OpenSource) -> None:
        grabber = source.grabber
        assert grabber is not None

        def publish(fact: object) -> None:
            if source is self._source:
                self.changed.emit(fact)

        key = self._read_fact.__qualname__
        source.worker.submit(lambda: self._read_fact(grabber), key=key, done=publish)
