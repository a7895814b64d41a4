"""The camera's own sets of settings."""

import threading

import pytest

from fakes import ScriptedGrabber
from grabbergui import sources
from grabbergui.core.errors import FeatureError, FeatureNotFoundError
from grabbergui.models.change_journal import ChangeJournal
from grabbergui.models.change_tracking import ChangeTrackingGrabber, revert
from grabbergui.models.settings.feature_set import capture, compare
from grabbergui.models.settings.user_sets import (
    has_user_sets,
    load_user_set,
    save_user_set,
    start_with_user_set,
    user_sets,
)
from grabbergui.models.undo_steps import Direction


@pytest.fixture
def grabber():
    camera = sources.create("sim:?width=64&height=64&pixel_format=RGB8")
    camera.open()
    noting = ChangeTrackingGrabber(camera, ChangeJournal())
    noting.open()
    yield noting
    noting.close()
    camera.close()


def value(grabber, name):
    return grabber.plain.feature(name).value


def test_the_sets_are_listed_and_the_selector_stays(grabber):
    grabber.write_feature("UserSetSelector", "UserSet2")
    found = user_sets(grabber)
    assert [(s.name, s.savable, s.startable, s.starts) for s in found] == [
        ("Default", False, True, True), ("UserSet1", True, True, False), ("UserSet2", True, True, False),
    ]  # fmt: skip
    assert value(grabber, "UserSetSelector") == "UserSet2"


def test_a_set_is_saved_and_loaded_while_the_camera_streams_and_loading_is_undone(grabber):
    grabber.plain.start()
    grabber.write_feature("Gain", 6.0)
    save_user_set(grabber, "UserSet1")
    grabber.write_feature("Gain", 12.0)
    grabber.write_feature("BalanceRatio", 3.0)
    grabber.plain.stop()
    before = capture(grabber.plain)
    grabber.plain.start()
    seen = []
    assert load_user_set(grabber, "UserSet1", progress=lambda done, of: seen.append((done, of))) == 2
    assert grabber.plain.streaming
    assert value(grabber, "Gain") == 6.0
    assert value(grabber, "UserSetSelector") == "Default"
    assert [done for done, _ in seen] == sorted(done for done, _ in seen)
    assert seen[-1][0] == seen[-1][1]
    assert grabber.journal.next_text(Direction.UNDO) == "UserSetLoad UserSet1"
    assert revert(grabber, Direction.UNDO) == []
    grabber.plain.stop()
    assert compare(before, capture(grabber.plain)) == []


def test_cancelled_in_time_nothing_is_loaded(grabber):
    cancelled = threading.Event()
    grabber.write_feature("Gain", 6.0)
    assert load_user_set(grabber, "Default", progress=lambda *_: cancelled.set(), cancelled=cancelled) == 0
    assert value(grabber, "Gain") == 6.0


def test_the_factorys_set_cannot_be_overwritten(grabber):
    with pytest.raises(FeatureError):
        save_user_set(grabber, "Default")


def test_the_set_for_power_on_can_be_chosen(grabber):
    start_with_user_set(grabber, "UserSet2")
    assert [s.name for s in user_sets(grabber) if s.starts] == ["UserSet2"]
    assert revert(grabber, Direction.UNDO) == []
    assert [s.name for s in user_sets(grabber) if s.starts] == ["Default"]


def test_a_camera_without_sets_reports_it():
    grabber = ChangeTrackingGrabber(ScriptedGrabber([]), ChangeJournal())
    assert not has_user_sets(grabber)
    for call in (user_sets, lambda h: load_user_set(h, "A"), lambda h: save_user_set(h, "A")):
        with pytest.raises(FeatureNotFoundError, match="keeps no sets"):
            call(grabber)
    with pytest.raises(FeatureNotFoundError, match="starts with the same"):
        start_with_user_set(grabber, "A")
