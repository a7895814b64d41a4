"""The gate: the only way by which commands reach a robot.

It refuses commands that are not finite or too fast, that would lead the hand out of the workspace or the arm
into the robot's body or an obstacle, and every motion while the emergency stop is on or the guardian could
not stop the robot. It stops the robot when commands cease. A stop always passes, from any thread, and goes to
the guardian, too; only a planned rest that the robot confirms does not. A stop is logged only afterwards, as
a terminal may take no text for a while (Ctrl-S).
"""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from grabbergui.calibration.geometry import Vector
from grabbergui.core.errors import GrabberError, RobotStoppedError
from grabbergui.servo.config import Config
from grabbergui.servo.guardian_link import ALLOWED, Guard, Verdict
from grabbergui.servo.kinematics import Body, Contact, nearest_box, parse_boxes
from grabbergui.servo.robots.robot import Bystander, Robot, RobotState

log = logging.getLogger(__name__)


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
    def moves(self) -> bool:
        """Whether anything is to move."""
        return bool(np.any(self.head) or np.any(self.hand) or self.head_step is not None)


LOOKAHEAD_S = 0.2
"Seconds that a hand may continue after its last command: the gate checks where that would lead."
LEAD_S = 0.1
"Seconds by which streamed positions are ahead of the robot; it moves for no longer without another."
SLOWER = (1.0, 0.5, 0.25, 0.1)
"Fractions of the wanted speed to try, so that the hand slows down near an obstacle."
_WATCH_S = 0.02
EDGE_M = 0.002
"Metres by which rounding and drives may take a hand beyond the workspace's edge."


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
        self._robot: Robot = Bystander(robot) if dry_run else robot
        self._dry_run = dry_run
        self._config = config
        self._obstacles = parse_boxes(config.safety.obstacles)
        self._guard = guard or Guard()
        self._lock = threading.RLock()
        self._last_word = -math.inf
        self._until = math.inf
        self._moving = False
        self._halt_lock = threading.RLock()
        "Guards the three below; held only while they are read or set, so that no stop waits."
        self._halted = ""
        self._acknowledged = False
        "Whether that reason is known to a person, so that another stop may replace it."
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
            self._obstacles = parse_boxes(config.safety.obstacles)

    def send(self, command: Command, now: float) -> bool:
        """Pass a command on; return whether it reached the robot. Stops a robot that rejects it."""
        with self._lock:
            if self._halted:
                self.refused += command.moves
                return False
            problem = self._problem(command)
            if problem:
                self.refused += 1
                self._rest()
                log.error("no command sent: %s", problem)
                return False
            command = self._kept_clear(command)
            self._last_word, self._until = now, command.until
            if command.halt or (not command.moves and not self._stepping):
                self._rest()
                return True
            # Before it is sent: the watchdog stops a robot that takes too long to accept it.
            before, self._moving = self._moving, True
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
                if self._halted or not self._moving:  # stopped while the head's part was sent
                    self.refused += command.moves
                    return False
                self._move_hand(command)
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

    def halt(self, reason: str) -> None:
        """Emergency stop: stop the robot even if it rests, and pass no command until `release`."""
        self._halt(reason, planned=False)

    def hold(self, reason: str) -> None:
        """Stop as `halt` does, because a person is to let the robot move; replace the last stop's reason."""
        self._halt(reason, planned=True)

    def _halt(self, reason: str, *, planned: bool) -> None:
        # Before the commands' lock is taken: a command that hangs in the network must not delay a stop.
        with self._halt_lock:
            if planned or self._acknowledged or not self._halted:
                self._halted = reason or "emergency stop"
                self._acknowledged = planned
            self._stops += 1
        self._guard.stop()
        self._robot.stop()
        with self._lock:
            self._robot.stop()  # again, as a command may have been in progress
            self._moving = False

    def release(self, stops: int | None = None) -> None:
        """End the emergency stop.

        `stops` is the number of stops when a person decided to end it, if that was earlier than now. Raises
        RobotStoppedError, and the stop stays on, if there was another one since, also while a guardian
        started; SourceUnavailableError if no guardian can be started.
        """
        with self._halt_lock:
            stops = self._stops if stops is None else stops
            self._check_stops(stops)
            self._acknowledged = True
        self._guard.renew()
        with self._lock, self._halt_lock:
            self._check_stops(stops)
            self._halted = ""

    def _check_stops(self, stops: int) -> None:
        if self._halted and self._stops != stops:
            raise RobotStoppedError(self._halted)

    def beat(self) -> None:
        """Send the guardian a heartbeat and obey its verdict. For a watchdog."""
        self._heed(self._guard.beat(lambda: self._moving))

    def watch(self, going: Callable[[], bool], clock: Callable[[], float] = time.monotonic) -> None:
        """Be the watchdog, on a thread of its own, while `going`: `expire` and `beat` every 20 ms."""
        while going():
            self.expire(clock())
            self.beat()
            time.sleep(_WATCH_S)

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

    def _rest(self) -> None:
        if self._moving:
            self._moving = False
            if not self._robot.stop():
                self._guard.stop()  # over its own connections

    # -- space -----------------------------------------------------------------------------------
    def _kept_clear(self, command: Command) -> Command:
        """Return the command with its hand slowed down or at rest if it would come too near to anything."""
        before, self.hindrance = self.hindrance, ""
        if not np.any(command.hand):
            return command
        state = self._robot.state()
        if state is None or not state.sound:
            self.hindrance = (
                "the robot has not reported where its hand is"
                if state is None
                else "the robot's readings are no numbers"
            )
            return replace(command, hand=np.zeros(6))
        distance_now = cache(lambda: self._distance_now(state))
        for factor in SLOWER:
            hand = command.hand * factor
            danger = self._danger(state, hand, distance_now)
            if not danger:
                return replace(command, hand=hand)
            self.hindrance = self.hindrance or danger
        self.refused += 1
        if self.hindrance != before:
            log.warning("the hand is held back: %s", self.hindrance)
        return replace(command, hand=np.zeros(6))

    def _danger(self, state: RobotState, hand: Vector, distance_now: Callable[[], float]) -> str:
        """Return why a twist of the hand must not last for `LOOKAHEAD_S`; empty if it may.

        `distance_now` is slow, so it is called only if the hand would come too near.
        """
        low, high = self._config.arm.workspace
        ahead = state.hand[:3, 3] + hand[:3] * LOOKAHEAD_S
        # A hand that is outside may return.
        leaving = ((ahead < low - EDGE_M) & (hand[:3] < 0)) | ((ahead > high + EDGE_M) & (hand[:3] > 0))
        if leaving.any():
            axis = int(np.argmax(leaving))
            return f"it would leave the workspace ({'xyz'[axis]} = {ahead[axis]:.2f} m)"
        model = self._robot.model
        if model.body is None or state.arm is None:
            return ""
        moved = model.arm.velocities_for(state.arm, hand) * LOOKAHEAD_S
        there = self._nearest(model.body, model.arm.clamped(state.arm + moved))
        if there.distance >= self._config.safety.clearance:
            return ""
        # An arm that is too near already may only move away.
        return _too_near(there) if there.distance < distance_now() else ""

    def _distance_now(self, state: RobotState) -> float:
        """Return the distance from the arm to the nearest shape, metres; infinite if it is not known."""
        model = self._robot.model
        if model.body is None or state.arm is None:
            return math.inf
        return self._nearest(model.body, model.arm.clamped(state.arm)).distance

    def obstruction(self, arm: Vector) -> str:
        """Return why the arm must not rest at joint angles (radians), as display text; empty if it may."""
        model = self._robot.model
        place = model.arm.forward(arm)[:3, 3]
        low, high = self._config.arm.workspace
        if ((place < low) | (place > high)).any():
            return "it would be outside the workspace"
        if model.body is None:
            return ""
        contact = self._nearest(model.body, arm)
        return _too_near(contact) if contact.distance < self._config.safety.clearance else ""

    def _nearest(self, body: Body, arm: Vector) -> Contact:
        contacts = [body.nearest(arm)]
        if self._obstacles:
            contacts.append(nearest_box(body.capsules(arm), self._obstacles))
        return min(contacts, key=lambda contact: contact.distance)

    # -- limits ----------------------------------------------------------------------------------
    def _problem(self, command: Command) -> str:
        config = self._config
        numbers = [command.head, command.hand]
        if command.head_step is not None:
            numbers.append(command.head_step)
        if not all(np.isfinite(part).all() for part in numbers):
            return "it has numbers that are not finite"
        slack = 1 + 1e-6
        if np.abs(command.head).max() > math.radians(config.head.fastest) * slack:
            return "the head would be too fast"
        if np.linalg.norm(command.hand[:3]) > max(config.arm.fastest, config.arm.follow) * slack:
            return "the hand would be too fast"
        if np.linalg.norm(command.hand[3:]) > math.radians(config.arm.fastest_turn) * slack:
            return "the hand would turn too fast"
        if command.head_step is not None and np.abs(command.head_step).max() > math.radians(10):
            return "the head's step would be too large"
        return ""


def _too_near(contact: Contact) -> str:
    return f"{contact.part} would come within {1e3 * max(contact.distance, 0):.0f} mm of {contact.other}"
