"""The connection: its states in order, failures in words, and nothing left behind."""

import re
import threading
import time
from dataclasses import replace

import pytest

from fakes import ScriptedGrabber
from grabbergui.core.errors import (
    AccessDeniedError,
    DeviceLostError,
    FeatureValueError,
    SourceNotFoundError,
    TransportError,
    UsageError,
)
from grabbergui.core.grabber import Access, ConnectionState
from grabbergui.core.settings import SettingKey
from grabbergui.models.connection import Connection
from grabbergui.models.messages import Severity
from grabbergui.models.open_source import LinkState
from lost_camera import away
from patience import PATIENCE, until

S = LinkState


class Source(ScriptedGrabber):
    """Opens as the test says; counts its calls and the threads they come from."""

    def __init__(self):
        super().__init__()
        self.calls = []
        self.opening = threading.Event()
        self.opening.set()
        self.problem = None
        self.start_problem = None

    def _note(self, call):
        self.calls.append(call)
        self.threads.add(threading.current_thread().name)

    def open(self, *args):
        self._note("open")
        assert self.opening.wait(PATIENCE)
        if self.problem:
            raise self.problem

    def start(self, *, keep_trigger=False):
        self._note("start")
        if self.start_problem:
            raise self.start_problem
        super().start()

    def stop(self):
        self._note("stop")
        super().stop()

    def close(self):
        self._note("close")
        super().close()


class Bench:
    def __init__(self):
        self.source = Source()
        self.others = {}
        self.link = Connection(lambda uri: self.others.get(str(uri), self.source))
        self.states = []
        self.failures = []
        self.link.state_changed.connect(lambda state, reason: self.states.append(state))
        self.link.failed.connect(self.failures.append)

    def said(self):
        """The messages that are to be seen."""
        return [message.sentence for message in self.link.messages.shown(self.link.source)]

    def until(self, state, seconds=PATIENCE):
        deadline = time.monotonic() + seconds
        while self.link.state is not state:
            assert time.monotonic() < deadline, f"{self.link.state}, not {state}: {self.failures}"
            time.sleep(0.002)

    def open_slowly_instead(self):
        """Return the current source, and the grabber that opens in its place once its `opening` is set."""
        self.others["sim:slow"] = slow = Source()
        slow.opening.clear()
        self.link.connect_to("sim:")
        self.until(S.STREAMING)
        first = self.link.source
        self.link.connect_to("sim:slow")
        return first, slow


@pytest.fixture
def bench():
    bench = Bench()
    yield bench
    bench.source.opening.set()
    bench.link.close_all()
    assert bench.link.wait_closed(PATIENCE)
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("features ")]


