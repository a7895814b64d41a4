"""Changes made again, by a command line and by a program."""

import shlex
import subprocess
import sys

import pytest

from grabbergui import cli, sources
from grabbergui.core.settings import SettingKey
from grabbergui.models.change_tracking import command_line, program, writes
from operator_bench import CAMERA, UNDO
from patience import PROGRAM

URI = "sim:?width=64&height=64&pixel_format=RGB8"
NAMES = ["ExposureTime", "Gain", "BalanceRatioSelector", "BalanceRatio", "Gamma", "DeviceUserID"]


@pytest.fixture
def tuned(sim):
    """A camera on which an operator was at work, and its settings at the end."""
    sim.write("ExposureTime", 4000.0)
    sim.write("Gain", 3.0)
    sim.write("ExposureTime", 5000.0)
    sim.write("BalanceRatioSelector", "Blue")
    sim.write("BalanceRatio", 2.5)
    sim.write("BalanceRatioSelector", "Red")
    sim.write("BalanceRatio", 1.5)
    sim.write("Gamma", 2.0)
    sim.revert(UNDO)
    sim.write("DeviceUserID", "it's $HOME")
    sim.journal.saw(SettingKey("BlackLevel"), 1.0, 9.0, CAMERA)
    return sim


def after(camera):
    return [camera.feature(name).value for name in NAMES]


def test_the_command_line_makes_the_changes_again(tuned, capsys, monkeypatch):
    line = command_line(URI, tuned.journal.changes)
    words = shlex.split(line)
    assert words[:3] == ["grabbergui", "set", URI]
    assert not [w for w in words if w.startswith(("Gamma", "BlackLevel")) or w == "ExposureTime=4000"]
    opened, create = [], sources.create

    def remembered(uri):
        opened.append(create(uri))
        monkeypatch.setattr(opened[-1], "close", lambda: None)
        return opened[-1]

    monkeypatch.setattr(sources, "create", remembered)
    assert cli.main(words[1:]) == 0
    (camera,) = opened
    monkeypatch.undo()
    try:
        assert after(camera) == after(tuned.grabber)
        camera.write_feature("BalanceRatioSelector", "Blue")
        assert camera.feature("BalanceRatio").value == 2.5
    finally:
        camera.close()
    assert "Gain = 3 dB" in capsys.readouterr().out


def test_the_program_makes_the_changes_again(tuned):
    text = program(URI, tuned.journal.changes)
    assert "camera['ExposureTime'] = 5000.0" in text
    text += f"    print([camera[name] for name in {NAMES}])\n"
    ran = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, timeout=PROGRAM)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.strip() == repr(after(tuned.grabber))


def test_commands_stand_where_they_were_run(sim):
    sim.write("Gain", 3.0)
    sim.tracked_grabber.execute("TimestampLatch")
    sim.write("Gain", 6.0)
    assert command_line("sim:", sim.journal.changes) == (
        "grabbergui set sim: Gain=3\ngrabbergui run sim: TimestampLatch\ngrabbergui set sim: Gain=6\n"
    )
    assert "camera.execute('TimestampLatch')" in program("sim:", sim.journal.changes)


def test_a_command_is_run_again_under_its_selectors(sim):
    """Also if the operator did not move them, and although a command may move them."""
    sim.grabber.write_feature("UserSetSelector", "UserSet1")
    sim.tracked_grabber.execute("UserSetSave")
    sim.tracked_grabber.execute_setting(SettingKey("UserSetLoad", (("UserSetSelector", "Default"),)))
    sim.tracked_grabber.execute("UserSetLoad")
    assert [str(change) for change in sim.journal.changes] == [
        "UserSetSave[UserSetSelector=UserSet1] run",
        "UserSetLoad[UserSetSelector=Default] run",
        "UserSetLoad[UserSetSelector=UserSet1] run",
    ]
    assert writes(sim.journal.changes) == [
        ("UserSetSelector", "UserSet1"),
        ("UserSetSave", None),
        ("UserSetSelector", "Default"),
        ("UserSetLoad", None),
        ("UserSetSelector", "UserSet1"),
        ("UserSetLoad", None),
    ]


def test_selectors_are_set_again_after_a_command(sim):
    sim.write("BalanceRatioSelector", "Blue")
    sim.write("BalanceRatio", 2.5)
    sim.tracked_grabber.execute("TimestampLatch")
    sim.write("BalanceRatio", 1.5)
    assert writes(sim.journal.changes)[2:] == [
        ("TimestampLatch", None),
        ("BalanceRatioSelector", "Blue"),
        ("BalanceRatio", 1.5),
    ]


def test_nothing_changed_makes_an_empty_line_and_a_program_that_runs(operator):
    assert command_line("sim:", ()) == ""
    compile(program("sim:", ()), "program", "exec")
