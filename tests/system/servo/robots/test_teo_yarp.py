"""TEO over YARP: messages, and both ends on a name server of our own."""

import threading
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grabbergui.calibration import camera_info, geometry
from grabbergui.calibration.marker_pose import MarkerDetection
from grabbergui.core.errors import (
    GrabberError,
    RemoteProtocolError,
    SourceNotFoundError,
    TransportError,
)
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.events import Message
from grabbergui.net.yarp.os.inputs import ConnectionInfo, Request
from grabbergui.net.yarp.os.ports import InputPort
from grabbergui.net.yarp.os.rpc_client import RpcClient
from grabbergui.net.yarp.os.values import Vocab
from grabbergui.servo import closed_loop
from grabbergui.servo.config import Config
from grabbergui.servo.detection import Sighting
from grabbergui.servo.robots import cartesian_messages, teo, teo_messages, teo_yarp
from grabbergui.servo.robots.cartesian_messages import (
    TWIST,
    announce,
    read_cartesian_command,
    read_status,
    status,
    stop_control,
)
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.robots.teo_board import SimulatedBoard
from grabbergui.servo.robots.teo_ports import SimulatedCartesian, TeoPorts
from grabbergui.servo.robots.teo_yarp import TeoOverYarp
from grabbergui.servo.yarp_publisher import YarpPublisher, markers_bottle
from patience import PATIENCE, attempts, until
from whole_chain import detecting_runner, reach_marker


def test_a_streamed_velocity_has_the_bytes_of_a_pair_of_lists():
    """A list of two: the vocab's list, then the doubles', each of one type; the layout of PortablePair."""
    wire = teo_messages.velocity_moves(np.radians([1.0, -2.0])).encode()
    assert wire.hex() == (
        "00010000" "02000000"
        "09010000" "01000000" "766d6f73"
        "0a010000" "02000000" "000000000000f03f" "00000000000000c0"
    )  # fmt: skip


@pytest.mark.parametrize(
    ("message", "text"),
    [
        (teo_messages.relative_moves(np.radians([2.0, 0.0])), "[set] [rels] (2.0 0.0)"),
        (teo_messages.control_modes(teo_messages.VELOCITY_MODE, 2), "[set] [icmd] [cmds] ([vel] [vel])"),
        (announce(TWIST), "[set] [cpsc] [twst]"),
        (stop_control(), "[stop]"),
        (cartesian_messages.twist(np.arange(6.0)), "[twst] 0.0 1.0 2.0 3.0 4.0 5.0"),
    ],
)
def test_requests_read_as_the_controllers_document_them(message, text):
    assert message.to_text() == text


def test_what_is_written_is_read():
    values = np.array([0.1, -0.2])
    through = Bottle.decode(teo_messages.velocity_moves(values).encode())
    assert teo_messages.read_board_command(through, 2).values == pytest.approx(values)
    assert teo_messages.read_encoders(teo_messages.encoders(values), 2) == pytest.approx(values)
    hand = geometry.pose_from_vector([0.3, -0.2, 0.4, 0.5, 1.0, -0.3])
    assert read_status(status(Vocab("ccnc"), hand, 1.5)) == pytest.approx(hand)
    assert read_status(status(Vocab("ccnc"), hand, 1.5)[:7]) == pytest.approx(hand)
    twist = read_cartesian_command(cartesian_messages.twist(np.arange(6.0)), "twst")
    assert twist.tolist() == list(range(6))


items = st.recursive(
    st.one_of(
        st.integers(-9, 9), st.floats(), st.text(max_size=4), st.just(Vocab("twst")), st.just(Vocab("vmos"))
    ),
    lambda inner: st.lists(inner, max_size=8),
    max_leaves=12,
)


@given(st.lists(items, max_size=9))
def test_no_message_does_worse_than_be_refused(content):
    for read in (
        read_status,
        lambda bottle: read_cartesian_command(bottle, "twst"),
        lambda bottle: teo_messages.read_encoders(bottle, 2),
        lambda bottle: getattr(teo_messages.read_board_command(bottle, 2), "values", None),
    ):
        try:
            result = read(Bottle(content))
        except RemoteProtocolError:
            continue
        assert result is None or np.isfinite(result).all()


@pytest.fixture
def simulated(names):
    robot = SimRobot(teo.MODEL)
    ports = TeoPorts(robot, names)
    ports.open()
    yield robot
    ports.close()


def test_whoever_only_listens_has_readings_and_no_connection_to_send_by(names, simulated):
    client = TeoOverYarp(names, listen_only=True)
    client.open()
    try:
        until(lambda: client.state() is not None)
        client.move_head(np.array([0.3, 0.0]))
        client.step_head(np.array([0.1, 0.0]))
        client.move_hand(np.array([0.05, 0, 0, 0, 0, 0]))
        assert client.stop()
        with pytest.raises(SourceNotFoundError):
            names.query("/grabbergui/servo/head/command:o")
        time.sleep(0.2)  # a while in which it might move
        assert simulated.speed == 0
    finally:
        client.close()


