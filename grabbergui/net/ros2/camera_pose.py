"""Where a camera sits: its frame on /tf_static."""

from __future__ import annotations

from typing import Any

from grabbergui.calibration.geometry import Pose, quaternion_from_rotation
from grabbergui.core.errors import SourceUnavailableError
from grabbergui.net.ros2.requirements import require_ros2
from grabbergui.net.ros2.runtime import Ros2Node


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
    """Publish on `/tf_static` where `child` sits on `parent` (REP 105); return the publisher.

    Later subscribers need the publisher to live. Raises SourceUnavailableError without tf's messages.
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
    publisher = node.create_publisher(TFMessage, "/tf_static", latched)
    entry = TransformStamped(child_frame_id=child)
    entry.header.frame_id = parent
    entry.header.stamp = node.get_clock().now().to_msg()
    fill_pose(entry.transform.translation, entry.transform.rotation, placed)
    publisher.publish(TFMessage(transforms=[entry]))
    return publisher


def fill_pose(position: Any, orientation: Any, placed: Pose) -> None:
    """Write a pose into a message's position and quaternion."""
    position.x, position.y, position.z = map(float, placed[:3, 3])
    orientation.x, orientation.y, orientation.z, orientation.w = quaternion_from_rotation(placed[:3, :3])
