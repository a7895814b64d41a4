"""The connection: its states in order, its messages, and nothing left behind."""

import threading
import time
from dataclasses import replace

import pytest

from grabbergui.core.errors import (
    AccessDeniedError,
    SourceNotFoundError,
    TransportError,
    UsageError,
)
from grabbergui.core.grabber import Access
from grabbergui.models.messages import Cause
from opener_bench import S, Source
from patience import PATIENCE, until


def test_states_come_in_order_and_all_calls_from_one_thread_that_is_not_ours(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    bench.link.stream.stop()
    bench.until(S.OPEN)
    bench.link.stream.start()
    bench.until(S.STREAMING)
    bench.sources.close_current()
    assert bench.sources.wait_closed(PATIENCE)
    assert bench.states == [S.OPENING, S.OPEN, S.STREAMING, S.OPEN, S.STREAMING, S.CLOSED]
    assert bench.source.calls == ["open", "start", "stop", "start", "close"]
    assert bench.source.threads == {"features sim:"}


def test_features_exist_when_opened_is_emitted(bench):
    seen = []
    bench.sources.opened.connect(lambda source: seen.append((source.grabber, source.features.root.name)))
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    assert seen == [(bench.source, "Root")]


def test_reports_of_a_source_are_passed_on_until_it_is_closed(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    bench.source.noticed.emit("images are 320×240 now")
    assert bench.texts() == ["Images are 320×240 now"] and bench.failures == []
    bench.sources.close_current()
    assert bench.texts() == []


def test_connecting_does_not_wait_and_can_be_cancelled(bench):
    bench.source.opening.clear()
    begun = time.monotonic()
    bench.link.connect_to("sim:")
    bench.sources.close_current()
    assert time.monotonic() - begun < PATIENCE / 2, "as long as the source takes to open"
    assert bench.states == [S.OPENING, S.CLOSED]
    bench.source.opening.set()
    assert bench.sources.wait_closed(PATIENCE)
    assert "start" not in bench.source.calls
    assert bench.states == [S.OPENING, S.CLOSED], "late answers are ignored"
    assert bench.source.calls in (["open", "close"], [])


def test_a_failure_to_open_is_reported_and_the_source_is_closed(bench):
    bench.source.problem = AccessDeniedError("another application holds the camera")
    bench.link.connect_to("sim:")
    bench.until(S.CLOSED)
    assert bench.sources.wait_closed(PATIENCE)
    assert bench.failures == ["another application holds the camera"]
    assert bench.source.calls == ["open", "open", "close"], "to control it, then to look at it only"


def test_why_nothing_is_connected_is_said_until_the_next_attempt(bench):
    """After 30 s only "Not connected" was left."""
    bench.source.problem = TransportError("the cable is out")
    bench.link.connect_to("sim:")
    until(bench.texts)
    (message,) = bench.link.messages.shown(None)
    assert (message.cause, message.ends) == (Cause.OPENING, None)
    bench.source.problem = None
    bench.link.connect_to("sim:")
    assert bench.texts() == []


def test_a_failure_to_open_another_source_is_said_for_a_while(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    bench.source.problem = TransportError("the cable is out")
    bench.link.connect_to("gige:1.2.3.4")
    until(bench.texts)
    (message,) = bench.link.messages.shown(bench.sources.current)
    assert message.cause is Cause.OPENING and message.ends is not None


def test_with_several_open_the_next_one_is_opened_beside_them(bench):
    """The tile of the current one vanished without a word."""
    bench.others = {f"sim:{name}": Source() for name in ("one", "two", "three")}
    bench.link.connect_to("sim:one")
    bench.until(S.STREAMING)
    bench.link.open_additional("sim:two")
    until(lambda: len(bench.sources.all) == 2)
    assert bench.link.replaced_by("sim:three") is None
    bench.link.connect_to("sim:three")
    assert bench.sources.current.title == bench.sources.all[0].title, "until the new one is open"
    until(lambda: [str(source.uri) for source in bench.sources.all] == ["sim:one", "sim:two", "sim:three"])
    until(lambda: str(bench.sources.current.uri) == "sim:three" and bench.sources.state is S.STREAMING)
    assert bench.sources.pending is None
    assert bench.link.replaced_by("sim:three") is bench.sources.current, (
        "opening the current one again closes it"
    )


def test_a_source_that_does_not_start_stays_open(bench):
    bench.source.start_problem = TransportError("no bandwidth left")
    bench.link.connect_to("sim:")
    until(lambda: bench.failures)
    assert bench.failures == ["Acme Script does not start: no bandwidth left"]
    assert bench.sources.state is S.OPEN


def test_a_malformed_uri_is_refused_and_the_open_source_stays(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    with pytest.raises(UsageError):
        bench.link.connect_to("no scheme")
    assert bench.sources.state is S.STREAMING


def test_another_source_replaces_the_first(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    first, bench.source = bench.source, Source()
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    assert bench.sources.current.grabber is bench.source
    assert bench.sources.wait_closed(PATIENCE)
    assert first.calls[-1] == "close"


def test_a_recording_is_played_and_the_camera_stays_open_also_if_it_cannot_be(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    camera, bench.source = bench.sources.current, Source()
    bench.link.play("file:/one.mcap")
    until(lambda: bench.sources.current is not camera and bench.sources.state is S.STREAMING)
    bench.source = Source()
    bench.link.play("file:/two.mcap")
    until(lambda: bench.sources.current.uri.name == "/two.mcap" and bench.sources.state is S.STREAMING)
    assert len(bench.sources.all) == 2, "one recording replaces another"
    bench.sources.close_current()
    assert bench.sources.current is camera

    bench.source = Source()
    bench.source.problem = AccessDeniedError("no such file")
    bench.link.play("file:/three.mcap")
    until(lambda: bench.failures == ["no such file"])
    until(lambda: bench.sources.all == (camera,) and bench.sources.current is camera)
    assert camera.state is S.STREAMING


def test_recordings_that_are_played_one_after_the_other_have_one_tile(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    camera = bench.sources.current

    def play(name):
        bench.source = Source()
        bench.link.play(f"file:{name}")
        until(lambda: bench.sources.current.uri.name == name and bench.sources.state is S.STREAMING)

    bench.source = Source()
    bench.link.open_additional("file:/opened by hand.mcap")
    until(lambda: bench.sources.all[-1].state is S.STREAMING)
    for name in ("/one.mcap", "/two.mcap", "/three.mcap"):
        assert bench.sources.current is camera
        play(name)
        bench.sources.make_current(camera)
    play("/four.mcap")
    play("/five.mcap")
    bench.sources.make_current(camera)
    again = bench.sources.all[-1]
    assert bench.link.replaced_by("file:/six.mcap", playing=True) is again
    play("/five.mcap")
    assert bench.sources.current is again, "the tile of the same recording"
    names = [source.uri.name for source in bench.sources.all]
    assert names == ["", "/opened by hand.mcap", "/five.mcap"]


def test_twenty_connections_leave_no_thread(bench):
    before = set(threading.enumerate())
    for _ in range(20):
        bench.link.connect_to("sim:")
        bench.until(S.STREAMING)
        bench.sources.close_current()
    assert bench.sources.wait_closed(PATIENCE)
    assert not set(threading.enumerate()) - before


class Held(Source):
    """Controlled by another program until that releases it."""

    def __init__(self, held=True, monitored=True):
        super().__init__()
        self.held, self.monitored = held, monitored
        self.refuses_take_over = False

    def open(self, access=Access.CONTROL):
        self._note(f"open {access.value}")
        taken = access is Access.TAKE_OVER and self.refuses_take_over
        if taken or (self.held and (access is Access.CONTROL or not self.monitored)):
            raise AccessDeniedError("another application at 10.0.0.5 controls it; close it there")
        self._access = access

    def start(self, *, keep_trigger=False):
        if self.access is Access.MONITOR:
            raise AccessDeniedError("the camera sends its images to 10.0.0.5")
        super().start()


def notices(bench):
    return [message.text for message in bench.link.messages.shown(bench.sources.current)]


def test_a_program_that_controls_the_camera_no_more_is_no_longer_named(bench):
    bench.source = source = Held()
    bench.link.connect_to("fake:")
    bench.until(S.OPEN)
    until(lambda: bench.sources.current.no_frames)
    source.held_changed.emit(True)
    assert "10.0.0.5" in notices(bench)[0], "what is known already changes nothing"
    bench.link.messages.dismiss(bench.link.messages.shown(bench.sources.current)[0])

    source.held_changed.emit(False)
    (message,) = bench.link.messages.shown(bench.sources.current)
    assert message.text.startswith("read only: no other application controls it any more; values")
    assert [offer.label for offer in message.offers] == ["Take control"]
    assert not bench.sources.current.no_frames

    source.held_changed.emit(True)
    assert notices(bench)[0].startswith("read only: another application controls it; values")
    source.held = False
    bench.link.take_control()
    bench.until(S.STREAMING)
    source.held_changed.emit(False)
    assert not bench.sources.current.read_only


def test_control_that_is_freed_while_a_camera_is_opened_for_reading_is_offered(bench):
    class Freed(Held):
        def open(self, access=Access.CONTROL):
            super().open(access)
            self.held_changed.emit(False)

    bench.source = Freed()
    bench.link.connect_to("fake:")
    until(lambda: notices(bench) and "no other application" in notices(bench)[0])


def test_a_camera_that_another_program_controls_is_opened_for_reading(bench):
    bench.source = source = Held()
    bench.link.connect_to("fake:")
    bench.until(S.OPEN)
    until(lambda: bench.sources.current.no_frames)
    assert source.access is Access.MONITOR and "10.0.0.5" in bench.sources.current.read_only
    assert bench.failures == []
    (message,) = bench.link.messages.shown(bench.sources.current)
    assert "10.0.0.5" in message.text and [offer.label for offer in message.offers] == ["Take control"]

    source.refuses_take_over = True
    bench.link.take_control()
    until(lambda: any("control was not given" in text for text in notices(bench)), "the refusal")
    assert "10.0.0.5" in notices(bench)[0] and bench.sources.current.read_only

    source.held = source.refuses_take_over = False
    until(lambda: bench.sources.current.no_frames)
    bench.link.take_control()
    bench.until(S.STREAMING)
    assert not bench.sources.current.read_only
    assert notices(bench) == ["this window has control now: values can be changed"]
    assert source.access is Access.TAKE_OVER, "on purpose, so that it may be taken from one who offers it"


def test_where_reading_is_refused_too_the_first_refusal_is_reported(bench):
    bench.source = Held(monitored=False)
    bench.link.connect_to("fake:")
    bench.until(S.CLOSED)
    assert bench.failures == ["another application at 10.0.0.5 controls it; close it there"]


def test_a_wrong_address_leaves_the_current_source_untouched(bench):
    bench.others["sim:gone"] = gone = Source()
    gone.problem = SourceNotFoundError("no camera answers there")
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    kept, reported = bench.sources.current, []
    bench.sources.pending_changed.connect(reported.append)
    bench.sources.closing.connect(reported.append)
    bench.link.connect_to("sim:gone")
    until(lambda: bench.failures, "a failure")
    assert bench.failures == ["no camera answers there"]
    assert bench.sources.current is kept and bench.sources.all == (kept,) and bench.sources.pending is None
    assert [getattr(source, "uri", None) and str(source.uri) for source in reported] == ["sim:gone", None]
    assert bench.states == [S.OPENING, S.OPEN, S.STREAMING] and bench.source.calls == ["open", "start"]
    until(lambda: "close" in gone.calls, "its release")


def test_the_current_source_continues_until_the_next_one_is_open(bench):
    first, slow = bench.open_slowly_instead()
    until(lambda: slow.calls, "opening")
    assert bench.sources.current is first and bench.source.streaming and bench.sources.pending is not None
    slow.opening.set()
    until(
        lambda: bench.sources.current is not first and bench.sources.state is S.STREAMING,
        "the next one",
    )
    assert bench.sources.current.grabber is slow and len(bench.sources.all) == 1
    assert bench.states == [S.OPENING, S.OPEN, S.STREAMING] * 2
    until(lambda: "close" in bench.source.calls, "the release of the first")


def test_a_source_that_is_being_opened_can_be_cancelled(bench):
    first, slow = bench.open_slowly_instead()
    bench.sources.cancel_pending()
    slow.opening.set()
    assert bench.sources.current is first and bench.sources.pending is None
    until(lambda: slow.calls[-1:] == ["close"] or not slow.calls, "its release")
    bench.link.connect_to("sim:")
    assert bench.sources.current is not first, "it was closed and opened again"
    assert bench.failures == []


class OneCamera(Source):
    """A camera with two names: whoever opens it holds it."""

    held = False

    def __init__(self, broken=False, shy=False):
        super().__init__()
        self.broken, self.shy, self.holds = broken, shy, False
        self.known_as = replace(self.info, serial="SN7")
        if not shy:  # one that is says who it is only once it is open
            self.info = self.known_as

    def open(self, access=Access.CONTROL):
        self._note(f"open {access.value}")
        if access is Access.CONTROL:
            if OneCamera.held or self.broken:
                raise AccessDeniedError("another application controls it")
            OneCamera.held = self.holds = True
        elif not self.shy:
            raise AccessDeniedError("it shows nothing either")
        self.info, self._access = self.known_as, access

    def close(self):
        if self.holds:
            OneCamera.held = self.holds = False
        super().close()


@pytest.mark.parametrize(
    ("broken", "shy"), [(False, False), (False, True), (True, False)], ids=["opens", "is shy", "does not"]
)
def test_the_same_camera_under_another_name_is_closed_first_and_reopened_on_failure(bench, broken, shy):
    OneCamera.held = False
    bench.others["sim:serial"] = OneCamera()
    bench.others["sim:address"] = OneCamera(broken, shy)
    bench.link.connect_to("sim:serial")
    bench.until(S.STREAMING)
    first = bench.sources.current
    if broken:
        bench.others["sim:serial"] = OneCamera()  # the one that comes back
    bench.link.connect_to("sim:address")
    until(
        lambda: bench.sources.current not in (first, None) and bench.sources.state is S.STREAMING,
        "the next one",
    )
    assert str(bench.sources.current.uri) == ("sim:serial" if broken else "sim:address")
    assert bench.failures == (["another application controls it"] if broken else [])
    assert not bench.sources.current.read_only and len(bench.sources.all) == 1


class Pair:
    """Two open sources, of which the first is current, and the order of what is opened and released."""

    def __init__(self, bench):
        self.link, self.reported = bench.link, []
        self.other = bench.others["sim:colour"] = Source()
        bench.link.connect_to("sim:")
        bench.until(S.STREAMING)
        self.first = bench.sources.current
        bench.link.open_additional("sim:colour")
        self.beside = bench.sources.all[1]
        until(lambda: self.beside.state is S.STREAMING)
        bench.sources.opened.connect(lambda source: self.reported.append(("opened", source)))
        bench.sources.closing.connect(lambda source: self.reported.append(("closing", source)))
        bench.sources.ending.connect(lambda source: self.reported.append(("ending", source)))
        del bench.states[:]


@pytest.fixture
def pair(bench):
    return Pair(bench)


def test_a_source_opened_in_the_background_leaves_the_other_current(bench, pair):
    assert bench.sources.current is pair.first and pair.beside.state is S.STREAMING
    assert bench.source.streaming and pair.other.streaming
    assert bench.states == [], "nothing happened to the current one"


def test_a_source_made_current_is_announced_like_a_newly_opened_one(bench, pair):
    bench.sources.make_current(pair.beside)
    assert pair.reported == [("closing", pair.first), ("opened", pair.beside)]
    assert bench.states == [S.OPENING, S.STREAMING]
    assert bench.sources.current is pair.beside and bench.source.streaming, (
        "the first goes on in the background"
    )
    bench.link.connect_to("sim:")
    assert bench.sources.current is pair.first, "connecting to a background source makes it current"
    assert bench.source.calls == ["open", "start"]


def test_closing_one_leaves_the_other(bench, pair):
    bench.sources.close(pair.beside)
    assert pair.reported == [("ending", pair.beside)] and bench.states == []
    assert bench.sources.wait_closed(PATIENCE) and "close" in pair.other.calls
    assert bench.sources.all == (pair.first,)


def test_when_the_current_source_is_closed_the_other_becomes_current(bench, pair):
    bench.sources.close_current()
    assert pair.reported[:2] == [("closing", pair.first), ("ending", pair.first)]
    assert bench.sources.current is pair.beside and bench.states == [
        S.CLOSED,
        S.OPENING,
        S.STREAMING,
    ]


def test_an_open_source_is_not_opened_in_the_background(bench, pair):
    for uri in ("sim:", "sim:colour"):
        bench.link.open_additional(uri)
    assert bench.failures == ["sim: is open already", "sim:colour is open already"]
    assert len(bench.sources.all) == 2


def test_a_background_source_that_fails_to_open_is_reported_and_removed(bench, pair):
    bench.others["sim:scene"] = broken = Source()
    broken.problem = TransportError("no such camera")
    bench.link.open_additional("sim:scene")
    until(lambda: bench.failures, "the failure")
    assert bench.failures == ["no such camera"] and bench.sources.current is pair.first
    assert len(bench.sources.all) == 2