def test_readings_arrive_as_they_are(robot, simulated):
    truth, seen = simulated.state(), robot.state()
    assert seen.head == pytest.approx(truth.head, abs=1e-9)
    assert seen.hand == pytest.approx(truth.hand, abs=1e-9)
    until(lambda: robot.state().arm is not None)
    assert robot.state().arm == pytest.approx(truth.arm, abs=1e-9)
    assert len(robot.skeleton(robot.state())) == 2
    until(lambda: time.monotonic() - robot.state().time < 0.1)


def test_a_robot_that_does_not_report_arm_angles_is_accepted(names, simulated, monkeypatch):
    monkeypatch.setattr(teo_yarp, "ARM_BOARD", "/anotherArm")
    client = TeoOverYarp(names)
    client.open()
    try:
        until(lambda: client.state() is not None)
        assert client.state().arm is None
        assert len(client.skeleton(client.state())) == 1
    finally:
        client.close()


def test_head_and_hand_follow_commands_and_stop(robot, simulated):
    start = simulated.state().hand

    def moved():
        robot.move_head(np.array([0.3, 0.0]))
        robot.move_hand(np.array([0.05, 0, 0, 0, 0, 0]))
        return robot.state().head[0] > 0.05 and robot.state().hand[0, 3] > start[0, 3] + 0.01

    for watch in attempts(1.0):
        until(moved)
        with watch:
            robot.stop()
            until(lambda: simulated.speed < 1e-3)
    # After a stop the stream has to be announced again, and is.
    until(lambda: robot.move_hand(np.array([0, 0, 0.05, 0, 0, 0])) or simulated.speed > 0.02)


def test_steps_go_by_request(robot, simulated):
    robot.step_head(np.radians([2.0, -2.0]))
    until(lambda: np.allclose(np.degrees(robot.state().head), [2, -2], atol=0.05))


def test_a_controller_that_was_left_obeying_the_hands_axes_obeys_the_bases(names, robot, simulated):
    other = RpcClient("/teoSim/rightArm/CartesianControl/rpc:s", names)
    try:
        assert other.call(Bottle.from_text("set cpf cpft")) == [teo_messages.OK]
        start = simulated.state().hand
        until(
            lambda: (
                robot.move_hand(np.array([0, 0, 0.05, 0, 0, 0]))
                or simulated.state().hand[2, 3] > start[2, 3] + 0.02
            )
        )
        assert np.abs(simulated.state().hand[:2, 3] - start[:2, 3]).max() < 0.01
        assert other.call(Bottle.from_text("get cpf"))[0] == Vocab("cpfb")
    finally:
        other.close()


def test_a_command_during_which_a_stop_came_is_not_sent(robot, simulated, monkeypatch):
    """A board that is long in changing its mode must not get the velocity of long ago after the stop."""
    ask = robot._ask

    def ask_and_be_stopped(client, request, timeout=1.0):
        ask(client, request, timeout)
        monkeypatch.undo()
        robot.stop()

    for command in (
        lambda: robot.move_head(np.array([0.3, 0.0])),
        lambda: robot.move_hand(np.array([0.05, 0, 0, 0, 0, 0])),
    ):
        monkeypatch.setattr(robot, "_ask", ask_and_be_stopped)
        with pytest.raises(TransportError, match="stopped before the command was sent"):
            command()
    assert not simulated._head_velocity.any()
    assert not simulated._twist.any()


def test_a_stop_does_not_wait_for_an_answer_to_something_else(robot, simulated, monkeypatch):
    """The arm's drives are long in changing their mode, while the head moves."""
    changing, let_go, heard = threading.Event(), threading.Event(), []
    set_one, obey = SimulatedCartesian._set, SimulatedBoard._obey

    def slow(self, what, value):
        changing.set()
        let_go.wait(PATIENCE)
        return set_one(self, what, value)

    def move_hand():
        with suppress(GrabberError):
            robot.move_hand(np.full(6, 0.01))

    monkeypatch.setattr(SimulatedBoard, "_obey", lambda *args: heard.append(args[1]) or obey(*args))
    robot.move_head(np.array([0.3, 0.0]))
    monkeypatch.setattr(SimulatedCartesian, "_set", slow)
    moving = threading.Thread(target=move_hand)
    moving.start()
    try:
        assert changing.wait(PATIENCE)
        robot.stop()
        until(lambda: heard == ["icmd", "stos"])
    finally:
        let_go.set()
        moving.join()


def test_a_robot_whose_board_is_gone_takes_no_velocities(robot, names, simulated):
    robot.move_head(np.zeros(2))
    robot._head_commands.remove_output("/teoSim/head/command:i")
    with pytest.raises(TransportError, match="no longer connected"):
        robot.move_head(np.array([0.1, 0.0]))


