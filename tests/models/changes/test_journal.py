"""Each change is recorded once, with its author, in bounded memory."""

import threading

import pytest
from operator_bench import CAMERA, NETWORK, OPERATOR, UNDO, Bench

from grabbergui.core.errors import FeatureError
from grabbergui.core.settings import SettingKey
from grabbergui.models.change_journal import MOST_STEPS, STEP_PAUSE


def test_a_write_is_noted_with_its_time_and_both_values(bench):
    noted = []
    bench.journal.noted.connect(noted.append)
    bench.write("Gain", 6.0)
    (change,) = noted
    assert (change.key, change.before, change.after) == (SettingKey("Gain"), 1.0, 6.0)
    assert (change.origin, change.time, change.number) == (OPERATOR, 1e9 + 100, 1)
    assert bench.journal.changes == (change,)


def test_what_the_camera_made_of_a_value_is_noted(bench):
    bench.grabber.on_write = lambda name, value: 5.5
    bench.write("Gain", 6.0)
    assert bench.log == [("Gain 1 → 5.5", OPERATOR)]


def test_a_write_that_changes_nothing_or_is_refused_is_not_noted(bench):
    bench.write("Gain", 1.0)
    with pytest.raises(FeatureError):
        bench.write("Gain", 1000.0)
    assert bench.log == []
    assert bench.journal.next_text(UNDO) == ""


def test_a_drag_is_one_change_and_one_step(bench):
    for value in range(2, 50):
        bench.write("Gain", value, wait=0.05)
    assert bench.log == [("Gain 1 → 49", OPERATOR)]
    assert bench.journal.next_text(UNDO) == "Gain 1 → 49"
    assert bench.revert(UNDO) == []
    assert bench.value("Gain") == 1.0
    assert bench.journal.next_text(UNDO) == ""


def test_a_control_in_hand_is_one_step_however_slow(bench):
    bench.journal.hold("Gain")
    for value in (2, 3, 4):
        bench.write("Gain", value, wait=10 * STEP_PAUSE)
    bench.journal.release("Gain")
    bench.write("Gain", 5)
    assert bench.log == [("Gain 1 → 4", OPERATOR), ("Gain 4 → 5", OPERATOR)]
    bench.revert(UNDO, times=2)
    assert bench.value("Gain") == 1.0


def test_what_is_typed_later_is_another_step_though_typing_holds_the_control(bench):
    for value in (2, 3):
        bench.journal.hold("Gain")
        bench.write("Gain", value, wait=0.01)
        bench.journal.release("Gain")
        bench.now += 10 * STEP_PAUSE
    assert bench.log == [("Gain 1 → 2", OPERATOR), ("Gain 2 → 3", OPERATOR)]
    bench.revert(UNDO)
    assert bench.value("Gain") == 2


def test_what_comes_between_ends_a_step(bench):
    bench.write("Gain", 2, wait=0.01)
    bench.write("Gamma", 2, wait=0.01)
    bench.write("Gain", 3, wait=0.01)
    assert bench.log == [("Gain 1 → 2", OPERATOR), ("Gamma 1 → 2", OPERATOR), ("Gain 2 → 3", OPERATOR)]
    bench.revert(UNDO)
    assert (bench.value("Gain"), bench.value("Gamma")) == (2, 2)


def test_what_is_dragged_back_leaves_no_step(bench):
    bench.write("Gain", 2, wait=0.01)
    bench.write("Gain", 1, wait=0.01)
    assert bench.journal.next_text(UNDO) == ""


def test_log_and_steps_are_bounded(bench):
    bench.journal._most = 50
    for turn in range(MOST_STEPS + 20):
        bench.write("Gain", 2.0 + turn % 2)
    assert len(bench.journal.changes) == 50
    undone = 0
    while bench.journal.next_text(UNDO):
        bench.revert(UNDO)
        undone += 1
    assert undone == MOST_STEPS


def test_notes_from_two_threads_lose_nothing(bench):
    def see(name):
        for turn in range(200):
            bench.journal.saw(SettingKey(f"{name}{turn}"), 0, 1, CAMERA)

    threads = [threading.Thread(target=see, args=(name,)) for name in "ab"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len({c.number for c in bench.journal.changes}) == 400


def test_what_moves_by_itself_was_the_camera(bench):
    bench.tracked_grabber.watch(bench.grabber.feature("Gain"))
    bench.grabber.set("Gain", 7.0)
    bench.tracked_grabber.watch(bench.grabber.feature("Gain"))
    assert bench.log == [("Gain 1 → 7", CAMERA)]
    assert bench.journal.next_text(UNDO) == "", "only the operator's own changes are undone"


def test_what_others_change_on_a_shared_camera_was_the_network(bench):
    bench.grabber.shared = True
    bench = Bench(bench.grabber)
    for name in ("Gain", "Gamma"):
        bench.tracked_grabber.watch(bench.grabber.feature(name))
    bench.grabber.set("Gain", 7.0)
    bench.tracked_grabber.watch(bench.grabber.feature("Gain"))
    bench.write("Exposure", 50.0, wait=0.1)
    bench.grabber.set("Gamma", 2.0)
    bench.tracked_grabber.watch(bench.grabber.feature("Gamma"))
    assert bench.log == [("Gain 1 → 7", NETWORK), ("Exposure 1 → 50", OPERATOR), ("Gamma 1 → 2", CAMERA)]


def test_the_operators_own_change_is_not_noted_twice_when_it_is_read(bench):
    bench.tracked_grabber.watch(bench.grabber.feature("Gain"))
    bench.write("Gain", 6.0)
    bench.tracked_grabber.watch(bench.grabber.feature("Gain"))
    assert bench.log == [("Gain 1 → 6", OPERATOR)]


def test_a_regulated_value_is_one_entry_that_grows(bench):
    for value in range(1, 20):
        bench.grabber.set("Gain", float(value))
        bench.tracked_grabber.watch(bench.grabber.feature("Gain"))
        bench.now += 0.2
    assert bench.log == [("Gain 1 → 19", CAMERA)]


def test_another_instance_seen_through_a_selector_is_no_change(sim):
    sim.tracked_grabber.watch(sim.grabber.feature("BalanceRatio"))
    sim.write("BalanceRatioSelector", "Blue")
    sim.tracked_grabber.watch(sim.grabber.feature("BalanceRatio"))
    sim.write("BalanceRatio", 2.0)
    sim.write("BalanceRatioSelector", "Red")
    sim.tracked_grabber.watch(sim.grabber.feature("BalanceRatio"))
    key = SettingKey("BalanceRatio", (("BalanceRatioSelector", "Blue"),))
    assert [c.key for c in sim.journal.changes if c.key.name == "BalanceRatio"] == [key]
