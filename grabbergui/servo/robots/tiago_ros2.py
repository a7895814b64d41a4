"""TIAGo on a ROS 2 network: its head takes joint trajectories, its hand twists; it tells joint states."""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.core.errors import RemoteProtocolError, SourceNotFoundError, TransportError
from grabbergui.net.ros2.runtime import Ros2Node
from grabbergui.servo.robots import tiago
from grabbergui.servo.robots import tiago_messages as messages
from grabbergui.servo.robots.robot import KinematicModel, Robot, RobotState
from grabbergui.servo.ros2_packages import ROBOT, require_packages

log = logging.getLogger(__name__)

FRESH_S = 0.15
"Age of a reading up to which the head is where it says."
HOLD_S = 0.05
"Seconds in which a head that is to hold its place settles there."
STEP_SPEED = np.radians(25)
"Of relative moves of the head."


@dataclass(frozen=True)
class Topics:
    """Where a TIAGo listens and tells."""

    head: str = "/head_controller/joint_trajectory"
    arm: str = "/servo_node/delta_twist_cmds"
    "`geometry_msgs/TwistStamped`; the default is MoveIt Servo's."
    joint_states: str = "/joint_states"
    camera_frame: str = tiago.CAMERA
    "The frame that pictures are taken in; where tf tells its place on the head, that is believed."


