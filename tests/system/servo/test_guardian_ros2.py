"""The guardian over ROS 2: how far TIAGo's hand still moves when the servo program is killed or frozen."""

import os
import signal
import subprocess
import sys
from importlib import resources
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
pytest.importorskip("trajectory_msgs", reason="ros-trajectory-msgs is not installed: make setup-ros2")
pytest.importorskip("pinocchio", reason="Pinocchio is not installed: pip install '.[servo]'")
pytest.importorskip("example_robot_data", reason="no robot data: pip install '.[servo]'")
pytestmark = pytest.mark.ros2

from benchmarks.servo.servo_guardian import GOAL_MM, at_full_speed, moved_after, tiago_on_ros2  # noqa: E402
from grabbergui.net.ros2.runtime import use_transports  # noqa: E402
from patience import PROGRAM, TRIES, allowance  # noqa: E402

PROFILES = "FASTDDS_DEFAULT_PROFILES_FILE"
IN_SHARED_MEMORY = """
import os, sys  # noqa: E402
from grabbergui.core.errors import TransportError  # noqa: E402
from grabbergui.net.ros2.runtime import Ros2Node  # noqa: E402
from grabbergui.servo.robots.tiago_channel import TiagoChannel  # noqa: E402

channel = TiagoChannel("/joint_states", head="/head", arm="/arm")
if sys.argv[1] == "guardian":
    try:
        channel.prepare()
    except TransportError as error:
        assert "no controller subscribes" in str(error)
else:
    ros = Ros2Node("another")
with open("/proc/self/maps") as maps:
    print(sum("/dev/shm/fastdds" in line for line in maps))
channel.close() if sys.argv[1] == "guardian" else ros.close()
"""


@pytest.fixture
def simulated(domain):
    with tiago_on_ros2() as (robot, _):
        yield robot


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP], ids=["killed", "frozen"])
def test_tiago_s_hand_moves_less_than_30_mm_after_its_program_is(simulated, number):
    moved = []
    while not moved or moved[-1] >= GOAL_MM / 1000 * allowance():
        assert len(moved) < TRIES, f"the hand moved {moved} m"
        with at_full_speed(simulated, "tiago") as program:
            moved.append(moved_after(simulated, program.process.pid, number))


@pytest.mark.parametrize(("program", "uses"), [("guardian", False), ("another", True)])
def test_the_guardian_shares_no_memory_with_a_program_that_may_be_frozen(domain, program, uses):
    """Also where the servo program, which started it, has set the profile with shared memory."""
    done = subprocess.run(
        [sys.executable, "-c", IN_SHARED_MEMORY, program],
        env=os.environ | {PROFILES: profile()},
        capture_output=True,
        text=True,
        timeout=PROGRAM,
    )
    assert done.returncode == 0, done.stderr
    assert (int(done.stdout) > 0) == uses


def test_a_copy_of_our_profile_is_ours_and_any_other_is_the_user_s(monkeypatch, tmp_path):
    copy, other = tmp_path / "more-room.xml", tmp_path / "other.xml"
    copy.write_text(Path(profile()).read_text("utf-8").replace("67108864", "134217728"), "utf-8")
    other.write_text('<profiles><participant profile_name="lab"/></profiles>', "utf-8")
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    for chosen, used in ((copy, str(copy)), (other, str(other)), (None, profile())):
        monkeypatch.delenv(PROFILES, raising=False)
        if chosen is not None:
            monkeypatch.setenv(PROFILES, str(chosen))
        use_transports(shared_memory=True)
        assert os.environ[PROFILES] == used
    monkeypatch.setenv(PROFILES, str(other))
    use_transports(shared_memory=False)
    assert os.environ[PROFILES] == str(other)
    monkeypatch.setenv(PROFILES, str(copy))
    for _ in range(2):
        use_transports(shared_memory=False)
        assert Path(os.environ[PROFILES]).name == "fastdds-loopback.xml"


def profile():
    return str(resources.files("grabbergui.resources") / "ros2" / "fastdds.xml")
