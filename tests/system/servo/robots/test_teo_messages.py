"""TEO's messages against those of real control boards and Cartesian controllers, recorded."""

import threading
from pathlib import Path

import numpy as np
import pytest

from grabbergui.calibration import geometry
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.events import Message
from grabbergui.net.yarp.os.inputs import ConnectionInfo, Request
from grabbergui.net.yarp.os.values import Dialect, Vocab
from grabbergui.servo.robots import cartesian_messages, teo, teo_messages
from grabbergui.servo.robots.cartesian_messages import (
    NOT_CONTROLLING,
)
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.robots.teo_board import SimulatedBoard
from grabbergui.servo.robots.teo_messages import FAIL, OK
from grabbergui.servo.robots.teo_ports import SimulatedCartesian

DATA = Path(__file__).parents[3] / "data" / "yarp"


def recorded(name, letters):
    lines = [line.split() for line in (DATA / name).read_text().splitlines() if not line.startswith("#")]
    return [(letter, bytes.fromhex(data)) for letter, data in lines if letter in letters]


def shape(item):
    """Return the words of a message and the kinds of its numbers, which are the same in any place."""
    if isinstance(item, list):
        return [shape(part) for part in item]
    return item if isinstance(item, (Vocab, str)) else type(item)


def asked(data):
    return Request(Message("d", memoryview(data)), ConnectionInfo("/peer", "tcp", ("127.0.0.1", 1)))


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def robot(clock):
    return SimRobot(teo.MODEL, clock)


@pytest.fixture
def board(robot, names):
    return SimulatedBoard(robot, names, "/head")


@pytest.fixture
def cartesian(robot, names):
    return SimulatedCartesian(robot, names, "/arm")


def pass_time(clock, simulated, seconds):
    for _ in range(round(seconds / 0.01)):
        clock.now += 0.01
        simulated.step()


def conversation(name):
    """Requests with their answers, streamed commands with None, in their order."""
    said = recorded(name, "QAC")
    for number, (letter, data) in enumerate(said):
        if letter != "A":
            yield data, said[number + 1][1] if letter == "Q" else None


BOARDS = pytest.mark.parametrize(
    ("dialect", "file"),
    [(Dialect.YARP3, "control_board_312.txt"), (Dialect.YARP4, "control_board_40.txt")],
    ids=["3.12", "4.0"],
)


@BOARDS
def test_the_simulated_board_answers_a_real_client_as_the_real_one(names, robot, clock, dialect, file):
    board = SimulatedBoard(robot, names, "/head", dialect)
    for data, answer in conversation(file):
        if answer is None:
            board._command(asked(data))
        else:
            assert answer_shape(board.answer(asked(data)), data) == answer_shape(answer, data), data
        pass_time(clock, board, 0.5)
    if dialect is Dialect.YARP4:  # the last that was streamed were positions
        *_, (_, there) = recorded(file, "S")
        rests = teo_messages.read_encoders(Bottle.decode(there), 2)
        assert robot.state().head == pytest.approx(rests, abs=1e-4)


def answer_shape(answer, request):
    if b"getRemoteProtocolVersion" in request:
        return answer  # no Bottle
    read = answer if isinstance(answer, Bottle) else Bottle.decode(answer)
    if b"getDeviceInterfaces" in request:
        # A simulated head has fewer of them, and must know all.
        return [read[0], [name for name, _ in read[1]]]
    return shape(read)


def test_the_simulated_controller_answers_a_real_client_as_the_real_one(cartesian, robot, clock):
    poses = []
    for data, answer in conversation("cartesian_control_312.txt"):
        if answer is None:
            cartesian._command(asked(data))
            pass_time(clock, cartesian, 0.05)
            continue
        verb = str(Bottle.decode(data)[0])
        if verb == "wait":
            pass_time(clock, cartesian, 3.0)
            poses.append(robot.state().hand)
        ours, theirs = cartesian.answer(asked(data)), Bottle.decode(answer)
        if Bottle.decode(data)[-1] == Vocab("prms"):
            ours, theirs = ({str(key): value for key, value in pairs} for pairs in (ours, theirs))
            assert ours == theirs
        elif verb in ("gcmp", "forc", "tool"):
            assert ours == [FAIL]
        else:
            assert shape(ours) == shape(theirs), Bottle.decode(data)
        if verb == "inv":
            assert ours == pytest.approx(theirs, abs=0.01)
    there, raised, lowered = poses
    assert there == pytest.approx(teo.RIGHT_ARM.forward(teo.HOME), abs=1e-3)
    assert raised[2, 3] - there[2, 3] == pytest.approx(0.05, abs=1e-3)
    assert lowered[2, 3] - raised[2, 3] == pytest.approx(-0.02, abs=1e-3)


def request(simulated, text):
    return simulated.answer(asked(Bottle.from_text(text).encode()))[0]


