"""The gate, command by command: limits to the last digit, what is counted, and what the guardian hears."""

import dataclasses
import logging
import math

import numpy as np
import pytest

from grabbergui.core.errors import AccessDeniedError, SourceUnavailableError
from grabbergui.servo.config import ArmConfig, Config, HeadConfig
from grabbergui.servo.errors import RobotStoppedError
from grabbergui.servo.gate import HERE, LEAD_S, Command, CommandGate
from grabbergui.servo.guardian_link import ALLOWED, Guard, Verdict
from grabbergui.servo.motion import STOPPING_S, planned
from grabbergui.servo.robots import teo
from robots_for_tests import RecordingRobot

HEAD, HAND, TURN = math.radians(40.0), 0.12, math.radians(35.0)
"The limits of a default configuration: rad/s, m/s, rad/s."
STEP = math.radians(10)


class Guardian(Guard):
    """Gives prepared answers and remembers the questions."""

    def __init__(self):
        self.verdict = ALLOWED
        self.moving = []
        self.stops = self.renewals = 0
        self.gone = False
        self.meanwhile = lambda: None
        "Called while it is renewed."

    def beat(self, moving):
        self.moving.append(moving())
        return self.verdict

    def stop(self):
        self.stops += 1

    def renew(self):
        self.renewals += 1
        self.meanwhile()
        if self.gone:
            raise SourceUnavailableError("no guardian")


class Bench:
    def __init__(self, config=None):
        self.robot, self.guardian = RecordingRobot(), Guardian()
        self.gate = CommandGate(self.robot, config or Config(), self.guardian)

    def send(self, now=1.0, **parts):
        return self.gate.send(Command(**{name: np.array(part) for name, part in parts.items()}), now)


@pytest.fixture
def bench():
    return Bench()


@pytest.fixture
def stepping():
    """A robot whose head goes by relative moves."""
    return Bench(Config(head=HeadConfig(mode="steps")))


def along(axis, value, size):
    vector = [0.0] * size
    vector[axis] = value
    return vector


@pytest.mark.parametrize(
    ("part", "vector", "fastest"),
    [
        ("head", [1.0, 0], HEAD),
        ("head", [0, -1.0], HEAD),
        ("hand", along(0, 1.0, 6), HAND),
        ("hand", along(2, -1.0, 6), HAND),
        ("hand", [0.6, 0.8, 0, 0, 0, 0], HAND),
        ("hand", along(3, 1.0, 6), TURN),
        ("hand", [0, 0, 0, 0, 0.6, -0.8], TURN),
        ("head_step", [0, 1.0], STEP),
        ("head_step", [-1.0, 0], STEP),
    ],
)
def test_a_command_is_slowed_down_as_a_whole_to_the_limit(bench, part, vector, fastest):
    for factor in (1.0, 20.0):
        assert bench.send(**{part: np.array(vector) * fastest * factor})
        ((_, sent),) = bench.robot.moves
        robot = bench.robot
        if part == "hand":
            sent = teo.RIGHT_ARM.jacobian(robot.arm) @ teo.RIGHT_ARM.response(robot.arm, sent)
            assert max(np.linalg.norm(sent[:3]) / HAND, np.linalg.norm(sent[3:]) / TURN) < 1 + 1e-9
            assert sent @ vector > 0.5 * fastest
        else:
            assert sent == pytest.approx(np.array(vector) * fastest)
        robot.moves.clear()
    assert bench.gate.refused == 0


@pytest.mark.parametrize("part", ["head", "hand", "head_step"])
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_numbers_that_are_not_finite_are_named(bench, caplog, part, bad):
    assert not bench.send(**{part: along(1, bad, 6 if part == "hand" else 2)})
    assert "not finite" in caplog.text
    assert bench.robot.moves == []


def test_other_limits_hold_from_the_next_command_on(bench):
    bench.gate.tune(Config(head=HeadConfig(fastest=10.0)))
    assert bench.send(head=[math.radians(11), 0])
    assert bench.robot.moves[-1][1] == pytest.approx([math.radians(10), 0])


