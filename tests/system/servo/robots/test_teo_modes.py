"""TEO moved in each mode: control boards of YARP 3.x and 4.0, Cartesian controllers of both versions."""

import time

import numpy as np
import pytest

from grabbergui.calibration import geometry
from grabbergui.core.errors import AckTimeoutError
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.rpc_client import RpcClient
from grabbergui.net.yarp.os.values import Dialect, Vocab
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.leading_target import HAND_SLACK, HEAD_SLACK
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.robots.teo_ports import TeoPorts
from grabbergui.servo.robots.teo_yarp import TeoOverYarp
from patience import until
from yarp_bytes import reply_to

LEAD = 0.1
"Seconds that positions are ahead."


@pytest.fixture
def simulated(names, request):
    dialect, pose_word = getattr(request, "param", (Dialect.YARP3, "pose"))
    robot = SimRobot(teo.MODEL)
    ports = TeoPorts(robot, names, dialect=dialect, pose_word=Vocab(pose_word))
    ports.open()
    yield robot
    ports.close()


KINDS = pytest.mark.parametrize(
    "simulated",
    [(Dialect.YARP3, "movi"), (Dialect.YARP4, "pose")],
    indirect=True,
    ids=["3.x movi", "4.0 pose"],
)


def taken(move, *values):
    """Whether the robot has taken a command: on a busy machine it may answer after the second that it has."""
    try:
        move(*values)
    except AckTimeoutError:
        return False
    return True


@KINDS
def test_head_and_hand_move_by_velocities_and_stop(robot, simulated):
    start = simulated.state()
    until(lambda: taken(robot.move_head, np.array([0.3, 0.0])) and robot.state().head[0] > 0.05)
    up = np.array([0, 0, 0.05, 0, 0, 0])
    until(lambda: taken(robot.move_hand, up) and robot.state().hand[2, 3] > start.hand[2, 3] + 0.01)
    assert robot.stop()
    until(lambda: simulated.speed < 1e-3)


@KINDS
def test_the_head_moves_by_requested_steps(robot, simulated):
    robot.step_head(np.radians([2.0, -2.0]))
    until(lambda: np.allclose(np.degrees(robot.state().head), [2, -2], atol=0.05))


@KINDS
def test_parts_moved_by_short_positions_rest_when_nobody_says_more(robot, simulated):
    """Nothing stops it here: neither gate nor guardian, nor a time-out of the simulated drives."""
    simulated.COMMAND_TIMEOUT = 1e9
    start = robot.state()
    turning, forward = np.array([0.3, 0.0]), np.array([0.05, 0, 0, 0, 0, 0])

    def moved():
        robot.lead_head(turning, LEAD)
        robot.lead_hand(forward, LEAD)
        time.sleep(0.02)
        state = robot.state()
        return state.head[0] > 0.1 and state.hand[0, 3] > start.hand[0, 3] + 0.02

    until(moved)
    last = robot.state()
    until(lambda: simulated.speed < 1e-3)
    rests = simulated.state()
    # As far ahead as it may be, and what it moved on while its last reading was on the way.
    assert rests.head[0] - last.head[0] < 2 * 0.3 * LEAD + HEAD_SLACK
    assert geometry.distance(rests.hand, last.hand) < 2 * 0.05 * LEAD + HAND_SLACK[0]
    assert np.abs((rests.hand - start.hand)[1:3, 3]).max() < 0.003
    assert robot.stop()


def test_the_word_before_may_2024_is_tried_first(names):
    """Until 2023 there was another `pose`, which took its first number for an interval."""
    heard = []

    class Controller:
        def answer(self, request):
            text = request.bottle().to_text()
            heard.append(text)
            return Bottle([Vocab("fail" if text.endswith("[movi]") else "ok")])

    robot = TeoOverYarp(names)
    controller = Controller()
    robot._arm_rpc.call = lambda request, timeout: controller.answer(asked(request))
    assert robot._announce(robot._pose_words, 0) == Vocab("pose")
    assert heard == ["[set] [cpf] [cpfb]", "[set] [cpsc] [movi]", "[set] [cpsc] [pose]"]


def asked(data):
    class Asked:
        def bottle(self):
            return Bottle.decode(data)

    return Asked()


REPLIES = {
    "getAxesRPC": "([ok]) 2",
    "getAxisNameRPC 1": "([ok]) FrontalNeck",
    "getEncoderAllRPC": "([ok]) (0.0 0.0)",
    "checkMotionDoneAllRPC": "([ok]) [ok]",
    "positionMoveAllRPC (1.0 1.0)": "[ok]",
    "setControlModeOneRPC 0 7103862": "[ok]",
    "relativeMoveOneRPC 0 1.0": "[err5]",
    "relativeMoveAllRPC (1.0 1.0)": "[err5]",
    "relativeMoveAllRPC (1.0)": "[err5]",
    "get axes": "[fail]",
    "danceRPC": "[fail]",
}


@pytest.mark.parametrize("simulated", [(Dialect.YARP4, "pose")], indirect=True, ids=["4.0"])
def test_a_board_of_4_answers_requests_for_its_methods(names, simulated):
    with RpcClient("/teoSim/head/nws/rpc:i", names) as client:
        client.dialect = Dialect.YARP4
        for request, reply in REPLIES.items():
            sent = Bottle.from_text(request, Dialect.YARP4).encode(Dialect.YARP4)
            assert client.call(sent).to_text() == reply, request
        request = Bottle(["getRemoteProtocolVersion"]).encode()
        version = reply_to(names.query("/teoSim/head/nws/rpc:i").address, request)
        assert version.hex() == "00010000" "01000000" "0000" "0400" "0000" "0000"  # fmt: skip
