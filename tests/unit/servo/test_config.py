"""The settings of servoing: the shipped file, and what is refused with which words."""

from itertools import pairwise
from pathlib import Path

import pytest

from every_case import every_case
from grabbergui.core.errors import UsageError
from grabbergui.servo.config import Config, HeadConfig


def test_the_shipped_file_says_what_the_defaults_are():
    shipped = Path(__file__).parents[3] / "resources/servo/servo.ini"
    assert Config.load(shipped) == Config()
    keys = {line.split()[0] for line in shipped.read_text().splitlines() if line and line[0].isalpha()}
    assert {"deadband", "fastest_turn", "image_timeout", "standoff"} <= keys


def test_the_shipped_file_explains_every_key():
    lines = (Path(__file__).parents[3] / "resources/servo/servo.ini").read_text().splitlines()
    bare = [line for before, line in pairwise(lines) if line[:1].isalpha() and not before.startswith("//")]
    assert {line.split()[0] for line in bare} == {"x_high", "y_low", "y_high", "z_low", "z_high"}


@every_case(
    ("text", "complaint"),
    [
        ("[head]\ngian 3", "did you mean gain?"),
        ("[legs]\ngain 3", r"\[legs\]"),
        ("[head]\ngain fast", "not a number"),
        ("[head]\ngain nan", "finite"),
        ("[arm]\nfastest -1", "not negative"),
        ("[arm]\nfastest 0", r"\[arm\] fastest of 0 m/s; allowed: 0.001 to 0.5"),
        ("[arm]\nfastest 3", r"\[arm\] fastest of 3 m/s; allowed: 0.001 to 0.5"),
        ("[arm]\nfastest_turn 0", "allowed: 0.1 to 180"),
        ("[arm]\ngain 1e9", r"\[arm\] gain of 1e\+09 1/s; allowed: 0 to 10"),
        ("[arm]\nacceleration 0", "allowed: 0.01 to 10"),
        ("[head]\nfastest 5000", r"\[head\] fastest of 5000 °/s; allowed: 0 to 120"),
        ("[head]\nstep 45", r"\[head\] step of 45 °; allowed: 0 to 10"),
        ("[safety]\nrobot_timeout 60", r"\[safety\] robot_timeout of 60 s; allowed: 0.02 to 0.2"),
        ("[safety]\nfreeze 1e6", r"\[safety\] freeze of 1e\+06 s; allowed: 0.1 to 2"),
        ("[safety]\ncommand_timeout 1", "allowed: 0.02 to 0.2"),
        ("[safety]\nguardian_timeout 1", "allowed: 0.04 to 0.2"),
        ("[head]\nmode jump", "velocity, direct and steps"),
        ("[head]\nstart 0.01", "never rest"),
        ("[safety]\nimage_timeout 0.5", "too long"),
        ("[loop]\nrate 0", "1 to 1000"),
        ("[faces]\ndetector ~nobody-of-this-name/yunet.onnx", "no such home directory"),
        ("[marker]\nid = 50", "4X4_50 has no marker 50; it has 0 to 49"),
        ("[marker]\nstandoff 0", r"\[marker\] standoff of 0 m; allowed: 0.01 to 1"),
        ("[track]\njump 0", r"\[track\] jump of 0 m; allowed: 0.001 to 1"),
        ("[track]\nconfirm 0", r"\[track\] confirm of 0 images; allowed: 1 to 100"),
        ("[track]\nsmoothing 0", r"\[track\] smoothing of 0; allowed: 0.001 to 1"),
        ("[track]\ngrace 100", "allowed: 0 to 2"),
        ("[head]\ndeadband 3\nstart 3", "allowed: 0 to 0.5"),
        (
            "[head]\nmode steps\nstep 10\nfastest 20",
            "every 0.2 s .step_period. is faster than fastest, 20 °/s",
        ),
        ("[head]\nstep_period 0", r"\[head\] step_period of 0 s; allowed: 0.02 to 10"),
        ("[arm]\nreached 0.003", r"\[arm\] reached must be at least twice deadband"),
        ("[arm]\ndeadband_turn 1", r"\[arm\] reached_turn must be at least twice deadband_turn"),
        ("[safety]\nimage_timeout 0", "allowed: 0.02 to 0.2"),
        ("[safety]\nstuck 0", "allowed: 0.1 to 60"),
        ("[safety]\nclearance 5", "allowed: 0 to 0.5"),
    ],
)
def test_a_setting_that_cannot_be_is_refused(text, complaint):
    with pytest.raises(UsageError, match=complaint):
        Config.parse(text)


@pytest.mark.parametrize("text", ["[arm]\nfastest 3", "[safety]\nrobot_timeout 60", "[head]\ngain fast"])
def test_a_refusal_names_the_file(tmp_path, text):
    (path := tmp_path / "mine.ini").write_text(text)
    with pytest.raises(UsageError, match=r"mine\.ini"):
        Config.load(path)


def test_a_setting_before_any_section_is_named():
    with pytest.raises(UsageError, match="'rate' precedes the first section; there are "):
        Config.parse("rate 10\n[arm]\ny_low -0.5")


@pytest.mark.parametrize("name", ["arms", "parse", "__init__"])
def test_a_section_that_is_none_is_named(name):
    with pytest.raises(UsageError, match=rf"has a section \[{name}\]; there are \[marker\], "):
        Config.parse(f"[{name}]\nrate 10")


def test_settings_change_what_they_name():
    config = Config.parse("[arm]\ny_low -0.5\n[marker]\nid 7\ndictionary 5X5_100")
    assert (config.arm.y_low, config.marker.id, config.marker.dictionary) == (-0.5, 7, "5X5_100")
    assert config.head == HeadConfig()
