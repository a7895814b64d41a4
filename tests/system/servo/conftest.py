"""ROS, where a test uses it, in a domain of its own; what a robot waits for on a busy machine."""

import os

import pytest

from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import NameServer
from grabbergui.servo.robots.teo_yarp import TeoOverYarp
from patience import until
from ros2_domain import own_domain
from servo_limits import MOST, patient_config


@pytest.fixture(scope="session")
def domain():
    """Nobody else's nodes, and none of ours beyond this machine."""
    os.environ.update(own_domain())


@pytest.fixture
def names():
    """A YARP name server of the test's own."""
    server = NameServer("127.0.0.1", 0)
    server.open()
    yield NameClient(server.contact)
    server.close()


@pytest.fixture
def robot(names, simulated):
    """The client of the TEO that a module serves as `simulated`, with its first readings."""
    client = TeoOverYarp(names)
    client.open()
    until(lambda: client.state() is not None)
    yield client
    client.close()


@pytest.fixture
def config():
    """Return the configuration of a run in real time."""
    return patient_config()


@pytest.fixture
def patient():
    """Return the configuration of a run in real time without limits."""
    return patient_config(MOST)
