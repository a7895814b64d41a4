"""The servo and a TIAGo as PAL configures it, over real rclpy: trajectories, a servo node, faults."""

import threading
import time
from contextlib import closing

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
pytest.importorskip("trajectory_msgs", reason="ros-trajectory-msgs is not installed: make setup-ros2")
pytest.importorskip("controller_manager_msgs", reason="no controller_manager_msgs: make setup-ros2")
pytest.importorskip("moveit_msgs", reason="no moveit_msgs: make setup-ros2")
pytest.importorskip("pinocchio", reason="Pinocchio is not installed: pip install '.[servo]'")
pytest.importorskip("example_robot_data", reason="no robot data: pip install '.[servo]'")
pytestmark = pytest.mark.ros2

from controller_manager_msgs.msg import ControllerState  # noqa: E402
from controller_manager_msgs.srv import ListControllers  # noqa: E402
from rclpy.clock import Clock  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile  # noqa: E402
from rclpy.task import Future  # noqa: E402

from fake_tiago import FakeTiago  # noqa: E402
from grabbergui.core.errors import SourceNotFoundError, SourceUnavailableError, TransportError  # noqa: E402
from grabbergui.driver.sim.rendered_scene import Things, board_pose  # noqa: E402
from grabbergui.net.ros2.runtime import Ros2Node  # noqa: E402
from grabbergui.servo import closed_loop  # noqa: E402
from grabbergui.servo.config import Config  # noqa: E402
from grabbergui.servo.robots import tiago, tiago_nodes, tiago_ros2  # noqa: E402
from grabbergui.servo.robots.robot import ARM, HEAD  # noqa: E402
from grabbergui.servo.robots.simulated import SimRobot  # noqa: E402
from grabbergui.servo.robots.tiago_nodes import ControllerManager, receive_description  # noqa: E402
from grabbergui.servo.robots.tiago_ros2 import TiagoOverRos2  # noqa: E402
from patience import until  # noqa: E402
from whole_chain import detecting_runner, reach_marker  # noqa: E402


@pytest.fixture
def fake(domain, model, request):
    fake = FakeTiago(SimRobot(model), servo=getattr(request, "param", "") == "servo node")
    fake.open()
    yield fake
    fake.close()


@pytest.fixture
def robot(fake, model):
    robot = TiagoOverRos2(model)
    robot.open()
    yield robot
    robot.close()


@pytest.mark.parametrize("fake", ["stock", "servo node"], indirect=True)
def test_the_head_follows_and_the_hand_reaches_the_marker(fake, robot, patient):
    assert "head streamed trajectories to /head_controller/joint_trajectory" in robot.summary
    arm = "streamed trajectories to /arm_controller" if ARM in fake.controllers else "twists to /servo_node"
    assert f"arm {arm}" in robot.summary
    things = closed_loop.things_for(Config().marker, Things(board=lambda seconds: board_pose()))
    camera = closed_loop.mounted_camera(fake.robot, things)
    camera.open()
    try:
        metres, degrees = reach_marker(detecting_runner(camera, robot, patient), fake.robot)
    finally:
        camera.close()
    assert metres < 0.010
    assert degrees < 2
    assert fake.robot.limit_violations == 0
    # A busy machine may deliver a trajectory late, which the robot refuses as it should.
    refused = [each for controller in fake.controllers.values() for each in controller.refused]
    assert [each for each in refused if not each.startswith("it ended")] == []


class SilentManager:
    """A node and its client of a controller manager that receives requests, and answers when it is told."""

    def __init__(self):
        self.requests = []

    def create_client(self, kind, service):
        return self

    def get_clock(self):
        return Clock()

    def create_timer(self, seconds, callback, clock):
        self.tick = callback

    def service_is_ready(self):
        return True

    def call_async(self, request):
        self.requests.append(Future())
        return self.requests[-1]

    def remove_pending_request(self, future):
        self.requests.remove(future)

    def answer(self, future, state):
        controller = ControllerState(name="arm_controller", type="any", state=state)
        future.set_result(ListControllers.Response(controller=[controller]))


def test_a_controller_manager_whose_answer_was_lost_is_asked_again(monkeypatch):
    now = 100.0
    monkeypatch.setattr(tiago_nodes.time, "monotonic", lambda: now)
    silent = SilentManager()
    manager = ControllerManager(silent)
    for _ in range(20):  # its first answers, as long as it has not discovered who reads them
        now += 0.5
        silent.tick()
    assert 2 <= len(silent.requests) < 10 and manager.listed() is None
    silent.answer(silent.requests[-1], "active")
    assert manager.state_of("arm_controller") == "active" and len(silent.requests) == 1
    now += 0.5
    silent.tick()  # to one that ends now
    now += 5
    silent.tick()  # to the one that was started in its place
    silent.answer(silent.requests[-1], "inactive")
    assert manager.state_of("arm_controller") == "inactive"


