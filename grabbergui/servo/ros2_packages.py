"""Which of ROS 2's message packages servoing needs, and what to do where one is missing."""

from __future__ import annotations

import importlib

from grabbergui.core.errors import SourceUnavailableError
from grabbergui.core.invocation import shell_command
from grabbergui.net.ros2.runtime import require_ros2

ROBOT = ("geometry_msgs.msg", "sensor_msgs.msg", "trajectory_msgs.msg")
PUBLISHER = ("diagnostic_msgs.msg", "geometry_msgs.msg", "std_msgs.msg", "std_srvs.srv")


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
