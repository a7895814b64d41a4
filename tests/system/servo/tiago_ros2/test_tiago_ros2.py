"""TIAGo over ROS 2 with real rclpy: both ends, what others see, and the commands."""

import itertools
import json
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
pytest.importorskip("grabber_interfaces", reason="the interface package is not built: make setup-ros2")
pytest.importorskip("trajectory_msgs", reason="ros-trajectory-msgs is not installed: make setup-ros2")
pytest.importorskip("pinocchio", reason="Pinocchio is not installed: pip install '.[servo]'")
pytest.importorskip("example_robot_data", reason="no robot data: pip install '.[servo]'")
pytestmark = pytest.mark.ros2

from geometry_msgs.msg import PoseStamped  # noqa: E402
from trajectory_msgs.msg import JointTrajectory  # noqa: E402

from grabbergui.calibration import geometry  # noqa: E402
from grabbergui.core.errors import SourceNotFoundError, UsageError  # noqa: E402
from grabbergui.net.ros2.image_messages import receive_camera_info  # noqa: E402
from grabbergui.servo import closed_loop  # noqa: E402
from grabbergui.servo.robots import tiago  # noqa: E402
from grabbergui.servo.robots.tiago_ros2 import TiagoOverRos2  # noqa: E402
from grabbergui.servo.ros2_publisher import Ros2Publisher  # noqa: E402
from patience import PATIENCE, PROGRAM, attempts, until  # noqa: E402
from servo_options import options  # noqa: E402
from whole_chain import reach_marker  # noqa: E402


def test_readings_arrive_as_they_are(robot, simulated):
    truth, seen = simulated.robot.state(), robot.state()
    assert seen.head == pytest.approx(truth.head, abs=1e-9)
    assert seen.arm == pytest.approx(truth.arm, abs=1e-9)
    assert seen.hand == pytest.approx(truth.hand, abs=1e-9)
    until(lambda: time.monotonic() - robot.state().time < 0.1)


def test_head_and_hand_follow_commands_and_stop(robot, simulated):
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


def test_a_head_without_further_commands_rests(robot, simulated):
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
    metres, degrees = reach_marker(runner, simulated.robot)
    assert metres < 0.010
    assert degrees < 2
    assert simulated.robot.limit_violations == 0


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
        begun = time.time()
        board_shown.set()
        marker = markers.get(timeout=PATIENCE)
        assert marker.header.frame_id == "head_camera"
        assert begun - 3 < marker.header.stamp.sec <= time.time()
        assert marker.pose.position.z == pytest.approx(0.65, abs=0.3)
        assert marker.pose.orientation.w >= 0
        until(lambda: simulated.robot.speed > 0.02)
        answer = listener.call("/servo/stop", publisher._ros.node)
        assert answer.success
        until(lambda: simulated.robot.speed < 1e-3)
        until(lambda: (status := states.get(timeout=PATIENCE)).level == DiagnosticStatus.ERROR and status)
        assert "resumed" in listener.call("/servo/resume", publisher._ros.node).message
        assert "not stopped" in listener.call("/servo/resume", publisher._ros.node).message
        until(lambda: simulated.robot.speed > 0.01)
        at_once = listener.node.create_publisher(Empty, "/servo/stop_now", 1)
        until(at_once.get_subscription_count)
        until(lambda: at_once.publish(Empty()) or runner.gate.halted == "stopped over ROS 2")
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


def test_a_stop_is_heard_while_another_one_is_being_ended(runner, listener, monkeypatch):
    """The guardian takes a second to start again."""
    from std_msgs.msg import Empty

    publisher = Ros2Publisher(runner, "/servo")
    publisher.open()
    began, stopped = threading.Event(), threading.Event()

    def release(stops, pressed):
        before = runner.gate.stops
        began.set()
        until(lambda: runner.gate.stops > before)
        stopped.set()

    try:
        runner.start()
        at_once = listener.node.create_publisher(Empty, "/servo/stop_now", 1)
        until(at_once.get_subscription_count)
        runner.emergency_stop("by a test")
        monkeypatch.setattr(runner.gate, "release", release)
        with ThreadPoolExecutor(1) as pool:
            resumed = pool.submit(listener.call, "/servo/resume", publisher._ros.node)
            assert began.wait(PATIENCE)
            until(lambda: at_once.publish(Empty()) or stopped.is_set())
            assert resumed.result(PATIENCE).success
    finally:
        runner.stop()
        publisher.close()


def test_a_bad_name_is_refused(runner):
    with pytest.raises(UsageError, match="letters, digits"):
        Ros2Publisher(runner, "/my servo")


def test_the_commands_reach_the_marker_in_two_processes(listener, tmp_path, capsys, monkeypatch, config):
    monkeypatch.setattr("grabbergui.servo.cli.servo.configuration", lambda options: config)
    markers = []
    listener.node.create_subscription(PoseStamped, "/grabbergui/servo/marker", markers.append, 50)
    simulation = subprocess.Popen(
        [sys.executable, "-m", "grabbergui", "simulate-tiago"], stdout=subprocess.PIPE, text=True
    )
    try:
        assert "TIAGo listens to" in simulation.stdout.readline()
        assert receive_camera_info("/camera/image_raw")[0].matrix == pytest.approx(
            closed_loop.calibration().matrix
        )
        duration = ("--seconds", str(PROGRAM), "--until-reached")
        outputs = ("--report", str(tmp_path), "--publish-ros2")
        chosen = options("servo", "--robot", "tiago", "--headless", *duration, *outputs)
        assert chosen.run(chosen) == 0
        report = json.loads((tmp_path / "report.json").read_text())
        assert report["reached"]
        assert report["images"] > 10  # as many as a busy machine draws
        assert "approaching" in capsys.readouterr().out
        assert {marker.header.frame_id for marker in markers} == {tiago.CAMERA}  # as camera_info has it
    finally:
        simulation.send_signal(signal.SIGINT)
        simulation.wait(PATIENCE)
        simulation.stdout.close()
    assert simulation.returncode == 0


def test_a_camera_without_a_calibration_is_named(domain):
    with pytest.raises(SourceNotFoundError, match="nobody publishes /nobody/camera_info"):
        receive_camera_info("/nobody", timeout=0.2)[0]
