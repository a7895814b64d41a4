"""ROS, where a test uses it, in a domain of its own; what a robot waits for on a busy machine."""

import os
from dataclasses import replace

import pytest

from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import NameServer
from grabbergui.servo.config import Config
from grabbergui.servo.robots.teo_yarp import TeoOverYarp
from patience import allowance, until
from ros2_domain import own_domain


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
    """Of a run in real time: on a machine that is slow just now, pictures and readings may be older.

    With the limits of a real robot it would rightly not move at all there. Tests in simulated time hold them.
    """
    config, slow = Config(), min(3 * allowance(), 30)
    limits = ("picture_timeout", "robot_timeout", "command_timeout", "freeze", "stuck", "guardian_timeout")
    relaxed = replace(config.safety, **{name: slow * getattr(config.safety, name) for name in limits})
    object.__setattr__(config, "safety", relaxed)  # past the check, which holds every user to 0.2 s
    return config
