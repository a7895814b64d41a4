"""How a source is doing: one condition at a time, from which every text derives."""

from dataclasses import replace

import pytest

from every_case import every_case
from fakes import ScriptedGrabber
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.grabber import ConnectionState
from grabbergui.models.diagnosis import Health, StreamHealth
from grabbergui.models.open_source import LinkState
from grabbergui.models.source_opener import SourceOpener
from grabbergui.models.status import (
    MOST_STEP,
    Condition,
    SourceReading,
    SourceStatus,
    StatusModel,
    Tone,
    rate_text,
)
from patience import PATIENCE, until

RUNNING = SourceReading(LinkState.STREAMING, frames=100, silent=0.1)
SILENT = replace(RUNNING, silent=5.0)
EMPTY = SourceReading(LinkState.STREAMING, silent=0.5)


@every_case(
    ("sighting", "condition"),
    [
        (SourceReading(LinkState.CLOSED), Condition.CLOSED),
        (SourceReading(LinkState.OPENING), Condition.CONNECTING),
        (SourceReading(LinkState.OPEN), Condition.STOPPED),
        (SourceReading(LinkState.OPEN, read_only=True), Condition.READ_ONLY),
        (replace(SILENT, link=LinkState.LOST, triggered=True, held=True), Condition.LOST),
        (RUNNING, Condition.LIVE),
        (replace(RUNNING, read_only=True), Condition.LIVE),
        (replace(RUNNING, triggered=True), Condition.LIVE),
        (SILENT, Condition.STALLED),
        (replace(SILENT, period=4.0), Condition.LIVE),
        (replace(SILENT, triggered=True), Condition.WAITING),
        (replace(EMPTY, triggered=True), Condition.WAITING),
        (EMPTY, Condition.STARTING),
        (replace(EMPTY, silent=3.0), Condition.STALLED),
        (replace(RUNNING, playing=True), Condition.PLAYING),
        (replace(SILENT, playing=True), Condition.PLAYING),
        (replace(SILENT, playing=False), Condition.PAUSED),
        (replace(RUNNING, held=True), Condition.PAUSED),
        (replace(SILENT, triggered=True, held=True), Condition.PAUSED),
    ],
)
def test_the_condition_of_a_source(sighting, condition):
    assert sighting.condition is condition


@every_case("condition", Condition)
def test_every_condition_has_its_words(condition):
    status = SourceStatus(condition, seconds=13, rate=20)
    assert status.text and status.tile
    assert ("connection lost" in status.title("Acme")) == (condition is Condition.LOST)
    assert (status.tone is Tone.GOOD) == (condition in (Condition.LIVE, Condition.PLAYING))
    assert (status.tone is Tone.BAD) == (condition is Condition.LOST)


def test_a_tile_shows_no_rate_that_contradicts_its_state():
    live = SourceStatus(Condition.LIVE, rate=0.0)
    assert live.tile == "live"
    assert replace(live, health=StreamHealth(Health.LOSING)).tile == "live, losing frames"
    assert [rate_text(rate) for rate in (0.0, 0.08, 0.5, 7.46, 30.0, 123.4)] == [
        "0.0",
        "0.08",
        "0.5",
        "7.5",
        "30.0",
        "123.4",
    ]
    assert (replace(live, rate=0.5).tile, replace(live, rate=1.4).tile) == ("0.5 fps", "1 fps")


def test_a_stream_that_loses_something_is_not_plainly_good():
    live = SourceStatus(Condition.LIVE, rate=20)
    assert (live.tone, live.loss_tone, live.tile) == (Tone.GOOD, Tone.IDLE, "20 fps")
    resent = replace(live, health=StreamHealth(Health.RESENT))
    assert (resent.tone, resent.loss_tone, resent.tile) == (Tone.BUSY, Tone.BUSY, "20 fps")
    losing = replace(live, health=StreamHealth(Health.LOSING))
    assert (losing.tone, losing.loss_tone, losing.tile) == (Tone.BUSY, Tone.BAD, "20 fps, losing frames")


def test_a_recording_is_in_the_title():
    assert SourceStatus(Condition.LIVE, recorded=True).title("Acme") == "● Recording — Acme"


class Counting(ScriptedGrabber):
    """A camera whose counters a test sets."""

    def __init__(self):
        mode = Feature(
            name="TriggerMode", kind=FeatureKind.ENUMERATION, access=AccessMode.READ_WRITE, value="Off"
        )
        super().__init__([mode])
        self.count = StreamStatistics()

    def statistics(self):
        return replace(self.count)


class Stand:
    """A camera that streams, its status, and a clock that the test turns."""

    def __init__(self):
        self.now = 0.0
        self.camera = Counting()
        self.link = SourceOpener(lambda uri: self.camera)
        self.model = StatusModel(self.link.open_sources, lambda: self.now)
        self.link.connect_to("sim:")
        until(lambda: self.link.open_sources.state is LinkState.STREAMING)

    def look(self, seconds=0.2, frames=0):
        self.now += seconds
        self.camera.count.frames += frames
        self.model.refresh()
        return self.model.of(self.link.open_sources.current)

    def wait(self, seconds, frames=0):
        for _ in range(round(seconds / 0.2)):
            status = self.look(frames=frames)
        return status


@pytest.fixture
def stand():
    stand = Stand()
    yield stand
    stand.model.close()
    stand.link.open_sources.close_all()
    assert stand.link.open_sources.wait_closed(PATIENCE)


def test_a_source_with_frames_is_live_and_silence_is_measured(stand):
    assert stand.look().condition is Condition.STARTING
    assert stand.wait(1, frames=4).condition is Condition.LIVE
    stalled = stand.wait(3)
    assert (stalled.condition, stalled.text) == (Condition.STALLED, "No frame for 3 s")
    assert stand.look(frames=1).condition is Condition.LIVE


def test_a_busy_window_is_not_mistaken_for_a_silent_source(stand):
    stand.look()
    assert stand.look(seconds=30).seconds <= MOST_STEP
    assert stand.model.of(stand.link.open_sources.current).condition is Condition.STARTING


def test_a_trigger_that_is_switched_on_is_waited_for(stand):
    stand.wait(1, frames=4)
    stand.camera.set("TriggerMode", "On")

    def waits():
        return stand.look().condition is Condition.WAITING

    until(waits)
    assert stand.look().facts.trigger_source == "an input"
    assert stand.look(frames=1).condition is Condition.LIVE, "a frame was triggered"
    stand.camera.set("TriggerMode", "Off")
    until(lambda: stand.look(frames=1).facts.trigger_source is None)


def test_a_loss_is_measured_and_ends(stand):
    stand.wait(1, frames=4)
    stand.camera.connection_changed.emit(ConnectionState.LOST, "gone")
    stand.link.open_sources.current.lost_since = stand.now
    lost = stand.wait(4)
    assert (lost.condition, lost.text, lost.tone) == (Condition.LOST, "Lost for 4 s", Tone.BAD)
    stand.camera.connection_changed.emit(ConnectionState.OPEN, "")
    assert stand.look(frames=1).condition is Condition.LIVE


def test_nothing_is_left_of_a_source_that_is_closed(stand):
    stand.look()
    source, heard = stand.link.open_sources.current, len(stand.camera.features_changed)
    stand.link.open_sources.close_current()
    stand.model.refresh()
    assert len(stand.camera.features_changed) < heard
    assert stand.model.of(None).condition is Condition.CLOSED
    assert stand.model.of(source) == SourceStatus(Condition.STARTING), "only what the source itself knows"
