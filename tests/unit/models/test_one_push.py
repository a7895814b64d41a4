"""One-push exposure and white balance."""

import pytest

from grabbergui.models.change_tracking import revert
from grabbergui.models.one_push import EXPOSURE_STEPS, EXPOSURE_TOLERANCE, balance, expose
from grabbergui.models.undo_steps import Direction
from patience import Stopwatch, allowance, until
from tuning_stage import REGION, on


@pytest.mark.parametrize("light", [0.02, 0.3, 1.0, 40.0])
def test_exposure_finds_the_target_without_any_automatic(stage, light):
    s = stage(light=light)
    assert "Exposed" in s.run(on(REGION, expose)), s.failures
    assert s.light().mean == pytest.approx(0.5, abs=EXPOSURE_TOLERANCE)
    assert 0.0 <= s.progress[0][0] <= s.progress[-1][0] < 1.0
    assert len(s.progress) <= EXPOSURE_STEPS


def test_the_time_grows_up_to_the_frame_rates_room_and_gain_does_the_rest(stage):
    s = stage(light=0.1, rate=50.0)
    assert "Exposed" in s.run(on(REGION, expose)), s.failures
    assert s.value("ExposureTimeRaw") == 20_000
    assert 60 < s.value("GainRaw") < 300
    s.grabber.light = 2.0
    assert "Exposed" in s.run(on(REGION, expose)), s.failures
    assert s.value("GainRaw") == 0, "gain is lowered before the time is shortened"


def test_an_unreachable_target_is_reported_and_the_nearest_value_kept(stage):
    s = stage(light=0.001, gain=False)
    assert "As bright as it gets" in s.run(on(REGION, expose))
    assert s.value("ExposureTimeRaw") == 33_320
    s = stage(light=5000.0)
    assert "As dark as it gets" in s.run(on(REGION, expose))
    assert s.value("ExposureTimeRaw") == 20


def test_all_that_was_tuned_is_undone_in_one_step(stage):
    s = stage(light=0.1)
    s.run(on(REGION, expose), name="Exposure on a region")
    assert s.journal.next_text(Direction.UNDO) == "Exposure on a region"
    assert revert(s.tracked_grabber, Direction.UNDO) == []
    assert (s.value("ExposureTimeRaw"), s.value("GainRaw")) == (1000, 0)
    assert s.journal.next_text(Direction.UNDO) == ""


@pytest.mark.parametrize(
    "options", ["pixel_format=Mono8", "pixel_format=BayerRG12p&exposure=50", "exposure=45000&fps=20"]
)
def test_exposure_on_a_region_of_the_simulated_camera(stage_on_sim, options):
    s = stage_on_sim(options)
    s.grabber.write_feature("Gamma", 0.8)
    s.grabber.write_feature("ExposureAuto", "Continuous")
    with Stopwatch() as watch:
        assert "Exposed" in s.run(on(REGION, expose)), s.failures
    # The scene wanders, so a little more than the tolerance is allowed; a busy machine looks late.
    until(lambda: s.light().mean == pytest.approx(0.5, abs=2 * EXPOSURE_TOLERANCE))
    assert s.value("ExposureAuto") == "Off"
    assert watch.seconds < 20 * allowance()


def test_white_balance_makes_grey_grey_without_any_automatic(stage):
    s = stage()
    s.run(on(REGION, expose))
    assert "Balanced" in s.run(on(REGION, balance), name="White balance"), s.failures
    light = s.light().channels
    assert light["R"] == pytest.approx(light["G"], rel=0.02)
    assert light["B"] == pytest.approx(light["G"], rel=0.02)
    ratios = s.grabber.ratios
    assert (ratios["Red"], ratios["Blue"]) == (pytest.approx(2.0, rel=0.03), pytest.approx(1 / 0.7, rel=0.03))
    assert ratios["Green"] == 1.0
    assert s.value("BalanceRatioSelector") == "Green"
    assert revert(s.tracked_grabber, Direction.UNDO) == []
    assert s.grabber.ratios == {"Red": 1.0, "Green": 1.0, "Blue": 1.0}


def test_a_lamp_beyond_the_ratios_is_reported(stage):
    s = stage(lamp=(0.1, 1.0, 1.0))
    s.run(on(REGION, expose))
    assert "As grey as it gets" in s.run(on(REGION, balance))
    assert s.grabber.ratios["Red"] == 4.0


@pytest.mark.parametrize(
    ("how", "reason"),
    [
        ({"pixel_format": "Mono8"}, "no colour"),
        ({"light": 50.0}, "saturated"),
        ({"light": 0.1}, "too dark"),
        ({"light": 8.0, "lamp": (1.0, 0.0, 0.7)}, "hardly any green"),
    ],
)
def test_an_impossible_white_balance_names_the_reason_and_changes_nothing(stage, how, reason):
    s = stage(**how)
    s.run(on(REGION, balance), name="White balance")
    assert reason in s.failures[0]
    assert [name for name, _, _ in s.grabber.writes if name == "BalanceRatio"] == []


@pytest.mark.parametrize("options", ["pixel_format=RGB8", "pixel_format=BayerGB8", "pixel_format=BayerRG12p"])
def test_white_balance_on_a_region_of_the_simulated_camera(stage_on_sim, options):
    s = stage_on_sim(options)
    for selected in ("Red", "Blue"):
        s.grabber.write_feature("BalanceRatioSelector", selected)
        s.grabber.write_feature("BalanceRatio", 1.0)
    before = s.light().channels
    assert abs(before["R"] / before["G"] - 1) > 0.2
    assert "Balanced" in s.run(on(REGION, balance)), s.failures
    light = s.light().channels
    assert light["R"] == pytest.approx(light["G"], rel=0.03)
    assert light["B"] == pytest.approx(light["G"], rel=0.03)
