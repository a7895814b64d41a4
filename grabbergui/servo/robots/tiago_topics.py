"""The simulated TIAGo behind the ROS 2 topics that the real one has, for any client of them.

The head always has a joint trajectory controller. The arm has a node that takes twists, as MoveIt Servo does,
or with `stock` its joint trajectory controller, as PAL's robot has out of the box.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from grabbergui.calibration.geometry import Vector
from grabbergui.core.durations import duration_text
from grabbergui.core.errors import RemoteProtocolError, SourceUnavailableError
from grabbergui.net.ros2.camera_pose import publish_frame
from grabbergui.net.ros2.requirements import require_packages
from grabbergui.net.ros2.runtime import Ros2Node, steady_timer
from grabbergui.servo.robots import tiago
from grabbergui.servo.robots import tiago_messages as messages
from grabbergui.servo.robots.joint_readings import joint_state
from grabbergui.servo.robots.joint_trajectory import Trajectory, read_trajectory
from grabbergui.servo.robots.robot import ARM, HEAD
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.robots.tiago_ros2 import Topics

log = logging.getLogger(__name__)

UPDATE = 0.01
"Seconds between two updates of the controllers, as in PAL's configuration of the controller manager."
UPDATES_PER_STATE = 2
"Updates from one joint state to the next, 0.02 s as on the robot."


class Follower:
    """What a joint trajectory controller computes: checks trajectories, samples the newest. One thread."""

    def __init__(self, joints: Sequence[str], low: Vector, high: Vector) -> None:
        self.joints = tuple(joints)
        self._low, self._high = low, high
        self._times = np.zeros(0)
        self._points = np.zeros((0, len(low)))

    def accept(self, trajectory: Trajectory, angles: Vector, now: float) -> None:
        """Replace the trajectory in progress. `angles` are those measured `now`, on the robot's clock.

        Raises RemoteProtocolError, and the trajectory before goes on: for joints that are not exactly its
        own, no points, times that do not increase, an end in the past, angles that are not finite or beyond
        the limits.
        """
        if sorted(trajectory.joints) != sorted(self.joints):
            raise RemoteProtocolError(f"joints {list(trajectory.joints)}, not {list(self.joints)}")
        points, times = np.asarray(trajectory.points, np.float64), np.asarray(trajectory.times, np.float64)
        if not len(times) or points.shape != (len(times), len(self.joints)):
            raise RemoteProtocolError(f"{len(times)} times with positions of shape {points.shape}")
        if not (np.isfinite(points).all() and np.isfinite(times).all()):
            raise RemoteProtocolError("positions or times that are not finite")
        if times[0] < 0 or (np.diff(times) <= 0).any():
            raise RemoteProtocolError(f"times {times.tolist()} do not increase")
        start = now if trajectory.start is None else trajectory.start
        if start + times[-1] < now:
            raise RemoteProtocolError(f"it ended {duration_text(now - start - times[-1])} ago")
        points = points[:, [trajectory.joints.index(name) for name in self.joints]]
        beyond = (points < self._low - 1e-3) | (points > self._high + 1e-3)
        if beyond.any():
            row, joint = np.argwhere(beyond)[0]
            raise RemoteProtocolError(
                f"{self.joints[joint]} at {points[row, joint]:.3f} rad is beyond limits"
            )
        times = start + times
        if times[0] > now:
            times, points = np.insert(times, 0, now), np.vstack((angles, points))
        self._times, self._points = times, points

    def sample(self, now: float) -> Vector | None:
        """Return the desired angles; the last point's after the end, None where nothing was accepted."""
        if not len(self._times):
            return None
        columns = [np.interp(now, self._times, column) for column in self._points.T]
        return np.array(columns)


class TrajectoryTopic:
    """A joint trajectory controller on a topic. Runs on the node's thread."""

    def __init__(
        self,
        node: Any,
        topic: str,
        follower: Follower,
        angles: Callable[[], Vector],
        go: Callable[[Vector], None],
    ) -> None:
        """`angles` reads the joints, `go` sends them to a position; both with the robot's signs."""
        from trajectory_msgs.msg import JointTrajectory

        self.topic = topic
        self.active = True
        "Whether it has its joints; an inactive controller listens, but does nothing."
        self.refused: list[str] = []
        "Why trajectories were refused, the newest last."
        self._node, self._follower, self._angles, self._go = node, follower, angles, go
        node.create_subscription(JointTrajectory, topic, self._on_trajectory, 1)

    def update(self) -> None:
        """Send the joints where the trajectory in progress has them now."""
        desired = self._follower.sample(self._now())
        if self.active and desired is not None:
            self._go(desired)

    def _on_trajectory(self, message: Any) -> None:
        try:
            if not self.active:
                raise RemoteProtocolError("the controller is not active")
            self._follower.accept(read_trajectory(message), self._angles(), self._now())
        except RemoteProtocolError as error:
            self.refused = [*self.refused[-99:], str(error)]
            log.warning("%s: refused %s", self.topic, error)

    def _now(self) -> float:
        return float(self._node.get_clock().now().nanoseconds) * 1e-9


