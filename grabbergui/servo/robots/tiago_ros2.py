"""TIAGo on a ROS 2 network: head and arm behind their controllers."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from typing_extensions import override

from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.core.errors import (
    RemoteProtocolError,
    SourceNotFoundError,
    SourceUnavailableError,
    TransportError,
)
from grabbergui.net.ros2.requirements import require_packages
from grabbergui.net.ros2.runtime import Ros2Node
from grabbergui.servo.robots import tiago
from grabbergui.servo.robots import tiago_messages as messages
from grabbergui.servo.robots.joint_readings import JointReadings
from grabbergui.servo.robots.joint_trajectory import stamp_of
from grabbergui.servo.robots.robot import ARM, HEAD, KinematicModel, Robot, RobotState
from grabbergui.servo.robots.static_frames import StaticFrames
from grabbergui.servo.robots.tiago_choice import ACTIVE, TWISTS, Choice, choose, stock_topics
from grabbergui.servo.robots.tiago_messages import CommandKind, Drive
from grabbergui.servo.robots.tiago_nodes import NODE, ControllerManager, OtherPrograms, ServoNode
from grabbergui.servo.robots.tiago_parts import HOLD_S, DrivenPart

log = logging.getLogger(__name__)

FRESH_S = 0.15
"Age up to which a reading counts as a part's present position, seconds."
GUARDIAN_FRESH_S = 0.5
"The same for the guardian, which knows no commands and stops a part by sending it to its reading."
STEP_SPEED = np.radians(25)
"Speed of relative moves of the head, rad/s."
SETTLE_S = 5.0
"""Seconds to wait for the second part's controller once the robot has answered.

Fast DDS repeats an announcement that was lost after 3 s (the heartbeats of its discovery)."""
LIST_S = 1.0
"""Seconds to wait for the controller manager's list. Without a manager any subscriber counts as a controller.

A stock robot's manager is discovered before its controllers, whose process it shares."""
JOINTS = {HEAD: tiago.HEAD_JOINTS, ARM: tiago.ARM_JOINTS}


@dataclass(frozen=True)
class Topics:
    """Names of a TIAGo's topics."""

    head: str = "/head_controller/joint_trajectory"
    "Any other name is used regardless of the controller manager's list."
    arm: str = TWISTS
    "`geometry_msgs/TwistStamped`, preferred if it has a subscriber; the default is MoveIt Servo's."
    joint_states: str = "/joint_states"
    camera_frame: str = tiago.CAMERA
    "The frame of the images; its place on the head is that of tf, else the URDF's."


