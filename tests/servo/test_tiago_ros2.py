"""TIAGo over ROS 2 with real rclpy: both ends, what goes wrong between them, and what others see."""

import itertools
import json
import math
import queue
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
pytest.importorskip("grabber_interfaces", reason="the interface package is not built: make setup-ros2")
pytest.importorskip("trajectory_msgs", reason="ros-trajectory-msgs is not installed: make setup-ros2")
pytest.importorskip("pinocchio", reason="Pinocchio is not installed: pip install '.[servo]'")
pytest.importorskip("example_robot_data", reason="no robot data: pip install '.[servo]'")
pytestmark = pytest.mark.ros2

from geometry_msgs.msg import PoseStamped, TwistStamped  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from test_closed_loop import options  # noqa: E402
from trajectory_msgs.msg import JointTrajectory  # noqa: E402

from grabbergui import sources  # noqa: E402
from grabbergui.calibration import geometry  # noqa: E402
from grabbergui.core.errors import SourceNotFoundError, TransportError, UsageError  # noqa: E402
from grabbergui.driver.sim.rendered.scene import Things, board_pose  # noqa: E402
from grabbergui.net.ros2.camera_info import receive_camera_info  # noqa: E402
from grabbergui.net.ros2.runtime import Ros2Node  # noqa: E402
from grabbergui.net.ros2.server import Ros2GrabberServer  # noqa: E402
from grabbergui.servo import closed_loop  # noqa: E402
from grabbergui.servo.config import Config  # noqa: E402
from grabbergui.servo.publisher_ros2 import Ros2Publisher  # noqa: E402
from grabbergui.servo.robots import tiago  # noqa: E402
from grabbergui.servo.robots.simulated import SimRobot  # noqa: E402
from grabbergui.servo.robots.tiago_ros2 import TiagoOverRos2  # noqa: E402
from grabbergui.servo.robots.tiago_topics import TiagoTopics  # noqa: E402
from grabbergui.servo.runner import Runner  # noqa: E402
from grabbergui.servo.state_machine import State  # noqa: E402
from patience import PATIENCE, PROGRAM, attempts, until  # noqa: E402


class Faulty(TiagoTopics):
    """Controllers whose joint states cease, or stand still, when told to."""

    def __init__(self, robot):
        super().__init__(robot)
        self.robot = robot
        self.silent = self.frozen = False
        self.joint_states = 0

    def _tell(self):
        if self.frozen:
            last = self._robot.state() if self._robot is self.robot else None
            if last is not None:
                self._robot = Still(self.robot, last)
        if not self.silent:
            self.joint_states += 1
            super()._tell()


class Still:
    """A robot whose readings repeat themselves, though it moves."""

    def __init__(self, robot, last):
        self._robot, self._last = robot, last

    def state(self):
        return self._last

    def __getattr__(self, name):
        return getattr(self._robot, name)


class Listener:
    """An independent node that hears what is commanded and what is published."""

    def __init__(self):
        self.ros = Ros2Node("listener")
        self.node = self.ros.node
        self.ros.start()

    def hear(self, kind, topic):
        """What comes from now on: networks find their ends late, and what was sent by then is lost."""
        heard = queue.Queue()
        subscription = self.node.create_subscription(kind, topic, heard.put, 50)
        until(subscription.get_publisher_count, f"a publisher of {topic}")
        return heard

    def call(self, service):
        from std_srvs.srv import Trigger

        client = self.node.create_client(Trigger, service)
        assert client.wait_for_service(PATIENCE)
        future = client.call_async(Trigger.Request())
        until(future.done)
        return future.result()


@pytest.fixture(scope="module")
def model():
    return tiago.model()


@pytest.fixture
def simulated(domain, model):
    topics = Faulty(SimRobot(model))
    topics.open()
    yield topics
    topics.close()


@pytest.fixture
def robot(simulated, model):
    client = TiagoOverRos2(model)
    client.open()
    yield client
    client.close()


@pytest.fixture
def listener(domain):
    listener = Listener()
    yield listener
    listener.ros.close()


@pytest.fixture
def board_shown():
    """Set while the person shows the board with the marker; clear it to see the person alone."""
    shown = threading.Event()
    shown.set()
    return shown