def test_the_hand_moves_at_the_commanded_speed_and_rests_without_commands(fake, robot):
    def speed():
        began, start = time.monotonic(), fake.robot.state().hand[0, 3]
        while time.monotonic() - began < 0.6:
            robot.move_hand(np.array([0.05, 0, 0, 0, 0, 0]))
            time.sleep(0.02)
        moved = (fake.robot.state().hand[0, 3] - start) / (time.monotonic() - began)
        until(lambda: fake.robot.speed < 1e-3)  # by itself
        return moved

    speeds = []
    until(lambda: speeds.append(speed()) or 0.03 < speeds[-1] < 0.055, f"0.05 m/s, not {speeds}")


@pytest.mark.parametrize("simulated_clock", [False, True])
def test_a_controller_that_stops_takes_no_commands_and_the_other_part_goes_on(fake, robot, simulated_clock):
    """The simulated clock stands, as when Gazebo is paused."""
    robot._ros.node.set_parameters([Parameter("use_sim_time", value=simulated_clock)])
    fake.controllers[ARM].active = False

    def refused():
        try:
            robot.move_hand(np.array([0.05, 0, 0, 0, 0, 0]))
        except TransportError as error:
            return "arm_controller is inactive" in str(error)
        return False

    until(refused)
    until(lambda: robot.move_head(np.array([0.3, 0.0])) or fake.robot.state().head[0] > 0.05)


def test_one_part_is_driven_alone_where_the_other_has_no_active_controller(fake, model):
    fake.controllers[ARM].active = False
    robot = TiagoOverRos2(model)
    robot.open()
    try:
        assert robot.parts == {HEAD}
        assert "arm not driven: arm_controller" in robot.summary
        assert "is inactive" in robot.summary
        until(lambda: robot.move_head(np.array([0.3, 0.0])) or fake.robot.state().head[0] > 0.05)
        before = fake.robot.state().arm
        robot.move_hand(np.array([0.05, 0, 0, 0, 0, 0]))
        assert fake.robot.state().arm == pytest.approx(before)
    finally:
        robot.close()


def test_a_robot_without_an_active_controller_is_refused_by_name(fake, model):
    for controller in fake.controllers.values():
        controller.active = False
    with (
        closing(TiagoOverRos2(model)) as robot,
        pytest.raises(SourceNotFoundError, match=r"head_controller \(.*\) is inactive.*arm_controller"),
    ):
        robot.open()


def test_a_controller_manager_that_answers_late_is_waited_for(fake, model, monkeypatch):
    """Its first answers are lost if it has not discovered who reads them."""
    monkeypatch.setattr(tiago_ros2, "LIST_S", 0.0)
    on_answer = ControllerManager._on_answer
    late = time.monotonic() + 2.5
    monkeypatch.setattr(
        ControllerManager,
        "_on_answer",
        lambda manager, future: time.monotonic() > late and on_answer(manager, future),
    )
    fake.controllers[HEAD].active = False
    with closing(TiagoOverRos2(model)) as robot:
        robot.open()
        assert robot.parts == {ARM} and "head_controller" in robot.summary


@pytest.mark.parametrize("fake", ["servo node"], indirect=True)
def test_services_of_moveit_servo_that_are_discovered_late_are_called(fake, model, monkeypatch):
    from rclpy.node import Node

    offered = Node.get_service_names_and_types
    late = time.monotonic() + 2.5
    monkeypatch.setattr(
        Node, "get_service_names_and_types", lambda node: offered(node) if time.monotonic() > late else []
    )
    with closing(TiagoOverRos2(model)) as robot:
        robot.open()
        assert (fake.command_type, fake.paused) == (1, False)


def test_a_description_that_comes_late_is_waited_for(domain):
    from std_msgs.msg import String

    publisher = Ros2Node("robot_state_publisher")
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    descriptions = publisher.node.create_publisher(String, "/robot_description", latched)
    later = threading.Timer(3.2, descriptions.publish, [String(data="<robot/>")])
    later.start()
    try:
        assert receive_description() == "<robot/>"
    finally:
        later.join()
        publisher.close()


def test_whoever_only_listens_makes_no_publisher(fake, model):
    robot = TiagoOverRos2(model, listen_only=True)
    robot.open()
    try:
        robot.move_head(np.array([0.3, 0.0]))
        robot.move_hand(np.array([0.05, 0, 0, 0, 0, 0]))
        robot.stop()
        node = fake._ros.node
        for topic in ("/head_controller/joint_trajectory", "/arm_controller/joint_trajectory"):
            assert node.count_publishers(topic) == 0
    finally:
        robot.close()


def test_a_robot_s_own_description_and_its_camera_s_frame_make_the_model(domain, tmp_path):
    from std_msgs.msg import String

    text = tiago.shipped_urdf().read_text("utf-8")
    text = text.replace("xtion_rgb_optical_frame", "head_front_camera_color_optical_frame")
    publisher = Ros2Node("robot_state_publisher")
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher.node.create_publisher(String, "/robot_description", latched).publish(String(data=text))
    publisher.start()
    try:
        received = until(receive_description)
    finally:
        publisher.close()
    path = tmp_path / "robot.urdf"
    path.write_text(received, "utf-8")
    model = tiago.model(path, seen_in="nothing_of_the_urdf")
    assert model.camera == pytest.approx(tiago.model().camera)
    with pytest.raises(SourceUnavailableError, match="has no xtion_rgb_optical_frame"):
        tiago.model(path, camera="xtion_rgb_optical_frame")