class TiagoTopics:
    """Controllers of head and hand, and the broadcaster of joint states, as one node."""

    def __init__(self, robot: SimRobot, topics: Topics | None = None, *, stock: bool = False) -> None:
        """Join the network. Raises SourceUnavailableError without ROS 2."""
        topics = topics or Topics()
        require_packages(*messages.PACKAGES)
        self._robot = robot
        self._topics = topics
        self._ros = Ros2Node("tiago")
        from sensor_msgs.msg import JointState

        node = self._ros.node
        self._states = node.create_publisher(JointState, topics.joint_states, 5)
        self.controllers = {HEAD: self._head_controller(node, topics.head)}
        if stock:
            self.controllers[ARM] = self._arm_controller(node, "/arm_controller/joint_trajectory")
            self.arm_topic = self.controllers[ARM].topic
        else:
            self._listen_to_twists(node, topics.arm)
            self.arm_topic = topics.arm
        self._obeys_twists = True
        "As from `start_servo` until `stop_servo` of MoveIt Servo (Humble)."
        self._updates = 0
        steady_timer(node, UPDATE, self._update)
        self._frames = self._publish_frames(node)

    def open(self) -> None:
        """Take commands and publish from now on."""
        self._ros.start()

    def close(self) -> None:
        """Stop the robot and leave the network. May be called twice; never raises."""
        self._ros.close()
        self._robot.stop()

    def _head_controller(self, node: Any, topic: str) -> TrajectoryTopic:
        head = self._robot.model.head
        low, high = np.sort((tiago.HEAD_SIGNS * head.low, tiago.HEAD_SIGNS * head.high), axis=0)

        def go(angles: Vector) -> None:
            self._robot.point_head(tiago.HEAD_SIGNS * angles, head.fastest)

        follower = Follower(tiago.HEAD_JOINTS, low, high)
        return TrajectoryTopic(node, topic, follower, lambda: tiago.HEAD_SIGNS * self._robot.truth().head, go)

    def _arm_controller(self, node: Any, topic: str) -> TrajectoryTopic:
        arm = self._robot.model.arm

        def angles() -> Vector:
            measured = self._robot.truth().arm
            assert measured is not None
            return measured

        follower = Follower(tiago.ARM_JOINTS, arm.low, arm.high)
        return TrajectoryTopic(node, topic, follower, angles, self._robot.point_arm)

    def _listen_to_twists(self, node: Any, topic: str) -> None:
        from geometry_msgs.msg import TwistStamped
        from std_srvs.srv import Trigger

        node.create_subscription(TwistStamped, topic, self._on_twist, 1)
        for service, on in (("start_servo", True), ("stop_servo", False)):
            node.create_service(
                Trigger, f"{topic.rpartition('/')[0]}/{service}", partial(self._switch_twists, on)
            )

    def _switch_twists(self, on: bool, _: Any, answer: Any) -> Any:
        self._obeys_twists = answer.success = True
        if not on:
            self._obeys_twists = False
            self._robot.move_hand(np.zeros(6))
        return answer

    def _update(self) -> None:
        for controller in self.controllers.values():
            controller.update()
        # Not on a timer of its own: in rclpy a timer takes as long as all of this.
        self._updates += 1
        if self._updates % UPDATES_PER_STATE == 0:
            self._publish_state()

    def _on_twist(self, message: Any) -> None:
        if not self._obeys_twists:
            return
        try:
            self._robot.move_hand(messages.read_twist(message))
        except RemoteProtocolError as error:
            log.warning("%s: refused %s", self._topics.arm, error)

    def _publish_state(self) -> None:
        if not self._robot.silent:
            stamp = self._ros.node.get_clock().now().to_msg()
            self._states.publish(joint_state(self._robot.state(), stamp))

    def _publish_frames(self, node: Any) -> Any:
        """Where the camera sits on the head, on `/tf_static`; the publisher, None without tf's messages."""
        try:
            return publish_frame(node, tiago.HEAD, self._topics.camera_frame, self._robot.model.camera)
        except SourceUnavailableError:
            return None