@pytest.mark.parametrize("part", ["hand", "arm"])
def test_no_hand_moves_by_readings_that_are_not_finite(bench, part):
    reading = bench.robot.state()
    wrong = {"hand": np.full((4, 4), np.nan), "arm": np.full(6, np.nan)}[part]
    bench.robot.state = lambda: dataclasses.replace(reading, **{part: wrong})
    bench.send(hand=along(0, 0.1, 6))
    assert bench.robot.moves == []
    assert bench.gate.hindrance == "the robot's readings are no numbers"


def test_a_command_reaches_head_and_hand(bench):
    assert bench.send(head=[0.1, 0.2], hand=along(1, 0.03, 6))
    (head, velocity), (hand, twist) = bench.robot.moves
    assert (head, hand) == ("head", "hand")
    assert velocity.tolist() == [0.1, 0.2]
    assert twist == pytest.approx(along(1, 0.03, 6))
    assert bench.guardian.moving == [True]
    assert bench.guardian.stops == 0


@pytest.mark.parametrize("part", [{"head": [0, 0.1]}, {"hand": along(5, 0.1, 6)}, {"head_step": [0.0, 0.0]}])
def test_each_part_alone_is_a_motion(bench, part):
    assert bench.send(**part)
    assert bench.gate.sent == 1
    assert bench.robot.stops == 0


def test_a_step_replaces_the_velocity(bench):
    assert bench.send(head=[0.1, 0], head_step=[0.01, 0], hand=along(0, 0.01, 6))
    assert [kind for kind, _ in bench.robot.moves] == ["step", "hand"]


def test_a_command_that_moves_nothing_stops_the_robot_once(bench):
    assert bench.send()
    assert bench.robot.stops == 0, "it rested already"
    bench.send(head=[0.1, 0])
    assert bench.send()
    assert bench.robot.stops == 1
    assert bench.gate.sent == 1
    assert bench.guardian.stops == 0


def test_a_stepping_head_continues_without_new_commands(stepping):
    assert stepping.send(head_step=[0.01, 0])
    assert stepping.send()
    assert [kind for kind, _ in stepping.robot.moves] == ["step"]
    assert stepping.robot.stops == 0
    assert stepping.gate.sent == 1


def test_a_halt_stops_a_step_too(stepping):
    stepping.send(head_step=[0.01, 0])
    assert stepping.gate.send(Command(halt=True), 1.1)
    assert stepping.robot.stops == 1


def test_the_emergency_stop_has_a_reason_and_counts_what_it_refuses(bench):
    assert bench.gate.halted == ""
    bench.gate.halt("")
    assert bench.gate.halted == "emergency stop"
    assert bench.guardian.stops == 1
    assert bench.robot.stops == 2
    assert not bench.send(head=[0.1, 0])
    assert not bench.send()
    assert bench.gate.refused == 1, "to rest is no motion"
    assert bench.guardian.moving == []


def test_the_first_of_several_stops_keeps_its_reason(bench):
    bench.gate.halt("the guardian ended")
    bench.gate.halt("the button")
    assert bench.gate.halted == "the guardian ended"
    assert bench.gate.stops == 2
    bench.gate.release()
    bench.gate.halt("the button")
    assert bench.gate.halted == "the button"


def test_a_robot_that_is_held_says_so_until_it_is_stopped(bench):
    bench.gate.halt("the button")
    bench.gate.hold("ready")
    assert bench.gate.halted == "ready"
    bench.gate.halt("the button, again")
    bench.gate.halt("the loop ended")
    assert bench.gate.halted == "the button, again"
    assert bench.guardian.stops == 4


def test_a_stop_since_the_decision_to_end_another_holds(bench):
    bench.gate.halt("the button")
    decided = bench.gate.stops
    bench.gate.halt("the button")
    with pytest.raises(RobotStoppedError, match="the button"):
        bench.gate.release(decided)
    assert not bench.send(head=[0.1, 0])
    bench.gate.release(bench.gate.stops)
    bench.gate.release(decided)  # another person ended it
    assert bench.send(head=[0.1, 0])


@pytest.mark.parametrize("pressed", [HERE, "YARP"])
def test_a_stop_that_was_pressed_here_is_not_lifted_from_a_network(bench, pressed):
    bench.gate.halt("pressed", pressed)
    bench.gate.halt("stopped over ROS 2", "ROS 2")
    with pytest.raises(AccessDeniedError, match=f"on {pressed}, where it was stopped"):
        bench.gate.release(pressed="ROS 2")
    assert not bench.send(head=[0.1, 0])
    bench.gate.release()
    assert bench.send(head=[0.1, 0])


