"""The gate: the only way by which commands reach a robot.

It slows every motion down to the limits (see `motion`), and refuses commands that are not finite, and every
motion while the emergency stop is on or the guardian could not stop the robot. It stops the robot when
commands cease, and when the guardian finds that the robot does something else (see `monitor`). A stop always
passes, from any thread, and goes to the guardian, too; only a planned rest that the robot confirms does not.
A stop is logged only afterwards, as a terminal may take no text for a while (Ctrl-S).
"""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from grabbergui.calibration.geometry import Vector
from grabbergui.core.errors import AccessDeniedError, GrabberError
from grabbergui.servo.config import Config
from grabbergui.servo.errors import RobotStoppedError
from grabbergui.servo.guardian_link import ALLOWED, HEARTBEAT_S, Guard, LocalGuard, Verdict
from grabbergui.servo.motion import STOPPING_S, MotionPlan, Observer, Space, limits_of, planned
from grabbergui.servo.robots.robot import Bystander, Robot, RobotState

log = logging.getLogger(__name__)
LEAD_S = 0.1
"Seconds by which streamed positions are ahead of the robot; it moves for no longer without another."
HEAD_STOPS_S = 0.05
"Seconds in which the head would reach a joint's limit at the highest speed that it may have there."
MOST_STEP = math.radians(10)
"The largest relative move of the head."
HERE = "this computer"
"Where a stop was pressed: in the window, or on the keyboard."


@dataclass(frozen=True, eq=False)
class Command:
    """One control cycle's command. A part whose velocity is zero rests."""

    head: Vector = field(default_factory=lambda: np.zeros(2))
    "Pan and tilt, rad/s."
    head_step: Vector | None = None
    "A relative move instead, radians."
    hand: Vector = field(default_factory=lambda: np.zeros(6))
    "Twist in the base, m/s and rad/s."
    halt: bool = False
    "Whether everything must stop, a step in progress included."
    until: float = math.inf
    "When its motion must have ended, in seconds on the loop's clock."

    def slowed(self, factor: float) -> Command:
        """Return the same motion at a fraction of its speed, or of its size for a step."""
        step = None if self.head_step is None else self.head_step * factor
        return replace(self, head=self.head * factor, head_step=step, hand=self.hand * factor)

    @property
    def finite(self) -> bool:
        """Whether all its numbers are finite."""
        parts = (self.head, self.hand) if self.head_step is None else (self.head, self.hand, self.head_step)
        return all(np.isfinite(part).all() for part in parts)

    @property
    def moves(self) -> bool:
        """Whether anything is to move."""
        return bool(np.any(self.head) or np.any(self.hand) or self.head_step is not None)