class TiagoOverRos2(Robot):
    """A TIAGo, real or simulated. Readings arrive on the node's thread."""

    def __init__(
        self,
        model: KinematicModel,
        topics: Topics | None = None,
        timeout: float = 15.0,
        *,
        listen_only: bool = False,
    ) -> None:
        """`timeout` is for the first reading, seconds. With `listen_only` it creates no publisher."""
        super().__init__(model)
        self._topics = topics or Topics()
        self._timeout = timeout
        self._listen_only = listen_only
        self._ros: Ros2Node | None = None
        self._manager: ControllerManager | None = None
        self._others: OtherPrograms | None = None
        self._servo: ServoNode | None = None
        self._stopped = False
        "Whether a stop was the last command."
        self._warned = ""
        "The last warning of strangers."
        self._drives: dict[str, Drive] = {}
        self._driven: dict[str, DrivenPart] = {}
        self._readings = JointReadings((*tiago.HEAD_JOINTS, *tiago.ARM_JOINTS))
        self._frames = StaticFrames()
        self._state: RobotState | None = None
        self._complaint = ""
        self.summary = ""
        "How each part is driven, in one line; empty before `connect`."

    def connect(self) -> None:
        """Join the network, await joint states and choose the controllers; command nothing.

        Raises SourceNotFoundError if no joint states arrive or no controller can be driven,
        SourceUnavailableError if another servo program drives them.
        """
        require_packages(*messages.PACKAGES)
        from sensor_msgs.msg import JointState

        self._ros = Ros2Node(f"{NODE}{time.time_ns() % 10**9}")
        node = self._ros.node
        self._others = None if self._listen_only else OtherPrograms(self._ros, self.name)
        self._manager = ControllerManager(node)
        node.create_subscription(JointState, self._topics.joint_states, self._on_joint_state, 5)
        self._listen_to_frames(node)
        self._ros.start()
        try:
            self._await_readings()
            self._choose_drives()
        except BaseException:
            self.close()
            raise

    def open(self) -> None:
        """Connect unless connected, and prepare the controllers. Raises as `connect` does."""
        if self._ros is None:
            self.connect()
        try:
            self._refuse_if_commanded()  # again: two programs may start at once
        except SourceUnavailableError:
            self._driven = {}  # the other program's, which a stop from here would disturb
            self.close()
            raise
        if self._others is not None:
            self._others.watch(self._pause_servo)
        arm = self._drives.get(ARM)
        if (
            arm is not None
            and arm.kind is CommandKind.TWIST
            and not self._listen_only
            and self._ros is not None
        ):
            self._servo = ServoNode(self._ros, arm.topic)
            self._servo.start()

    @override
    def close(self) -> None:
        if self._ros is not None:
            self.stop()
            self._driven, self._others, self._servo = {}, None, None
            self._ros.close()
            self._ros = None

    @property
    @override
    def parts(self) -> frozenset[str]:
        return frozenset(self._drives) if self._drives else super().parts

    def state(self) -> RobotState | None:
        """Return the newest reading, as old as its oldest joint's."""
        return self._state

    def move_head(self, velocity: Vector) -> None:
        """Move pan and tilt from the reference on, at rad/s; the motion ends after `COMMAND_TIMEOUT`."""
        state = self._known()
        part = self._part(HEAD)
        if part is not None:
            self._stream(part, tiago.HEAD_SIGNS * velocity, tiago.HEAD_SIGNS * state.head)

    @override
    def step_head(self, move: Vector) -> None:
        state = self._known()
        part = self._part(HEAD)
        if part is not None:
            target = self.model.head.clamped(state.head + move)
            part.go_to(tiago.HEAD_SIGNS * target, max(float(np.abs(move).max() / STEP_SPEED), HOLD_S))

    def move_hand(self, twist: Vector) -> None:
        """Send a twist, or the joint velocities that come nearest to it."""
        part = self._part(ARM)
        if part is None:
            return
        if part.drive.kind is CommandKind.TWIST:
            self._stopped = False
            if self._servo is not None and self._servo.paused:
                self._servo.start()
            part.move_hand(twist, self._stamp())
            return
        state = self._known()
        assert state.arm is not None
        self._stream(part, self.model.arm.velocities_for(state.arm, twist), state.arm)

    def stop(self) -> bool:
        """Bring every part to rest where it is.

        While other nodes publish commands, MoveIt Servo is paused, too: it would obey the next of theirs.
        """
        state, now = self._state, time.monotonic()
        delivered = True
        self._stopped = True
        self._pause_servo()
        for name in (ARM, HEAD):
            part = self._driven.get(name)
            if part is None:
                continue
            try:
                angles = None if state is None else _angles(state, name)
                # A part has left the place of an old reading and reached its newest target.
                fresh = state is not None and (now - state.time < FRESH_S or part.target is None)
                part.stop(angles if fresh else None, self._stamp())
            except Exception as error:  # rclpy has no common ancestor of what publishing may raise
                log.error("%s could not be stopped: %s", self.name, error)
                delivered = False
        return delivered

    def _pause_servo(self) -> None:
        """Pause MoveIt Servo if the robot is stopped and other nodes command it; they may join later."""
        if not self._stopped or self._servo is None or self._servo.paused or self._others is None:
            return
        strangers = ", ".join(sorted(self._others.strangers))
        if not strangers:
            return
        how = "MoveIt Servo is paused" if self._servo.pause() else "end them: a stop here does not stop them"
        text = f"{self.name} is commanded by {strangers}, too: {how}"
        if text != self._warned or self._servo.paused:
            log.warning("%s", text)
        self._warned = text

    @override
    def stop_channels(self) -> list[dict[str, str]]:
        drives = self._drives or {
            HEAD: Drive(CommandKind.TRAJECTORY, self._topics.head),
            ARM: Drive(CommandKind.TWIST, self._topics.arm),
        }
        channel = {"kind": "tiago", "joint_states": self._topics.joint_states}
        for name, drive in drives.items():
            channel |= {name: drive.topic, f"{name}_kind": drive.kind.value}
        return [channel]

    def _known(self) -> RobotState:
        if self._state is None:
            raise TransportError(f"{self.name} has not reported the positions of its joints")
        return self._state

    def _part(self, name: str) -> DrivenPart | None:
        """Return the part, or None if it is not driven. Raises TransportError if it may not move."""
        if self._ros is None:
            raise TransportError(f"{self.name} is not open")
        if self._others is not None:
            self._others.require_none()
        part = self._driven.get(name)
        if part is not None and part.drive.controller and self._manager is not None:
            state = self._manager.state_of(part.drive.controller)
            if state not in (ACTIVE, None):
                raise TransportError(f"{part.drive.controller} is {state}: activate it on the robot")
        return part

    def _stream(self, part: DrivenPart, velocity: Vector, measured: Vector) -> None:
        now = time.monotonic()
        part.move(velocity, measured, now, self._readings.robot_time(now))

    def _stamp(self) -> Any:
        """Return the time on the robot's clock if it is known: MoveIt Servo ignores old twists."""
        if self._ros is None:
            raise TransportError(f"{self.name} is not open")
        seconds = self._readings.robot_time(time.monotonic())
        return stamp_of(seconds) if seconds else self._ros.node.get_clock().now().to_msg()

    def _choose_drives(self) -> None:
        """Wait for a controller of each part for `SETTLE_S`; one part is enough."""
        deadline = time.monotonic() + min(self._timeout, SETTLE_S)
        assert self._manager is not None
        if self._manager.can_ask:  # an inactive controller subscribes, too
            self._wait_until(lambda: self._manager is None or self._manager.listed() is not None, LIST_S)
        while True:
            awaited = self._manager.awaited
            choices = self._choices()
            complete = all(choice.drive for choice in choices.values())
            if (complete and not awaited) or time.monotonic() > deadline:
                break
            time.sleep(0.05)
        self._drives = {name: choice.drive for name, choice in choices.items() if choice.drive is not None}
        if not self._drives:
            reasons = "; ".join(f"{name}: {choice.reason}" for name, choice in choices.items())
            raise SourceNotFoundError(f"no part of {self.name} can be driven; {reasons}")
        self.summary = f"{self.name}: " + ", ".join(f"{name} {choice}" for name, choice in choices.items())
        log.info("%s", self.summary)
        if self._listen_only or self._ros is None:
            return
        node = self._ros.node
        self._refuse_if_commanded()
        self._driven = {name: part_for(node, name, drive, self.model) for name, drive in self._drives.items()}
        self._wait_until(lambda: all(part.heard for part in self._driven.values()), SETTLE_S)

    def _refuse_if_commanded(self) -> None:
        if self._others is not None:
            self._others.refuse([drive.topic for drive in self._drives.values()])

    def _choices(self) -> dict[str, Choice]:
        assert self._ros is not None and self._manager is not None
        node, listed = self._ros.node, self._manager.listed()
        topics = [self._topics.arm, *stock_topics(JOINTS)]
        listeners = {topic: node.count_subscribers(topic) for topic in topics}
        choices = {
            name: choose(name, joints, listed, listeners, self._topics.arm if name == ARM else "")
            for name, joints in JOINTS.items()
        }
        if self._topics.head != Topics.head:
            choices[HEAD] = Choice(Drive(CommandKind.TRAJECTORY, self._topics.head))
        return choices

    def _wait_until(self, condition: Callable[[], bool], seconds: float) -> bool:
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline:
                return False
            time.sleep(0.02)
        return True

    def _on_joint_state(self, message: Any) -> None:
        try:
            # The robot's clock may differ, so a reading's time is its arrival.
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
        if not self._wait_until(lambda: self._state is not None, self._timeout):
            raise SourceNotFoundError(self._what_is_missing())

    def _what_is_missing(self) -> str:
        missing = self._readings.missing()
        if len(missing) == len(tiago.HEAD_JOINTS) + len(tiago.ARM_JOINTS):
            topic = self._topics.joint_states
            return f"no node publishes TIAGo's joints on {topic}; check the topics and ROS_DOMAIN_ID"
        return f"{self._topics.joint_states} does not contain {', '.join(missing)}"

    def _listen_to_frames(self, node: Any) -> None:
        """Subscribe to `/tf_static`: on this robot the camera's place may differ from the URDF's."""
        try:
            from tf2_msgs.msg import TFMessage
        except ImportError:
            log.info("tf2_msgs is not installed: the camera's place is the URDF's")
            return
        from rclpy.qos import DurabilityPolicy, QoSProfile

        latched = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        node.create_subscription(TFMessage, "/tf_static", self._on_frames, latched)

    def _on_frames(self, message: Any) -> None:
        self._frames.take(message)
        place: Pose | None = self._frames.of(self._topics.camera_frame, tiago.HEAD)
        if place is not None:
            self.model = replace(self.model, camera=place)


def part_for(node: Any, name: str, drive: Drive, model: KinematicModel) -> DrivenPart:
    """Return the publisher of one part, with its limits in the robot's signs."""
    if name == ARM:
        return DrivenPart(node, drive, tiago.ARM_JOINTS, model.arm.low, model.arm.high)
    low, high = tiago.HEAD_SIGNS * model.head.low, tiago.HEAD_SIGNS * model.head.high
    return DrivenPart(node, drive, tiago.HEAD_JOINTS, np.minimum(low, high), np.maximum(low, high))


def _angles(state: RobotState, name: str) -> Vector | None:
    """Return a part's angles with the robot's signs."""
    return tiago.HEAD_SIGNS * state.head if name == HEAD else state.arm