def test_a_robot_that_is_gone_is_noticed_and_a_stop_does_not_hang(names, caplog):
    ports = TeoPorts(SimRobot(teo.MODEL), names)
    ports.open()
    client = TeoOverYarp(names)
    client.open()
    until(lambda: client.state() is not None)
    assert client.silence() == ""
    ports.close()
    until(lambda: time.monotonic() - client.state().time > 0.2)
    until(lambda: "start the program again once the robot is back" in client.silence())
    for watch in attempts(2.0):
        with watch:
            client.stop()
    client.stop()
    unconfirmed = [record for record in caplog.records if "did not confirm the stop" in record.getMessage()]
    assert [record.levelname for record in unconfirmed].count("ERROR") == 2, "one for each controller"
    with pytest.raises(GrabberError):
        client.step_head(np.radians([2.0, 0.0]))
    client.close()


def test_readings_that_cannot_be_understood_do_not_fill_the_log(caplog):
    readings = {}
    port = teo_yarp._ReadingPort(
        "/x", None, "head", readings, lambda bottle: teo_messages.read_encoders(bottle, 2)
    )

    def arrive(*angles):
        message = Message("D", memoryview(Bottle(angles).encode()))
        port.deliver(Request(message, ConnectionInfo("/robot", "tcp", ("127.0.0.1", 1))))

    for angle in range(5):  # of a head with three joints
        arrive(float(angle), 0.0, 0.0)
    assert len(caplog.records) == 1 and not readings
    arrive(1.0, 2.0)
    arrive(1.0, 2.0, 3.0)
    assert len(caplog.records) == 2


def test_a_missing_robot_is_reported(names):
    client = TeoOverYarp(names, "/nobody")
    with pytest.raises(SourceNotFoundError, match="/nobody/head"):
        client.open()


@pytest.mark.parametrize("text", ["stat", "help me", "set cpsc pose", "()", "set rels (1 nan)"])
def test_the_ports_answer_whatever_is_asked(names, simulated, text):
    for port in ("/teoSim/head/rpc:i", "/teoSim/rightArm/CartesianControl/rpc:s"):
        client = RpcClient(port, names)
        try:
            assert client.call(Bottle.from_text(text))
        finally:
            client.close()


def test_the_whole_chain_reaches_the_marker_over_yarp(robot, simulated, patient):
    camera = closed_loop.mounted_camera(simulated, closed_loop.things_for(Config().marker), fps=10)
    camera.open()
    try:
        metres, degrees = reach_marker(detecting_runner(camera, robot, patient), simulated)
    finally:
        camera.close()
    assert metres < 0.010
    assert degrees < 2


def test_what_happens_is_published_and_anybody_can_stop_it(names, robot, simulated, patient):
    camera = closed_loop.mounted_camera(simulated, closed_loop.things_for(Config().marker), fps=10)
    camera.open()
    runner = detecting_runner(camera, robot, patient)
    publisher = YarpPublisher(runner, names, "/servo")
    reader, caller = InputPort("/reader", names, depth=50), RpcClient("/servo/rpc:s", names)
    try:
        publisher.open()
        reader.open()
        assert caller.call(Bottle(["state"]))[0] == Vocab("fail")
        runner.start()
        reader.connect("/servo/markers:o")
        marker = dict(Bottle.decode(reader.read(PATIENCE)[0])[0])
        assert marker["id"] == 20
        assert marker["z"] == pytest.approx(0.75, abs=0.3)
        until(lambda: simulated.speed > 0.02)
        assert caller.call(Bottle(["stop"])) == [Vocab("ok")]
        until(lambda: simulated.speed < 1e-3)
        for _ in range(3):
            assert caller.call(Bottle(["stop"])) == [Vocab("ok")]
            assert caller.call(Bottle(["state"]))[0] == "stopped"
            assert caller.call(Bottle(["resume"])) == [Vocab("ok")]
            assert caller.call(Bottle(["state"]))[0] != "stopped"
        until(lambda: simulated.speed > 0.01)
        assert caller.call(Bottle(["dance"]))[0] == Vocab("fail")
    finally:
        caller.close()
        runner.stop()
        publisher.close()
        reader.close()
        camera.close()


def test_a_marker_without_a_pose_is_published_with_the_reason():
    square = np.zeros((4, 2))
    sighting = Sighting(0.0, (MarkerDetection(7, square, None, "two poses explain it"),))
    assert markers_bottle(sighting) == [[["id", 7], ["problem", "two poses explain it"]]]


def test_the_shipped_calibration_is_that_of_the_simulated_camera():
    shipped = camera_info.load(Path(__file__).parents[4] / "resources/servo/teo-sim-camera.yaml")
    assert np.array_equal(shipped.matrix, closed_loop.calibration().matrix)
    assert (shipped.width, shipped.height) == (closed_loop.WIDTH, closed_loop.HEIGHT)
