"""What the connection says: of a loss, of the return, of failures, each once and as long as it holds."""

import re

import pytest

from grabbergui.core.errors import (
    DeviceLostError,
    FeatureValueError,
    SourceNotFoundError,
    TransportError,
)
from grabbergui.core.features import Category, FeatureDescription, FeatureKind
from grabbergui.core.grabber import ConnectionState
from grabbergui.core.settings import SettingKey
from grabbergui.models.messages import Severity
from grabbergui.models.source_opener import SourceOpener
from lost_camera import away
from opener_bench import S, Source
from patience import PATIENCE, until


def lose(bench, reason="the camera does not answer"):
    bench.source.connection_changed.emit(ConnectionState.LOST, reason)


def come_back(bench, reason="set as before"):
    bench.source.connection_changed.emit(ConnectionState.OPEN, reason)


def test_losses_are_one_line_until_it_is_back_with_a_count(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    for losses in (1, 2):
        lose(bench)
        lose(bench)  # reported by two threads, it is still one loss
        assert bench.sources.state is S.LOST
        (reported,) = bench.texts()
        assert re.match(r"Reconnecting since \d\d:\d\d:\d\d: the camera does not answer", reported)
        assert ("(×2)" in reported) == (losses == 2)
        come_back(bench)
        assert bench.sources.state is S.STREAMING
        (reported,) = bench.texts()
        assert reported.startswith("Back after ") and "s, set as before" in reported
    assert len(bench.failures) == 2


def test_a_source_that_returns_with_other_features_shows_these(bench):
    """A driver node that was started with other parameters, or a camera with new firmware."""
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    features, shown = bench.sources.current.features, []
    features.structure_changed.connect(lambda: shown.append(features.root))
    lose(bench)
    come_back(bench)
    bench.source.tree = Category("Root", members=(FeatureDescription(name="Gamma", kind=FeatureKind.FLOAT),))
    lose(bench)
    come_back(bench)
    until(lambda: shown)
    assert shown == [bench.source.tree], "once, as the first return changed nothing"


@pytest.mark.parametrize("call", ["open", "start", "stop"])
def test_a_source_lost_while_a_call_ends_is_lost(bench, call):
    """What the call reached holds no more; the window showed it for good, as it missed the return too."""
    source, reached = bench.source, getattr(bench.source, call)

    def lost_at_its_end(*arguments, **options):
        reached(*arguments, **options)
        setattr(source, call, reached)
        lose(bench)

    setattr(source, call, lost_at_its_end)
    if call == "open":
        source.start_problem = DeviceLostError("the camera does not answer")
    bench.link.connect_to("sim:")
    until(lambda: "start" in source.calls)
    if call == "stop":
        bench.until(S.STREAMING)
        bench.link.stream.stop()
    opened = bench.sources.current
    until(lambda: opened.losses == 1)
    opened.worker.submit(lambda: None, done=lambda _: source.calls.append("done"))
    until(lambda: "done" in source.calls)
    assert bench.sources.state is S.LOST and bench.sources.reason == "the camera does not answer"
    assert any(reported.startswith("Reconnecting since") for reported in bench.texts())
    source.start_problem = None
    if call == "open":
        source.start()  # as a camera does that was to start when it was lost
    come_back(bench)
    assert bench.sources.state is (S.OPEN if call == "stop" else S.STREAMING)


def test_a_source_lost_before_it_replaces_another_is_lost(bench):
    _, slow = bench.open_slowly_instead()
    until(lambda: slow.calls == ["open"])
    slow.connection_changed.emit(ConnectionState.LOST, "unplugged")
    slow.opening.set()
    until(lambda: "start" in slow.calls)
    opened = bench.sources.current
    opened.worker.submit(lambda: None, done=lambda _: slow.calls.append("done"))
    until(lambda: "done" in slow.calls)
    assert (bench.sources.state, bench.sources.reason) == (S.LOST, "unplugged")
    (reported,) = bench.texts()
    assert reported.startswith("Reconnecting since") and reported.endswith("unplugged")
    slow.connection_changed.emit(ConnectionState.OPEN, "")
    assert bench.sources.state is S.STREAMING


def test_a_new_reason_for_the_same_loss_is_shown(bench):
    """As when the server of a lost camera ends, or when another camera is refused in its place."""
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    lose(bench)
    lost_since = bench.sources.current.lost_since
    bench.source.connection_changed.emit(ConnectionState.LOST, "another camera is at its address")
    (reported,) = bench.texts()
    assert reported.startswith("Reconnecting since") and reported.endswith("another camera is at its address")
    assert bench.sources.reason == "another camera is at its address"
    assert (bench.sources.current.losses, bench.sources.current.lost_since) == (
        1,
        lost_since,
    )
    come_back(bench)
    assert bench.sources.current.lost_since is None and bench.sources.state is S.STREAMING


def test_settings_that_were_not_restored_are_shown_until_dismissed(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    lose(bench)
    bench.source.unlike_before = ("Gain=6: the camera answered: busy",)
    come_back(bench)
    (message,) = bench.link.messages.shown(bench.sources.current)
    assert "but not as before: Gain=6" in message.text
    assert (message.severity, message.ends) == (Severity.WARNING, None)
    bench.link.messages.dismiss(message)
    bench.source.unlike_before = ()
    lose(bench)
    (lost,) = bench.link.messages.shown(bench.sources.current)
    assert "reconnecting since" in lost.text, "a new loss is news"
    bench.link.messages.dismiss(lost)
    come_back(bench)
    assert "set as before" in bench.texts()[0], "and so is its end"


def test_settings_that_others_changed_meanwhile_are_shown_until_dismissed(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    lose(bench)
    bench.source.changed_meanwhile = tuple(f"{name} is 2 instead of 1" for name in "abcde")
    come_back(bench)
    (message,) = bench.link.messages.shown(bench.sources.current)
    assert "set as before; changed meanwhile, not by us: a is 2 instead of 1; b" in message.text
    assert message.text.endswith("; and 2 more")
    assert (message.severity, message.ends) == (Severity.WARNING, None)


def test_a_loss_and_the_differences_after_it_are_logged_once(caplog):
    caplog.set_level("INFO")
    link = SourceOpener()
    link.connect_to("sim:?width=64&height=48")
    until(lambda: link.open_sources.state is S.STREAMING)
    camera = link.open_sources.current.grabber
    with away(camera, "the cable is out"):
        camera._writes().memory.note(SettingKey("Gain"), 0.004)
        until(lambda: link.open_sources.state is S.LOST)
    until(lambda: link.messages.shown(link.open_sources.current)[0].text.startswith("back after"))
    assert "Gain is 0 instead of 0.004" in link.messages.shown(link.open_sources.current)[0].text
    assert [
        caplog.text.count(reported) for reported in ("the cable is out", "Gain is 0 instead of 0.004")
    ] == [1, 1]
    link.open_sources.close_all()
    link.open_sources.wait_closed(PATIENCE)


def test_failures_caused_by_a_loss_are_not_shown_in_addition(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    features = bench.sources.current.features
    features.failed.emit(TransportError("no answer within 0.5 s"))
    assert bench.texts() == ["No answer within 0.5 s"]
    lose(bench)
    features.failed.emit(TransportError("no answer within 0.5 s"))
    features.failed.emit(DeviceLostError("the camera is lost"))
    assert len(bench.texts()) == 1 and "Reconnecting since" in bench.texts()[0]
    come_back(bench)
    features.failed.emit(DeviceLostError("the camera is lost"))
    assert len(bench.texts()) == 1 and "Back after" in bench.texts()[0]


def test_a_refused_write_is_shown_for_its_own_camera_only(bench):
    bench.link.connect_to("sim:")
    bench.until(S.STREAMING)
    first = bench.sources.current
    bench.others["sim:2"] = Source()
    bench.link.open_additional("sim:2")
    first.features.failed.emit(FeatureValueError("Gain=99 is above 24", "Gain"))
    assert bench.texts() == ["Gain=99 is above 24"]
    second = bench.sources.all[1]
    until(lambda: second.state is S.STREAMING)
    bench.sources.make_current(second)
    assert bench.texts() == []


def test_a_failure_to_open_is_shown_until_the_next_attempt(bench):
    bench.source.problem = SourceNotFoundError("no camera answers")
    bench.link.connect_to("sim:")
    bench.until(S.CLOSED)
    until(bench.texts)
    assert bench.texts() == ["No camera answers"]
    bench.source.problem = None
    bench.link.connect_to("sim:")
    assert bench.texts() == []
