"""The monitor: what a robot does is compared with what it was commanded, in simulated time."""

import math
from dataclasses import asdict, replace

import numpy as np
import pytest

from grabbergui.servo.monitor import Monitor, Observation, SpeedLimits

LAG, DT = 0.15, 0.02
SPEED = 0.3
"Commanded, rad/s of the first joint."


class Watched:
    """One arm joint and a head, whose commands and readings are functions of the time."""

    def __init__(self, commanded, measured, **others):
        self.monitor, self.commanded, self.measured = Monitor(LAG), commanded, measured
        self.others = others

    def run(self, seconds):
        """Return when it was stopped, and why; infinity and nothing if it was not."""
        for step in range(round(seconds / DT)):
            now = step * DT
            others = {name: value(now) for name, value in self.others.items()}
            seen = Observation(
                now, (self.commanded(now), 0.0, 0.0), now, (self.measured(now), 0.0, 0.0), **others
            )
            if problem := self.monitor.look(seen):
                return now, problem
        return math.inf, ""


def ramp(speed=SPEED, begin=0.0, end=math.inf):
    return lambda now: speed * max(0.0, min(now, end) - begin)


@pytest.mark.parametrize("late", [0.0, 0.05, 0.14])
def test_a_robot_that_is_late_but_does_what_it_is_commanded_is_left_alone(late):
    assert Watched(ramp(begin=0.5, end=2.0), ramp(begin=0.5 + late, end=2.0 + late)).run(4) == (math.inf, "")


def test_a_robot_that_reverses_and_lags_is_left_alone():
    def sway(now):
        return 0.4 * math.sin(2 * now)

    assert Watched(sway, lambda now: sway(now - 0.1) if now > 0.1 else 0.0).run(5)[1] == ""


@pytest.mark.parametrize("noise", [0.0, 1e-5])
def test_readings_that_freeze_are_noticed_within_300_ms(noise):
    frozen = ramp(end=1.0)
    when, why = Watched(ramp(), lambda now: frozen(now) + noise * math.sin(1e3 * now)).run(3)
    assert 1.0 < when <= 1.3
    assert "the arm does not move as commanded" in why


@pytest.mark.parametrize("commanded", [0.0, SPEED], ids=["at rest", "in motion"])
def test_motion_that_was_not_commanded_is_noticed_within_200_ms(commanded):
    def measured(now):
        return commanded * now - ramp(0.6, begin=1.0)(now)

    when, why = Watched(ramp(commanded), measured).run(3)
    assert 1.0 < when <= 1.2
    assert ("moves though that was not commanded" in why) or commanded


def test_one_reading_that_jumps_is_enough():
    when, why = Watched(lambda now: 0.0, lambda now: 0.3 if abs(now - 1.0) < 1e-9 else 0.0).run(2)
    assert when == pytest.approx(1.0)
    assert "17.2°" in why


class Joints:
    """An arm of four joints and a head, with commanded and measured velocities."""

    def __init__(self):
        self.monitor, self.now = Monitor(LAG), 0.0
        self.commanded, self.measured = np.zeros(6), np.zeros(6)

    def run(self, seconds, commanded, measured=None, *, looks=True, stopped=False):
        """Return after how long it was stopped, and why; without `looks` everything goes on unobserved.

        `stopped` is whether it begins with a stop.
        """
        begun, commanded = self.now, np.array([*commanded, 0.0, 0.0])
        measured = commanded if measured is None else np.array([*measured, 0.0, 0.0])
        for _ in range(round(seconds / DT)):
            self.now += DT
            self.commanded, self.measured = self.commanded + commanded * DT, self.measured + measured * DT
            seen = Observation(
                self.now, tuple(self.commanded), self.now, tuple(self.measured), stopped=stopped
            )
            stopped = False
            if looks and (problem := self.monitor.look(seen)):
                return self.now - begun, problem
        return math.inf, ""


FAST, SLOW = np.array([0.8, -0.5, 0.5, 0.1]), np.array([0.08, 0.06, -0.05, 0.06])
BESIDE, STILL = np.array([0.06, 0.1, 0.05, -0.1]), np.zeros(4)


def test_joints_that_are_slow_each_are_noticed_together_when_they_freeze():
    """Each alone made too little of a difference: it took 0.67 s."""
    arm = Joints()
    assert arm.run(2, SLOW) == (math.inf, "")
    when, why = arm.run(2, SLOW, STILL)
    assert when <= 0.32
    assert "the arm does not move as commanded: only" in why


def test_motion_beside_that_of_fast_joints_is_noticed():
    """Each joint's delay alone could have explained it: it took 0.63 s."""
    arm = Joints()
    assert arm.run(2, FAST) == (math.inf, "")
    when, why = arm.run(2, FAST, FAST + BESIDE)
    assert when <= 0.22
    assert "the arm moves though that was not commanded" in why


@pytest.mark.parametrize("moves_on", [0.0, 0.2])
@pytest.mark.parametrize("pause", [0.1, 0.3, 0.5])
def test_what_a_busy_computer_did_not_command_is_not_missed(pause, moves_on):
    """Nor is what the robot did in such a pause, before its commands' time was over."""
    arm = Joints()
    arm.run(2, FAST)
    arm.run(min(pause, moves_on), FAST, looks=False)
    arm.run(pause - min(pause, moves_on), FAST, STILL, looks=False)
    assert arm.run(0.1, STILL) == (math.inf, "")
    assert arm.run(3, FAST) == (math.inf, "")