def test_a_velocity_goes_on_until_another_command(board, robot, clock):
    assert request(board, "set icmd cmds (vel vel)") == OK
    board._command(asked(teo_messages.velocity_moves(np.radians([5.0, 0.0])).encode()))
    pass_time(clock, board, 2.0)
    assert np.degrees(robot.state().head) == pytest.approx([10.0, 0.0], abs=0.3)
    assert request(board, "set stos") == OK
    pass_time(clock, board, 1.0)
    assert robot.speed < 1e-6


def test_a_board_obeys_only_what_its_mode_is_for(board, robot, clock):
    board._command(asked(teo_messages.velocity_moves(np.radians([5.0, 0.0])).encode()))
    pass_time(clock, board, 0.5)
    assert not robot.state().head.any()
    request(board, "set icmd cmod 0 vel")
    assert request(board, "set rels (1.0 1.0)") == FAIL
    board._command(asked(teo_messages.velocity_moves(np.radians([5.0, 5.0])).encode()))
    pass_time(clock, board, 0.5)
    assert robot.state().head[0] > 0.02
    assert robot.state().head[1] == 0


@pytest.mark.parametrize(
    "text",
    (
        *("set pos 7 1.0", "set vel -1 1.0", "set rels (1.0)", "set icmd cmds (vel foo)", "get llim", "get"),
        *("set", "get llim 7", "dance", "set icmd", "get icmd cmod 2"),
    ),
)
def test_a_board_refuses_what_it_cannot_do(board, text):
    assert request(board, text) == FAIL


def test_twists_go_along_the_hands_axes_if_so_asked_and_until_a_stop(cartesian, robot, clock):
    assert request(cartesian, "set cpf cpft") == OK
    assert request(cartesian, "set cpsc twst") == OK
    before = robot.state().hand
    cartesian._command(asked(cartesian_messages.twist(np.array([0, 0, 0.02, 0, 0, 0])).encode()))
    pass_time(clock, cartesian, 1.0)
    moved = before[:3, :3].T @ (robot.state().hand[:3, 3] - before[:3, 3])
    assert moved == pytest.approx([0, 0, 0.02], abs=2e-3)
    assert request(cartesian, "stop") == OK
    pass_time(clock, cartesian, 0.5)
    rests = robot.state().hand
    cartesian._command(asked(cartesian_messages.twist(np.array([0, 0, 0.02, 0, 0, 0])).encode()))
    pass_time(clock, cartesian, 0.5)
    assert geometry.distance(robot.state().hand, rests) < 1e-6


def test_a_move_that_takes_longer_than_is_waited_for_is_stopped(cartesian, robot, clock):
    assert request(cartesian, "movv 0.0 0.0 0.01 0.0 0.0 0.0") == OK
    assert request(cartesian, "wait 0.05") == OK  # as the reference: only for moves that end
    assert request(cartesian, "relj 0.0 0.0 0.05 0.0 0.0 0.0") == OK
    assert request(cartesian, "stat") == Vocab("ccjc")
    assert request(cartesian, "wait 0.05") == FAIL
    assert request(cartesian, "stat") == NOT_CONTROLLING


def test_a_wait_may_be_longer_than_the_system_can_count(cartesian):
    assert request(cartesian, "relj 0.0 0.0 0.05 0.0 0.0 0.0") == OK
    threading.Timer(0.1, cartesian.stop).start()
    assert request(cartesian, "wait 1e300") == OK


@pytest.mark.parametrize(
    "text",
    (
        *("movl", "movl 1.0 2.0", "movl 9.0 0.0 0.0 0.0 0.0 0.0", "set cpsc wrnc", "set cpts 0.0"),
        *("set foo 1.0", "set prms", "set prms (cpcg)", "set", "get", "set cpcg many", "wait nan"),
    ),
)
def test_a_controller_refuses_what_it_cannot_do(cartesian, text):
    assert request(cartesian, text) == FAIL


def test_joint_velocities_hold_until_the_next_command(robot, names, clock):
    cartesian = SimulatedCartesian(robot, names, "/arm", kdl=True)
    cartesian.answer(asked(Bottle([Vocab("set"), Vocab("cpsc"), Vocab("twst")]).encode()))
    cartesian._command(asked(cartesian_messages.twist(np.array([0.0, 0.0, 0.05, 0, 0, 0])).encode()))
    pass_time(clock, cartesian, 0.5)
    before = robot.truth().arm
    pass_time(clock, cartesian, 0.5)
    middle = robot.truth().arm
    pass_time(clock, cartesian, 0.5)
    assert robot.truth().arm - middle == pytest.approx(middle - before, rel=1e-3)
    assert np.abs(middle - before).max() > 0.05
    assert cartesian.answer(asked(Bottle([Vocab("stop")]).encode())) == Bottle([OK])
    pass_time(clock, cartesian, 0.5)
    rests = robot.truth().arm
    pass_time(clock, cartesian, 0.3)
    assert robot.truth().arm == pytest.approx(rests, abs=1e-5)
