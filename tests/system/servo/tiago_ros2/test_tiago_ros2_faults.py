"""TIAGo over ROS 2 with real rclpy: what goes wrong between both ends."""

import collections
import math
import time
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
pytest.importorskip("grabber_interfaces", reason="the interface package is not built: make setup-ros2")
pytest.importorskip("trajectory_msgs", reason="ros-trajectory-msgs is not installed: make setup-ros2")
pytest.importorskip("pinocchio", reason="Pinocchio is not installed: pip install '.[servo]'")
pytest.importorskip("example_robot_data", reason="no robot data: pip install '.[servo]'")
pytestmark = pytest.mark.ros2

from geometry_msgs.msg import TwistStamped  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from trajectory_msgs.msg import JointTrajectory  # noqa: E402

from grabbergui import sources  # noqa: E402
from grabbergui.core.errors import (  # noqa: E402
    SourceNotFoundError,
    SourceUnavailableError,
    TransportError,
)
from grabbergui.net.ros2 import runtime  # noqa: E402
from grabbergui.net.ros2.runtime import Ros2Node  # noqa: E402
from grabbergui.net.ros2.server import Ros2GrabberServer  # noqa: E402
from grabbergui.servo import closed_loop  # noqa: E402
from grabbergui.servo.config import Config, SafetyConfig  # noqa: E402
from grabbergui.servo.guardian_link import LocalGuard  # noqa: E402
from grabbergui.servo.own_motion import OwnMotionWatch  # noqa: E402
from grabbergui.servo.robots import tiago  # noqa: E402
from grabbergui.servo.robots.tiago_nodes import NODE  # noqa: E402
from grabbergui.servo.robots.tiago_ros2 import TiagoOverRos2  # noqa: E402
from grabbergui.servo.state_machine import State  # noqa: E402
from patience import PATIENCE, attempts, until  # noqa: E402
from ros2_patience import be_patient  # noqa: E402
from whole_chain import detecting_runner  # noqa: E402


def approaching(runner, simulated):
    machine = runner.loop.machine
    runner.start()
    until(
        lambda: (
            machine.state is State.STOPPED
            or (machine.state is State.APPROACHING and simulated.robot.speed > 0.02)
        )
    )
    assert machine.state is State.APPROACHING, machine.reason


def at_rest(twists):
    """Whether the newest command heard by now, perhaps later than by the robot, is to rest."""
    newest = [twists.get() for _ in range(twists.qsize())][-1:]
    return [(t.linear.x, t.linear.y, t.linear.z, t.angular.x) for t in (each.twist for each in newest)] == [
        (0, 0, 0, 0)
    ]


def test_joint_states_that_cease_end_all_motion(runner, simulated, listener):
    twists = listener.hear(TwistStamped, "/servo_node/delta_twist_cmds")
    approaching(runner, simulated)
    until(twists.qsize)
    simulated.silent = True
    until(lambda: runner.loop.machine.state is State.LOST)
    until(lambda: simulated.robot.speed < 1e-3)
    sent = runner.gate.sent
    time.sleep(0.3)  # a while in which no command may follow
    assert runner.gate.sent == sent
    last = [twists.get() for _ in range(twists.qsize())][-1].twist
    assert (last.linear.x, last.linear.y, last.linear.z, last.angular.x) == (0, 0, 0, 0)
    simulated.silent = False
    until(lambda: simulated.robot.speed > 0.01)


def test_joint_states_that_stand_still_stop_it_for_good(runner, simulated, listener):
    twists = listener.hear(TwistStamped, "/servo_node/delta_twist_cmds")
    approaching(runner, simulated)
    # A robot's own limit: only to get here a busy machine may have needed a wider one.
    runner.gate._guard = LocalGuard(SafetyConfig().lag)
    simulated.frozen = True
    until(lambda: runner.loop.machine.state is State.STOPPED)
    assert "does not move as commanded" in runner.loop.machine.reason
    until(lambda: simulated.robot.speed < 1e-3)
    until(lambda: at_rest(twists), "a last command to rest")


def test_images_over_ros_that_cease_end_all_motion(robot, simulated, config, monkeypatch):
    be_patient(monkeypatch)
    # To see the head nod takes eight images a second, which a busy machine may not have.
    monkeypatch.setattr(OwnMotionWatch, "shown", property(lambda _: True, lambda *_: None), raising=False)
    others = ("robot_timeout", "command_timeout", "freeze", "stuck")  # may not be the first to stop it
    limits = replace(config.safety, **dict.fromkeys(others, PATIENCE))
    object.__setattr__(config, "safety", limits)
    camera = closed_loop.mounted_camera(simulated.robot, closed_loop.things_for(Config().marker))
    camera.open()
    server = Ros2GrabberServer(camera, "/camera")
    server.start()
    images = sources.create("ros2:/camera")
    runner = detecting_runner(images, robot, config)
    cycles = []
    runner.cycle_done.connect(lambda cycle, frame: cycles.append(cycle))
    try:
        images.open()
        approaching(runner, simulated)
        server.stop()
        until(lambda: cycles[-1].state is State.LOST and "no fresh image" in cycles[-1].reason)
        until(lambda: cycles[-1].time - last_moving(cycles).time > 0.3)
        assert last_moving(cycles).time - runner.loop.sighting.captured <= config.safety.image_timeout
        until(lambda: simulated.robot.speed < 1e-3)
    finally:
        runner.stop()
        images.close()
        server.stop()
        camera.close()


def last_moving(cycles):
    return next(cycle for cycle in reversed(cycles) if cycle.command.moves)