@pytest.fixture
def runner(robot, simulated, config, board_shown):
    """The whole loop, its pictures from the simulated head: a person, and a second later the marker."""
    things = Things(board=lambda seconds: board_pose() if seconds > 1 and board_shown.is_set() else None)
    camera = closed_loop.mounted_camera(simulated.robot, closed_loop.things_for(Config().marker, things))
    camera.open()
    runner = Runner(
        camera, robot, lambda frame: closed_loop.detector(config, closed_loop.calibration()), config
    )
    yield runner
    runner.stop()
    camera.close()


# -- both ends -----------------------------------------------------------------------------------
def test_readings_arrive_as_they_are(robot, simulated):
    truth, seen = simulated.robot.state(), robot.state()
    assert seen.head == pytest.approx(truth.head, abs=1e-9)
    assert seen.arm == pytest.approx(truth.arm, abs=1e-9)
    assert seen.hand == pytest.approx(truth.hand, abs=1e-9)
    until(lambda: time.monotonic() - robot.state().time < 0.1)


def test_head_and_hand_move_as_told_and_stop(robot, simulated):
    start = simulated.robot.state().hand

    def moved():
        robot.move_head(np.array([0.3, 0.1]))
        robot.move_hand(np.array([0.05, 0, 0, 0, 0, 0]))
        state = robot.state()
        return state.head[0] > 0.05 and state.head[1] > 0.01 and state.hand[0, 3] > start[0, 3] + 0.01

    for watch in attempts(1.0):
        until(moved)
        with watch:
            robot.stop()
            until(lambda: simulated.robot.speed < 1e-3)


def test_the_head_moves_as_fast_as_it_is_commanded(robot):
    directions = itertools.cycle((0.4, -0.4))

    def as_commanded():
        speed = next(directions)
        began, start = time.monotonic(), robot.state().head[0]
        while time.monotonic() - began < 1.0:
            robot.move_head(np.array([speed, 0.0]))
            time.sleep(0.02)
        moved = robot.state()
        # It starts from what was read a moment ago, so it lags by that much at each command.
        return (moved.head[0] - start) / (moved.time - began) == pytest.approx(speed, rel=0.35)

    until(as_commanded)


def test_a_head_that_is_told_nothing_more_rests_by_itself(robot, simulated):
    for watch in attempts(1.5):
        until(lambda: robot.move_head(np.array([0.4, 0.0])) or simulated.robot.speed > 0.1)
        with watch:
            until(lambda: simulated.robot.speed < 1e-2)


def test_an_axis_that_rests_holds_its_place_while_the_other_moves(robot, listener):
    heard = listener.hear(JointTrajectory, "/head_controller/joint_trajectory")
    until(lambda: robot.move_head(np.array([0.3, 0.0])) or heard.qsize() > 10)
    tilts = {heard.get().points[0].positions[1] for _ in range(10)}
    assert len(tilts) == 1


def test_steps_go_by_one_trajectory_each(robot, simulated):
    robot.step_head(np.radians([2.0, -2.0]))
    until(lambda: np.allclose(np.degrees(robot.state().head), [2, -2], atol=0.1))


def test_a_target_beyond_the_neck_s_limits_is_cut_off(robot, listener, model):
    heard = listener.hear(JointTrajectory, "/head_controller/joint_trajectory")
    until(lambda: robot.step_head(np.array([3.0, 3.0])) or heard.qsize())
    positions = tiago.HEAD_SIGNS * np.array(heard.get().points[0].positions)
    assert positions == pytest.approx(model.head.high)


def test_the_whole_chain_reaches_the_marker(runner, simulated):
    runner.start()
    until(lambda: runner.loop.machine.state is State.REACHED, seconds=PROGRAM)
    runner.stop()
    goal = runner.loop.arm.goal(closed_loop.in_base(simulated.robot, closed_loop.rendered_scene.board_pose()))
    hand = simulated.robot.state().hand
    assert geometry.distance(hand, goal) < 0.010
    assert math.degrees(geometry.angle_between(hand, goal)) < 2
    assert simulated.robot.limit_violations == 0


# -- what goes wrong -----------------------------------------------------------------------------
def approaching(runner, simulated):
    runner.start()
    until(lambda: runner.loop.machine.state is State.APPROACHING and simulated.robot.speed > 0.02)


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
    simulated.frozen = True
    until(lambda: runner.loop.machine.state is State.STOPPED)
    assert "encoders stand still" in runner.loop.machine.reason
    until(lambda: simulated.robot.speed < 1e-3)
    last = [twists.get() for _ in range(twists.qsize())][-1].twist
    assert (last.linear.x, last.linear.y, last.linear.z, last.angular.x) == (0, 0, 0, 0)