class CommandGate:
    """Checks commands and passes them on. Any thread."""

    def __init__(
        self, robot: Robot, config: Config, guard: Guard | None = None, *, dry_run: bool = False
    ) -> None:
        """In a dry run everything is checked, but neither motion nor stop reaches the robot."""
        self.sent = 0
        "Motion commands that reached the robot."
        self.refused = 0
        "Commands that were refused."
        self.hindrance = ""
        "Why the newest command's hand was slowed down or refused; empty if it was not."
        self.paused = ""
        "Why the robot waits at rest, as display text; empty if it need not. Any thread may set it."
        self._robot: Robot = Bystander(robot) if dry_run else robot
        self._dry_run = dry_run
        self._guard = guard or LocalGuard(config.safety.lag)
        self._lock = threading.RLock()
        self._observer, self._observing = Observer(robot.model.arm), threading.Lock()
        self.tune(config)
        self._last_word = -math.inf
        self._until = math.inf
        self._moving = False
        self._halt_lock = threading.RLock()
        "Guards the four below; held only while they are read or set, so that no stop waits."
        self._halted = ""
        self._acknowledged = False
        "Whether that reason is known to a person, so that another stop may replace it."
        self._pressed: set[str] = set()
        "Where persons have stopped it since it was last released."
        self._stops = 0

    @property
    def halted(self) -> str:
        """Why no command passes; empty if commands pass. Of several stops, the reason of the first."""
        return self._halted

    @property
    def stops(self) -> int:
        """Number of stops so far, those of a stopped robot included."""
        return self._stops

    @property
    def dry_run(self) -> bool:
        """Whether neither motion nor stop reaches the robot."""
        return self._dry_run

    def tune(self, config: Config) -> None:
        """Change the limits."""
        with self._lock:
            self._config = config
            self._space, self._limits = Space(self._robot.model, config), limits_of(config)

    def send(self, command: Command, now: float) -> bool:
        """Pass a command on; return whether it reached the robot. Stops a robot that rejects it."""
        with self._lock:
            if self._halted:
                self.refused += command.moves
                return False
            if self.paused:
                self.refused += command.moves
                self._rest()
                return False
            if not command.finite:
                self.refused += 1
                self._rest()
                log.error("no command sent: it has numbers that are not finite")
                return False
            command, joints = self._within_limits(command, now)
            self._last_word, self._until = now, command.until
            if command.halt or (not command.moves and not self._stepping):
                self._rest()
                self._observe(now)
                return True
            # Before it is sent: the watchdog stops a robot that takes too long to accept it.
            before, self._moving = self._moving, True
            self._observe(now)
            verdict = self._guard.beat(lambda: self._moving)
            if verdict != ALLOWED:
                self.refused += command.moves
                self._moving = before
                self._heed(verdict)
                return False
            try:
                if self._dry_run:
                    self._moving = False
                    return False
                self._move_head(command)
                with self._observing:
                    self._observer.command_head(now, command.head, command.head_step)
                if self._halted or not self._moving:  # stopped while the head's part was sent
                    self.refused += command.moves
                    return False
                self._move_hand(command)
                # Only now: drives that change their mode obey later, or not at all if a stop comes first.
                with self._observing:
                    self._observer.command_arm(now, joints)
            except GrabberError as error:
                self.refused += 1
                overtaken = self._halted or not self._moving
                self._guard.stop()
                self._robot.stop()
                self._moving = False
                if overtaken:
                    # After a stop from another thread, the robot refuses an older command.
                    log.info("%s: a command was overtaken by a stop: %s", self._robot.name, error)
                else:
                    log.error("%s does not take a command: %s", self._robot.name, error)
                return False
            self.sent += command.moves
            self._moving = True  # again, as the watchdog may have stopped it in between
            return True

    def _move_head(self, command: Command) -> None:
        if command.head_step is not None:
            self._robot.step_head(command.head_step)
        elif self._config.head.mode == "velocity":
            self._robot.move_head(command.head)
        elif not self._stepping or np.any(command.head):  # a search has velocities in any mode
            self._robot.lead_head(command.head, LEAD_S)

    def _move_hand(self, command: Command) -> None:
        if self._config.arm.mode == "direct":
            self._robot.lead_hand(command.hand, LEAD_S)
        else:
            self._robot.move_hand(command.hand)

    @property
    def _stepping(self) -> bool:
        """Whether the head completes a step without further commands."""
        return self._config.head.mode == "steps"

    def rest(self) -> None:
        """Bring the robot to rest; commands may follow."""
        with self._lock:
            self._rest()

    def halt(self, reason: str, pressed: str = "") -> None:
        """Emergency stop: stop the robot even if it rests, and pass no command until `release`.

        `pressed` is where a person pressed the stop: `HERE`, or a network's name; empty for a fault.
        """
        self._halt(reason, pressed, planned=False)

    def hold(self, reason: str) -> None:
        """Stop as `halt` does, because a person here is to let the robot move; replace the last reason."""
        self._halt(reason, HERE, planned=True)

    def _halt(self, reason: str, pressed: str, *, planned: bool) -> None:
        # Before the commands' lock is taken: a command that hangs in the network must not delay a stop.
        with self._halt_lock:
            if planned or self._acknowledged or not self._halted:
                self._halted = reason or "emergency stop"
                self._acknowledged = planned
            self._pressed |= {pressed} - {""}
            self._stops += 1
        self._guard.stop()
        self._robot.stop()
        with self._lock:
            self._robot.stop()  # again, as a command may have been in progress
            self._moving = False

    def release(self, stops: int | None = None, pressed: str = HERE) -> None:
        """End the emergency stop, as a person demands who is at `HERE` or on a network.

        `stops` is the number of stops when the person decided it, if that was earlier than now. Raises
        RobotStoppedError, and the stop stays on, if there was another one since, also while a guardian
        started; AccessDeniedError if it was pressed elsewhere; SourceUnavailableError if no guardian can be
        started.
        """
        with self._halt_lock:
            stops = self._stops if stops is None else stops
            self._check_stops(stops)
            elsewhere = sorted(self._pressed - {pressed})
            if pressed != HERE and self._halted and elsewhere:
                raise AccessDeniedError(
                    f"{self._halted}; let the robot move on {' and '.join(elsewhere)}, where it was stopped"
                )
            self._acknowledged = True
        self._guard.renew()
        with self._lock, self._halt_lock:
            self._check_stops(stops)
            self._halted, self._pressed = "", set()
            with self._observing:
                self._observer.forget()

    def _check_stops(self, stops: int) -> None:
        if self._halted and self._stops != stops:
            raise RobotStoppedError(self._halted)

    def beat(self, now: float) -> None:
        """Send the guardian a heartbeat and the newest reading, and obey its verdict. For a watchdog."""
        self._observe(now)
        self._heed(self._guard.beat(lambda: self._moving))

    def watch(self, going: Callable[[], bool], clock: Callable[[], float] = time.monotonic) -> None:
        """Be the watchdog, on a thread of its own, while `going`: `expire` and `beat` every `HEARTBEAT_S`."""
        while going():
            now = clock()
            self.expire(now)
            self.beat(now)
            time.sleep(HEARTBEAT_S)

    def expire(self, now: float) -> bool:
        """Stop a robot whose last command has expired; return whether it moved. For a watchdog."""
        if not self._moving:  # read first, as `send` sets it last
            return False
        silent, over = now - self._last_word, now > self._until
        if not over and silent <= self._config.safety.command_timeout:
            return False
        # Before the stop, which may take a while: a command during it moves the robot again.
        self._moving = False
        self._guard.stop()
        self._robot.stop()
        why = "the image is too old" if over else f"no command for {1e3 * silent:.0f} ms"
        log.warning("%s: stopped", why)
        return True

    def _heed(self, verdict: Verdict) -> None:
        if verdict.for_good and not self._halted:
            self.halt(verdict.why_not)
            log.error("%s", verdict.why_not)
        elif verdict != ALLOWED and self._moving:
            # The guardian has stopped it; this end of its connections must follow.
            self._moving = False
            self._robot.stop()

    def _observe(self, now: float) -> None:
        """Let the guardian compare the newest reading with what was commanded, while commands may pass."""
        if self._halted or self._dry_run or (state := self._reading()) is None:
            return
        with self._observing:
            if not self._moving:
                self._observer.rest(now)
            # This thread may have waited since `now`, while the robot moved on.
            seen = self._observer.look(max(now, state.time), state, self._space, self._limits)
            if seen is not None:  # with the lock, in the order of the readings
                self._guard.observe(seen)

    def _reading(self) -> RobotState | None:
        try:
            return self._robot.state()
        except GrabberError as error:
            log.debug("%s: %s", self._robot.name, error)
            return None

    def _rest(self) -> None:
        if self._moving:
            self._moving = False
            if not self._robot.stop():
                self._guard.stop()  # over its own connections

    def obstruction(self, arm: Vector) -> str:
        """Return why the arm must not rest at joint angles (radians), as display text; empty if it may."""
        return self._space.refused(arm)

    def _within_limits(self, command: Command, now: float) -> tuple[Command, Vector]:
        """Return the command, slowed down until all limits hold, and the arm's joint velocities."""
        state, chain = self._reading(), self._robot.model.head
        head = command.head * min(1.0, self._limits.head / max(float(np.abs(command.head).max()), 1e-9))
        if state is not None and state.sound and head.any():
            room = np.minimum(chain.low - state.head, 0.0), np.maximum(chain.high - state.head, 0.0)
            head = np.clip(head, room[0] / HEAD_STOPS_S, room[1] / HEAD_STOPS_S)
        step = None if command.head_step is None else np.clip(command.head_step, -MOST_STEP, MOST_STEP)
        before, self.hindrance = self.hindrance, ""
        plan = self._planned(command.hand, state, now) if np.any(command.hand) else self._still()
        self.hindrance = plan.reason
        if plan.reason and not np.any(plan.twist):
            self.refused += 1
            if not before:
                log.warning("the hand is held back: %s", plan.reason)
        return replace(command, head=head, head_step=step, hand=plan.twist), plan.joints

    def _planned(self, hand: Vector, state: RobotState | None, now: float) -> MotionPlan:
        if state is None:
            return self._still("the robot has not reported where its hand is")
        if not state.sound:
            return self._still("the robot's readings are no numbers")
        if state.arm is None:
            return self._still("the robot does not report the angles of its arm")
        age = min(max(now - state.time, 0.0), STOPPING_S)
        arm = self._robot.model.arm
        return planned(arm, self._space, self._limits, state.arm, hand, age)

    def _still(self, reason: str = "") -> MotionPlan:
        return MotionPlan(np.zeros(6), np.zeros_like(self._robot.model.arm.low), reason)
