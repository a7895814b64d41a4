"""Servoing on ROS 2: the message packages that it needs, and frames that never move against each other.

Those frames are on `/tf_static` (REP 105, tf2's static broadcaster).
"""

from __future__ import annotations

import importlib
from typing import Any

from grabbergui.calibration.geometry import Pose, quaternion_from_rotation
from grabbergui.core.environment import shell_command
from grabbergui.core.errors import SourceUnavailableError
from grabbergui.net.ros2.runtime import Ros2Node, require_ros2

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


TOPIC = "/tf_static"


class StaticFrame:
    """Publishes where one frame sits on another, until it is closed. `open` and `close` from one thread."""

    def __init__(self, parent: str, child: str, placed: Pose) -> None:
        self._parent, self._child, self._placed = parent, child, placed
        self._ros: Ros2Node | None = None
        self._publisher: Any = None

    def open(self) -> None:
        """Publish it. Raises SourceUnavailableError without ROS 2 or tf's messages."""
        require_ros2()
        self._ros = Ros2Node("static_frame", "/grabbergui")
        try:
            self._publisher = publish_frame(self._ros.node, self._parent, self._child, self._placed)
        except BaseException:
            self.close()
            raise
        self._ros.start()

    def close(self) -> None:
        """Leave the network. May be called twice; never raises."""
        ros, self._ros = self._ros, None
        if ros is not None:
            ros.close()


def publish_frame(node: Any, parent: str, child: str, placed: Pose) -> Any:
    """Publish where `child` sits on `parent`; return the publisher, which later subscribers need to live.

    Raises SourceUnavailableError without tf's messages.
    """
    try:
        from tf2_msgs.msg import TFMessage
    except ImportError as error:
        raise SourceUnavailableError(
            f"the ROS 2 package tf2_msgs is not installed: source the system's setup.bash first ({error})"
        ) from error
    from geometry_msgs.msg import TransformStamped
    from rclpy.qos import DurabilityPolicy, QoSProfile

    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher = node.create_publisher(TFMessage, TOPIC, latched)
    entry = TransformStamped(child_frame_id=child)
    entry.header.frame_id = parent
    entry.header.stamp = node.get_clock().now().to_msg()
    place, turn = entry.transform.translation, entry.transform.rotation
    place.x, place.y, place.z = map(float, placed[:3, 3])
    turn.x, turn.y, turn.z, turn.w = quaternion_from_rotation(placed[:3, :3])
    publisher.publish(TFMessage(transforms=[entry]))
    return publisher