def test_pictures_over_ros_that_cease_end_all_motion(robot, simulated, config):
    others = ("robot_timeout", "command_timeout", "freeze", "stuck")  # may not be the first to stop it
    limits = replace(config.safety, **dict.fromkeys(others, PATIENCE))
    object.__setattr__(config, "safety", limits)
    camera = closed_loop.mounted_camera(simulated.robot, closed_loop.things_for(Config().marker))
    camera.open()
    server = Ros2GrabberServer(camera, "/camera")
    server.start()
    pictures = sources.create("ros2:/camera")
    runner = Runner(
        pictures, robot, lambda frame: closed_loop.detector(config, closed_loop.calibration()), config
    )
    cycles = []
    runner.cycle_done.connect(lambda cycle, frame: cycles.append(cycle))
    try:
        pictures.open()
        approaching(runner, simulated)
        server.stop()
        until(lambda: cycles[-1].state is State.LOST and cycles[-1].time - last_moving(cycles).time > 0.3)
        assert last_moving(cycles).time - runner.loop.sighting.captured <= config.safety.picture_timeout
        assert "no fresh picture" in cycles[-1].reason
        until(lambda: simulated.robot.speed < 1e-3)
    finally:
        runner.stop()
        pictures.close()
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
    """Told to hold, it holds where it was last sent, not where it was when it fell silent."""
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
            return "nobody listens to /servo_node/delta_twist_cmds" in str(error)
        return False

    until(refused)
    with pytest.raises(TransportError, match="/head_controller/joint_trajectory"):
        robot.move_head(np.array([0.1, 0.0]))
    for watch in attempts(1.0):
        with watch:
            robot.stop()


def test_a_robot_that_is_not_there_is_said_not_to_be(domain, model):
    with pytest.raises(SourceNotFoundError, match="nobody tells of TIAGo's joints at /joint_states"):
        TiagoOverRos2(model, timeout=0.3).open()


@pytest.mark.parametrize(
    ("joints", "complaint"),
    [
        ((*tiago.HEAD_JOINTS, *tiago.ARM_JOINTS[:-1]), "nothing of arm_7_joint"),
        ((*tiago.HEAD_JOINTS, *tiago.ARM_JOINTS), "nobody listens to"),
    ],
)
def test_half_a_robot_is_told_from_a_whole_one(listener, model, joints, complaint):
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
    for positions in ([math.nan] * 9, [0.1] * 8, [math.inf] * 9):
        states.publish(JointState(name=names, position=positions))
    states.publish(JointState(name=names, position=[0.05] * 9))
    until(lambda: robot.state() is not before)
    assert np.isfinite(robot.state().hand).all()


def test_commands_before_it_is_open_are_refused(model):
    robot = TiagoOverRos2(model)
    for command in (lambda: robot.move_head(np.zeros(2)), lambda: robot.move_hand(np.zeros(6))):
        with pytest.raises(TransportError):
            command()
    robot.stop()
    robot.close()


# -- tf ------------------------------------------------------------------------------------------
def test_the_camera_is_where_tf_has_it(simulated, model, listener):
    messages = pytest.importorskip("tf2_msgs.msg", reason="tf2_msgs is not installed")
    from geometry_msgs.msg import TransformStamped
    from rclpy.qos import DurabilityPolicy, QoSProfile

    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher = listener.node.create_publisher(messages.TFMessage, "/tf_static", latched)
    robot = TiagoOverRos2(model)
    robot.open()
    try:
        until(lambda: robot.model is not model)  # from the simulated robot, which says what the URDF says
        assert robot.model.camera == pytest.approx(model.camera, abs=1e-9)
        entry = TransformStamped(child_frame_id=tiago.CAMERA)
        entry.header.frame_id = tiago.HEAD
        entry.transform.translation.x = 0.5
        publisher.publish(messages.TFMessage(transforms=[entry]))
        until(lambda: robot.model.camera[0, 3] == 0.5)
        moved = robot.camera_pose(np.zeros(2)) @ geometry.inverse(model.camera_pose(np.zeros(2)))
        assert not np.allclose(moved, np.eye(4))
    finally:
        robot.close()


