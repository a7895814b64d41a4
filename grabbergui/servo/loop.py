"""The servo loop: detections and the robot's state in, a command out, once a control cycle. No I/O."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from grabbergui.calibration.geometry import Pose, Vector, diff, pose
from grabbergui.servo.config import Config
from grabbergui.servo.control import ArmController, HeadController
from grabbergui.servo.detection import Sighting
from grabbergui.servo.gate import Command
from grabbergui.servo.own_motion import SLOWEST, Nod, OwnMotionWatch
from grabbergui.servo.progress_watch import ProgressWatch
from grabbergui.servo.robots.robot import ARM, HEAD, JointHistory, Robot, RobotState
from grabbergui.servo.state_machine import Situation, State, StateMachine
from grabbergui.servo.target_motion import TargetMotion
from grabbergui.servo.tracking import FaceTrack, MarkerTrack

RESPONSE_S = 0.04
"Seconds that drives take to follow a command: the loop sends the velocity that the marker will have by then."
FOLLOWED_M = 0.04
"Metres from a moving goal within which the hand starts to follow it; it stops to follow at twice as many."
RARE_S = 2.0
"Seconds between two images beyond which the camera has paused; below, they come too rarely to be used."
LATE_S = 5.0
"Seconds after a late image in which a missing one counts as late, too."


@dataclass(frozen=True, eq=False)
class ControlCycle:
    """The outcome of one control cycle, for plots, overlays and the network."""

    time: float
    state: State
    reason: str
    command: Command
    off_centre: tuple[float, float]
    "Angles of the head's target from the centre, to the right and down, in radians; NaN without a target."
    error: tuple[float, float]
    "Metres and radians from the hand to its goal; NaN without a marker."
    robot: RobotState | None
    began: float | None = None
    "The time of the loop's first cycle; None: this one."

    @property
    def elapsed(self) -> float:
        """Seconds since the loop's first cycle: the one clock of console, window and report."""
        return 0.0 if self.began is None else self.time - self.began


@dataclass(frozen=True, eq=False)
class Moment:
    """A control cycle and the loop's knowledge at its end, for display. Poses and points are in the base."""

    cycle: ControlCycle
    sighting: Sighting | None = None
    marker: Pose | None = None
    goal: Pose | None = None
    "The hand's goal for this marker."
    person: Vector | None = None


