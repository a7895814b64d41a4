"""`grabbergui rig` on simulated cameras on the wire."""

import json
import os
from types import SimpleNamespace

import numpy as np
import pytest

from grabbergui.cli import main
from grabbergui.cli.rig import LevelTrigger
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.server import GigeCamera
from grabbergui.rig import rig_file

NET = f"127.88.{os.getpid() % 250 + 1}"
"Network of this test run alone: others may run at the same time."
ADDRESSES = (f"{NET}.1", f"{NET}.2")


@pytest.fixture(scope="module")
def cameras():
    small = {reg.WIDTH: 64, reg.HEIGHT: 48, reg.EXPOSURE_TIME: 2000.0}
    started = [GigeCamera(address, power_on=small) for address in ADDRESSES]
    yield started
    for camera in started:
        camera.close()


@pytest.fixture
def file(cameras, tmp_path, capsys):
    path = tmp_path / "stereo.yaml"
    sources = [f"{name}=gige:{address}" for name, address in zip(("left", "right"), ADDRESSES, strict=True)]
    assert main(["rig", "new", str(path), *sources, "--trigger", "action", "--rate", "10"]) == 0
    assert f"open it as rig:{path}" in capsys.readouterr().out
    return path


def test_a_new_rig_is_checked_planned_and_recorded(file, capsys, tmp_path):
    main(["rig", "check", str(file), "-t", "2", "--json"])
    checked = json.loads(capsys.readouterr().out)
    assert checked["sets"]["complete"] >= 5 and set(checked["clocks"]) == {"left", "right"}
    assert {clock["kind"] for clock in checked["clocks"].values()} == {"ptp"}
    assert checked["cameras"]["left"]["frames"] >= 5

    assert main(["rig", "budget", str(file)]) == 0
    table = capsys.readouterr().out
    assert "GevSCPD=" in table and "write it into the file with --apply" in table
    assert "GevSCPD" not in file.read_text()
    assert main(["rig", "budget", str(file), "--apply"]) == 0
    assert rig_file.read(file).cameras["right"].settings["GevSCPD"] > 1000

    recording = tmp_path / "run.mcap"
    assert main(["rig", "record", str(file), "--out", str(recording), "-n", "5", "--json"]) == 0
    recorded = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert recorded["sets"] == 5 and recorded["counts"]["skew_median_ns"] < 5_000_000
    assert main(["rig", "check", str(recording)]) == 2
    assert f"play it as rig:{recording}" in capsys.readouterr().err
    assert main(["grab", f"rig:{recording}", "--json"]) == 0

    assert main(["rig", "budget", str(file), "--undo"]) == 0
    assert not rig_file.read(file).cameras["right"].settings


def test_a_wrong_group_mask_is_named(file, cameras, capsys):
    entry = rig_file.read(file)
    text = rig_file.to_text(entry).replace("rate: 10.0", "rate: 10.0\n  group_mask: 0")
    file.write_text(text)
    assert main(["rig", "check", str(file), "-t", "0.5"]) == 1
    assert "left: the camera ignores the actions: ActionGroupMask 0x0" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["new", "{file}", "a=sim:"], "is there already"),
        (["new", "{folder}/b.yaml", "a"], "write a name and a source"),
        (["new", "{folder}/b.yaml", "a=sim:", "a=sim:colour"], "two cameras have one name"),
        (["new", "{folder}/b.yaml", "9=sim:"], "cannot be a camera's name"),
        (["new", "{folder}/b.yaml", "a=gige:GV01", "b=gige://GV01"], "cameras.b: gige:GV01 is a already"),
        (["check", "{folder}/none.yaml"], "none.yaml"),
        (["check", "{file}", "a=sim:"], "takes no cameras"),
        (["budget", "{file}", "--apply", "--undo"], "write it alone"),
        (["record", "{file}"], "--out run.mcap"),
        (["serve", "{file}"], "--yarp /PORT or --ros2 /NAME"),
    ],
)
def test_wrong_usage_is_named(file, arguments, problem, capsys):
    capsys.readouterr()
    assert main(["rig", *(text.format(file=file, folder=file.parent) for text in arguments)]) == 2
    assert problem in capsys.readouterr().err


def test_the_seconds_before_an_event_are_recorded(file, cameras, capsys, tmp_path):
    recording = tmp_path / "event.mcap"
    on = ["--before", "2", "--after", "0.3", "--on", "FrameStart"]
    assert main(["rig", "record", str(file), "--out", str(recording), "-n", "4", *on]) == 0
    assert "4 sets" in capsys.readouterr().out
    never = [
        "--out",
        str(tmp_path / "never.mcap"),
        "--before",
        "2",
        "--on",
        "Line1RisingEdge",  # no line is wired; a busy machine does miss triggers
        "-t",
        "0.3",
    ]
    assert main(["rig", "record", str(file), *never]) == 0
    assert "nothing of --on happened" in capsys.readouterr().out
    assert main(["rig", "record", str(file), "--out", "x.mcap", "--before", "2"]) == 2
    assert main(["rig", "record", str(file), "--out", "x.mcap", "--before", "2", "--on", "Nothing"]) == 2
    assert "no camera has this event" in capsys.readouterr().err


def test_cameras_without_a_link_have_no_budget(capsys, tmp_path):
    path = tmp_path / "two.yaml"
    assert main(["rig", "new", str(path), "a=sim:", "b=sim:"]) == 0
    capsys.readouterr()
    assert main(["rig", "budget", str(path)]) == 0
    assert capsys.readouterr().out == "a, b: not on a network or USB, so there is no link to divide\n"


def test_a_level_is_noticed_once_when_it_is_crossed():
    seen = []
    trigger = LevelTrigger(0.5, lambda: seen.append(1))
    for value in (200, 10, 200, 200, 10, 255):
        trigger.look(SimpleNamespace(mono=lambda value=value: np.full((16, 16), value, np.uint8)))
    assert len(seen) == 2
