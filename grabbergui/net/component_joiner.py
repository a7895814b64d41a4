"""Components of a frame that travel one by one over a network: names, metres, and joining by stamps."""

from __future__ import annotations

import math
import re
from collections import OrderedDict, deque
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

from grabbergui.core.component import (
    Component,
    ComponentKind,
    further_components,
    own_component,
)
from grabbergui.core.frame import Frame

WAIT: Final = 0.1
"""Seconds that an image waits for a component that was in time for earlier images."""
MOST_WAITING: Final = 4
"""Images of each kind that wait for the others of their frame. Beyond that the oldest frame is returned as it
is, the oldest image of a component dropped."""
MOST_COMPONENTS: Final = 16
"""Components of one camera, sent or received; further ones are ignored."""
_MOST_AHEAD: Final = 1_000_000_000
"""Nanoseconds by which a component's stamp may be later than its camera's newest image. A later stamp is
from before the clock was set back; it would make the component of every further image look lost."""
_REMEMBERED: Final = 32
"""Delivered images whose arrival times are kept, to measure how late a component is."""

_NAME = re.compile(r"([a-z]+)(?:_\d{1,2})?")
_KINDS: Final = {kind.name.lower(): kind for kind in ComponentKind if kind is not ComponentKind.METADATA}


def kind_of(name: str) -> ComponentKind | None:
    """Return the kind of a component that a network names: `range`, `range_2`; None for any other name."""
    match = _NAME.fullmatch(name)
    return _KINDS.get(match[1]) if match else None


def components_of(frame: Frame) -> Iterator[tuple[str, Component]]:
    """Yield the images, by name, that a network offers besides the frame's own.

    If the frame's own image holds distances, it is yielded as `range`, too.
    """
    own = own_component(frame.components)
    if own is not None and own.pixel_format.is_coordinate:
        yield "range", own
    yield from further_components(frame.parts)


@dataclass
class _Waiting:
    """An image whose components are on their way."""

    frame: Frame
    arrived: float
    missing: set[str]
    parts: dict[str, Frame]


class ComponentJoiner:
    """Adds to each image the components with the same `timestamp_ns`. No I/O, no clock; one thread at a time.

    A component without a stamp (0) is dropped, as its image is unknown.

    An image waits at most `WAIT` seconds, and only for components that were in time for earlier images. It
    gives a component up when a later image of that component arrives: its own was lost. Images are returned
    in the order of their arrival, and late components are dropped.
    """

    def __init__(self) -> None:
        self._waiting: deque[_Waiting] = deque()
        self._parts: dict[str, OrderedDict[int, Frame]] = {}
        self._punctual: set[str] = set()
        "The components that are waited for."
        self._arrivals: OrderedDict[int, float] = OrderedDict()
        "Arrival times of returned images, by stamp."
        self.late = 0
        "Components that arrived after their image had been returned."

    @property
    def deadline(self) -> float | None:
        """Time at which `due` returns an image; None while no image waits."""
        return self._waiting[0].arrived + WAIT if self._waiting else None

    def image(self, frame: Frame, now: float) -> list[Frame]:
        """Take an image that arrived at `now` (seconds); return the complete images."""
        stamp = frame.timestamp_ns
        self._forget_stamps(after=stamp + _MOST_AHEAD)
        parts = {name: images.pop(stamp) for name, images in self._parts.items() if stamp in images}
        wanted = self._punctual if stamp else set()
        missing = {name for name in wanted - parts.keys() if not self._passed(name, stamp)}
        self._waiting.append(_Waiting(frame, now, missing, parts))
        if len(self._waiting) > MOST_WAITING:
            self._waiting[0].missing.clear()
        return self._complete()

    def component(self, name: str, frame: Frame, now: float) -> list[Frame]:
        """Take a component that arrived at `now`, named as in `kind_of`; return the complete images."""
        stamp = frame.timestamp_ns
        if not stamp:
            return []
        if name not in self._parts:
            if len(self._parts) >= MOST_COMPONENTS:
                return []
            self._parts[name] = OrderedDict()
        if stamp in self._arrivals:
            self.late += 1
            if now - self._arrivals[stamp] <= WAIT:
                self._punctual.add(name)
            return []
        for waiting in self._waiting:
            if waiting.frame.timestamp_ns == stamp:
                waiting.parts[name] = frame
                self._punctual.add(name)
            if waiting.frame.timestamp_ns <= stamp:
                waiting.missing.discard(name)  # one stream keeps its order: an earlier one was lost
        if not any(waiting.frame.timestamp_ns == stamp for waiting in self._waiting):
            images = self._parts[name]
            images[stamp] = frame
            while len(images) > MOST_WAITING:
                images.popitem(last=False)
        return self._complete()

    def due(self, now: float) -> list[Frame]:
        """Return the images that have waited long enough, without the components they lack."""
        for waiting in self._waiting:
            if now - waiting.arrived >= WAIT:
                self._punctual -= waiting.missing
                waiting.missing.clear()
        return self._complete()

    def forget(self, name: str) -> list[Frame]:
        """Stop waiting for a component that is no longer sent; return the complete images."""
        self._punctual.discard(name)
        self._parts.pop(name, None)
        for waiting in self._waiting:
            waiting.missing.discard(name)
        return self._complete()

    def _forget_stamps(self, *, before: float = -math.inf, after: float = math.inf) -> None:
        """Forget component images whose stamps are outside this range."""
        for images in self._parts.values():
            for stamp in [stamp for stamp in images if not before <= stamp <= after]:
                del images[stamp]

    def _passed(self, name: str, stamp: int) -> bool:
        """Return whether a later image of a component has arrived."""
        return any(other > stamp for other in self._parts.get(name, ()))

    def _complete(self) -> list[Frame]:
        done = []
        while self._waiting and not self._waiting[0].missing:
            waiting = self._waiting.popleft()
            stamp = waiting.frame.timestamp_ns
            self._arrivals[stamp] = waiting.arrived
            while len(self._arrivals) > _REMEMBERED:
                self._arrivals.popitem(last=False)
            self._forget_stamps(before=stamp)
            done.append(joined(waiting.frame, waiting.parts))
        return done


def joined(frame: Frame, parts: dict[str, Frame]) -> Frame:
    """Return the frame with these images after its own component; without any, the frame itself.

    A `range` is left out if the frame's own image holds distances.
    """
    (own,) = frame.components or (None,)
    if own is not None and own.kind is ComponentKind.RANGE:
        parts = {name: part for name, part in parts.items() if name != "range"}
    if own is None or not parts:
        return frame
    further = [
        _component(part, kind_of(name) or ComponentKind.UNDEFINED)
        for name, part in sorted(parts.items(), key=lambda entry: _place(entry[0]))
    ]
    return replace(frame, parts=(own, *further))


def _place(name: str) -> tuple[int, str]:
    kind = kind_of(name)
    return (len(_KINDS) if kind is None else int(kind), name)


def _component(frame: Frame, kind: ComponentKind) -> Component:
    return Component(
        frame.payload,
        frame.width,
        frame.height,
        frame.pixel_format,
        kind,
        padding_x=frame.padding_x,
        big_endian=frame.big_endian,
    )
