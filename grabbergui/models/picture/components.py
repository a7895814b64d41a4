"""The components of a frame by the labels that a user chooses from.

Also: the images of all stream channels as components of one frame, and facts about the current camera that
the values need: whether its sensor is polarised, its Scan3d features.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable
from dataclasses import replace

from psygnal import Signal

from grabbergui.core.component import Component, ComponentKind, own_component
from grabbergui.core.errors import GrabberError
from grabbergui.core.frame import EncodedFrame, Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.models.connection import Connection
from grabbergui.models.language import translate
from grabbergui.models.open_source import OpenSource

MOST_BESIDE = 9
"""Components that are shown side by side; more would be too small to be seen."""


def labels(frame: Frame) -> tuple[str, ...]:
    """Return the names of a frame's components in the user's language, each once; empty without a choice."""
    if len(frame.parts) < 2:
        return ()
    seen: Counter[str] = Counter()
    found = []
    several = len({part.source for part in frame.parts}) > 1
    for part in frame.parts:
        name = _name(part)
        if several:
            name = translate("Components", "{0}, source {1}").format(name, part.source)
        seen[name] += 1
        found.append(f"{name} {seen[name]}" if seen[name] > 1 else name)
    return tuple(found)


def own_label(frame: Frame) -> str:
    """Return the label of the frame's own image; empty without a choice."""
    own = own_component(frame.parts)
    return next((label for label, part in zip(labels(frame), frame.parts, strict=False) if part is own), "")


def chosen(frame: Frame, label: str) -> Frame:
    """Return the component of that label as a frame; the frame itself for its own image."""
    known = labels(frame)
    if label not in known or label == own_label(frame):
        return frame
    return frame.of_component(frame.parts[known.index(label)])


def beside(labels: tuple[str, ...], label: str) -> tuple[str, ...]:
    """Return the labels of the components to show beside that of `label`, at most `MOST_BESIDE` in all."""
    return tuple(other for other in labels if other != label)[: MOST_BESIDE - 1]


def _name(part: Component) -> str:
    return {
        ComponentKind.INTENSITY: translate("Components", "Intensity"),
        ComponentKind.INFRARED: translate("Components", "Infrared"),
        ComponentKind.ULTRAVIOLET: translate("Components", "Ultraviolet"),
        ComponentKind.RANGE: translate("Components", "Range"),
        ComponentKind.REFLECTANCE: translate("Components", "Reflectance"),
        ComponentKind.CONFIDENCE: translate("Components", "Confidence"),
        ComponentKind.SCATTER: translate("Components", "Scatter"),
        ComponentKind.DISPARITY: translate("Components", "Disparity"),
        ComponentKind.MULTISPECTRAL: translate("Components", "Multispectral"),
    }.get(part.kind, translate("Components", "Component"))


SILENCE = 2.0
"Seconds after which a channel that sends nothing is not shown any more."
MOST_CHANNELS = 16


class StreamChannels:
    """Merges the frames of several stream channels for display; with one channel, frames pass as they are.

    Channels need not run at one rate: each is shown as it was last. One thread at a time.
    """

    def __init__(self) -> None:
        self._latest: dict[int, tuple[Frame, float]] = {}

    def clear(self) -> None:
        """Forget all frames: another stream begins."""
        self._latest.clear()

    def merged(self, frame: Frame, now: float) -> Frame:
        """Take a frame that arrived at `now` (seconds); return it with the other channels' newest images.

        The result is the frame of the lowest channel; each component's `source` is its channel.
        """
        self._latest[frame.stream_channel] = (frame, now)
        latest = {
            channel: kept for channel, (kept, seen) in sorted(self._latest.items()) if now - seen < SILENCE
        }
        if len(latest) != len(self._latest):
            self._latest = {channel: self._latest[channel] for channel in latest}
        if len(latest) < 2 or any(isinstance(kept, EncodedFrame) for kept in latest.values()):
            return frame
        parts = tuple(
            replace(part, source=channel)
            for channel, kept in list(latest.items())[:MOST_CHANNELS]
            for part in kept.components
        )
        return replace(next(iter(latest.values())), parts=parts)


_POLARISED = re.compile(r"Polar(i[sz]|Mono|Angle)", re.IGNORECASE)
"""`PolarizedAngles_0d_45d_90d_135d_Mono8`, `PolarizeMono12p`, `PolarizationMode`: the makers' names."""


def is_polarised(grabber: FrameGrabber) -> bool:
    """Return whether a camera offers polarised pixel formats, or has features of polarisation.

    Blocks while the camera answers. The convention (PFNC 2.4) marks no mosaic: a camera of which neither is
    known sends it as Mono.
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
    """Reads one fact about each camera that becomes current, and again after changes that it depends on.

    No call waits. `changed` is emitted with the fact, on the source's thread.
    """

    changed = Signal(object)

    def __init__(
        self,
        connection: Connection,
        read: Callable[[FrameGrabber], object],
        depends_on: Callable[[frozenset[str]], bool] = lambda _: False,
    ) -> None:
        """`depends_on` returns whether a change of the features of these names calls for reading again."""
        self._read_fact = read
        self._depends_on = depends_on
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
