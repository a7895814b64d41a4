"""`python -m benchmarks servo_faults`: its figures, and the options of the simulators that it uses."""

import argparse
import subprocess
import sys

import numpy as np
import pytest

from benchmarks.servo import servo_faults
from benchmarks.servo._forked_commands import Command, Launcher
from benchmarks.servo.servo_faults import MARKERS, Trial, Truth, judge
from grabbergui import cli
from grabbergui.servo.config import Config
from grabbergui.servo.robots import teo
from patience import until

FAULT = Trial("teo", MARKERS["teo"], "hand-jumps@0.5")


def record(fault=1.0):
    """A hand that leaves the workspace by 30 mm along x: at 100 mm/s from 0.5 s to 1.5 s, then rests."""
    times = np.arange(0.0, 4.0, 0.01)
    hand = np.tile((0.78, -0.3, 0.2), (len(times), 1))
    hand[:, 0] += 0.1 * np.clip(times - 0.5, 0.0, 1.0)
    return Truth(times, hand, fault)


def test_a_fault_is_judged_from_its_beginning():
    said = [(0.6, "approaching: …"), (1.2, "stopped: the hand jumped"), (2.5, "searching: …")]
    outcome = judge(FAULT, record(), said, Config())
    assert outcome.speed == pytest.approx(100, abs=1)
    assert outcome.outside == pytest.approx(30, abs=0.1)
    assert outcome.moved == pytest.approx(50, abs=0.1)
    assert outcome.stopped_after == pytest.approx(0.5, abs=0.02)
    assert (outcome.said, outcome.said_after) == ("stopped: the hand jumped", pytest.approx(0.2))
    assert outcome.happened


def test_an_approach_is_judged_from_its_motion():
    said = [(2.0, "reached: the hand is at the marker")]
    outcome = judge(Trial("teo", MARKERS["teo"]), record(None), said, Config())
    assert outcome.moved == pytest.approx(100, abs=0.1)
    assert outcome.stopped_after == pytest.approx(1.0, abs=0.02)
    assert outcome.reached_after == pytest.approx(1.5, abs=0.02)


def test_a_fault_that_did_not_begin_and_a_hand_that_does_not_rest_are_reported():
    assert not judge(FAULT, record(None), [], Config()).happened
    whole = record()
    moving = Truth(whole.times[:140], whole.hand[:140], whole.fault)
    assert judge(FAULT, moving, [], Config()).stopped_after is None


def test_a_speed_is_that_of_the_fastest_50_ms():
    times = np.arange(0.0, 1.0, 0.01)
    hand = np.zeros((len(times), 3))
    hand[50:55, 1] = np.linspace(0.002, 0.010, 5)
    hand[55:, 1] = 0.010
    assert Truth(times, hand, None).speeds().max() == pytest.approx(0.2, rel=0.02)


def test_random_markers_are_visible_and_their_goals_in_the_workspace():
    source = np.random.default_rng(3)
    for _ in range(3):
        marker = servo_faults.visible_marker(source, "teo", teo.MODEL)
        assert servo_faults._visible(servo_faults.at(*marker), teo.MODEL)


def test_a_trial_in_simulated_time_has_figures():
    outcome = servo_faults.simulate(Trial("teo", MARKERS["teo"], "camera-lost@0.3"), Config(), teo.MODEL)
    assert outcome.happened
    assert 5 < outcome.moved < 30
    assert outcome.stopped_after < 0.3
    assert outcome.said.startswith("lost")


def test_the_next_slice_does_what_is_not_in_the_file(tmp_path):
    file, near = tmp_path / "trials.json", Trial("teo", MARKERS["teo"])
    servo_faults._store([judge(near, record(None), [], Config()), judge(FAULT, record(), [], Config())], file)
    before = servo_faults.stored(file)
    assert [outcome.trial for outcome in before] == [near, FAULT]
    other = Trial("tiago", MARKERS["tiago"], "hand-jumps@0.5")
    assert servo_faults.remaining([near, FAULT, near, other], before) == [near, other]
    assert servo_faults.stored(tmp_path / "none.json") == []
    file.write_text('[{"speed": 1}]', "utf-8")
    with pytest.raises(SystemExit, match=r"trials\.json has no trials of this benchmark"):
        servo_faults.stored(file)


def test_the_table_for_the_manual_has_the_longest_of_each_fault():
    later = Trial("teo", MARKERS["teo"], "hand-jumps@1.2")
    outcomes = [judge(FAULT, record(), [], Config()), judge(later, record(1.2), [], Config())]
    rows = servo_faults.for_the_manual(outcomes).splitlines()
    (row,) = (row for row in rows if row.startswith("| `hand-jumps`"))
    assert row.endswith("| 50 mm, 0.5 s (2) | not tried (0) |")


def test_more_trials_begin_with_the_same_ones():
    few, many = (
        servo_faults.trials(
            argparse.Namespace(
                seed=1, approaches=number, near=0, each=number, fault=["hand-jumps"], simulated_time=False
            ),
            {"teo": teo.MODEL},
        )
        for number in (1, 3)
    )
    assert set(few) < set(many)


def test_a_forked_command_has_its_own_output_and_is_ended():
    launcher = Launcher()
    command = Command(
        launcher, ["simulate-teo", "--with-name-server", "--nameserver", "127.0.0.1:0"], {}, first=False
    )
    try:
        assert command.wait_for("is on the name server at 127")
        assert command.running
        command.end()
        until(lambda: not command.running)
        wrong = Command(launcher, ["simulate-teo", "--fault", "hand"], {}, first=False)
        assert wrong.wait_for("there is no fault 'hand'")
        until(lambda: not wrong.running)
    finally:
        launcher.close()


@pytest.mark.parametrize("command", ["simulate-teo", "simulate-tiago"])
@pytest.mark.parametrize(
    ("option", "message"),
    [
        (["--fault", "hand"], "there is no fault 'hand'; there are arm-blocked, hand-drifts"),
        (["--fault", "hand-jumps@soon"], "write hand-jumps@SECONDS"),
        (["--marker", "0.7,0,0.4"], "write x,y,z in metres and yaw,pitch,roll in degrees"),
        (["--marker", "0.7,0,nan,0,0,0"], "write x,y,z in metres and yaw,pitch,roll in degrees"),
        (["--truth", "/nowhere/truth.csv"], "/nowhere/truth.csv"),
    ],
)
def test_a_wrong_option_is_refused(command, option, message, capsys):
    if command == "simulate-tiago":
        pytest.importorskip("pinocchio", reason="Pinocchio is not installed")
        pytest.importorskip("rclpy", reason="ROS 2 is not installed")
    try:
        code = cli.main([command, *option])
    except SystemExit as end:
        code = end.code
    assert code == 2 or "truth" in message
    assert code
    assert message in capsys.readouterr().err


def test_the_simulator_records_the_truth_with_the_marker_in_view(tmp_path):
    file = tmp_path / "truth.csv"
    arguments = ["simulate-teo", "--with-name-server", "--nameserver", "127.0.0.1:0", "--truth", str(file)]
    marker = "--marker=0.7,-0.32,0.36,4,-8,180"
    process = subprocess.Popen(
        [sys.executable, "-m", "grabbergui", *arguments, marker, "--fault", "hand-jumps"]
    )
    try:
        until(lambda: file.exists() and len(file.read_text("utf-8").splitlines()) > 10)
    finally:
        process.terminate()
        assert process.wait(30) == 0
    head = [float(value) for value in file.read_text("utf-8").splitlines()[5].split(",")[8:10]]
    assert head == pytest.approx([-0.42, 0.1], abs=0.1)
