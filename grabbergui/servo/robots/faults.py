"""Faults that a simulated robot, its camera, or a stranger on its network can have. No I/O, no clock.

`fault_list` has their names. A simulator asks a `Faults` what its robot reports, which images its camera
sends, and what strangers send, at times on the robot's clock. A fault begins some seconds after the arm first
moves, so that it meets a hand in motion however long the servo program took to start.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Generic, TypeVar

import numpy as np

from grabbergui.calibration.geometry import Vector
from grabbergui.servo.kinematics import Chain
from grabbergui.servo.robots.fault_list import Fault
from grabbergui.servo.robots.robot import RobotState

STARTED = 0.01
"Speed of the fastest joint of an arm that has begun to move, rad/s."
NOISE = 1e-5
"Standard deviation of the noise of otherwise frozen readings, metres and radians."
JUMP_M = 0.3
DRIFT = 0.05
"Metres per second."
FAR = 1e12
LATE_S = 1.0
MASTER_TWIST = np.array([0.0, -0.3, 0.0, 0.0, 0.0, 0.0])
"The second master's twist, m/s along the base's axes."
X_AXIS = np.array([1.0, 0.0, 0.0])
OF_STRANGERS = frozenset(("false-readings", "second-master"))
"Faults for which another program joins the network."
STRANGER_PERIOD = 0.005
"Seconds between two messages of a stranger."
Image = TypeVar("Image")


class Faults:
    """The faults of one simulation. Its owner serialises calls; times never decrease."""

    def __init__(
        self,
        faults: Sequence[Fault] = (),
        *,
        reports_hand: bool = True,
        direction: Vector = X_AXIS,
        seed: int = 1,
    ) -> None:
        """Without `reports_hand` the robot reports only joints; faults of the hand's reading are theirs.

        `direction` is the unit vector along which the hand's reading is off.
        """
        self._after = {fault.name: fault.after for fault in faults}
        self._reports_hand, self._direction = reports_hand, direction
        self.random = np.random.default_rng(seed)
        "Source of noise, and of which message overtakes which."
        self._moved: float | None = None
        self._held: RobotState | None = None
        "The last true reading before a fault of the readings."

    def __bool__(self) -> bool:
        return bool(self._after)

    @property
    def of_strangers(self) -> bool:
        """Whether another program is needed for one of them."""
        return not OF_STRANGERS.isdisjoint(self._after)

    def moved(self, now: float) -> None:
        """Note that the arm moves."""
        if self._moved is None:
            self._moved = now

    def since(self, name: str, now: float) -> float | None:
        """Return for how many seconds a fault has lasted; None before it begins, and if it is not wanted."""
        if self._moved is None or name not in self._after:
            return None
        lasted = now - self._moved - self._after[name]
        return lasted if lasted >= 0 else None

    def active(self, now: float) -> list[str]:
        """Return the names of the faults that have begun."""
        return [name for name in self._after if self.since(name, now) is not None]

    def reading(self, true: RobotState, chain: Chain) -> RobotState:
        """Return what the robot reports instead of its true state; the last reading if it reports no more.

        `chain` is the arm's.
        """
        now = true.time
        if self._held is None or not self._reading_faults(now):
            self._held = true
        held = self._held
        if self.since("readings-stop", now) is not None:
            return held
        if self.since("readings-nan", now) is not None:
            nothing = None if true.arm is None else np.full_like(true.arm, np.nan)
            return RobotState(now, np.full_like(true.head, np.nan), np.full((4, 4), np.nan), nothing)
        if self.since("readings-repeat", now) is not None:
            return replace(held, time=now)
        if self.since("readings-freeze", now) is not None:
            return self.noisy(replace(held, time=now))
        for name, metres in (("hand-jumps", JUMP_M), ("hand-far", FAR), ("hand-drifts", DRIFT)):
            lasted = self.since(name, now)
            if lasted is not None:
                return self._displaced(true, chain, metres * (lasted if name == "hand-drifts" else 1.0))
        return true

    def false_reading(self, now: float) -> RobotState | None:
        """Return what a stranger sends as the robot's reading; None while there is none."""
        if self.since("false-readings", now) is None or self._held is None:
            return None
        return self.noisy(replace(self._held, time=now))

    def master_twist(self, now: float) -> Vector | None:
        """Return the twist that a second master sends the hand; None while there is none."""
        return None if self.since("second-master", now) is None else MASTER_TWIST.copy()

    def noisy(self, state: RobotState) -> RobotState:
        """Return a reading with noise of NOISE."""
        hand = state.hand.copy()
        hand[:3, 3] += self.random.normal(0, NOISE, 3)
        arm = None if state.arm is None else state.arm + self.random.normal(0, NOISE, state.arm.shape)
        return replace(
            state, head=state.head + self.random.normal(0, NOISE, state.head.shape), hand=hand, arm=arm
        )

    def _reading_faults(self, now: float) -> bool:
        names = ("readings-stop", "readings-repeat", "readings-freeze", "false-readings")
        return any(self.since(name, now) is not None for name in names)

    def _displaced(self, true: RobotState, chain: Chain, metres: float) -> RobotState:
        if self._reports_hand or true.arm is None:
            hand = true.hand.copy()
            hand[:3, 3] += metres * self._direction
            return replace(true, hand=hand)
        # The joint that moves the hand most, by as much.
        reach = np.linalg.norm(chain.jacobian(true.arm)[:3], axis=0)
        arm = true.arm.copy()
        joint = int(np.argmax(reach))
        arm[joint] += metres / reach[joint] if metres < FAR else metres
        return replace(true, arm=arm, hand=chain.forward(arm))


class ImageFaults(Generic[Image]):
    """Faults between a camera and its readers, whatever stands for an image. Use from one thread."""

    def __init__(
        self,
        faults: Faults,
        restamped: Callable[[Image, float], Image],
        spoiled: Callable[[Image, str], Image],
    ) -> None:
        """`restamped` returns an image as if exposed at a time; `spoiled` dark, mirrored, or as noise.

        The second argument of `spoiled` is the fault's name.
        """
        self._faults, self._restamped, self._spoiled = faults, restamped, spoiled
        self._last: deque[Image] = deque(maxlen=2)
        self._sent = 0
        self._late: deque[tuple[float, Image]] = deque()

    def pass_on(self, image: Image, now: float) -> list[Image]:
        """Return the images that arrive, when one is exposed and delivered `now`."""
        active = self._faults.active(now)
        if "camera-lost" in active:
            return []
        repeats = "image-repeats" in active or "images-alternate" in active
        if not repeats or not self._last:
            self._last.append(image)
        if repeats:
            kept = list(self._last)[-1 if "image-repeats" in active else -2 :]
            repeated = kept[self._sent % len(kept)]
            self._sent += 1
            return [self._restamped(repeated, now)]
        for name in ("images-dark", "images-mirrored", "images-noise"):
            if name in active:
                image = self._spoiled(image, name)
        late = [name for name in active if name.startswith("images-late")]
        if not late:
            return [image]
        self._late.append((now, image))
        arrived = []
        while self._late and self._late[0][0] <= now - LATE_S:
            due = self._late.popleft()[1]
            arrived.append(self._restamped(due, now) if "images-late-restamped" in late else due)
        return arrived
