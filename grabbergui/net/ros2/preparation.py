"""Loads what takes most of a server's start: its modules and the type support of its messages."""

from __future__ import annotations

from importlib import import_module

from grabbergui.net.ros2.requirements import require_ros2

MESSAGES = {
    "sensor_msgs.msg": ("Image", "CameraInfo", "CompressedImage"),
    "sensor_msgs.srv": ("SetCameraInfo",),
    "diagnostic_msgs.msg": ("DiagnosticArray",),
    "rcl_interfaces.msg": ("ParameterEvent", "Log"),
    "rcl_interfaces.srv": ("GetParameters", "SetParameters", "ListParameters", "DescribeParameters"),
    "std_srvs.srv": ("Trigger", "SetBool"),
}
"Modules and the types in them."


def prepare() -> None:
    """Load them. Joins no network. Raises SourceUnavailableError without ROS 2."""
    require_ros2()
    from rclpy.type_support import check_for_type_support

    import_module("grabbergui.net.ros2.server")
    for module, names in MESSAGES.items():
        for name in names:
            check_for_type_support(getattr(import_module(module), name))
