"""The gate stops the robot: bad commands, the stop button, silence, a robot that takes long or is deaf."""

import math
import threading

import numpy as np
import pytest

from grabbergui.core.errors import TransportError
from grabbergui.servo.config import Config
from grabbergui.servo.gate import Command, CommandGate
from grabbergui.servo.guardian_link import ALLOWED, Guard, Verdict
from patience import PATIENCE, until
from robots_for_tests import RecordingRobot


def fast(**parts):
    """Return a command that moves head and hand, with other parts as given."""
    command = {"head": np.array([0.1, 0.0]), "hand": np.array([0.02, 0, 0, 0, 0, 0.1])}
    return Command(**(command | parts))


@pytest.mark.parametrize(
    "command",
    [
        fast(head=np.array([math.nan, 0])),
        fast(hand=np.array([0, 0, math.inf, 0, 0, 0])),
        fast(head_step=np.array([math.nan, 0])),
    ],
    ids=["nan head", "inf hand", "nan step"],
)
def test_the_gate_lets_no_bad_command_through_and_stops_what_moves(command):
    robot = RecordingRobot()
    gate = CommandGate(robot, Config())
    assert gate.send(fast(), 0.0)
    robot.moves.clear()
    assert not gate.send(command, 0.02)
    assert robot.moves == []
    assert not robot.moving
    assert gate.refused == 1


def test_an_emergency_stop_goes_through_and_holds():
    robot = RecordingRobot()
    gate = CommandGate(robot, Config())
    gate.halt("pressed at rest")
    assert robot.stops >= 1
    assert not gate.send(fast(), 0.0)
    assert robot.moves == []
    gate.release()
    assert gate.send(fast(), 0.1)
    gate.halt("pressed in motion")
    assert not robot.moving


def test_a_stop_is_not_held_up_by_a_command_that_hangs():
    robot = RecordingRobot()
    entered, leave = threading.Event(), threading.Event()

    def hang(twist):
        entered.set()
        leave.wait(PATIENCE)

    robot.move_hand = hang
    gate = CommandGate(robot, Config())
    sender = threading.Thread(target=gate.send, args=(fast(), 0.0))
    sender.start()
    assert entered.wait(PATIENCE)
    stopper = threading.Thread(target=gate.halt, args=("pressed",))
    before = robot.stops
    stopper.start()
    until(lambda: robot.stops > before)
    leave.set()
    sender.join(PATIENCE)
    stopper.join(PATIENCE)
    assert not robot.moving


def test_a_command_that_reaches_the_robot_after_a_stop_is_stopped_too():
    """A stop does not wait for a command that is being sent, so it is said again once that is through."""
    robot = RecordingRobot()
    entered, leave, move_hand = threading.Event(), threading.Event(), robot.move_hand

    def late(twist):
        entered.set()
        leave.wait(PATIENCE)
        move_hand(twist)

    robot.move_hand = late
    gate = CommandGate(robot, Config())
    sender = threading.Thread(target=gate.send, args=(fast(), 0.0))
    stopper = threading.Thread(target=gate.halt, args=("pressed",))
    sender.start()
    assert entered.wait(PATIENCE)
    stopper.start()
    until(lambda: robot.stops)
    leave.set()
    sender.join(PATIENCE)
    stopper.join(PATIENCE)
    assert robot.moves
    assert not robot.moving


def test_the_watchdog_stops_a_robot_that_hears_nothing_more():
    robot = RecordingRobot()
    gate = CommandGate(robot, Config())
    gate.send(fast(), 1.0)
    assert not gate.expire(1.1)
    assert robot.moving
    assert gate.expire(1.16)
    assert not robot.moving
    assert not gate.expire(2.0)


def test_a_robot_that_accepts_no_commands_is_stopped():
    robot = RecordingRobot()
    gate = CommandGate(robot, Config())
    robot.deaf = True
    assert not gate.send(fast(), 0.0)
    assert robot.stops == 1


def test_a_rest_that_the_robot_cannot_be_given_is_the_guardians_too():
    class Asked(Guard):
        stops = 0

        def stop(self):
            self.stops += 1

    robot, guard = RecordingRobot(), Asked()
    gate = CommandGate(robot, Config(), guard)
    assert gate.send(fast(), 0.0)
    gate.rest()
    assert guard.stops == 0
    assert gate.send(fast(), 0.1)
    robot.deaf = True
    gate.rest()
    assert robot.moving
    assert guard.stops == 1


def test_no_hand_moves_after_a_stop_that_came_while_the_head_took_its_part():
    robot = RecordingRobot()
    gate = CommandGate(robot, Config())
    robot.move_head = lambda velocity: gate.halt("the button")
    assert not gate.send(Command(hand=np.full(6, 0.01)), 1.0)
    assert robot.moves == []
    assert gate.refused == 1


def test_a_robot_that_takes_long_over_its_first_command_is_stopped_meanwhile():
    """As where the drives must change their mode first: by then the image is too old."""
    robot = RecordingRobot()
    gate = CommandGate(robot, Config())
    robot.move_head = lambda velocity: gate.expire(1.3)
    assert not gate.send(Command(head=np.array([0.1, 0.0]), hand=np.full(6, 0.01)), 1.0)
    assert robot.stops == 1
    assert robot.moves == []


def test_a_command_that_a_stop_overtook_is_no_error(caplog):
    robot = RecordingRobot()
    gate = CommandGate(robot, Config())

    def refuse(velocity):
        gate.expire(1.3)
        raise TransportError("the robot was stopped before the command was sent")

    robot.move_head = refuse

    assert not gate.send(Command(head=np.array([0.1, 0])), 1.0)
    assert not [record for record in caplog.records if record.levelname == "ERROR"]
    assert robot.stops


class Dying(Guard):
    """A guardian that ends on request."""

    verdict = ALLOWED

    def beat(self, moving):
        return self.verdict


def bad_command(gate, robot, guard):
    gate.send(fast(head=np.array([math.nan, 0])), 0.02)


def refusal(gate, robot, guard):
    def refuse(velocity):
        raise TransportError("its port is gone")

    robot.move_head = refuse
    gate.send(fast(), 0.02)


def guardian_that_ends(gate, robot, guard):
    guard.verdict = Verdict("the guardian has ended", for_good=True)
    gate.beat(0.0)


@pytest.mark.parametrize("fault", [bad_command, refusal, guardian_that_ends])
def test_the_robot_is_stopped_before_the_log_says_why(fault, caplog):
    """A terminal in which Ctrl-S was pressed takes no text: the stop waited for it."""
    robot, guard = RecordingRobot(), Dying()
    gate = CommandGate(robot, Config(), guard)
    assert gate.send(fast(), 0.0)
    moving = []
    caplog.handler.addFilter(lambda record: moving.append(robot.moving) or True)
    fault(gate, robot, guard)
    assert moving == [False]


def test_the_watchdog_looks_after_the_robot_while_it_is_wanted():
    robot, left = RecordingRobot(), iter([True, True, False])
    gate = CommandGate(robot, Config())
    gate.send(fast(), 1.0)
    times = iter([1.1, 1.16])
    watchdog = threading.Thread(target=gate.watch, args=(lambda: next(left), lambda: next(times)))
    watchdog.start()
    watchdog.join(PATIENCE)
    assert not robot.moving