@pytest.mark.parametrize("pause", [0.1, 0.2])
def test_what_a_network_lost_is_not_missed_but_readings_that_freeze_are(pause):
    arm = Joints()
    arm.run(2, FAST)
    arm.run(pause, FAST, STILL, looks=False)
    assert arm.run(3, FAST) == (math.inf, "")
    for _ in range(5):
        arm.run(pause, FAST, STILL, looks=False)
        _, why = arm.run(0.5, FAST, STILL)
        if why:
            break
    assert "does not move as commanded" in why


def test_a_robot_whose_path_turns_aside_in_a_pause_is_left_alone():
    """A controller holds the twist, and in another pose that is another motion of the joints."""
    arm = Joints()
    arm.run(2, FAST)
    arm.run(0.2, FAST, FAST + np.array([0.0, 0.0, 0.0, 0.5]), looks=False)
    arm.run(0.14, FAST, STILL, looks=False)
    assert arm.run(0.5, STILL) == (math.inf, "")


@pytest.mark.parametrize("seconds", [0.04, 0.08, 0.14])
def test_a_motion_that_a_stop_has_overtaken_is_not_missed_but_readings_that_freeze_are(seconds):
    """Late images stopped a hand that had not set out yet, and then it "did not move as commanded"."""
    arm = Joints()
    arm.run(2, STILL)
    assert arm.run(seconds, FAST, STILL) == (math.inf, "")
    assert arm.run(2, STILL, stopped=True) == (math.inf, "")
    when, why = arm.run(1, FAST, STILL)
    assert when <= 0.3 and "does not move as commanded" in why


def test_a_jump_during_a_pause_is_noticed():
    arm = Joints()
    arm.run(2, FAST)
    arm.run(0.3, STILL, (0.0, 0.0, 0.0, 1.0), looks=False)
    assert "moves though that was not commanded" in arm.run(DT, STILL)[1]


def test_a_slow_drift_is_noticed_before_it_is_far():
    when, _ = Watched(lambda now: 0.0, ramp(0.05, begin=1.0)).run(5)
    assert 0.05 * (when - 1.0) < 0.035


def test_a_head_that_moves_by_itself_is_named():
    monitor = Monitor(LAG)
    still = Observation(0.0, (0.0,) * 3, 0.0, (0.0,) * 3)
    assert monitor.look(still) == ""
    assert "the head moves" in monitor.look(replace(still, now=0.1, time=0.1, measured=(0.0, 0.0, 0.1)))


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"metres": 0.011}, "11 mm and 0° from where its joints put it"),
        ({"radians": 0.06}, "0 mm and 3.44° from where its joints put it"),
        ({"metres": 0.011, "apart": 0.02}, ""),
        ({"metres": 1e12, "apart": 0.02}, "where its joints put it"),
        ({"outside": 0.0051}, "5.1 mm outside the workspace"),
        ({"outside": 0.0049}, ""),
    ],
)
def test_each_reading_is_checked(changes, why):
    monitor = Monitor(LAG)
    seen = Observation(0.0, (0.0,) * 3, 0.0, (0.0,) * 3, limits=SpeedLimits(0.12, 0.6, 0.7))
    assert monitor.look(seen) == ""
    assert why in (found := monitor.look(replace(seen, now=0.02, time=0.02, **changes)))
    assert bool(found) is bool(why)


def test_a_hand_that_begins_outside_may_come_back_but_not_go_further():
    monitor = Monitor(LAG)
    for step, outside in enumerate((0.1, 0.05, 0.02)):
        seen = Observation(step * DT, (0.0,) * 3, step * DT, (0.0,) * 3, outside=outside)
        assert monitor.look(seen) == ""
    assert "outside the workspace" in monitor.look(replace(seen, now=1.0, time=1.0, outside=0.03))


@pytest.mark.parametrize(("speed", "too_fast"), [(0.12, False), (0.2, True)])
def test_a_hand_that_is_faster_than_its_limit_is_stopped(speed, too_fast):
    places = {"hand": lambda now: (speed * now, 0.0, 0.0), "limits": lambda now: SpeedLimits(speed=0.12)}
    _, why = Watched(ramp(), ramp(), **places).run(1)
    assert ("200 mm/s; its limit is 120 mm/s" in why) is too_fast


def test_a_person_who_resumes_lets_it_start_again():
    monitor = Monitor(LAG)
    seen = Observation(0.0, (0.0,) * 3, 0.0, (0.0,) * 3, outside=0.0)
    monitor.look(seen)
    moved = replace(seen, now=0.1, time=0.1, measured=(1.0, 0.0, 0.0), outside=0.1)
    assert monitor.look(moved)
    monitor.forget()
    assert monitor.look(replace(moved, now=0.2, time=0.2)) == ""


def test_an_observation_survives_the_pipe():
    seen = Observation(1.0, (0.1,) * 8, 0.9, (0.2,) * 8, (1.0, 2.0, 3.0), limits=SpeedLimits(0.12, 0.6, 0.7))
    assert Observation.read(asdict(seen)) == replace(seen)