def test_states_come_in_order_and_all_calls_from_one_thread_that_is_not_ours(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    bench.link.stop()
    bench.until(S.OPEN)
    bench.link.start()
    bench.until(S.STREAMING)
    bench.link.disconnect()
    assert bench.link.wait_closed(PATIENCE)
    assert bench.states == [S.OPENING, S.OPEN, S.STREAMING, S.OPEN, S.STREAMING, S.CLOSED]
    assert bench.source.calls == ["open", "start", "stop", "start", "close"]
    assert bench.source.threads == {"features sim:"}


def test_features_are_there_when_it_says_opened(bench):
    seen = []
    bench.link.opened.connect(lambda source: seen.append((source.grabber, source.features.root.name)))
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    assert seen == [(bench.source, "Root")]


def test_reports_of_a_source_are_passed_on_until_it_is_closed(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    bench.source.noticed.emit("pictures are 320×240 now")
    assert bench.said() == ["Pictures are 320×240 now"] and bench.failures == []
    bench.link.disconnect()
    assert bench.said() == []


def test_connecting_does_not_wait_and_can_be_given_up(bench):
    bench.source.opening.clear()
    begun = time.monotonic()
    bench.link.connect_to("sim:")
    bench.link.disconnect()
    assert time.monotonic() - begun < PATIENCE / 2, "as long as the source takes to open"
    assert bench.states == [S.OPENING, S.CLOSED]
    bench.source.opening.set()
    assert bench.link.wait_closed(PATIENCE)
    assert "start" not in bench.source.calls
    assert bench.states == [S.OPENING, S.CLOSED], "late answers are ignored"
    assert bench.source.calls in (["open", "close"], [])


def test_a_failure_to_open_is_reported_and_the_source_is_closed(bench):
    bench.source.problem = AccessDeniedError("another application holds the camera")
    bench.link.connect_to("sim:")
    bench.until(S.CLOSED)
    assert bench.link.wait_closed(PATIENCE)
    assert bench.failures == ["another application holds the camera"]
    assert bench.source.calls == ["open", "open", "close"], "to control it, then to look at it only"


def test_a_source_that_does_not_start_stays_open(bench):
    bench.source.start_problem = TransportError("no bandwidth left")
    bench.link.connect_to("sim:")
    deadline = time.monotonic() + PATIENCE
    while not bench.failures and time.monotonic() < deadline:
        time.sleep(0.002)
    assert bench.failures == ["Acme Script does not start: no bandwidth left"]
    assert bench.link.state is S.OPEN


def test_a_malformed_uri_is_refused_and_leaves_what_is_open(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    with pytest.raises(UsageError):
        bench.link.connect_to("no scheme")
    assert bench.link.state is S.STREAMING


def lose(bench, reason="the camera does not answer"):
    bench.source.connection_changed.emit(ConnectionState.LOST, reason)


def come_back(bench, reason="set as before"):
    bench.source.connection_changed.emit(ConnectionState.OPEN, reason)


def test_losses_are_one_line_until_it_is_back_with_a_count(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    for losses in (1, 2):
        lose(bench)
        lose(bench)  # said by two threads, it is still one loss
        assert bench.link.state is S.LOST
        (said,) = bench.said()
        assert re.match(r"Reconnecting since \d\d:\d\d:\d\d: the camera does not answer", said)
        assert ("(×2)" in said) == (losses == 2)
        come_back(bench)
        assert bench.link.state is S.STREAMING
        (said,) = bench.said()
        assert said.startswith("Back after ") and "s, set as before" in said
    assert len(bench.failures) == 2


def test_another_reason_for_which_it_is_still_lost_is_shown_too(bench):
    """As when the server of a lost camera ends, or when another camera is refused in its place."""
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    lose(bench)
    lost_since = bench.link.source.lost_since
    bench.source.connection_changed.emit(ConnectionState.LOST, "another camera is at its address")
    (said,) = bench.said()
    assert said.startswith("Reconnecting since") and said.endswith("another camera is at its address")
    assert bench.link.reason == "another camera is at its address"
    assert (bench.link.source.losses, bench.link.source.lost_since) == (1, lost_since)
    come_back(bench)
    assert bench.link.source.lost_since is None and bench.link.state is S.STREAMING


def test_settings_that_were_not_restored_are_shown_until_dismissed(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    lose(bench)
    bench.source.unlike_before = ("Gain=6: the camera answered: busy",)
    come_back(bench)
    (message,) = bench.link.messages.shown(bench.link.source)
    assert "but not as before: Gain=6" in message.text
    assert (message.severity, message.ends) == (Severity.WARNING, None)
    bench.link.messages.dismiss(message)
    bench.source.unlike_before = ()
    lose(bench)
    (lost,) = bench.link.messages.shown(bench.link.source)
    assert "reconnecting since" in lost.text, "a new loss is news"
    bench.link.messages.dismiss(lost)
    come_back(bench)
    assert "set as before" in bench.said()[0], "and so is its end"


def test_settings_that_others_changed_meanwhile_are_shown_until_dismissed(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    lose(bench)
    bench.source.changed_meanwhile = tuple(f"{name} is 2 instead of 1" for name in "abcde")
    come_back(bench)
    (message,) = bench.link.messages.shown(bench.link.source)
    assert "set as before; changed meanwhile, not by us: a is 2 instead of 1; b" in message.text
    assert message.text.endswith("; and 2 more")
    assert (message.severity, message.ends) == (Severity.WARNING, None)


def test_a_loss_and_what_differs_after_it_are_logged_once(caplog):
    caplog.set_level("INFO")
    link = Connection()
    link.connect_to("sim:?width=64&height=48")
    until(lambda: link.state is S.STREAMING)
    camera = link.source.grabber
    with away(camera, "the cable is out"):
        camera._writes().memory.note(SettingKey("Gain"), 0.004)
        until(lambda: link.state is S.LOST)
    until(lambda: link.messages.shown(link.source)[0].text.startswith("back after"))
    assert "Gain is 0 instead of 0.004" in link.messages.shown(link.source)[0].text
    assert [caplog.text.count(said) for said in ("the cable is out", "Gain is 0 instead of 0.004")] == [1, 1]
    link.close_all()
    link.wait_closed(PATIENCE)


def test_failures_caused_by_a_loss_are_not_shown_in_addition(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    features = bench.link.source.features
    features.failed.emit(TransportError("no answer within 0.5 s"))
    assert bench.said() == ["No answer within 0.5 s"]
    lose(bench)
    features.failed.emit(TransportError("no answer within 0.5 s"))
    features.failed.emit(DeviceLostError("the camera is lost"))
    assert len(bench.said()) == 1 and "Reconnecting since" in bench.said()[0]
    come_back(bench)
    features.failed.emit(DeviceLostError("the camera is lost"))
    assert len(bench.said()) == 1 and "Back after" in bench.said()[0]


def test_a_refused_write_is_shown_for_its_own_camera_only(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    first = bench.link.source
    bench.others["sim:2"] = Source()
    bench.link.open_additional("sim:2")
    first.features.failed.emit(FeatureValueError("Gain=99 is above 24", "Gain"))
    assert bench.said() == ["Gain=99 is above 24"]
    second = bench.link.sources[1]
    until(lambda: second.state is S.STREAMING)
    bench.link.make_current(second)
    assert bench.said() == []


def test_a_failure_to_open_is_shown_until_the_next_attempt(bench):
    bench.source.problem = SourceNotFoundError("no camera answers")
    bench.link.connect_to("sim:")
    bench.until(S.CLOSED)
    until(bench.said)
    assert bench.said() == ["No camera answers"]
    bench.source.problem = None
    bench.link.connect_to("sim:")
    assert bench.said() == []


def test_another_source_takes_the_place_of_the_first(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    first, bench.source = bench.source, Source()
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    assert bench.link.source.grabber is bench.source
    assert bench.link.wait_closed(PATIENCE)
    assert first.calls[-1] == "close"


def test_twenty_connections_leave_no_thread(bench):
    before = threading.active_count()
    for _ in range(20):
        bench.link.connect_to("sim:")
        bench.until(S.STREAMING)
        bench.link.disconnect()
    assert bench.link.wait_closed(PATIENCE)
    assert threading.active_count() == before


class Held(Source):
    """Controlled by another program until that lets go."""

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
            raise AccessDeniedError("the camera sends its pictures to 10.0.0.5")
        super().start()


def said(bench):
    return [message.text for message in bench.link.messages.shown(bench.link.source)]


def test_a_camera_that_another_program_controls_is_opened_for_reading(bench):
    bench.source = source = Held()
    bench.link.connect_to("fake:")
    bench.until(S.OPEN)
    until(lambda: bench.link.source.no_frames)
    assert source.access is Access.MONITOR and "10.0.0.5" in bench.link.source.read_only
    assert bench.failures == []
    (message,) = bench.link.messages.shown(bench.link.source)
    assert "10.0.0.5" in message.text and [offer.label for offer in message.offers] == ["Take control"]

    source.refuses_take_over = True
    bench.link.take_control()
    until(lambda: any("control was not given" in text for text in said(bench)), "the refusal")
    assert "10.0.0.5" in said(bench)[0] and bench.link.source.read_only

    source.held = source.refuses_take_over = False
    until(lambda: bench.link.source.no_frames)
    bench.link.take_control()
    bench.until(S.STREAMING)
    assert not bench.link.source.read_only
    assert said(bench) == ["this window has control now: values can be changed"]
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
    kept, reported = bench.link.source, []
    bench.link.pending_changed.connect(reported.append)
    bench.link.closing.connect(reported.append)
    bench.link.connect_to("sim:gone")
    until(lambda: bench.failures, "a failure")
    assert bench.failures == ["no camera answers there"]
    assert bench.link.source is kept and bench.link.sources == (kept,) and bench.link.pending is None
    assert [getattr(source, "uri", None) and str(source.uri) for source in reported] == ["sim:gone", None]
    assert bench.states == [S.OPENING, S.OPEN, S.STREAMING] and bench.source.calls == ["open", "start"]
    until(lambda: "close" in gone.calls, "letting go of it")


def test_the_current_source_continues_until_the_next_one_is_open(bench):
    first, slow = bench.open_slowly_instead()
    until(lambda: slow.calls, "opening")
    assert bench.link.source is first and bench.source.streaming and bench.link.pending is not None
    slow.opening.set()
    until(lambda: bench.link.source is not first and bench.link.state is S.STREAMING, "the next one")
    assert bench.link.source.grabber is slow and len(bench.link.sources) == 1
    assert bench.states == [S.OPENING, S.OPEN, S.STREAMING] * 2
    until(lambda: "close" in bench.source.calls, "letting go of the first")


def test_what_is_being_opened_can_be_given_up(bench):
    first, slow = bench.open_slowly_instead()
    bench.link.cancel_pending()
    slow.opening.set()
    assert bench.link.source is first and bench.link.pending is None
    until(lambda: slow.calls[-1:] == ["close"] or not slow.calls, "letting go of it")
    bench.link.connect_to("sim:")
    assert bench.link.source is not first, "the same once more: closed, and opened anew"
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
def test_the_same_camera_by_another_name_is_closed_first_and_comes_back_where_that_fails(bench, broken, shy):
    OneCamera.held = False
    bench.others["sim:serial"] = OneCamera()
    bench.others["sim:address"] = OneCamera(broken, shy)
    bench.link.connect_to("sim:serial")
    bench.until(S.STREAMING)
    first = bench.link.source
    if broken:
        bench.others["sim:serial"] = OneCamera()  # the one that comes back
    bench.link.connect_to("sim:address")
    until(lambda: bench.link.source not in (first, None) and bench.link.state is S.STREAMING, "the next one")
    assert str(bench.link.source.uri) == ("sim:serial" if broken else "sim:address")
    assert bench.failures == (["another application controls it"] if broken else [])
    assert not bench.link.source.read_only and len(bench.link.sources) == 1


class Pair:
    """Two open sources, of which the first is current, and the order of what is opened and released."""

    def __init__(self, bench):
        self.link, self.reported = bench.link, []
        self.other = bench.others["sim:colour"] = Source()
        bench.link.connect_to("sim:")
        bench.until(S.STREAMING)
        self.first = bench.link.source
        bench.link.open_additional("sim:colour")
        self.beside = bench.link.sources[1]
        deadline = time.monotonic() + PATIENCE
        while self.beside.state is not S.STREAMING and time.monotonic() < deadline:
            time.sleep(0.002)
        bench.link.opened.connect(lambda source: self.reported.append(("opened", source)))
        bench.link.closing.connect(lambda source: self.reported.append(("closing", source)))
        bench.link.ending.connect(lambda source: self.reported.append(("ending", source)))
        del bench.states[:]


@pytest.fixture
def pair(bench):
    return Pair(bench)


def test_a_source_opened_in_the_background_leaves_the_other_current(bench, pair):
    assert bench.link.source is pair.first and pair.beside.state is S.STREAMING
    assert bench.source.streaming and pair.other.streaming
    assert bench.states == [], "nothing happened to the one at hand"


def test_a_source_made_current_is_announced_like_a_newly_opened_one(bench, pair):
    bench.link.make_current(pair.beside)
    assert pair.reported == [("closing", pair.first), ("opened", pair.beside)]
    assert bench.states == [S.OPENING, S.STREAMING]
    assert bench.link.source is pair.beside and bench.source.streaming, "the first goes on aside"
    bench.link.connect_to("sim:")
    assert bench.link.source is pair.first, "connecting to what is aside brings it forward"
    assert bench.source.calls == ["open", "start"]


def test_closing_one_leaves_the_other(bench, pair):
    bench.link.close(pair.beside)
    assert pair.reported == [("ending", pair.beside)] and bench.states == []
    assert bench.link.wait_closed(PATIENCE) and "close" in pair.other.calls
    assert bench.link.sources == (pair.first,)


def test_when_the_current_source_is_closed_the_other_becomes_current(bench, pair):
    bench.link.disconnect()
    assert pair.reported[:2] == [("closing", pair.first), ("ending", pair.first)]
    assert bench.link.source is pair.beside and bench.states == [S.CLOSED, S.OPENING, S.STREAMING]


def test_another_source_replaces_only_the_current_one(bench, pair):
    bench.others["sim:scene"] = third = Source()
    bench.link.connect_to("sim:scene")
    until(lambda: third.streaming, "the start")
    assert pair.first not in bench.link.sources and bench.link.sources[1] is pair.beside
    assert third.streaming and pair.other.streaming


def test_an_open_source_is_not_opened_in_the_background(bench, pair):
    for uri in ("sim:", "sim:colour"):
        bench.link.open_additional(uri)
    assert bench.failures == ["sim: is open already", "sim:colour is open already"]
    assert len(bench.link.sources) == 2


def test_a_background_source_that_fails_to_open_is_reported_and_removed(bench, pair):
    bench.others["sim:scene"] = broken = Source()
    broken.problem = TransportError("no such camera")
    bench.link.open_additional("sim:scene")
    until(lambda: bench.failures, "the failure")
    assert bench.failures == ["no such camera"] and bench.link.source is pair.first
    assert len(bench.link.sources) == 2
