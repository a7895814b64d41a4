"""Steps undone and redone, with all that hung on them."""

import time

import pytest

from grabbergui.core.errors import DeviceLostError, FeatureError
from grabbergui.core.settings import SettingKey
from grabbergui.models.language import set_translator
from grabbergui.models.settings.feature_set import FeatureSet, capture, compare
from grabbergui.models.settings.loading import load_onto
from grabbergui.models.undo_steps import UndoStep
from operator_bench import REDO, UNDO
from patience import PATIENCE, until


def test_steps_are_undone_and_redone_in_order(operator):
    operator.write("Gain", 2)
    operator.write("Gamma", 3)
    operator.revert(UNDO)
    assert (operator.value("Gain"), operator.value("Gamma")) == (2, 1)
    assert operator.journal.next_text(REDO) == "Gamma 1 → 3"
    operator.revert(UNDO)
    assert operator.value("Gain") == 1
    operator.revert(REDO, times=2)
    assert (operator.value("Gain"), operator.value("Gamma")) == (2, 3)
    assert operator.journal.next_text(REDO) == ""
    assert operator.revert(REDO) == []


def test_undoing_is_in_the_log(operator):
    operator.write("Gain", 2)
    operator.revert(UNDO)
    assert [(str(c), c.cause) for c in operator.journal.changes] == [
        ("Gain 1 → 2", ""),
        ("Gain 2 → 1", "Undo"),
    ]


def test_undoing_is_named_in_the_users_language(operator):
    set_translator(lambda context, text: f"<{text}>")
    try:
        operator.write("Gain", 2)
        operator.revert(UNDO)
        assert operator.journal.changes[-1].cause == "<Undo>"
    finally:
        set_translator(None)


def test_something_new_ends_what_can_be_redone(operator):
    operator.write("Gain", 2)
    operator.revert(UNDO)
    operator.write("Gamma", 3)
    assert operator.journal.next_text(REDO) == ""


def test_commands_are_noted_cannot_be_undone_and_break_nothing(sim):
    sim.write("Gain", 3.0, wait=0.01)
    sim.tracked_grabber.execute("TimestampLatch")
    sim.write("Gain", 6.0, wait=0.01)
    assert [text for text, _ in sim.log] == ["Gain 0 → 3", "TimestampLatch run", "Gain 3 → 6"]
    sim.revert(UNDO)
    assert sim.value("Gain") == 3
    sim.revert(UNDO)
    assert sim.value("Gain") == 0
    assert [text for text, _ in sim.log].count("TimestampLatch run") == 1


def test_an_undo_that_is_refused_reports_it_and_leaves_the_steps_before_it(operator):
    operator.write("Gain", 2)
    operator.write("Gamma", 3)
    operator.grabber.refusals["Gamma"] = FeatureError("Gamma=1: the camera answered: busy", "Gamma")
    assert operator.revert(UNDO) == ["Undo of Gamma 1 → 3: Gamma=1: the camera answered: busy"]
    assert operator.revert(UNDO) == []
    assert operator.value("Gain") == 1


def test_an_undo_on_a_lost_camera_can_be_tried_again(operator):
    operator.write("Gain", 2)
    operator.grabber.failures["Gain"] = DeviceLostError("gone")
    with pytest.raises(DeviceLostError):
        operator.revert(UNDO)
    operator.grabber.failures.clear()
    assert operator.revert(UNDO) == []
    assert operator.value("Gain") == 1


def test_undoing_brings_back_the_automatic_mode_that_a_write_took_away(sim):
    sim.write("ExposureAuto", "Continuous")
    sim.write("ExposureTime", 5000.0)
    assert sim.value("ExposureAuto") == "Off"
    sim.revert(UNDO)
    assert sim.value("ExposureAuto") == "Continuous"


def test_undoing_an_automatic_mode_restores_the_previous_value(sim):
    sim.write("ExposureTime", 5000.0)
    sim.write("ExposureAuto", "Continuous")
    sim.grabber.start()
    queue = sim.grabber.open_queue()
    deadline = time.monotonic() + PATIENCE
    while sim.value("ExposureTime") <= 6000:
        assert time.monotonic() < deadline
        queue.get(PATIENCE)
    sim.revert(UNDO)
    assert (sim.value("ExposureAuto"), sim.value("ExposureTime")) == ("Off", 5000.0)


def test_undoing_a_white_balance_by_the_camera_brings_back_every_ratio(sim):
    def ratios():
        found = []
        for selected in ("Red", "Blue"):
            sim.grabber.write_feature("BalanceRatioSelector", selected)
            found.append(sim.value("BalanceRatio"))
        return found

    for selected, ratio in (("Red", 1.1), ("Blue", 2.2)):
        sim.grabber.write_feature("BalanceRatioSelector", selected)
        sim.grabber.write_feature("BalanceRatio", ratio)
    sim.grabber.start()
    sim.write("BalanceWhiteAuto", "Once")
    until(lambda: sim.value("BalanceWhiteAuto") == "Off")
    assert sim.value("BalanceRatioSelector") == "Blue"
    assert ratios()[0] == pytest.approx(1.6, rel=0.1)
    assert sim.revert(UNDO) == []
    assert ratios() == [pytest.approx(1.1), pytest.approx(2.2)]


def test_undoing_finds_the_instance_whatever_is_selected(sim):
    sim.write("BalanceRatioSelector", "Blue")
    before = sim.value("BalanceRatio")
    sim.write("BalanceRatio", 3.0)
    sim.grabber.write_feature("BalanceRatioSelector", "Red")
    red = sim.value("BalanceRatio")
    assert sim.revert(UNDO) == []
    assert (sim.value("BalanceRatioSelector"), sim.value("BalanceRatio")) == ("Red", red)
    sim.grabber.write_feature("BalanceRatioSelector", "Blue")
    assert sim.value("BalanceRatio") == before


def test_a_loaded_set_is_one_step(sim):
    before = capture(sim.grabber)
    wanted = FeatureSet(
        {
            SettingKey("OffsetX"): 64,
            SettingKey("Width"): 128,
            SettingKey("Gain"): 3.0,
            SettingKey("BalanceRatio", (("BalanceRatioSelector", "Blue"),)): 2.0,
        }
    )
    with sim.journal.within(UndoStep("Loaded a set")):
        assert load_onto(sim.tracked_grabber, wanted).settled
    assert sim.journal.next_text(UNDO) == "Loaded a set"
    assert {c.cause for c in sim.journal.changes} == {"Loaded a set"}
    assert not [c for c in sim.journal.changes if c.key.name.endswith("Selector")]
    sim.grabber.start()
    assert sim.revert(UNDO) == []
    assert sim.grabber.streaming
    sim.grabber.stop()
    assert compare(before, capture(sim.grabber)) == []
    assert sim.revert(REDO) == []
    assert (sim.value("Width"), sim.value("OffsetX"), sim.value("Gain")) == (128, 64, 3.0)
