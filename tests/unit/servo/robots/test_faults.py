"""Faults of simulated robots: what is reported, which images arrive, and when, without a clock."""

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from every_case import every_case
from grabbergui.calibration import geometry
from grabbergui.core.errors import UsageError
from grabbergui.servo import closed_loop
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.fault_list import DEFAULT_AFTER, FAULTS, Fault
from grabbergui.servo.robots.faults import Faults, ImageFaults
from grabbergui.servo.robots.robot import RobotState
from grabbergui.servo.robots.simulated import SimRobot

TWIST = np.array([0.0, 0.0, 0.1, 0.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("hand-jumps", Fault("hand-jumps", DEFAULT_AFTER)),
        ("hand-jumps@0", Fault("hand-jumps", 0.0)),
        ("images-late@2.5", Fault("images-late", 2.5)),
    ],
)
def test_a_fault_has_a_name_and_perhaps_a_time(text, fault):
    assert Fault.parse(text) == fault


@pytest.mark.parametrize(
    "text", ["", "hand", "hand-jumps@", "hand-jumps@-1", "hand-jumps@nan", "hand-jumps@1e9"]
)
def test_another_fault_or_time_is_refused(text):
    with pytest.raises(
        UsageError, match=r"--fault .*(there are .*hand-jumps.*second-master|hand-jumps@SECONDS)"
    ):
        Fault.parse(text)


class _Moving:
    """A TEO whose hand moves up, on a clock that the test sets."""

    def __init__(self, *names, reports_hand=True):
        self.now = 0.0
        self.faults = Faults([Fault(name) for name in names], reports_hand=reports_hand)
        self.robot = SimRobot(teo.MODEL, lambda: self.now, faults=self.faults)

    def until(self, seconds):
        while self.now < seconds:
            self.now += 0.01
            self.robot.move_hand(TWIST)
            self.robot.state()
        return self.robot.state(), self.robot.truth()


def at_the_fault(name, seconds=0.7, **options):
    moving = _Moving(name, **options)
    before = moving.until(0.4)
    assert before[0] is before[1]
    return moving.until(seconds)


def off(states):
    return geometry.distance(states[0].hand, states[1].hand)


def test_a_fault_waits_for_motion():
    moving = _Moving("hand-jumps")
    moving.now = 100.0
    state = moving.robot.state()
    assert state is moving.robot.truth()
    moving.until(101.0)
    assert moving.robot.state() is not moving.robot.truth()


def test_a_reading_is_off_as_the_fault_says():
    assert off(at_the_fault("hand-jumps")) == pytest.approx(0.3)
    assert off(at_the_fault("hand-far")) == pytest.approx(1e12)
    assert off(at_the_fault("hand-drifts", 1.6)) == pytest.approx(0.05, abs=0.005)


@pytest.mark.parametrize(("name", "metres"), [("hand-jumps", 0.3), ("hand-drifts", 0.05)])
def test_a_robot_that_reports_only_joints_reports_a_wrong_joint(name, metres):
    reported, true = at_the_fault(name, 1.6, reports_hand=False)
    wrong = np.flatnonzero(reported.arm != true.arm)
    assert len(wrong) == 1
    assert off((reported, true)) == pytest.approx(metres, rel=0.15)
    assert np.array_equal(reported.hand, teo.RIGHT_ARM.forward(reported.arm))


def test_frozen_readings_scatter_and_repeated_ones_do_not():
    for name, scatter in (("readings-freeze", 1e-5), ("readings-repeat", 0.0)):
        moving = _Moving(name)
        first, second = (moving.until(seconds)[0] for seconds in (0.7, 1.2))
        assert geometry.distance(first.hand, second.hand) == pytest.approx(0.0, abs=10 * scatter)
        assert np.array_equal(first.arm, second.arm) == (not scatter)
        assert second.time == moving.robot.truth().time
        assert off((second, moving.robot.truth())) > 0.04


