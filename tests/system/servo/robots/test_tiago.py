"""TIAGo without a network: its kinematics by Pinocchio, and the loop that moves it, in simulated time."""

import itertools
import json
import math
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from grabbergui.calibration import geometry
from grabbergui.core.errors import SourceUnavailableError, UsageError
from grabbergui.driver.sim.rendered_scene import Things, board_pose
from grabbergui.net.ros2 import runtime
from grabbergui.servo import closed_loop
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.state_machine import State

pinocchio = pytest.importorskip("pinocchio", reason="Pinocchio is not installed: pip install '.[servo]'")
pytest.importorskip("example_robot_data", reason="no robot data: pip install '.[servo]'")

from grabbergui.net.ros2.requirements import require_packages  # noqa: E402
from grabbergui.servo.robots import tiago  # noqa: E402
from grabbergui.servo.robots.urdf_chain import UrdfChain, load_urdf  # noqa: E402


@pytest.fixture(scope="module")
def model():
    return tiago.model()


def some_angles(chain, count=10):
    return np.random.default_rng(4).uniform(chain.low, chain.high, (count, len(chain.low)))


def test_the_nearest_contact_is_the_least_distance_of_all_pairs_on_every_thread(model):
    shapes = model.body._shapes
    poses = [model.home, *some_angles(model.arm, 4)]

    def brute_force(angles):
        configuration, data = pinocchio.neutral(model.body._model), shapes.createData()
        configuration[model.body._places] = angles
        pinocchio.computeDistances(
            model.body._model, model.body._model.createData(), shapes, data, configuration
        )
        return min(result.min_distance for result in data.distanceResults)

    expected = [pytest.approx(brute_force(angles), abs=1e-6) for angles in poses]

    def measured():
        return [model.body.nearest(angles).distance for angles in poses]

    with ThreadPoolExecutor(2) as threads:
        assert list(threads.map(lambda _: measured(), range(4))) == [expected] * 4
    assert measured() == expected


def test_the_head_looks_ahead_at_rest_turns_left_and_looks_down(model):
    ahead = model.camera_pose(np.zeros(2))
    assert ahead[:3, 2] == pytest.approx([1, 0, 0], abs=1e-6)
    assert ahead[:3, 1] == pytest.approx([0, 0, -1], abs=1e-6)
    # Of the URDF: the torso's link to the head's two, and the camera on the second.
    assert ahead[:3, 3] == pytest.approx([0.2778, 0.022, 0.178], abs=1e-3)
    assert model.camera_pose(np.array([0.5, 0.0]))[1, 2] == pytest.approx(math.sin(0.5), abs=1e-6)
    assert model.camera_pose(np.array([0.0, 0.5]))[2, 2] == pytest.approx(-math.sin(0.5), abs=1e-6)
    assert np.degrees(model.head.low) == pytest.approx([-75, -45])
    assert np.degrees(model.head.high) == pytest.approx([75, 60])


def test_the_hand_at_home_points_ahead_and_its_x_down(model):
    hand = model.arm.forward(model.home)
    assert hand[:3, 2] == pytest.approx([1, 0, 0], abs=0.02)
    assert hand[:3, 0] == pytest.approx([0, 0, -1], abs=0.02)
    assert np.all((model.arm.low < model.home) & (model.home < model.arm.high))


@pytest.mark.parametrize("part", ["head", "arm"])
def test_the_jacobian_is_the_derivative(model, part):
    chain, step = getattr(model, part), 1e-6
    for angles in some_angles(chain):
        jacobian = chain.jacobian(angles)
        for joint in range(len(angles)):
            moved = angles.copy()
            moved[joint] += step
            numeric = geometry.diff(chain.forward(angles), chain.forward(moved)) / step
            assert jacobian[:, joint] == pytest.approx(numeric, abs=1e-5)


def test_links_hang_together_from_the_base_to_the_hand(model):
    frames = model.arm.frames(model.home)
    assert len(frames) == 7 + 2
    assert frames[0] == pytest.approx(np.eye(4))
    assert all(geometry.distance(one, next_one) < 0.4 for one, next_one in itertools.pairwise(frames))
    assert frames[-1] == pytest.approx(model.arm.forward(model.home))


@pytest.mark.parametrize("chain", [teo.HEAD, teo.RIGHT_ARM], ids=lambda chain: chain.name)
def test_teo_s_table_is_the_same_to_pinocchio(chain):
    """Each row of the table as a joint about z, a shift along it, a shift along x and a cycle about x."""
    model, parent, placement = pinocchio.Model(), 0, pinocchio.SE3(chain.base)
    for joint in chain.joints:
        parent = model.addJoint(parent, pinocchio.JointModelRZ(), placement, joint.name)
        along = about((0, 0, math.radians(joint.offset)), (0, 0, joint.d))
        across = about((math.radians(joint.alpha), 0, 0), (joint.a, 0, 0))
        placement = pinocchio.SE3(along @ across)
    last = placement * pinocchio.SE3(chain.tool)
    tool = model.addFrame(pinocchio.Frame("tool", parent, last, pinocchio.FrameType.OP_FRAME))
    data = model.createData()
    for angles in some_angles(chain):
        pinocchio.forwardKinematics(model, data, angles)
        reached = pinocchio.updateFramePlacement(model, data, tool).homogeneous
        assert chain.forward(angles) == pytest.approx(reached, abs=1e-12)
        axes = pinocchio.LOCAL_WORLD_ALIGNED
        jacobian = pinocchio.computeFrameJacobian(model, data, angles, tool, axes)
        assert chain.jacobian(angles) == pytest.approx(jacobian, abs=1e-12)


