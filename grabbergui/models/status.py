"""Status of each open source.

Status strip, title, tiles and messages all show this one state, so they cannot contradict each other.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum

from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.grabber import FrameGrabber
from grabbergui.models.diagnosis import CameraFacts, Health, HealthMeter, StreamHealth
from grabbergui.models.language import QT_TRANSLATE_NOOP, localized, translate
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.open_sources import OpenSources

LEAST_RATE = 0.05
"Frames per second below which a tile shows no rate."
STALLED = 1.0
"Seconds without a frame after which the silence is shown."
STARTING = 2.0
"Seconds that the first frame may take."
MOST_STEP = 0.5
"""Most seconds of silence that count between two observations: while the window is busy, it may miss the
frames of a source."""
FACTS_PERIOD = 1.0
"Seconds between two reads from a source that sends no frames."
_DECISIVE = frozenset({"TriggerMode", "TriggerSource", "TriggerSelector", "PlaybackActive"})
"Features whose change may change the condition."


class Condition(Enum):
    """The condition of a source, with seconds for {0}."""

    CLOSED = QT_TRANSLATE_NOOP("Status", "Not connected")
    CONNECTING = QT_TRANSLATE_NOOP("Status", "Connecting")
    STOPPED = QT_TRANSLATE_NOOP("Status", "Stopped")
    READ_ONLY = QT_TRANSLATE_NOOP("Status", "Read only")
    STARTING = QT_TRANSLATE_NOOP("Status", "Starting")
    LIVE = QT_TRANSLATE_NOOP("Status", "Live")
    PLAYING = QT_TRANSLATE_NOOP("Status", "Playing")
    PAUSED = QT_TRANSLATE_NOOP("Status", "Paused")
    WAITING = QT_TRANSLATE_NOOP("Status", "Waiting for trigger")
    STALLED = QT_TRANSLATE_NOOP("Status", "No frame for {0:.0f} s")
    LOST = QT_TRANSLATE_NOOP("Status", "Lost for {0:.0f} s")


class Tone(Enum):
    """Colour class of a condition."""

    IDLE = "idle"
    BUSY = "busy"
    GOOD = "good"
    BAD = "bad"


_TONES = {
    Condition.CLOSED: Tone.IDLE,
    Condition.STOPPED: Tone.IDLE,
    Condition.READ_ONLY: Tone.IDLE,
    Condition.LIVE: Tone.GOOD,
    Condition.PLAYING: Tone.GOOD,
    Condition.LOST: Tone.BAD,
}
"All other conditions are busy."


def rate_text(rate: float) -> str:
    """Return a frame rate as display text: a decimal, and two below a tenth."""
    return localized(f"{rate:.2f}" if 0 < rate < 0.095 else f"{rate:.1f}")


@dataclass(frozen=True)
class SourceReading:
    """Observations of a source at one moment, from which `condition` follows."""

    link: LinkState
    read_only: bool = False
    frames: int = 0
    "Frames since the stream was started."
    silent: float = 0.0
    "Seconds without a frame."
    period: float = 0.0
    "Frame period in seconds by the camera's settings; 0 if unknown."
    triggered: bool = False
    "Whether frames come only when the camera is triggered."
    playing: bool | None = None
    "Whether a recording plays; None for a camera."
    held: bool = False
    "Whether the window shows a past frame."

    @property
    def condition(self) -> Condition:
        """The condition of the source."""
        if self.link is not LinkState.STREAMING:
            stopped = Condition.READ_ONLY if self.read_only else Condition.STOPPED
            return {
                LinkState.CLOSED: Condition.CLOSED,
                LinkState.OPENING: Condition.CONNECTING,
                LinkState.LOST: Condition.LOST,
            }.get(self.link, stopped)
        if self.held or self.playing is False:
            return Condition.PAUSED
        if self.playing:
            return Condition.PLAYING
        if self.frames and self.silent < max(STALLED, 3 * self.period):
            return Condition.LIVE
        if self.triggered:
            return Condition.WAITING
        if not self.frames and self.silent < max(STARTING, 3 * self.period):
            return Condition.STARTING
        return Condition.STALLED


@dataclass(frozen=True)
class SourceStatus:
    """A source's status as the window shows it."""

    condition: Condition = Condition.CLOSED
    seconds: float = 0.0
    "Duration of the loss or the silence in seconds."
    rate: float = 0.0
    "Frames per second."
    health: StreamHealth = field(default_factory=StreamHealth)
    statistics: StreamStatistics | None = None
    "None if nothing is open."
    facts: CameraFacts = field(default_factory=CameraFacts)
    recorded: bool = False
    "Whether it is being recorded."

    @property
    def text(self) -> str:
        """The condition as display text, a few words."""
        return translate("Status", self.condition.value).format(self.seconds)

    @property
    def tone(self) -> Tone:
        """Colour class of the condition; a stream with losses is never good."""
        tone = _TONES.get(self.condition, Tone.BUSY)
        return Tone.BUSY if tone is Tone.GOOD and self.health.health is not Health.WHOLE else tone

    @property
    def loss_tone(self) -> Tone:
        """Colour class of the losses."""
        return {Health.WHOLE: Tone.IDLE, Health.RESENT: Tone.BUSY}.get(self.health.health, Tone.BAD)

    @property
    def tile(self) -> str:
        """The status in a few letters: the frame rate while frames arrive."""
        rate = self.text.lower()  # "0 fps" would contradict "live"
        if self.rate >= LEAST_RATE:
            digits = f"{self.rate:.0f}" if self.rate >= 1 else localized(f"{self.rate:.1f}")
            rate = translate("Status", "{0} fps").format(digits)
        if self.condition is Condition.LIVE and self.health.health in (Health.LOSING, Health.OVERRUN):
            return translate("Status", "{0}, losing frames").format(rate)
        if self.condition is Condition.LIVE:
            return rate
        return self.text.lower()

    def title(self, name: str) -> str:
        """Return the title of a window that shows the source under this name."""
        parts = [name]
        if self.recorded:
            parts.insert(0, translate("Status", "● Recording"))
        if self.condition is Condition.LOST:
            parts.append(translate("Status", "connection lost"))
        return " — ".join(parts)


