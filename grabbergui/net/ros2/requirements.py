"""Requirements of ROS 2 on this computer, and remedies where one is missing."""

from __future__ import annotations

import ctypes
import functools
import importlib
import logging
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

from grabbergui.core.environment import shell_command
from grabbergui.core.errors import SourceUnavailableError
from grabbergui.net.ros2 import shared_memory as memory

log = logging.getLogger(__name__)

_OR_SOURCE = "or source the system's setup.bash first"


def require_ros2() -> None:
    """Raise SourceUnavailableError, in one line, where rclpy or its middleware is missing, or would hang."""
    memory.require_unblocked()
    _require_middleware()
    try:
        import rclpy  # noqa: F401
    except ImportError as error:
        raise SourceUnavailableError(
            f"ROS 2 is not installed: run `{shell_command('setup', 'ros2')}`, {_OR_SOURCE} ({error})"
        ) from error


@functools.cache
def _require_middleware() -> None:
    """Raise SourceUnavailableError if RMW_IMPLEMENTATION is not installed; rcl would end this process."""
    wanted = os.environ.get("RMW_IMPLEMENTATION")
    if not wanted or "rclpy" in sys.modules:
        return
    probe = subprocess.run([sys.executable, "-c", "import rclpy"], capture_output=True, check=False)
    if probe.returncode and b"exiting with" in probe.stderr:
        raise SourceUnavailableError(
            f"ROS 2 cannot start: RMW_IMPLEMENTATION={wanted} is not installed with it; install it, or unset "
            "the variable"
        )


def require_packages(*modules: str) -> None:
    """Raise SourceUnavailableError, in one line, where rclpy or one of the modules is missing."""
    require_ros2()
    for module in modules:
        try:
            importlib.import_module(module)
        except ImportError as error:
            package = module.partition(".")[0]
            raise SourceUnavailableError(
                f"the ROS 2 package {package} is not installed: run "
                f"`{shell_command('setup', 'ros2')}` ({error})"
            ) from error


def require_interfaces() -> None:
    """Raise SourceUnavailableError, in one line, where our services' package is missing."""
    try:
        import grabber_interfaces.srv
    except ImportError as error:
        raise SourceUnavailableError(
            f"the package grabber_interfaces is not built: run `{shell_command('setup', 'ros2')}` ({error})"
        ) from error
    load_type_support(grabber_interfaces)


def load_type_support(package: ModuleType) -> None:
    """Load the libraries of an interface package, once, wherever it is installed."""
    _load_libraries(Path(str(package.__file__)))


@functools.cache
def _load_libraries(package: Path) -> None:
    """Load a package's libraries from `<prefix>/lib`.

    The middleware opens them by bare name, on the path of a sourced setup file. Our package may be installed
    in an environment that is not sourced; libraries that are already loaded are found by name.
    """
    libraries = package.parents[3].glob(f"lib{package.parent.name}__rosidl_typesupport_*_c.so")
    for library in sorted(libraries):
        try:
            ctypes.CDLL(str(library))
        except OSError as error:  # of a middleware that is not installed
            log.debug("%s: %s", library, error)