# -- what others see -----------------------------------------------------------------------------
def test_what_happens_is_published_and_anybody_can_stop_it(runner, simulated, listener, board_shown):
    from diagnostic_msgs.msg import DiagnosticStatus
    from std_msgs.msg import Empty

    publisher = Ros2Publisher(runner, "/servo", "head_camera")
    publisher.open()
    try:
        markers = listener.hear(PoseStamped, "/servo/marker")
        heads = listener.hear(PoseStamped, "/servo/head")
        states = listener.hear(DiagnosticStatus, "/servo/state")
        board_shown.clear()  # where a marker is seen, heads are not looked for
        runner.start()
        assert heads.get(timeout=PATIENCE).pose.position.z == pytest.approx(1.3, abs=0.4)
        board_shown.set()
        marker = markers.get(timeout=PATIENCE)
        assert marker.header.frame_id == "head_camera"
        assert abs(marker.header.stamp.sec - time.time()) < 3
        assert marker.pose.position.z == pytest.approx(0.65, abs=0.3)
        assert marker.pose.orientation.w >= 0
        until(lambda: simulated.robot.speed > 0.02)
        answer = listener.call("/servo/stop")
        assert answer.success
        until(lambda: simulated.robot.speed < 1e-3)
        until(lambda: (status := states.get(timeout=PATIENCE)).level == DiagnosticStatus.ERROR and status)
        assert "resumed" in listener.call("/servo/resume").message
        assert "not stopped" in listener.call("/servo/resume").message
        until(lambda: simulated.robot.speed > 0.01)
        at_once = listener.node.create_publisher(Empty, "/servo/stop_now", 1)
        until(at_once.get_subscription_count)
        at_once.publish(Empty())
        until(lambda: runner.gate.halted == "stopped over ROS 2")
        until(lambda: simulated.robot.speed < 1e-3)
        status = {}
        until(lambda: "state" in status or status.update(pairs(states)))
        assert status["state"]
    finally:
        runner.stop()
        publisher.close()


def pairs(states):
    return {pair.key: pair.value for pair in states.get(timeout=PATIENCE).values}


def test_all_detections_are_published_where_vision_msgs_is_there(runner, listener, board_shown):
    vision = pytest.importorskip("vision_msgs.msg", reason="vision_msgs is not installed")
    publisher = Ros2Publisher(runner, "/servo")
    publisher.open()
    try:
        markers = listener.hear(vision.Detection3DArray, "/servo/markers")
        heads = listener.hear(vision.Detection3DArray, "/servo/heads")
        board_shown.clear()
        runner.start()
        assert heads.get(timeout=PATIENCE).header.frame_id == "camera"
        board_shown.set()
        found = []
        until(lambda: found or found.extend(markers.get(timeout=PATIENCE).detections))
        assert found[0].id == "20"
        assert found[0].results[0].hypothesis.class_id == "20"
        assert found[0].bbox.size.x == pytest.approx(0.1)
        assert found[0].results[0].pose.pose == found[0].bbox.center
    finally:
        runner.stop()
        publisher.close()


def test_a_bad_name_is_refused(runner):
    with pytest.raises(UsageError, match="letters, digits"):
        Ros2Publisher(runner, "/my servo")


# -- the commands --------------------------------------------------------------------------------
def test_the_commands_reach_the_marker_in_two_processes(domain, tmp_path, capsys, monkeypatch, config):
    monkeypatch.setattr("grabbergui.cli.servo._config", lambda options: config)
    simulation = subprocess.Popen(
        [sys.executable, "-m", "grabbergui", "simulate-tiago"], stdout=subprocess.PIPE, text=True
    )
    try:
        assert "TIAGo listens to" in simulation.stdout.readline()
        assert receive_camera_info("/camera/image_raw")[0].matrix == pytest.approx(
            closed_loop.calibration().matrix
        )
        so_long = ("--seconds", str(PROGRAM), "--until-reached")
        chosen = options("servo", "--robot", "tiago", "--headless", *so_long, "--report", str(tmp_path))
        assert chosen.run(chosen) == 0
        report = json.loads((tmp_path / "report.json").read_text())
        assert report["reached"]
        assert report["pictures"] > 10  # as many as a busy machine draws
        assert "approaching" in capsys.readouterr().out
    finally:
        simulation.send_signal(signal.SIGINT)
        simulation.wait(PATIENCE)
        simulation.stdout.close()
    assert simulation.returncode == 0


def test_a_camera_that_tells_no_calibration_is_named(domain):
    with pytest.raises(SourceNotFoundError, match="nobody publishes /nobody/camera_info"):
        receive_camera_info("/nobody", timeout=0.2)[0]
