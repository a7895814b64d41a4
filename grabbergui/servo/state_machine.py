"""The states of a run and their transitions.

No clock: time is an argument.

                ┌─────────── target lost, images or robot silent ────────────┐
SEARCHING ──► CENTRING ──► WAITING ──► CENTRING (on the marker) ──► APPROACHING ──► REACHED
    ▲             ▲                                                    │   ▲ marker moved │
    └── LOST ─────┘ seen again                        comes no nearer  ▼   ├──────────────┘
                                                                     STUCK ┘ marker moved

APPROACHING ◄──► FOLLOWING while the marker moves, where the hand may follow
LOST ──► APPROACHING when images were missing only for a moment and show the marker again
anything ──► STOPPED (emergency stop, or a fault of the robot) ──► LOST on resume
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum


class State(Enum):
    """The states, with their published names as values."""

    SEARCHING = "searching"
    CENTRING = "centring"
    WAITING = "waiting for the marker"
    APPROACHING = "approaching"
    FOLLOWING = "following"
    REACHED = "reached"
    STUCK = "stuck"
    LOST = "lost"
    STOPPED = "stopped"

    @property
    def head_moves(self) -> bool:
        """Whether the head may be commanded."""
        return self not in (State.LOST, State.STOPPED)

    @property
    def arm_moves(self) -> bool:
        """Whether the arm may be commanded."""
        return self in (State.APPROACHING, State.FOLLOWING)


@dataclass(frozen=True)
class Situation:
    """The inputs of a transition."""

    images: bool = True
    "Whether the newest image is fresh."
    robot: bool = True
    "Whether the robot's encoders are fresh."
    target: bool = False
    "Whether there is a target, confirmed by several images."
    centred: bool = False
    "Whether the target is in the middle of the image."
    marker: bool = False
    "Whether the chosen marker is seen, confirmed by several images."
    old: str = ""
    "Why the images may be too old for the arm to move, as display text; empty if they are of now."
    arrived: bool = False
    "Whether the hand is at its goal."
    settled: bool = False
    "Whether it is as near as it gets, and rests."
    following: bool = False
    "Whether the hand may follow the marker, which moves, and is near enough."
    stuck: str = ""
    "Why the hand cannot reach its goal, as display text; empty while it may."
    problem: str = ""
    "Why there is no usable marker, image or reading, as display text."


@dataclass(frozen=True)
class Transition:
    """One change of state, for log and report."""

    time: float
    state: State
    reason: str


class StateMachine:
    """Chooses the state. It starts lost, in which nothing moves."""

    HOLD = 0.4
    "Seconds at the goal before it counts as reached."
    SETTLES = 1.2
    "The same if the hand does not come to rest, for instance because a person holds the marker."

    def __init__(self, grace: float, search_after: float) -> None:
        self.state = State.LOST
        self.reason = "no image yet"
        self.transitions: list[Transition] = []
        self._grace = grace
        self._search_after = search_after
        self._since: float | None = None
        self._target_seen = -math.inf
        self._marker_seen = -math.inf
        self._arrived_since: float | None = None
        self._interrupted = -math.inf
        "When images last stopped coming while the arm moved."

    def step(self, now: float, situation: Situation) -> State:
        """Make the transition that the situation demands; return the new state."""
        if situation.target:
            self._target_seen = now
        if situation.marker:
            self._marker_seen = now
        if self._since is None:
            self._since = now
        if self.state is State.STOPPED:
            return self.state
        if not situation.images or not situation.robot:
            silent = "no fresh image" if not situation.images else "the robot does not answer"
            if not situation.robot:
                self._interrupted = -math.inf
            elif self.state.arm_moves:
                self._interrupted = now
            self._enter(now, State.LOST, situation.problem or silent)
            self._since = now  # the search begins some time after images arrive again
            return self.state
        self._choose(now, situation)
        return self.state

    def stop(self, now: float, reason: str) -> None:
        """Enter the emergency stop, which holds until `resume`."""
        self._interrupted = -math.inf
        self._enter(now, State.STOPPED, reason)

    def resume(self, now: float) -> None:
        """End a stop; the machine starts again from lost."""
        if self.state is State.STOPPED:
            self._enter(now, State.LOST, "resumed")

    def _choose(self, now: float, situation: Situation) -> None:
        state = self.state
        if state is State.LOST:
            self._look_for_target(now, situation)
        elif state is State.SEARCHING:
            if situation.target:
                self._enter(now, State.CENTRING, "a target is seen")
        elif now - self._target_seen > self._grace:
            self._enter(now, State.LOST, situation.problem or "the target is not seen")
        elif state in (State.CENTRING, State.WAITING):
            self._centre(now, situation)
        elif self._marker_lost(now):
            self._enter(now, State.LOST, situation.problem or "the marker is not seen")
        elif state is State.APPROACHING:
            self._approach(now, situation)
        elif state is State.FOLLOWING:
            if not situation.following:
                self._enter(now, State.APPROACHING, "the marker rests, or it is too fast to be followed")
        elif situation.marker and not (situation.arrived if state is State.REACHED else situation.stuck):
            self._enter(now, State.APPROACHING, "the marker moved")

    def _marker_lost(self, now: float) -> bool:
        return now - self._marker_seen > self._grace

    def _look_for_target(self, now: float, situation: Situation) -> None:
        if situation.marker and now - self._interrupted <= self._grace:
            self._enter(now, State.APPROACHING, "images arrive again")
        elif situation.target:
            self._enter(now, State.CENTRING, "a target is seen")
        elif self._since is not None and now - self._since >= self._search_after:
            self._enter(now, State.SEARCHING, "nothing to be seen")
        else:
            self.reason = situation.problem or self.reason

    def _centre(self, now: float, situation: Situation) -> None:
        waiting = self.state is State.WAITING
        if waiting and situation.problem:
            self.reason = situation.problem
        if situation.centred and situation.marker:
            if situation.stuck:
                self._enter(now, State.STUCK, situation.stuck)
            elif situation.old:
                self._enter(now, State.CENTRING, situation.old)
            else:
                self._enter(now, State.APPROACHING, "the marker is centred")
        elif situation.centred and not waiting and self._marker_lost(now):
            self._enter(now, State.WAITING, "centred; no marker yet")
        elif not situation.centred and waiting:
            self._enter(now, State.CENTRING, "the target is off centre")

    def _approach(self, now: float, situation: Situation) -> None:
        if situation.stuck and not situation.arrived:
            self._enter(now, State.STUCK, situation.stuck)
        elif situation.following:
            self._enter(now, State.FOLLOWING, "the hand goes along with the marker")
        else:
            self._arrive(now, situation.arrived, self.HOLD if situation.settled else self.SETTLES)

    def _arrive(self, now: float, arrived: bool, hold: float) -> None:
        if not arrived:
            self._arrived_since = None
        elif self._arrived_since is None:
            self._arrived_since = now
        elif now - self._arrived_since >= hold:
            self._enter(now, State.REACHED, "the hand is at the marker")

    def _enter(self, now: float, state: State, reason: str) -> None:
        if state is self.state:
            self.reason = reason
            return
        self.state, self.reason, self._since = state, reason, now
        self._arrived_since = None
        self.transitions.append(Transition(now, state, reason))