class TiagoOverRos2(Robot):
    """A TIAGo, real or simulated. Readings arrive on the node's thread."""

    def __init__(self, model: KinematicModel, topics: Topics | None = None, timeout: float = 15.0) -> None:
        """`timeout` is for the first reading, seconds."""
        super().__init__(model)
        self._topics = topics or Topics()
        self._timeout = timeout
        self._ros: Ros2Node | None = None
        self._head: Any = None
        self._arm: Any = None
        self._readings = messages.JointReadings((*tiago.HEAD_JOINTS, *tiago.ARM_JOINTS))
        self._frames = messages.StaticFrames()
        self._state: RobotState | None = None
        self._held = np.full(2, np.nan)
        "Where axes of the head rest that are not to move."
        self._target = np.full(2, np.nan)
        "Of the newest trajectory."
        self._complaint = ""

    def open(self) -> None:
        """See Robot. Raises SourceNotFoundError where no joint states come."""
        require_packages(*ROBOT)
        from geometry_msgs.msg import TwistStamped
        from sensor_msgs.msg import JointState
        from trajectory_msgs.msg import JointTrajectory

        self._ros = Ros2Node(f"grabbergui_servo_{time.time_ns() % 10**9}")
        node = self._ros.node
        self._head = node.create_publisher(JointTrajectory, self._topics.head, 1)
        self._arm = node.create_publisher(TwistStamped, self._topics.arm, 1)
        node.create_subscription(JointState, self._topics.joint_states, self._on_joint_state, 5)
        self._listen_to_frames(node)
        self._ros.start()
        try:
            self._await_readings()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """See Robot."""
        if self._ros is not None:
            self.stop()
            self._head = self._arm = None
            self._ros.close()
            self._ros = None

    def state(self) -> RobotState | None:
        """See Robot; as old as the oldest joint's reading."""
        return self._state

    def move_head(self, velocity: Vector) -> None:
        """See Robot. A target as far ahead as the velocity leads until it would expire, then it rests."""
        state = self._known()
        resting = velocity == 0
        self._held = np.where(resting & np.isnan(self._held), state.head, self._held)
        self._held = np.where(resting, self._held, np.nan)
        ahead = state.head + velocity * self.COMMAND_TIMEOUT
        self._aim(np.where(resting, self._held, ahead), self.COMMAND_TIMEOUT)

    def step_head(self, move: Vector) -> None:
        """See Robot."""
        self._held = np.full(2, np.nan)
        seconds = float(np.abs(move).max() / STEP_SPEED)
        self._aim(self._known().head + move, max(seconds, HOLD_S))

    def move_hand(self, twist: Vector) -> None:
        """See Robot."""
        self._publish(self._arm, messages.twist_stamped(twist, self._now()))

    def stop(self) -> bool:
        """See Robot. The hand is told to rest, the head to hold its place."""
        state = self._state
        self._held = np.full(2, np.nan)
        try:
            if self._arm is not None:
                self._arm.publish(messages.twist_stamped(np.zeros(6), self._now()))
            if self._head is not None and state is not None:
                # An old reading is not where the head is: by then it has come to its newest target.
                fresh = time.monotonic() - state.time < FRESH_S or np.isnan(self._target).any()
                self._head.publish(messages.head_trajectory(state.head if fresh else self._target, HOLD_S))
        except Exception as error:  # rclpy has no common ancestor of what publishing may raise
            log.error("%s could not be told to stop: %s", self.name, error)
            return False
        return True

    def stop_channels(self) -> list[dict[str, str]]:
        """See Robot."""
        topics = self._topics
        return [
            {"kind": "tiago", "head": topics.head, "arm": topics.arm, "joint_states": topics.joint_states}
        ]

    # -- commands ------------------------------------------------------------------------------------
    def _known(self) -> RobotState:
        if self._state is None:
            raise TransportError(f"{self.name} has not told where its joints are")
        return self._state

    def _aim(self, target: Vector, seconds: float) -> None:
        self._target = self.model.head.clamped(target)
        self._publish(self._head, messages.head_trajectory(self._target, seconds))

    def _publish(self, publisher: Any, message: Any) -> None:
        if publisher is None:
            raise TransportError(f"{self.name} is not open")
        if not publisher.get_subscription_count():
            raise TransportError(f"nobody listens to {publisher.topic_name}; is the controller running?")
        publisher.publish(message)

    def _now(self) -> Any:
        if self._ros is None:
            raise TransportError(f"{self.name} is not open")
        return self._ros.node.get_clock().now().to_msg()

    # -- readings ------------------------------------------------------------------------------------
    def _on_joint_state(self, message: Any) -> None:
        try:
            # The robot's clock may be another; a reading is as old as its arrival.
            self._readings.take(message, time.monotonic())
        except RemoteProtocolError as error:
            if str(error) != self._complaint:
                self._complaint = str(error)
                log.warning("%s: %s", self._topics.joint_states, error)
            return
        head = self._readings.angles(tiago.HEAD_JOINTS)
        arm = self._readings.angles(tiago.ARM_JOINTS)
        if head is not None and arm is not None:
            hand = self.model.arm.forward(arm[1])
            self._state = RobotState(min(head[0], arm[0]), tiago.HEAD_SIGNS * head[1], hand, arm[1])

    def _await_readings(self) -> None:
        deadline = time.monotonic() + self._timeout
        while self._state is None or not self._heard():
            if time.monotonic() > deadline:
                raise SourceNotFoundError(self._what_is_missing())
            time.sleep(0.02)

    def _heard(self) -> bool:
        return bool(self._head.get_subscription_count() and self._arm.get_subscription_count())

    def _what_is_missing(self) -> str:
        missing = self._readings.missing()
        advice = "; check the topics and ROS_DOMAIN_ID"
        if len(missing) == len(tiago.HEAD_JOINTS) + len(tiago.ARM_JOINTS):
            return f"nobody tells of TIAGo's joints at {self._topics.joint_states}{advice}"
        if missing:
            return f"{self._topics.joint_states} tells nothing of {', '.join(missing)}"
        deaf = [port.topic_name for port in (self._head, self._arm) if not port.get_subscription_count()]
        return f"nobody listens to {' and '.join(deaf)}{advice}"

    # -- tf ------------------------------------------------------------------------------------------
    def _listen_to_frames(self, node: Any) -> None:
        """The camera may sit elsewhere on this robot's head than on the one the URDF is of."""
        try:
            from tf2_msgs.msg import TFMessage
        except ImportError:
            log.info("tf2_msgs is not installed: the camera is taken to be where the URDF has it")
            return
        from rclpy.qos import DurabilityPolicy, QoSProfile

        latched = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        node.create_subscription(TFMessage, "/tf_static", self._on_frames, latched)

    def _on_frames(self, message: Any) -> None:
        self._frames.take(message)
        place: Pose | None = self._frames.of(self._topics.camera_frame, tiago.HEAD)
        if place is not None:
            self.model = replace(self.model, camera=place)
