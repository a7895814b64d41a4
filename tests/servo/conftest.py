"""ROS, where a test uses it, in a domain of its own."""

import os

import pytest

from ros2_domain import own_domain


@pytest.fixture(scope="session")
def domain():
    """Nobody else's nodes, and none of ours beyond this machine."""
    os.environ.update(own_domain())
