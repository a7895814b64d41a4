"""How Fast DDS sends: in shared memory, but by UDP beside the programs of another user."""

import fcntl
import os
from pathlib import Path

import pytest

from grabbergui.core.errors import SourceUnavailableError
from grabbergui.net.ros2 import runtime

PROFILES = "FASTDDS_DEFAULT_PROFILES_FILE"
RESOURCES = Path(__file__).parents[3] / "resources/ros2"


@pytest.fixture
def segment(tmp_path):
    """The shared memory of a DDS program that runs, with its lock."""
    path = tmp_path / "fastdds_0123456789abcdef"
    path.touch()
    with (tmp_path / f"{path.name}_el").open("wb") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield path


def test_shared_memory_of_the_same_user_is_ignored(segment):
    assert runtime.other_user_in_shared_memory(segment.parent) == ""


def test_shared_memory_of_another_user_is_found(segment, monkeypatch):
    monkeypatch.setattr(os, "geteuid", lambda: segment.stat().st_uid + 1)
    assert runtime.other_user_in_shared_memory(segment.parent) == segment.owner()


def test_shared_memory_left_by_an_ended_program_is_ignored(tmp_path, monkeypatch):
    uid = os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: uid + 1)
    for name in ("fastdds_0123456789abcdef", "fastdds_0123456789abcdef_el"):
        (tmp_path / name).touch()
    assert runtime.other_user_in_shared_memory(tmp_path) == ""


@pytest.mark.parametrize(("other", "profile"), [("", "fastdds.xml"), ("root", "fastdds-network.xml")])
def test_udp_is_used_beside_another_users_programs(other, profile, monkeypatch):
    monkeypatch.setenv(PROFILES, "")  # so that it is afterwards what it was before
    monkeypatch.delenv(PROFILES)
    monkeypatch.delenv("ROS_AUTOMATIC_DISCOVERY_RANGE", raising=False)
    monkeypatch.setattr(runtime, "other_user_in_shared_memory", lambda: other)
    runtime.use_transports(shared_memory=True)
    assert Path(os.environ[PROFILES]).name == profile
    assert (RESOURCES / profile).exists()


@pytest.mark.parametrize("domain", ["233", "300", "0000000233", "9" * 5000])
def test_a_domain_that_does_not_exist_is_refused_before_fast_dds_ends_the_program(monkeypatch, domain):
    pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
    monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    with pytest.raises(SourceUnavailableError, match="domains have numbers from 0 to 232"):
        runtime.Ros2Node("nowhere")
