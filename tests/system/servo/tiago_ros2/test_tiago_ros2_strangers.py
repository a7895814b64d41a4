"""Strangers on a TIAGo's topics: what they move, what they make the program believe, what ends it."""

import time

import numpy as np
import pytest

from grabbergui.servo.robots.fault_list import Fault
from grabbergui.servo.robots.faults import Faults
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.robots.strangers import Ros2Stranger
from grabbergui.servo.robots.tiago_messages import CommandKind, Drive
from patience import until

pytest.importorskip("rclpy", reason="ROS 2 is not installed")
pytest.importorskip("pinocchio", reason="Pinocchio is not installed")

UP = np.array([0.0, 0.0, 0.03, 0.0, 0.0, 0.0])


@pytest.fixture
def faulty(domain, model, request):
    """A simulated TIAGo with the fault that the test names, from its first motion on."""
    from grabbergui.servo.robots.tiago_topics import TiagoTopics

    robot = SimRobot(model, faults=Faults([Fault(request.param, 0.0)], reports_hand=False))
    topics = TiagoTopics(robot)
    topics.open()
    stranger = Ros2Stranger(robot, Drive(CommandKind.TWIST, topics.arm_topic), "/joint_states")
    stranger.start()
    yield robot
    stranger.close()
    topics.close()


@pytest.fixture
def client(faulty, model):
    from grabbergui.servo.robots.tiago_ros2 import TiagoOverRos2

    client = TiagoOverRos2(model)
    client.open()
    yield client
    client.close()


def place(state):
    return state.hand[:3, 3].copy()


@pytest.mark.parametrize("faulty", ["second-master"], indirect=True)
def test_a_stranger_has_joined_before_the_robot_moves(faulty, client):
    """Joining held Python's lock for 0.3 s: the simulated robot stood still in the middle of its motion."""
    until(lambda: "stranger" in client._ros.node.get_node_names())
    assert not faulty.faults.active(np.inf)


@pytest.mark.parametrize("faulty", ["second-master"], indirect=True)
def test_a_stop_pauses_moveit_servo_while_a_second_master_commands(faulty, client, caplog):
    start = place(faulty.truth())
    client.move_hand(UP)
    until(lambda: place(faulty.truth())[1] < start[1] - 0.03, "the second master's motion")
    until(lambda: client._others.strangers == {"stranger"}, "the second master's discovery")
    client.stop()
    until(lambda: faulty.speed < 1e-4)
    assert "is commanded by stranger, too: MoveIt Servo is paused" in caplog.text
    rests = place(faulty.truth())
    time.sleep(0.1)  # twenty of its messages
    assert place(faulty.truth()) == pytest.approx(rests, abs=1e-6)
    client.move_hand(UP)  # a person has let it move again
    until(lambda: faulty.speed > 0.01)
    client.stop()
    until(lambda: faulty.speed < 1e-4)


@pytest.mark.parametrize("faulty", ["false-readings"], indirect=True)
def test_a_stranger_makes_the_program_believe_old_joints(faulty, client):
    start = faulty.truth().arm
    client.move_hand(UP)

    def believes():
        client.move_hand(UP)  # it expires
        true, heard = faulty.truth().arm, client.state().arm
        return np.abs(true - start).max() > 0.1 and np.abs(heard - start).max() < 0.05

    until(believes)
    client.stop()
