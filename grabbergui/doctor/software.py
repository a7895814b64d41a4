"""Checks of software: the display of the window, YARP, ROS 2, and the memory that ROS 2 left behind."""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from grabbergui.core.environment import shell_command
from grabbergui.core.errors import GrabberError
from grabbergui.doctor.findings import Finding, good, note, problem

if TYPE_CHECKING:
    pass


def check_software() -> Iterator[Finding]:
    """The display, YARP and ROS 2."""
    yield from display(os.environ, sys.platform)
    yield from yarp()
    yield from ros2()


def display(environment: Mapping[str, str], platform: str) -> Iterator[Finding]:
    """Check the display for the window."""
    if not platform.startswith("linux") or environment.get("DISPLAY") or environment.get("WAYLAND_DISPLAY"):
        yield good("there is a display for the window")
    else:
        yield note("there is no display", shell_command("gui", "--offscreen", "--screenshot", "window.png"))


def yarp() -> Iterator[Finding]:
    """Check the name server that YARP's configuration names."""
    from grabbergui.net.yarp.os.name_client import NameClient

    try:
        names = NameClient.find()
        ports = names.list()
    except GrabberError as error:
        yield note(f"no YARP network: {error}", f"{shell_command('yarp-server')} runs a name server")
    else:
        yield good(
            f"the YARP name server at {names.server.host}:{names.server.port} knows {len(ports)} ports"
        )


def ros2() -> Iterator[Finding]:
    """Check whether rclpy can be imported."""
    if importlib.util.find_spec("rclpy") is None:
        yield note(
            "ROS 2 is not installed here",
            f"{shell_command('setup', 'ros2')}, or source the system's setup.bash first",
        )
    else:
        yield good("ROS 2 is installed")


def shared_memory(folder: Path) -> Iterator[Finding]:
    """Report the memory that killed programs left behind, and files of others in the way of ROS 2."""
    from grabbergui.net.ros2 import shared_memory as ros2_memory

    found = ros2_memory.leftovers(folder)
    if found:
        yield note(
            f"killed ROS 2 programs left {ros2_memory.megabytes(found)} in {folder}: {len(found)} segments "
            "and ports of Fast DDS that no process uses",
            shell_command("doctor", "--clear-shared-memory"),
            partial(ros2_memory.clear, found),
        )
    elif folder.is_dir():
        yield good(f"no killed ROS 2 program left shared memory in {folder}")
    try:
        ros2_memory.require_unblocked(folder)
    except GrabberError as error:
        yield problem(str(error), "find out who put it there")
    if why := ros2_memory.irregular(folder):
        yield problem(f"ROS 2 programs hang here, or send by UDP: {why}", "find out who put it there")