class ServoLoop:
    """Joins tracks, controllers and the state machine. Use from one thread."""

    def __init__(self, config: Config, robot: Robot, *, dry_run: bool = False) -> None:
        """A dry run does not judge the hand's progress, as nothing moves.

        The loop reads the robot's model, camera pose and parts, and commands nothing.
        """
        self._dry_run = dry_run
        self._held_back = ""
        self._late, self._lateness = -np.inf, ""
        "When an image last came too late, and by how much, as display text."
        self.config = config
        self.machine = StateMachine(config.track.grace, config.safety.search_after)
        self.marker = MarkerTrack(config.marker.target, config.track)
        self.person = FaceTrack(config.track)
        self.head = HeadController(config.head, robot.model.head.low, robot.model.head.high)
        self.arm = ArmController(config.arm, config.marker.standoff)
        self.own_motion = OwnMotionWatch(
            config.safety.image_timeout, config.safety.image_timeout + config.track.grace
        )
        "Whether the images show the head's motion in time."
        self._nod = Nod(robot.model.head.low, robot.model.head.high)
        self.sighting: Sighting | None = None
        "The detections in the newest image."
        self.no_image = ""
        "Why the newest image does not count, as display text; empty if it does."
        self.motion = TargetMotion()
        "The marker's motion, in the robot's base."
        self._camera_pose = robot.camera_pose
        self._parts = robot.parts
        self._silence = robot.silence
        self._history = JointHistory()
        self._progress = ProgressWatch(config.safety.stuck)
        self._stuck = ""
        self._hindrance = robot.model.arm.hindrance
        self._pending: Sighting | None = None
        self._before = -np.inf
        "When the image before the newest one was exposed."
        self._last = 0.0
        self._began: float | None = None
        "The time of the first cycle."

    def tune(self, config: Config) -> None:
        """Change gains and limits of head, arm and loop; detection and safety stay as they were."""
        self.config = replace(self.config, head=config.head, arm=config.arm, loop=config.loop)
        self.head.tune(config.head)
        self.arm.tune(config.arm)

    def see(self, sighting: Sighting) -> None:
        """Use an image's detections in the next cycle; ignore an image that is not newer than the last."""
        if self.sighting is None or sighting.captured > self.sighting.captured:
            self._before = -np.inf if self.sighting is None else self.sighting.captured
            self.sighting = self._pending = sighting

    def cycle(self, now: float, robot: RobotState | None) -> ControlCycle:
        """Run one control cycle. `now` only grows; `robot` is the newest reading, whatever its age."""
        safety = self.config.safety
        seconds = min(max(now - self._last, 0.0), 0.1)
        self._last = now
        self._began = now if self._began is None else self._began
        sound = robot is not None and robot.sound
        if robot is not None and sound:
            self._history.add(robot.time, robot.head)
            self.own_motion.look(robot.time, self._camera_pose(robot.head))
        fresh_robot = sound and robot is not None and now - robot.time <= safety.robot_timeout
        captured = self.sighting.captured if self.sighting is not None else -np.inf
        fresh = -0.01 <= now - captured <= safety.image_timeout
        if self._pending is not None and (lateness := self._lateness_of(now, captured)):
            self._late, self._lateness = now, lateness
        self._update_tracks()
        marker = self._marker_at(now)
        target = self._target(marker)
        if not fresh or not fresh_robot or robot is None:
            target = marker = None
        self._measure(target, marker, robot)
        self._judge_progress(now, marker, robot)
        state = self.machine.step(
            now,
            Situation(
                images=bool(fresh),
                robot=fresh_robot,
                target=target is not None,
                centred=target is not None and robot is not None and self._centred(robot),
                marker=marker is not None and self._reachable(marker),
                old=self._old(),
                arrived=marker is not None and self.arm.arrived,
                settled=self.arm.settled,
                following=marker is not None and self._follows(),
                stuck=self._stuck,
                problem=self._problem(now, bool(fresh), robot, sound, fresh_robot),
            ),
        )
        command = Command(halt=True)
        if robot is not None and fresh and fresh_robot and state.head_moves:
            until = captured + safety.image_timeout + 1 / self.config.loop.rate
            command = replace(self._command(state, target, marker, robot, now, seconds), until=until)
        if not np.any(command.hand):
            self.arm.rest()
        right, down = map(float, self.head.offset) if target is not None else (np.nan, np.nan)
        error = self.arm.error if marker is not None else (np.nan, np.nan)
        reason = f"{self.machine.reason} (dry run: nothing is sent)" if self._dry_run else self.machine.reason
        return ControlCycle(now, state, reason, command, (right, down), error, robot, self._began)

    def moment(self, cycle: ControlCycle) -> Moment:
        """Return the loop's knowledge at the end of the newest cycle. On the loop's thread."""
        marker = self.marker.pose
        goal = None if marker is None else self.arm.goal(marker)
        return Moment(cycle, self.sighting, marker, goal, self.person.point)

    def held_back(self, reason: str) -> None:
        """Note the gate's reason for slowing the hand down or refusing its motion; empty without one."""
        self._held_back = reason

    def _command(
        self,
        state: State,
        target: Vector | None,
        marker: Pose | None,
        robot: RobotState,
        now: float,
        seconds: float,
    ) -> Command:
        camera = self._camera_pose(robot.head)
        head, step, hand = np.zeros(2), None, np.zeros(6)
        moves = marker is not None and self.motion.moving
        velocity = self.motion.velocity(now + RESPONSE_S) if moves else None
        if HEAD not in self._parts:
            pass
        elif state is State.SEARCHING:
            head = self.head.search(robot.head)
        elif target is not None and self.config.head.mode != "steps":
            head = self.head.look(target, camera, robot.head, velocity)
        elif target is not None:
            step = self.head.step(target, camera, robot.head, now)
        else:
            self.head.rest()
        nods = self._nod.under_way(now) or self._centred(robot)
        if state is State.CENTRING and marker is not None and self._old() and nods:
            head = self._nod.velocity(now, robot.head, float(self.head.offset[1]))
        if state.arm_moves and marker is not None and ARM in self._parts:
            followed = velocity if self.config.arm.follow > 0 else None
            hand = self.arm.approach(robot.hand, marker, seconds, followed)
        return Command(head, step, hand).slowed(self.config.loop.speed)

    def _update_tracks(self) -> None:
        sighting, self._pending = self._pending, None
        if sighting is None:
            return
        angles = self._history.at(sighting.captured)
        camera = None if angles is None else self._camera_pose(angles)
        self.marker.update(sighting, camera)
        marker = sighting.only(self.config.marker.target)
        self.own_motion.add(sighting.captured, None if marker is None else marker.pose)
        self.person.update(sighting, camera)
        seen = self.marker.seen
        if seen is None:
            self.motion.restart()
        else:
            self.motion.add(sighting.captured, seen[:3, 3])

    def _marker_at(self, now: float) -> Pose | None:
        """Return the marker's pose, predicted for `now` if the marker moves."""
        marker, place = self.marker.pose, self.motion.position(now)
        if marker is None or place is None:
            return marker
        return pose(marker[:3, :3], place)

    def _follows(self) -> bool:
        """Return whether the hand follows a moving marker."""
        following = self.machine.state is State.FOLLOWING
        near = FOLLOWED_M * (2 if following else 1)
        return self.config.arm.follow > 0 and self.motion.moving and self.arm.error[0] < near

    def _target(self, marker: Pose | None) -> Vector | None:
        """Return the head's target: the marker, or else a person."""
        if marker is not None:
            return marker[:3, 3]
        face = self.person.point
        return None if face is None else face - (0.0, 0.0, self.config.head.below)

    def _measure(self, target: Vector | None, marker: Pose | None, robot: RobotState | None) -> None:
        if robot is not None and target is not None:
            from_camera = self._camera_pose(robot.head)
            self.head.see(target, from_camera)
        if robot is not None and marker is not None:
            self.arm.measure(robot.hand, marker)

    def _judge_progress(self, now: float, marker: Pose | None, robot: RobotState | None) -> None:
        """Note whether the hand still comes nearer, and if not, why."""
        if self.machine.state is State.STOPPED:
            self._progress.reset()
            self._stuck = ""
        if robot is None or marker is None or self._dry_run:
            return
        goal = self.arm.goal(marker)
        approaching = self.machine.state is State.APPROACHING
        self._progress.update(now, robot.hand, goal, approaching, self.config.loop.speed)
        if not self._progress.stuck:
            self._stuck = ""
        elif not self._stuck:
            metres, radians = self.arm.error
            self._stuck = (
                f"the hand comes no nearer than {1e3 * metres:.0f} mm and {np.degrees(radians):.0f}°: "
                + self._reason(robot, goal)
            )

    def _reason(self, robot: RobotState, goal: Pose) -> str:
        if self._held_back:
            return self._held_back
        hindrance = "" if robot.arm is None else self._hindrance(robot.arm, diff(robot.hand, goal))
        return hindrance or "the arm does not get there"

    def _centred(self, robot: RobotState) -> bool:
        if HEAD not in self._parts:
            return True  # it will never be better
        waiting = self.machine.state is State.WAITING
        return self.head.centred(robot.head, slack=2.5 if waiting and self.marker.pose is None else 1.0)

    def _reachable(self, marker: Pose) -> bool:
        return ARM in self._parts and self.arm.inside(self.arm.goal(marker)[:3, 3])

    def _old(self) -> str:
        """Return why the images may be too old for the arm to move; empty if they are of now.

        A head that cannot nod leaves this open.
        """
        watch, head = self.own_motion, self.config.head
        if watch.shown or HEAD not in self._parts or self._dry_run:
            return ""
        if head.mode == "steps" or math.radians(head.fastest) < SLOWEST:
            return ""
        if not watch.lag:
            return "the head nods: the images must show its motion in time"
        permitted = 1e3 * self.config.safety.image_timeout
        return f"images show the head's motion {watch.lag:.1f} s late, where {permitted:.0f} ms are allowed"

    def _lateness_of(self, now: float, captured: float) -> str:
        """Return how much too late a new image came, or too long after the one before; empty if neither."""
        timeout = self.config.safety.image_timeout
        allowed = f"where {1e3 * timeout:.0f} ms are allowed"
        if timeout < now - captured < RARE_S:
            return f"{1e3 * (now - captured):.0f} ms after their exposure, {allowed}"
        if timeout < now - self._before < RARE_S:
            return f"{1e3 * (now - self._before):.0f} ms after the exposure of the one before, {allowed}"
        return ""

    def _problem(
        self, now: float, fresh: bool, robot: RobotState | None, sound: bool, fresh_robot: bool
    ) -> str:
        if robot is None:
            return "the robot has not answered yet"
        if not sound:
            return "the robot's readings are no numbers"
        if not fresh_robot:
            return self._silence() or "the robot's readings are old"
        if not fresh:
            if self.no_image or now - self._late >= LATE_S:
                return self.no_image or "no fresh image"
            return f"images come too late, {self._lateness}: is this computer busy?"
        marker = self.marker.pose
        if marker is not None and ARM not in self._parts:
            return "the arm is not driven: only the head follows"
        if marker is not None and not self._reachable(marker):
            return "the marker is outside the workspace"
        return self.marker.problem