def test_a_first_start_that_is_awaited_here_is_not_replaced_by_a_network(bench):
    bench.gate.hold("ready")
    with pytest.raises(AccessDeniedError, match="ready"):
        bench.gate.release(pressed="YARP")
    assert bench.gate.halted == "ready"


def test_a_network_may_lift_its_own_stop_and_that_of_a_fault(bench):
    bench.gate.halt("a fault")
    bench.gate.halt("stopped over YARP", "YARP")
    bench.gate.release(pressed="YARP")
    assert bench.send(head=[0.1, 0])


def test_the_emergency_stop_ends_only_with_a_guardian(bench):
    bench.gate.halt("the button")
    bench.guardian.gone = True
    with pytest.raises(SourceUnavailableError):
        bench.gate.release()
    assert bench.gate.halted == "the button"
    bench.guardian.gone = False
    bench.gate.release()
    assert bench.gate.halted == ""
    assert bench.guardian.renewals == 2


def test_a_stop_while_the_emergency_stop_is_being_ended_holds(bench):
    bench.gate.halt("the button")
    bench.guardian.meanwhile = lambda: bench.gate.halt("the button, again")
    with pytest.raises(RobotStoppedError, match="the button, again"):
        bench.gate.release()
    assert bench.gate.halted == "the button, again"
    assert not bench.send(head=[0.1, 0])
    assert bench.robot.moves == []


def test_silence_of_just_the_timeout_is_allowed(bench):
    assert not bench.gate.expire(5.0), "nothing moves yet"
    bench.send(head=[0.1, 0], now=0.0)
    assert not bench.gate.expire(0.15)
    assert bench.gate.expire(0.1501)
    assert (bench.robot.stops, bench.guardian.stops) == (1, 1)
    assert not bench.gate.expire(9.0)


def test_a_command_that_begins_while_the_watchdog_looks_is_not_stopped(bench):
    """It took the age of the command before for that of the new one."""

    class Age(float):
        def __rsub__(self, now):
            bench.send(head=[0.1, 0], now=10.0)
            return now - float(self)

    bench.send(head=[0.1, 0], now=1.0)
    bench.gate.rest()
    bench.gate._last_word = Age(1.0)
    assert not bench.gate.expire(10.0)
    assert bench.robot.stops == 1


def test_a_command_that_is_over_is_stopped_however_new(bench, caplog):
    caplog.set_level(logging.WARNING)
    bench.gate.send(Command(head=np.array([0.1, 0]), until=1.05), 1.0)
    assert not bench.gate.expire(1.05)
    assert bench.gate.expire(1.06)
    assert "the image is too old: stopped" in caplog.text
    bench.send(head=[0.1, 0], now=2.0)
    assert bench.gate.expire(4.0)
    assert "no command for 2000 ms: stopped" in caplog.text


def test_a_rest_takes_the_watchdog_away(bench):
    bench.send(head=[0.1, 0])
    bench.gate.rest()
    assert bench.robot.stops == 1
    bench.gate.rest()
    assert bench.robot.stops == 1
    assert not bench.gate.expire(99.0)


def test_after_a_stop_a_command_moves_it_again_and_the_watchdog_watches(bench):
    bench.send(head=[0.1, 0], now=1.0)
    bench.gate.expire(2.0)
    assert bench.send(head=[0.1, 0], now=3.0)
    assert bench.gate.expire(4.0)


def test_a_refusal_counts_once_and_the_guardian_stops_too(bench, caplog):
    bench.robot.deaf = True
    assert not bench.send(head=[0.1, 0])
    assert (bench.gate.sent, bench.gate.refused) == (0, 1)
    assert (bench.robot.stops, bench.guardian.stops) == (1, 1)
    assert "recording robot does not take a command" in caplog.text
    assert not bench.gate.expire(99.0)


def test_refusals_add_up_whatever_their_reason(bench):
    assert not bench.send(head=[math.nan, 0])
    assert not bench.send(head=[math.nan, 0])
    bench.guardian.verdict = Verdict("it starts")
    assert not bench.send(head=[0.1, 0])
    bench.guardian.verdict = ALLOWED
    bench.robot.deaf = True
    assert not bench.send(head=[0.1, 0])
    bench.robot.move_head = lambda velocity: bench.gate.expire(99.0)
    assert not bench.send(head=[0.1, 0])
    assert (bench.gate.sent, bench.gate.refused) == (0, 5)


