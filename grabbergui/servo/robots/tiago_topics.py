"""The simulated TIAGo behind the ROS 2 topics that the real one has, for any client of them."""

from __future__ import annotations

import logging
from typing import Any

from grabbergui.calibration.geometry import quaternion_from_rotation
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.net.ros2.runtime import Ros2Node
from grabbergui.servo.robots import tiago
from grabbergui.servo.robots import tiago_messages as messages
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.robots.tiago_ros2 import Topics
from grabbergui.servo.ros2_packages import ROBOT, require_packages

log = logging.getLogger(__name__)

PERIOD = 0.02
"Seconds between two joint states, as on the robot."


class TiagoTopics:
    """Controllers of head and hand, and the broadcaster of joint states, as one node."""

    def __init__(self, robot: SimRobot, topics: Topics | None = None, node_name: str = "tiago") -> None:
        """Join the network. Raises SourceUnavailableError without ROS 2."""
        topics = topics or Topics()
        require_packages(*ROBOT)
        self._robot = robot
        self._topics = topics
        self._ros = Ros2Node(node_name)
        from geometry_msgs.msg import TwistStamped
        from sensor_msgs.msg import JointState
        from trajectory_msgs.msg import JointTrajectory

        node = self._ros.node
        self._joint_state = JointState
        self._states = node.create_publisher(JointState, topics.joint_states, 5)
        node.create_subscription(JointTrajectory, topics.head, self._on_trajectory, 1)
        node.create_subscription(TwistStamped, topics.arm, self._on_twist, 1)
        node.create_timer(PERIOD, self._tell)
        self._frames = self._tell_frames(node)

    def open(self) -> None:
        """Obey and tell from now on."""
        self._ros.start()

    def close(self) -> None:
        """Stop the robot and leave the network. May be called twice; never raises."""
        self._ros.close()
        self._robot.stop()

    def _on_trajectory(self, message: Any) -> None:
        try:
            self._robot.aim_head(*messages.read_head_trajectory(message))
        except RemoteProtocolError as error:
            log.warning("%s: refused %s", self._topics.head, error)

    def _on_twist(self, message: Any) -> None:
        try:
            self._robot.move_hand(messages.read_twist(message))
        except RemoteProtocolError as error:
            log.warning("%s: refused %s", self._topics.arm, error)

    def _tell(self) -> None:
        state = self._robot.state()
        message = self._joint_state(name=[*tiago.HEAD_JOINTS, *tiago.ARM_JOINTS])
        message.header.stamp = self._ros.node.get_clock().now().to_msg()
        arm = () if state.arm is None else state.arm
        message.position = [float(angle) for angle in (*(tiago.HEAD_SIGNS * state.head), *arm)]
        self._states.publish(message)

    def _tell_frames(self, node: Any) -> Any:
        """Where the camera sits on the head, on `/tf_static`; the publisher, None without tf's messages."""
        try:
            from tf2_msgs.msg import TFMessage
        except ImportError:
            return None
        from geometry_msgs.msg import TransformStamped
        from rclpy.qos import DurabilityPolicy, QoSProfile

        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        publisher = node.create_publisher(TFMessage, "/tf_static", latched)
        camera = self._robot.model.camera
        entry = TransformStamped(child_frame_id=self._topics.camera_frame)
        entry.header.frame_id = tiago.HEAD
        entry.header.stamp = node.get_clock().now().to_msg()
        place, turn = entry.transform.translation, entry.transform.rotation
        place.x, place.y, place.z = map(float, camera[:3, 3])
        turn.x, turn.y, turn.z, turn.w = quaternion_from_rotation(camera[:3, :3])
        publisher.publish(TFMessage(transforms=[entry]))
        return publisher
