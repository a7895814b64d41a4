"""Each change is recorded once, with its author, in bounded memory."""

import threading

import pytest

from grabbergui.core.errors import FeatureError
from grabbergui.core.settings import SettingKey
from grabbergui.models import change_journal
from grabbergui.models.undo_steps import MOST_STEPS, STEP_PAUSE
from operator_bench import CAMERA, NETWORK, OPERATOR, UNDO, Bench


def test_a_write_is_noted_with_its_time_and_both_values(operator):
    noted = []
    operator.journal.noted.connect(noted.append)
    operator.write("Gain", 6.0)
    (change,) = noted
    assert (change.key, change.before, change.after) == (SettingKey("Gain"), 1.0, 6.0)
    assert (change.origin, change.time, change.number) == (OPERATOR, 1e9 + 100, 1)
    assert operator.journal.changes == (change,)


def test_the_value_that_the_camera_accepted_is_recorded(operator):
    operator.grabber.on_write = lambda name, value: 5.5
    operator.write("Gain", 6.0)
    assert operator.log == [("Gain 1 → 5.5", OPERATOR)]


def test_a_write_that_changes_nothing_or_is_refused_is_not_noted(operator):
    operator.write("Gain", 1.0)
    with pytest.raises(FeatureError):
        operator.write("Gain", 1000.0)
    assert operator.log == []
    assert operator.journal.next_text(UNDO) == ""


def test_a_drag_is_one_change_and_one_step(operator):
    for value in range(2, 50):
        operator.write("Gain", value, wait=0.05)
    assert operator.log == [("Gain 1 → 49", OPERATOR)]
    assert operator.journal.next_text(UNDO) == "Gain 1 → 49"
    assert operator.revert(UNDO) == []
    assert operator.value("Gain") == 1.0
    assert operator.journal.next_text(UNDO) == ""


def test_a_control_in_hand_is_one_step_however_slow(operator):
    operator.journal.hold("Gain")
    for value in (2, 3, 4):
        operator.write("Gain", value, wait=10 * STEP_PAUSE)
    operator.journal.release("Gain")
    operator.write("Gain", 5)
    assert operator.log == [("Gain 1 → 4", OPERATOR), ("Gain 4 → 5", OPERATOR)]
    operator.revert(UNDO, times=2)
    assert operator.value("Gain") == 1.0


def test_values_typed_later_are_separate_steps(operator):
    for value in (2, 3):
        operator.journal.hold("Gain")
        operator.write("Gain", value, wait=0.01)
        operator.journal.release("Gain")
        operator.now += 10 * STEP_PAUSE
    assert operator.log == [("Gain 1 → 2", OPERATOR), ("Gain 2 → 3", OPERATOR)]
    operator.revert(UNDO)
    assert operator.value("Gain") == 2


def test_another_change_in_between_ends_a_step(operator):
    operator.write("Gain", 2, wait=0.01)
    operator.write("Gamma", 2, wait=0.01)
    operator.write("Gain", 3, wait=0.01)
    assert operator.log == [("Gain 1 → 2", OPERATOR), ("Gamma 1 → 2", OPERATOR), ("Gain 2 → 3", OPERATOR)]
    operator.revert(UNDO)
    assert (operator.value("Gain"), operator.value("Gamma")) == (2, 2)


def test_a_value_that_is_dragged_back_leaves_no_step(operator):
    noted = []
    operator.journal.noted.connect(noted.append)
    operator.write("Gain", 2, wait=0.01)
    operator.write("Gain", 1, wait=0.01)
    assert operator.journal.next_text(UNDO) == ""
    assert operator.log == []
    assert [(change.number, change.effective) for change in noted] == [(1, True), (1, False)]
    operator.write("Gain", 3, wait=0.01)
    assert operator.log == [("Gain 1 → 3", OPERATOR)]


def test_a_regulated_value_that_swings_back_leaves_no_entry(operator):
    for value in (1.0, 4.0, 1.0):
        operator.grabber.set("Gain", value)
        operator.tracked_grabber.watch(operator.grabber.feature("Gain"))
    assert operator.log == []


def test_log_and_steps_are_bounded(operator, monkeypatch):
    monkeypatch.setattr(change_journal, "MOST_CHANGES", 50)
    for turn in range(MOST_STEPS + 20):
        operator.write("Gain", 2.0 + turn % 2)
    assert len(operator.journal.changes) == 50
    undone = 0
    while operator.journal.next_text(UNDO):
        operator.revert(UNDO)
        undone += 1
    assert undone == MOST_STEPS


def test_notes_from_two_threads_lose_nothing(operator):
    def see(name):
        for turn in range(200):
            operator.journal.saw(SettingKey(f"{name}{turn}"), 0, 1, CAMERA)

    threads = [threading.Thread(target=see, args=(name,)) for name in "ab"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len({c.number for c in operator.journal.changes}) == 400


def test_a_spontaneous_change_is_the_cameras(operator):
    operator.tracked_grabber.watch(operator.grabber.feature("Gain"))
    operator.grabber.set("Gain", 7.0)
    operator.tracked_grabber.watch(operator.grabber.feature("Gain"))
    assert operator.log == [("Gain 1 → 7", CAMERA)]
    assert operator.journal.next_text(UNDO) == "", "only the operator's own changes are undone"


def test_changes_by_others_on_a_shared_camera_are_the_networks(operator):
    operator.grabber.shared = True
    operator = Bench(operator.grabber)
    for name in ("Gain", "Gamma"):
        operator.tracked_grabber.watch(operator.grabber.feature(name))
    operator.grabber.set("Gain", 7.0)
    operator.tracked_grabber.watch(operator.grabber.feature("Gain"))
    operator.write("Exposure", 50.0, wait=0.1)
    operator.grabber.set("Gamma", 2.0)
    operator.tracked_grabber.watch(operator.grabber.feature("Gamma"))
    assert operator.log == [("Gain 1 → 7", NETWORK), ("Exposure 1 → 50", OPERATOR), ("Gamma 1 → 2", CAMERA)]


def test_the_operators_own_change_is_not_recorded_again_when_it_is_read(operator):
    operator.tracked_grabber.watch(operator.grabber.feature("Gain"))
    operator.write("Gain", 6.0)
    operator.tracked_grabber.watch(operator.grabber.feature("Gain"))
    assert operator.log == [("Gain 1 → 6", OPERATOR)]


def test_a_regulated_value_is_one_entry_that_grows(operator):
    for value in range(1, 20):
        operator.grabber.set("Gain", float(value))
        operator.tracked_grabber.watch(operator.grabber.feature("Gain"))
        operator.now += 0.2
    assert operator.log == [("Gain 1 → 19", CAMERA)]


def test_another_instance_seen_through_a_selector_is_no_change(sim):
    sim.tracked_grabber.watch(sim.grabber.feature("BalanceRatio"))
    sim.write("BalanceRatioSelector", "Blue")
    sim.tracked_grabber.watch(sim.grabber.feature("BalanceRatio"))
    sim.write("BalanceRatio", 2.0)
    sim.write("BalanceRatioSelector", "Red")
    sim.tracked_grabber.watch(sim.grabber.feature("BalanceRatio"))
    key = SettingKey("BalanceRatio", (("BalanceRatioSelector", "Blue"),))
    assert [c.key for c in sim.journal.changes if c.key.name == "BalanceRatio"] == [key]
