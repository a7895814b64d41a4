"""Shared memory of killed ROS 2 programs is seen and cleared; that of living ones is left alone."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from grabbergui.core.shared_folder import MEMORY
from grabbergui.net.ros2.shared_memory import clear, leftovers
from patience import PROGRAM, until
from ros2_domain import own_domain


def names(found):
    return [leftover.name for leftover in found]


PROGRAM_TEXT = """
import sys, time
from grabbergui.net.ros2.runtime import Ros2Node
from sensor_msgs.msg import Image
ros = Ros2Node("leaves_memory")
ros.node.create_publisher(Image, "/left", 5)
ros.start()
print("ready", flush=True)
time.sleep(600)
"""


@pytest.mark.ros2
def test_a_killed_ros_program():
    """One of two programs is killed: what it left is found, and the other's memory is not."""
    pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
    programs = [
        subprocess.Popen(
            [sys.executable, "-c", PROGRAM_TEXT],
            env=os.environ | own_domain(),
            stdout=subprocess.PIPE,
            text=True,
        )
        for _ in range(2)
    ]
    killed, living = programs
    used = []
    try:
        for program in programs:
            assert program.stdout.readline().strip() == "ready"
        used = [until(lambda pid=program.pid: _used_by(pid)) for program in programs]
        modes = {name: (MEMORY / name).stat().st_mode & 0o777 for name in used[0]}
        assert set(modes.values()) == {0o600}, "images would be readable by all users"
        # The living program unmaps the memory that the killed one created some seconds later.
        kept = used[1] - _owned_by(killed.pid)
        assert _owned_by(living.pid) <= kept
        assert not used[0] & set(names(leftovers(MEMORY, youngest=0)))

        killed.send_signal(signal.SIGKILL)
        killed.wait(PROGRAM)

        left = [leftover for leftover in leftovers(MEMORY, youngest=0) if leftover.name in used[0] - used[1]]
        assert left and sum(leftover.size for leftover in left) > 0
        clear(left)
        assert not [path for leftover in left for path in leftover.files if path.exists()]
        assert kept <= _used_by(living.pid) and all((MEMORY / name).exists() for name in kept)
    finally:
        for program in programs:
            program.kill()
            program.wait(PROGRAM)
            program.stdout.close()
        mine = set().union(*used)
        clear([leftover for leftover in leftovers(MEMORY, youngest=0) if leftover.name in mine])


def _used_by(pid):
    """Names of the segments and ports in a process's memory."""
    lines = Path(f"/proc/{pid}/maps").read_text().splitlines()
    return {Path(line.split()[-1]).name for line in lines if "/dev/shm/fastdds_" in line}


def _owned_by(pid):
    """Names of the segments and ports that a process made: it holds their lock."""
    open_files = [file.resolve() for file in Path(f"/proc/{pid}/fd").iterdir()]
    return {file.name.removesuffix("_el") for file in open_files if file.name.startswith("fastdds_")}