@pytest.mark.parametrize("stop", ["rest", "halt", "expire", "deaf", "refused"])
def test_the_guardian_hears_that_a_stopped_robot_does_not_move(bench, stop):
    bench.send(head=[0.1, 0])
    if stop == "rest":
        bench.gate.rest()
    elif stop == "halt":
        bench.gate.halt("the button")
    elif stop == "expire":
        assert bench.gate.expire(99.0)
    elif stop == "deaf":
        bench.robot.deaf = True
        assert not bench.send(head=[0.1, 0])
    else:
        bench.guardian.verdict = Verdict("it was late")
        bench.gate.beat(1.0)
    bench.gate.beat(1.0)
    assert bench.guardian.moving[-1] is False


def test_a_robot_that_is_to_wait_rests_until_it_need_not(bench):
    bench.send(head=[0.1, 0])
    bench.gate.paused = "the window does not answer"
    assert not bench.send(head=[0.1, 0])
    assert bench.robot.stops == 1
    bench.gate.paused = ""
    assert bench.send(head=[0.1, 0])


def test_while_the_guardian_is_not_ready_nothing_moves(bench):
    bench.guardian.verdict = Verdict("it starts")
    assert not bench.send(head=[0.1, 0])
    assert bench.robot.moves == []
    assert (bench.gate.refused, bench.gate.halted) == (1, "")
    assert not bench.gate.expire(99.0), "it never moved"
    bench.guardian.verdict = ALLOWED
    assert bench.send(head=[0.1, 0])


def test_a_robot_that_moves_is_stopped_when_the_guardian_refuses(bench):
    bench.send(head=[0.1, 0])
    bench.guardian.verdict = Verdict("it was late")
    assert not bench.send(head=[0.2, 0])
    assert bench.robot.stops == 1
    assert not bench.gate.expire(99.0)


def test_a_beat_says_whether_the_robot_moves_and_heeds_the_answer(bench):
    bench.gate.beat(1.0)
    bench.send(head=[0.1, 0])
    bench.gate.beat(1.0)
    assert bench.guardian.moving == [False, True, True]
    assert bench.robot.stops == 0
    bench.guardian.verdict = Verdict("it was late")
    bench.gate.beat(1.0)
    bench.gate.beat(1.0)
    assert bench.robot.stops == 1


def test_a_guardian_that_is_gone_is_an_emergency_stop(bench, caplog):
    bench.send(head=[0.1, 0])
    bench.guardian.verdict = Verdict("the guardian ended", for_good=True)
    bench.gate.beat(1.0)
    assert bench.gate.halted == "the guardian ended"
    assert "the guardian ended" in caplog.text
    stops = bench.robot.stops
    bench.gate.beat(1.0)
    assert bench.robot.stops == stops, "once is enough"


def test_a_slower_command_is_the_same_motion():
    command = Command(np.array([0.2, -0.4]), hand=np.array([0.1, 0, 0, 0, 0, -0.6]), until=5.0).slowed(0.5)
    assert command.head.tolist() == [0.1, -0.2] and command.head_step is None and command.until == 5.0
    assert command.hand.tolist() == [0.05, 0, 0, 0, 0, -0.3]
    assert Command(head_step=np.array([0.2, 0.1])).slowed(0.5).head_step.tolist() == [0.1, 0.05]


class LedRobot(RecordingRobot):
    """Remembers which parts are led for a moment instead of moved."""

    def __init__(self):
        super().__init__()
        self.led = []

    def lead_head(self, velocity, seconds):
        self.led.append(("head", velocity.tolist(), seconds))

    def lead_hand(self, twist, seconds):
        self.led.append(("hand", np.round(twist, 6).tolist(), seconds))


HEAD_LED, HAND_LED = ("head", [0.1, 0.0], LEAD_S), ("hand", [0.02, 0, 0, 0, 0, 0], LEAD_S)


