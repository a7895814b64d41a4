"""Checks of this machine's software: the window's display, YARP, ROS 2."""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Iterator, Mapping

from grabbergui.core.errors import GrabberError
from grabbergui.core.invocation import shell_command
from grabbergui.doctor.finding import Finding, good, note


def check() -> Iterator[Finding]:
    """All checks of this kind."""
    yield from display(os.environ, sys.platform)
    yield from yarp()
    yield from ros2()


def display(environment: Mapping[str, str], platform: str) -> Iterator[Finding]:
    """Where the window would appear."""
    if not platform.startswith("linux") or environment.get("DISPLAY") or environment.get("WAYLAND_DISPLAY"):
        yield good("there is a display for the window")
    else:
        yield note("there is no display", shell_command("gui", "--offscreen", "--screenshot", "window.png"))


def yarp() -> Iterator[Finding]:
    """The name server that YARP's configuration names."""
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
    """Whether rclpy can be imported."""
    if importlib.util.find_spec("rclpy") is None:
        yield note(
            "ROS 2 is not installed here",
            f"{shell_command('setup', 'ros2')}, or source the system's setup.bash first",
        )
    else:
        yield good("ROS 2 is installed")