def about(vector, place):
    return geometry.pose(geometry.rotation_from_vector(vector), place)


def test_what_is_no_robot_is_refused(tmp_path):
    with pytest.raises(SourceUnavailableError, match="no robot that Pinocchio can read"):
        load_urdf(tmp_path / "none.urdf")
    (tmp_path / "bad.urdf").write_text("<robot")
    with pytest.raises(SourceUnavailableError, match="no robot that Pinocchio can read"):
        tiago.model(tmp_path / "bad.urdf")
    with pytest.raises(SourceUnavailableError, match="no gripper_link"):
        tiago.model(hand="gripper_link")
    with pytest.raises(SourceUnavailableError, match="no arm_9_joint"):
        UrdfChain("arm", load_urdf(tiago.shipped_urdf()), tiago.BASE, ["arm_9_joint"], tiago.HAND)


@pytest.mark.parametrize("angles", [[0.0], [float("nan")] * 7, np.zeros((7, 1))])
def test_angles_that_are_none_are_refused(model, angles):
    for ask in (model.arm.forward, model.arm.jacobian):
        with pytest.raises(UsageError, match="TIAGo's arm has 7 joints"):
            ask(angles)


def test_it_keeps_to_its_limits_whatever_it_is_commanded(model):
    now, random = 0.0, np.random.default_rng(7)
    robot = SimRobot(model, lambda: now)
    for _ in range(300):
        robot.move_hand(random.normal(0, 5, 6))
        robot.point_head(random.normal(0, 2, 2), abs(random.normal(0, 5, 2)))
        now += 0.02
    state = robot.state()
    assert robot.limit_violations == 0
    assert np.all((model.arm.low - 1e-9 <= state.arm) & (state.arm <= model.arm.high + 1e-9))
    assert np.all((model.head.low - 1e-9 <= state.head) & (state.head <= model.head.high + 1e-9))


def test_a_head_that_is_pointed_gets_there_at_its_speed_and_stays(model):
    now = 0.0
    robot = SimRobot(model, lambda: now)
    robot.point_head(np.array([0.4, -0.2]), np.array([0.4, 0.2]))
    now = 0.5
    assert robot.state().head == pytest.approx([0.19, -0.095], abs=0.015)
    now = 1.4
    assert robot.state().head == pytest.approx([0.4, -0.2], abs=2e-3)
    now = 20.0
    assert robot.state().head == pytest.approx([0.4, -0.2], abs=1e-3)
    robot.point_head(np.array([np.nan, 0.0]), np.array([0.4, 0.2]))
    now = 22.0
    assert robot.state().head == pytest.approx([0.4, -0.2], abs=1e-3)


def test_it_looks_waits_approaches_and_arrives(model):
    run = closed_loop.ClosedLoop(
        model, things=Things(board=lambda seconds: board_pose() if seconds > 1 else None)
    )
    run.run(20, State.REACHED)
    states = [step.state for step in run.loop.machine.transitions]
    assert states[-2:] == [State.APPROACHING, State.REACHED]
    assert State.WAITING in states
    run.run(1.0)
    metres, radians = run.true_error()
    assert metres < 0.010
    assert math.degrees(radians) < 2
    assert run.robot.limit_violations == 0
    assert run.robot.speed == 0
    assert run.gate.refused == 0


def test_a_face_is_seen_in_every_image_from_below_too(model):
    """TIAGo is shorter than who stands before it; what they wear must not hide their chin."""
    run = closed_loop.ClosedLoop(model, things=Things(board=lambda seconds: None))
    run.run(3)
    after = [cycle.state for cycle in run.cycles if cycle.time > 0.5]
    assert State.LOST not in after


def test_the_command_takes_it_by_name(tmp_path, capsys):
    from servo_options import options

    seen = set()
    for seconds in ("1.5", "6", "20"):  # a machine with much else to do takes its time for images
        chosen = options(
            "servo", "--robot", "sim-tiago", "--headless", "--seconds", seconds, "--report", str(tmp_path)
        )
        assert chosen.run(chosen) in (0, 1)  # the marker is shown only later
        written = json.loads((tmp_path / "report.json").read_text())
        assert written["limit_violations"] == 0
        seen = {step["state"] for step in written["states"]}
        if "centring" in seen:
            break
    assert seen >= {"lost", "centring"}


def test_without_the_extra_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    with pytest.raises(SourceUnavailableError, match=r"pip install 'grabbergui\[servo\]'"):
        load_urdf(tiago.shipped_urdf())


def test_without_ros_every_way_to_it_says_what_to_do(model, monkeypatch):
    from grabbergui.servo.robots.tiago_ros2 import TiagoOverRos2
    from grabbergui.servo.robots.tiago_topics import TiagoTopics
    from grabbergui.servo.ros2_publisher import Ros2Publisher

    monkeypatch.setitem(sys.modules, "rclpy", None)
    for opened in (
        TiagoOverRos2(model).open,
        Ros2Publisher(None).open,
        lambda: TiagoTopics(SimRobot(model)),
    ):
        with pytest.raises(SourceUnavailableError, match="setup ros2"):
            opened()


def test_a_message_package_that_is_missing_is_named(monkeypatch):
    monkeypatch.setattr(runtime, "require_ros2", lambda: None)
    for module in ("trajectory_msgs", "trajectory_msgs.msg"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(SourceUnavailableError, match="the ROS 2 package trajectory_msgs is not installed"):
        require_packages("trajectory_msgs.msg")
