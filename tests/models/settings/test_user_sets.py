"""The camera's own sets of settings."""

import threading

import pytest

from fakes import ScriptedGrabber
from grabbergui import sources
from grabbergui.core.errors import FeatureError, FeatureNotFoundError
from grabbergui.models.changes.history import Direction
from grabbergui.models.changes.journal import ChangeJournal
from grabbergui.models.changes.tracking import NotingGrabber
from grabbergui.models.changes.undoing import revert
from grabbergui.models.settings import user_sets
from grabbergui.models.settings.feature_set import capture, compare


@pytest.fixture
def hands():
    camera = sources.create("sim:?width=64&height=64&pixel_format=RGB8")
    camera.open()
    noting = NotingGrabber(camera, ChangeJournal())
    noting.open()
    yield noting
    noting.close()
    camera.close()


def value(hands, name):
    return hands.plain.feature(name).value


def test_the_sets_are_told_and_the_selector_stays(hands):
    hands.write_feature("UserSetSelector", "UserSet2")
    found = user_sets.user_sets(hands)
    assert [(s.name, s.savable, s.startable, s.starts) for s in found] == [
        ("Default", False, True, True), ("UserSet1", True, True, False), ("UserSet2", True, True, False),
    ]  # fmt: skip
    assert value(hands, "UserSetSelector") == "UserSet2"


def test_a_set_is_saved_and_loaded_while_the_camera_streams_and_loading_is_undone(hands):
    hands.plain.start()
    hands.write_feature("Gain", 6.0)
    user_sets.save(hands, "UserSet1")
    hands.write_feature("Gain", 12.0)
    hands.write_feature("BalanceRatio", 3.0)
    hands.plain.stop()
    before = capture(hands.plain)
    hands.plain.start()
    seen = []
    assert user_sets.load(hands, "UserSet1", progress=lambda done, of: seen.append((done, of))) == 2
    assert hands.plain.streaming
    assert value(hands, "Gain") == 6.0
    assert value(hands, "UserSetSelector") == "Default"
    assert [done for done, _ in seen] == sorted(done for done, _ in seen)
    assert seen[-1][0] == seen[-1][1]
    assert hands.journal.next_text(Direction.UNDO) == "UserSetLoad UserSet1"
    assert revert(hands, Direction.UNDO) == []
    hands.plain.stop()
    assert compare(before, capture(hands.plain)) == []


def test_cancelled_in_time_nothing_is_loaded(hands):
    cancelled = threading.Event()
    hands.write_feature("Gain", 6.0)
    assert user_sets.load(hands, "Default", progress=lambda *_: cancelled.set(), cancelled=cancelled) == 0
    assert value(hands, "Gain") == 6.0


def test_the_factorys_set_cannot_be_overwritten(hands):
    with pytest.raises(FeatureError):
        user_sets.save(hands, "Default")


def test_which_set_it_starts_with(hands):
    user_sets.start_with(hands, "UserSet2")
    assert [s.name for s in user_sets.user_sets(hands) if s.starts] == ["UserSet2"]
    assert revert(hands, Direction.UNDO) == []
    assert [s.name for s in user_sets.user_sets(hands) if s.starts] == ["Default"]


def test_a_camera_without_sets_says_so():
    hands = NotingGrabber(ScriptedGrabber([]), ChangeJournal())
    assert not user_sets.has_user_sets(hands)
    for call in (user_sets.user_sets, lambda h: user_sets.load(h, "A"), lambda h: user_sets.save(h, "A")):
        with pytest.raises(FeatureNotFoundError, match="keeps no sets"):
            call(hands)
    with pytest.raises(FeatureNotFoundError, match="starts with the same"):
        user_sets.start_with(hands, "A")