def test_a_stop_goes_out_though_the_robot_says_nothing(robot, simulated, listener):
    twists = listener.hear(TwistStamped, "/servo_node/delta_twist_cmds")
    heads = listener.hear(JointTrajectory, "/head_controller/joint_trajectory")
    simulated.silent = True
    until(lambda: time.monotonic() - robot.state().time > 0.3)
    until(lambda: robot.stop() or (twists.qsize() and heads.qsize()))


def test_a_head_of_which_old_news_is_known_is_not_turned_back(robot, simulated):
    """A command to hold keeps the last commanded place, not the one at which readings ended."""
    robot.move_head(np.array([0.0, 0.0]))
    simulated.silent = True
    robot.step_head(np.radians([8.0, 0.0]))
    until(lambda: simulated.robot.state().head[0] > np.radians(7.5))
    until(lambda: time.monotonic() - robot.state().time > 0.3)
    robot.stop()
    time.sleep(0.3)  # a while in which it might cycle back
    assert np.degrees(simulated.robot.state().head[0]) == pytest.approx(8, abs=0.6)


def test_a_robot_that_is_gone_takes_no_command_and_a_stop_does_not_hang(robot, simulated):
    simulated.close()

    def refused():
        try:
            robot.move_hand(np.zeros(6))
        except TransportError as error:
            return "no controller subscribes to /servo_node/delta_twist_cmds" in str(error)
        return False

    until(refused)
    with pytest.raises(TransportError, match="/head_controller/joint_trajectory"):
        robot.move_head(np.array([0.1, 0.0]))
    for watch in attempts(1.0):
        with watch:
            robot.stop()


@pytest.fixture
def second(model):
    """Another program's client."""
    client = TiagoOverRos2(model)
    yield client
    client.close()


def test_a_second_program_is_refused_as_the_stop_of_one_would_not_stop_the_other(robot, second, model):
    until(lambda: refused(second))
    watching = TiagoOverRos2(model, listen_only=True)
    watching.open()
    watching.close()
    robot.close()
    until(lambda: opened(second))


def test_a_second_program_whose_name_has_not_arrived_is_waited_for(robot, second, monkeypatch):
    """DDS lists a publisher before its node's name, as it often does with a robot that answers at once."""
    from rclpy.node import Node

    listed, unnamed = Node.get_publishers_info_by_topic, collections.Counter()

    def unnamed_at_first(node, topic):
        infos = listed(node, topic)
        unnamed[node] += bool(infos)
        for info in infos if unnamed[node] <= 6 else ():
            info.node_name = "_NODE_NAME_UNKNOWN_"
        return infos

    monkeypatch.setattr(runtime, "DISCOVERY_S", 4.0)
    monkeypatch.setattr(Node, "get_publishers_info_by_topic", unnamed_at_first)
    until(lambda: refused(second))


@pytest.mark.parametrize("simulated_clock", [False, True])
def test_a_second_program_that_is_discovered_late_ends_the_commands(robot, simulated, simulated_clock):
    robot._ros.node.set_parameters([Parameter("use_sim_time", value=simulated_clock)])
    other = Ros2Node(f"{NODE}late")
    other.node.create_publisher(JointTrajectory, "/head_controller/joint_trajectory", 1)
    other.start()
    try:
        until(lambda: told_to_end_one(robot))
        assert robot.stop()
    finally:
        other.close()
    until(lambda: not told_to_end_one(robot))


def refused(robot):
    """Whether it is refused; a program that DDS has not discovered yet is found by a later try."""
    try:
        robot.open()
    except SourceUnavailableError as error:
        return "another servo program, node grabbergui_servo_" in str(error) and "end it" in str(error)
    robot.close()
    return False


def told_to_end_one(robot):
    try:
        robot.move_head(np.zeros(2))
    except TransportError as error:
        return "grabbergui_servo_late, commands TIAGo, too: end one" in str(error)
    return False


def opened(robot):
    with suppress(SourceUnavailableError):
        robot.open()
        return True


def test_a_missing_robot_is_reported(domain, model):
    with pytest.raises(SourceNotFoundError, match="no node publishes TIAGo's joints on /joint_states"):
        TiagoOverRos2(model, timeout=0.3).open()


@pytest.mark.parametrize(
    ("joints", "complaint"),
    [
        ((*tiago.HEAD_JOINTS, *tiago.ARM_JOINTS[:-1]), "does not contain arm_7_joint"),
        ((*tiago.HEAD_JOINTS, *tiago.ARM_JOINTS), "no controller subscribes to"),
    ],
)
def test_an_incomplete_robot_is_reported(listener, model, joints, complaint):
    states = listener.node.create_publisher(JointState, "/joint_states", 5)
    message = JointState(name=list(joints), position=[0.1] * len(joints))
    listener.node.create_timer(0.02, lambda: states.publish(message))

    def complained():
        with pytest.raises(SourceNotFoundError) as refused:
            TiagoOverRos2(model, timeout=1.5).open()
        return complaint in str(refused.value)

    until(complained)


def test_readings_that_are_no_numbers_are_not_believed(robot, simulated, listener):
    states = listener.node.create_publisher(JointState, "/joint_states", 5)
    simulated.silent = True
    names = [*tiago.HEAD_JOINTS, *tiago.ARM_JOINTS]
    until(lambda: states.get_subscription_count())
    before = robot.state()

    def changed():
        for positions in ([math.nan] * 9, [0.1] * 8, [math.inf] * 9, [0.05] * 9):
            states.publish(JointState(name=names, position=positions))
        return robot.state() is not before

    until(changed)
    assert np.isfinite(robot.state().hand).all()


def test_commands_before_it_is_open_are_refused(model):
    robot = TiagoOverRos2(model)
    for command in (lambda: robot.move_head(np.zeros(2)), lambda: robot.move_hand(np.zeros(6))):
        with pytest.raises(TransportError):
            command()
    robot.stop()
    robot.close()