@pytest.mark.parametrize(
    ("head", "arm", "led", "moved"),
    [
        ("velocity", "velocity", [], ["head", "hand"]),
        ("direct", "velocity", [HEAD_LED], ["hand"]),
        ("velocity", "direct", [HAND_LED], ["head"]),
        ("steps", "velocity", [HEAD_LED], ["hand"]),
    ],
)
def test_each_part_is_moved_in_its_mode(head, arm, led, moved):
    robot = LedRobot()
    gate = CommandGate(robot, Config(head=HeadConfig(mode=head), arm=ArmConfig(mode=arm)), Guardian())
    assert gate.send(Command(np.array([0.1, 0.0]), hand=np.array([0.02, 0, 0, 0, 0, 0])), 1.0)
    assert robot.led == led and [part for part, _ in robot.moves] == moved


@pytest.mark.parametrize(("mode", "led"), [("direct", [("head", [0.0, 0.0], LEAD_S)]), ("steps", [])])
def test_a_head_that_goes_by_steps_is_left_alone_between_them(mode, led):
    robot = LedRobot()
    gate = CommandGate(robot, Config(head=HeadConfig(mode=mode)), Guardian())
    assert gate.send(Command(hand=np.array([0.02, 0, 0, 0, 0, 0])), 1.0)
    assert robot.led == led


@pytest.mark.parametrize(
    ("floating", "reason"),
    [
        (True, "the robot does not report the angles of its arm"),
        (False, "the robot has not reported where its hand is"),
    ],
    ids=["no angles", "silent"],
)
def test_a_hand_of_unknown_place_rests_and_says_why(floating, reason):
    robot = RecordingRobot(floating=floating)
    robot.silent = not floating
    gate = CommandGate(robot, Config(), Guardian())
    gate.send(Command(np.array([0.1, 0]), hand=np.array([0.02, 0, 0, 0, 0, 0])), 1.0)
    assert gate.hindrance == reason and robot.twist.tolist() == [0.0] * 6
    assert [part for part, _ in robot.moves] == ["head"]


@pytest.mark.parametrize(("now", "age"), [(1.0, 0.0), (1.05, 0.05), (0.9, 0.0), (9.0, STOPPING_S)])
def test_a_reading_is_as_old_as_its_time_says_and_counts_for_as_long_as_a_stop_takes(
    bench, monkeypatch, now, age
):
    ages = []

    def plan(*arguments):
        ages.append(arguments[-1])
        return planned(*arguments)

    monkeypatch.setattr("grabbergui.servo.gate.planned", plan)
    bench.robot.time = 1.0
    bench.send(now, hand=along(0, 0.02, 6))
    assert ages == pytest.approx([age])


def test_where_the_arm_may_not_rest_is_said(bench):
    assert bench.gate.obstruction(teo.HOME) == ""
    assert "it would leave the workspace" in bench.gate.obstruction(np.zeros(6))


@pytest.fixture
def observed(bench, monkeypatch):
    """Return what the guardian is given to compare."""
    seen = []
    monkeypatch.setattr(bench.guardian, "observe", seen.append)
    return seen


def test_the_guardian_compares_what_was_commanded_with_what_is_measured(bench, observed):
    bench.robot.time = 1.0
    bench.send(1.0, head=[0.1, 0])
    for now in (1.1, 1.2):
        bench.robot.advance(now, 0.1)
        bench.gate.beat(now)
    assert observed[-1].commanded[-2:] == pytest.approx((0.02, 0.0))
    assert observed[-1].measured[-2:] == pytest.approx((0.02, 0.0))
    bench.gate.rest()
    for now in (1.3, 1.4):
        bench.robot.advance(now, 0.1)
        bench.gate.beat(now)
    assert observed[-1].commanded[-2:] == pytest.approx((0.03, 0.0)), "until the rest was noticed"
    count = len(observed)
    bench.gate.beat(1.5)
    assert len(observed) == count, "no new reading"


def test_while_it_is_stopped_the_guardian_compares_nothing(bench, observed):
    bench.gate.halt("stopped")
    bench.robot.time = 2.0
    bench.gate.beat(2.0)
    assert observed == []


def test_a_dry_run_gives_the_guardian_nothing_to_compare():
    robot, guardian, seen = RecordingRobot(), Guardian(), []
    guardian.observe = seen.append
    gate = CommandGate(robot, Config(), guardian, dry_run=True)
    robot.time = 1.0
    gate.send(Command(np.array([0.1, 0])), 1.0)
    gate.beat(1.0)
    assert seen == [] and robot.moves == []