def test_readings_that_stop_grow_old_and_others_are_no_numbers():
    reported, true = at_the_fault("readings-stop")
    assert true.time - reported.time == pytest.approx(0.15, abs=0.05)
    assert not at_the_fault("readings-nan")[0].sound


def test_a_blocked_arm_reports_that_it_rests():
    moving = _Moving("arm-blocked")
    first = moving.until(0.7)[0]
    assert geometry.distance(first.hand, moving.until(1.0)[1].hand) == 0.0


def arrivals(name, images=80, period=0.04):
    """(exposed, stamped, arrived, what) of every image that arrives from a camera at 25 Hz."""
    faults = Faults([Fault(name, 0.0)])
    camera = ImageFaults(
        faults, lambda image, now: (image[0], now, image[2]), lambda image, how: (*image[:2], how)
    )
    found = []
    for number in range(images):
        now = number * period
        if number == 5:
            faults.moved(now)
        found += [(*image[:2], now, image[2]) for image in camera.pass_on((number, now, ""), now)]
    return found


def test_a_lost_camera_and_a_hanging_one():
    assert [image[0] for image in arrivals("camera-lost")] == [0, 1, 2, 3, 4]
    for name, kept in (("image-repeats", {4}), ("images-alternate", {3, 4})):
        images = arrivals(name)
        assert len(images) == 80
        assert {image[0] for image in images[5:]} == kept
        assert all(image[1] == image[2] for image in images)  # with new stamps
        assert all(a[0] != b[0] for a, b in pairwise(images)) == (name == "images-alternate")


def test_late_images_come_a_second_after_their_exposure():
    images = arrivals("images-late")
    assert [image[0] for image in images] == list(range(55))
    assert all(arrived - stamped == pytest.approx(1.02, abs=0.03) for _, stamped, arrived, _ in images[5:])
    assert all(stamped == arrived for _, stamped, arrived, _ in arrivals("images-late-restamped"))


@pytest.mark.parametrize("name", ["images-dark", "images-mirrored", "images-noise"])
def test_an_image_is_spoiled(name):
    assert [image[3] for image in arrivals(name)] == [""] * 5 + [name] * 75


def test_a_second_master_and_a_stranger_need_no_robot_of_their_own():
    faults = Faults([Fault("second-master", 0.0), Fault("false-readings", 0.0)])
    robot = SimRobot(teo.MODEL, lambda: 0.0, faults=faults)
    assert robot.state().sound
    assert faults.master_twist(1.0) is None
    assert faults.false_reading(1.0) is None
    faults.moved(1.0)
    assert faults.master_twist(1.0)[1] == -0.3
    false = faults.false_reading(2.0)
    assert (false.time, off((false, robot.truth()))) == (2.0, pytest.approx(0.0, abs=1e-4))


def test_a_stranger_moves_a_hand_only_while_twists_are_obeyed():
    now = [0.0]
    robot = SimRobot(teo.MODEL, lambda: now[0])
    robot.obey_stranger(TWIST)
    now[0] = 0.1
    assert robot.speed == 0
    robot.move_hand(np.zeros(6))
    robot.obey_stranger(TWIST)
    now[0] = 0.2
    assert robot.speed > 0
    robot.stop()
    robot.obey_stranger(TWIST)
    now[0] = 0.3
    assert robot.speed == 0


def test_the_manual_lists_every_fault():
    manual = (Path(__file__).parents[4] / "docs/servoing.md").read_text("utf-8")
    listed = re.findall(r"^\| `([a-z-]+)` \|", manual, re.MULTILINE)
    assert listed == list(FAULTS)


@every_case("name", FAULTS)
def test_every_fault_can_be_run_without_a_clock(name):
    faults = Faults([Fault(name, 0.1)])
    run = closed_loop.ClosedLoop(rendered=False, head=closed_loop.AT_BOARD, faults=faults)
    run.run(1.2)
    assert faults.active(run.now) == [name]
    assert isinstance(run.robot.truth(), RobotState)
    assert run.robot.truth().sound
