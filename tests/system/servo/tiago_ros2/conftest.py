"""TIAGo over ROS 2: both ends and a listener. What needs ROS or Pinocchio is imported where it is used."""

import threading

import pytest

from grabbergui.driver.sim.rendered_scene import Things, board_pose
from grabbergui.servo import closed_loop
from grabbergui.servo.config import Config
from grabbergui.servo.robots.simulated import SimRobot
from patience import until
from whole_chain import detecting_runner


@pytest.fixture(scope="module")
def model():
    from grabbergui.servo.robots import tiago

    return tiago.model()


@pytest.fixture
def simulated(domain, model):
    from tiago_stage import Faulty

    topics = Faulty(SimRobot(model))
    topics.open()
    yield topics
    topics.close()


@pytest.fixture
def robot(simulated, model, monkeypatch):
    """Its client, which knows that there is no controller manager and nothing else to wait for."""
    from grabbergui.net.ros2 import runtime
    from grabbergui.servo.robots import tiago_nodes, tiago_ros2
    from grabbergui.servo.robots.tiago_ros2 import TiagoOverRos2

    monkeypatch.setattr(tiago_ros2, "LIST_S", 0.0)
    monkeypatch.setattr(tiago_nodes, "JOIN_S", 0.0)
    monkeypatch.setattr(runtime, "DISCOVERY_S", 0.0)
    client = TiagoOverRos2(model)
    client.open()
    until(lambda: simulated.hears(client), "commands that arrive")
    yield client
    client.close()


@pytest.fixture
def listener(domain):
    from tiago_stage import Listener

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
    """The whole loop, its images from the simulated head: a person, and a second later the marker."""
    things = Things(board=lambda seconds: board_pose() if seconds > 1 and board_shown.is_set() else None)
    camera = closed_loop.mounted_camera(simulated.robot, closed_loop.things_for(Config().marker, things))
    camera.open()
    runner = detecting_runner(camera, robot, config)
    yield runner
    runner.stop()
    camera.close()