def test_a_stop_on_two_computers_is_released_on_both(bench):
    bench.gate.halt("stopped", "YARP")
    bench.gate.halt("stopped", "ROS 2")
    with pytest.raises(AccessDeniedError, match=r"move on ROS 2 and YARP, where it was stopped$"):
        bench.gate.release(pressed="the web")


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("end", ["low", "high"])
def test_a_head_near_its_limit_gets_there_and_no_further(bench, axis, end):
    limit, outwards = getattr(teo.HEAD, end)[axis], -1.0 if end == "low" else 1.0
    for distance, speed in ((0.002, 0.04), (0.0, 0.0), (-0.01, 0.0)):
        bench.robot.head[axis] = limit - outwards * distance
        bench.send(head=along(axis, outwards * 0.5, 2))
        assert bench.robot.velocity == pytest.approx(along(axis, outwards * speed, 2)), "within 50 ms"
        bench.send(head=along(axis, -outwards * 0.5, 2))
        assert bench.robot.velocity == pytest.approx(along(axis, -outwards * 0.5, 2)), "back it may"


def test_a_head_moves_although_its_place_is_unknown(bench):
    bench.robot.silent = True
    assert bench.send(head=[0.3, 0]) and bench.robot.velocity.tolist() == [0.3, 0.0]
    reading = RecordingRobot().state()
    bench.robot.state = lambda: dataclasses.replace(reading, hand=np.full((4, 4), np.nan), head=teo.HEAD.high)
    assert bench.send(head=[0.3, 0]) and bench.robot.velocity.tolist() == [0.3, 0.0]


def test_every_command_to_a_stopped_robot_counts_as_refused(bench):
    bench.gate.halt("stopped")
    for _ in range(3):
        assert not bench.send(head=[0.1, 0])
    bench.send()
    assert (bench.gate.refused, bench.gate.sent) == (3, 0)


def test_a_hand_that_is_held_back_is_counted_each_time_and_logged_once(caplog):
    robot = RecordingRobot(floating=True)
    gate = CommandGate(robot, Config(), Guardian())
    for now in (1.0, 1.02, 1.04):
        gate.send(Command(hand=np.array([0.02, 0, 0, 0, 0, 0])), now)
    assert gate.refused == 3 and caplog.text.count("the hand is held back") == 1
    gate.send(Command(np.array([0.1, 0])), 1.06)
    assert gate.hindrance == "" and gate.refused == 3
    gate.send(Command(hand=np.array([0.02, 0, 0, 0, 0, 0])), 1.08)
    assert caplog.text.count("the hand is held back") == 2, "again, after it was allowed"


def test_in_a_dry_run_nothing_moves_so_nothing_expires():
    robot = RecordingRobot()
    gate = CommandGate(robot, Config(), Guardian(), dry_run=True)
    assert gate.send(Command(np.array([0.1, 0])), 1.0) is False
    assert gate.expire(100.0) is False and robot.stops == 0


def test_the_guardian_compares_steps_of_the_head_and_the_joints_of_the_arm(monkeypatch):
    stepping, seen = Bench(Config(head=HeadConfig(mode="steps"))), []
    monkeypatch.setattr(stepping.guardian, "observe", seen.append)
    stepping.robot.time = 1.0
    stepping.send(1.0, head_step=[0.1, -0.05], hand=along(0, 0.02, 6))
    stepping.robot.advance(1.1, 0.1)
    stepping.gate.beat(1.1)
    assert seen[-1].commanded[-2:] == pytest.approx((0.1, -0.05))
    arm = np.array(seen[-1].commanded[:-2])
    moved = teo.RIGHT_ARM.forward(teo.HOME + arm)[:3, 3] - teo.RIGHT_ARM.forward(teo.HOME)[:3, 3]
    assert moved == pytest.approx([0.002, 0, 0], abs=1e-4), "0.02 m/s for 0.1 s"
    assert arm == pytest.approx(np.array(seen[-1].measured[:-2]), abs=1e-3)


def test_a_dry_run_stops_no_robot():
    robot = RecordingRobot()
    gate = CommandGate(robot, Config(), Guardian(), dry_run=True)
    gate.halt("stopped")
    assert (robot.stops, gate.halted, gate.hindrance, gate.paused) == (0, "stopped", "", "")
