"""White balance by one push, on a camera without any automatic and on the simulated one."""

import pytest
from stage import REGION, on

from grabbergui.models.changes.history import Direction
from grabbergui.models.changes.undoing import revert
from grabbergui.models.tuning.one_push import balance, expose


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
    ("how", "said"),
    [({"pixel_format": "Mono8"}, "no colour"), ({"light": 50.0}, "saturated"), ({"light": 0.1}, "too dark")],
)
def test_white_balance_says_what_hinders_it_and_changes_nothing(stage, how, said):
    s = stage(**how)
    s.run(on(REGION, balance), name="White balance")
    assert said in s.failures[0]
    assert [name for name, _, _ in s.grabber.writes if name == "BalanceRatio"] == []


@pytest.mark.parametrize("options", ["pixel_format=RGB8", "pixel_format=BayerGB8", "pixel_format=BayerRG12p"])
def test_white_balance_on_a_region_of_the_simulated_camera(sim, options):
    s = sim(options)
    for selected in ("Red", "Blue"):
        s.grabber.write_feature("BalanceRatioSelector", selected)
        s.grabber.write_feature("BalanceRatio", 1.0)
    before = s.light().channels
    assert abs(before["R"] / before["G"] - 1) > 0.2
    assert "Balanced" in s.run(on(REGION, balance)), s.failures
    light = s.light().channels
    assert light["R"] == pytest.approx(light["G"], rel=0.03)
    assert light["B"] == pytest.approx(light["G"], rel=0.03)
