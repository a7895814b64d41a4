"""Whether a camera has a polarised sensor, as far as its features say so."""

from __future__ import annotations

import re

from psygnal import Signal

from grabbergui.core.errors import GrabberError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.models.connection import Connection
from grabbergui.models.open_source import OpenSource

_NAME = re.compile(r"Polar(i[sz]|Mono|Angle)", re.IGNORECASE)
"""`PolarizedAngles_0d_45d_90d_135d_Mono8`, `PolarizeMono12p`, `PolarizationMode`: the makers' names."""


def is_polarised(grabber: FrameGrabber) -> bool:
    """Return whether a camera offers polarised pixel formats, or has features of polarisation.

    Blocks while the camera answers. The convention (PFNC 2.4) marks no mosaic: a camera of which neither is
    known sends it as Mono.
    """
    try:
        if any(_NAME.match(feature.name) for feature in grabber.feature_tree().descriptions()):
            return True
        if not grabber.has_feature("PixelFormat"):
            return False
        return any(_NAME.match(entry.name) for entry in grabber.feature("PixelFormat").entries)
    except GrabberError:
        return False


class PolarisationWatch:
    """Finds out whether the current camera is polarised. `found` is emitted on the source's thread."""

    found = Signal(bool)

    def __init__(self, connection: Connection) -> None:
        self._source: OpenSource | None = None
        connection.opened.connect(self._on_opened)
        connection.closing.connect(self._on_closing)

    def _on_opened(self, source: OpenSource) -> None:
        grabber = source.grabber
        if grabber is None:
            return
        self._source = source

        def publish(polarised: bool) -> None:
            if source is self._source:
                self.found.emit(polarised)

        source.worker.submit(lambda: is_polarised(grabber), key="Polarised", done=publish)

    def _on_closing(self, source: OpenSource) -> None:
        if source is self._source:
            self._source = None
