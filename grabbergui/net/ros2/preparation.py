"""Loads what takes most of a server's start: its modules and the type support of its messages."""

from __future__ import annotations

from importlib import import_module

from grabbergui.net.ros2.requirements import require_interfaces, require_ros2

MODULES = ("grabbergui.net.ros2.server", "rclpy.node", "rclpy.executors", "rclpy.lifecycle")
"What a node needs and rclpy imports only then."
MESSAGES = {
    "sensor_msgs.msg": ("Image", "CameraInfo", "CompressedImage"),
    "sensor_msgs.srv": ("SetCameraInfo",),
    "diagnostic_msgs.msg": ("DiagnosticArray",),
    "rcl_interfaces.msg": ("ParameterEvent", "Log"),
    "rcl_interfaces.srv": (
        "GetParameters", "GetParameterTypes", "SetParameters", "SetParametersAtomically", "ListParameters",
        "DescribeParameters",
    ),
    "rosgraph_msgs.msg": ("Clock",),
    "std_srvs.srv": ("Trigger", "SetBool"),
    "grabber_interfaces.srv": (
        "HasFeature", "GetFeature", "SetFeature", "GetFeatureRange", "SetMode", "Ask",
    ),
}  # fmt: skip
"Modules and the types in them."


def prepare() -> None:
    """Load them. Joins no network. Raises SourceUnavailableError without ROS 2."""
    require_ros2()
    require_interfaces()
    from rclpy.type_support import check_for_type_support

    for module in MODULES:
        import_module(module)
    for module, names in MESSAGES.items():
        for name in names:
            check_for_type_support(getattr(import_module(module), name))