class StatusModel:
    """Observes every open source with each `refresh`. One thread; no call waits."""

    def __init__(self, open_sources: OpenSources, clock: Callable[[], float] = time.monotonic) -> None:
        self._open_sources = open_sources
        self._clock = clock
        self._watches: dict[OpenSource, _Watch] = {}
        self.held = False
        "Whether the window shows a past frame of the current source."
        self.recorded: Callable[[OpenSource], bool] = lambda source: False
        "Whether a source is being recorded."

    def refresh(self) -> None:
        """Observe every open source."""
        sources = self._open_sources.all
        for closed in self._watches.keys() - set(sources):
            self._watches.pop(closed).close()
        for source in sources:
            if source not in self._watches:
                self._watches[source] = _Watch(source)
            self._watches[source].observe(self._clock())

    def of(self, source: OpenSource | None) -> SourceStatus:
        """Return the status of a source. Only the current one can be paused by a past frame."""
        if source is None:
            return SourceStatus()
        watch = self._watches.get(source)
        if watch is None:
            return SourceStatus(SourceReading(source.state, bool(source.read_only)).condition)
        held = self.held and source is self._open_sources.current
        return watch.status(self._clock(), held, self.recorded(source))

    def close(self) -> None:
        """Stop observing."""
        for watch in self._watches.values():
            watch.close()
        self._watches.clear()


class _Watch:
    """Observes one source."""

    def __init__(self, source: OpenSource) -> None:
        self._source = source
        self._grabber: FrameGrabber | None = None
        self._statistics: StreamStatistics | None = None
        self._meter = HealthMeter()
        self._health = StreamHealth()
        self._facts = CameraFacts()
        self._observed: float | None = None
        self._silent = 0.0
        self._changed = True
        "Whether the facts may have changed. Set by any thread."
        self._requested = -FACTS_PERIOD

    def observe(self, now: float) -> None:
        """Read the counters; request the camera's facts on its own thread if they may have changed."""
        step = min(now - self._observed, MOST_STEP) if self._observed is not None else 0.0
        self._observed = now
        grabber = self._source.grabber
        if grabber is None or self._source.features is None:
            return
        if self._grabber is None:
            self._grabber = grabber
            grabber.features_changed.connect(self._on_features_changed)
        before, self._statistics = self._statistics, grabber.statistics()
        self._health = self._meter.judge(now, self._statistics)
        streams = self._source.state is LinkState.STREAMING
        arrived = before is None or before.frames != self._statistics.frames
        self._silent = self._silent + step if streams and not arrived else 0.0
        silent = streams and self._silent >= STALLED
        if not self._source.state.connected:
            self._changed = True
        elif self._changed or (silent and now - self._requested >= FACTS_PERIOD):
            self._request_facts(grabber, now)

    def status(self, now: float, held: bool, recorded: bool) -> SourceStatus:
        """Return the status that follows from the observations."""
        source, statistics = self._source, self._statistics
        sighting = SourceReading(
            source.state,
            bool(source.read_only),
            statistics.frames if statistics is not None else 0,
            self._silent,
            self._facts.period or 0.0,
            self._facts.trigger_source is not None,
            self._facts.playing,
            held,
        )
        lost = now - source.lost_since if source.lost_since is not None else 0.0
        return SourceStatus(
            sighting.condition,
            lost if sighting.condition is Condition.LOST else self._silent,
            statistics.frame_rate if statistics is not None else 0.0,
            self._health,
            statistics,
            self._facts,
            recorded,
        )

    def close(self) -> None:
        if self._grabber is not None:
            self._grabber.features_changed.disconnect(self._on_features_changed, missing_ok=True)

    def _request_facts(self, grabber: FrameGrabber, now: float) -> None:
        self._requested, self._changed = now, False
        self._source.worker.submit(lambda: CameraFacts.read(grabber), key="facts", done=self._on_facts)

    def _on_facts(self, facts: CameraFacts) -> None:
        self._facts = facts

    def _on_features_changed(self, names: frozenset[str]) -> None:
        if not names.isdisjoint(_DECISIVE):
            self._changed = True
