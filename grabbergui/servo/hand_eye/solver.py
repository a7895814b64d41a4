"""Hand–eye calibration: finds the pose of a camera on a robot, from images of a target in many joint poses.

The best result of OpenCV's closed-form methods (Tsai, Park, Horaud, Andreff, Daniilidis) is refined by
Levenberg–Marquardt on the pixels of all corners together, weighted by the noise of corners and of joint
readings. `hand_eye_model` has the geometry.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Vector
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import CalibrationError
from grabbergui.servo.hand_eye.measurement import (
    OFFSET_SPREAD,
    Arrangement,
    Guess,
    HandEyeMeasurement,
    Problem,
    camera_from_target,
    root_mean_square,
)

FEWEST_VIEWS = 5
LEAST_NOISE = 0.01
"Lower limit of the noise of detected corners, pixels."
READING_SPREADS = tuple(math.radians(degrees) for degrees in (0.0, 0.02, 0.05, 0.1, 0.2, 0.5))
"Standard deviations of joint readings to try, radians."
OUTLIER = 4.0
"Error of a view that is left out, relative to the median."
_TOO_LITTLE = "the views differ too little: turn camera or target about two axes between them"
_METHODS = {
    "Park": cv2.CALIB_HAND_EYE_PARK,
    "Horaud": cv2.CALIB_HAND_EYE_HORAUD,
    "Daniilidis": cv2.CALIB_HAND_EYE_DANIILIDIS,
    "Tsai": cv2.CALIB_HAND_EYE_TSAI,
    "Andreff": cv2.CALIB_HAND_EYE_ANDREFF,
}
_ITERATIONS = 60


@dataclass(frozen=True, eq=False)
class HandEyeResult(Guess):
    """The result of a calibration and its uncertainty."""

    covariance: NDArray[np.float64] = field(default_factory=lambda: np.zeros((6, 6)))
    "(6, 6) of the camera's pose: metres along, then radians about the axes of its mount."
    rms: float = 0.0
    "Root mean square error of the used views, pixels."
    errors: tuple[float, ...] = ()
    "Root mean square error of each view, pixels; NaN for one that was left out."
    reading_spread: float = 0.0
    "Estimated standard deviation of the joint readings, one of `READING_SPREADS`, radians."
    method: str = ""
    "OpenCV's method whose solution was refined: Park, Horaud, Daniilidis, Tsai or Andreff."

    @property
    def uncertainty(self) -> tuple[float, float]:
        """Return the camera's standard deviations: metres, and radians (root sum of squares of the axes)."""
        spread = np.diag(self.covariance)
        return math.sqrt(float(spread[:3].sum())), math.sqrt(float(spread[3:].sum()))


def solve(
    arrangement: Arrangement, views: Sequence[HandEyeMeasurement], calibration: Calibration
) -> HandEyeResult:
    """Find camera, target and joint offsets. Raises CalibrationError for too few views or too little motion.

    The noise of corners is measured by fitting the target to each image alone; the noise of joint readings is
    the one of `READING_SPREADS` with the highest likelihood of all views.
    """
    if len(views) < FEWEST_VIEWS:
        raise CalibrationError(f"hand–eye calibration needs {FEWEST_VIEWS} views or more, not {len(views)}")
    try:
        return _solved(Problem(arrangement, calibration), views)
    except (np.linalg.LinAlgError, cv2.error) as error:  # of motion about one axis only, for instance
        raise CalibrationError(_TOO_LITTLE) from error


def _solved(problem: Problem, views: Sequence[HandEyeMeasurement]) -> HandEyeResult:
    start, pixel, method = _start(problem, views)
    best = _best_fit(problem, views, start, pixel)
    strange = [best.strangeness(view, best.guess) for view in views]
    limit = OUTLIER * max(float(np.median(strange)), 1.0)
    used = [view for view, much in zip(views, strange, strict=True) if much <= limit]
    if len(used) < FEWEST_VIEWS:
        raise CalibrationError(
            "the views contradict one another: check the target's size and the calibration"
        )
    if len(used) < len(views):
        best = _best_fit(problem, used, start, pixel)
    guess, errors = best.guess, [problem.error(view, best.guess) for view in views]
    return HandEyeResult(
        guess.camera,
        guess.target,
        guess.camera_offsets,
        guess.target_offsets,
        best.covariance()[:6, :6],
        math.sqrt(float(np.mean([problem.error(view, guess) ** 2 for view in used]))),
        tuple(error if much <= limit else math.nan for error, much in zip(errors, strange, strict=True)),
        best.spread,
        method,
    )


class _Fit:
    """The most likely guess for a given noise of corners and joint readings, by Levenberg–Marquardt."""

    def __init__(
        self, problem: Problem, views: Sequence[HandEyeMeasurement], start: Guess, pixel: float, spread: float
    ) -> None:
        self.spread = spread
        self._problem, self._views, self._pixel = problem, views, pixel
        self._white = self._whitening(start)
        self.guess = self._descended(start)
        # Again, as the effect of the readings' noise depends on the geometry that was just found.
        self._white = self._whitening(self.guess)
        self.guess = self._descended(self.guess)
        self.likelihood = self._trimmed_likelihood()

    def strangeness(self, view: HandEyeMeasurement, guess: Guess) -> float:
        """Return the root mean square error of a view relative to its noise."""
        white = self._whitened(view, guess) @ self._problem.residuals(view, guess)
        return math.sqrt(float(white @ white) / len(white))

    def covariance(self) -> NDArray[np.float64]:
        """Return the parameters' covariance. Raises CalibrationError if a parameter is not determined."""
        jacobian, residuals = self._jacobian(self.guess), self._residuals(self.guess)
        known = jacobian.T @ jacobian
        if not np.linalg.cond(known) <= 1e14:
            raise CalibrationError(_TOO_LITTLE)
        freedom = max(len(residuals) - len(known), 1)
        return np.linalg.inv(known).astype(np.float64) * max(1.0, float(residuals @ residuals) / freedom)

    def _descended(self, guess: Guess) -> Guess:
        now, damping = self._residuals(guess), 1e-3
        for _ in range(_ITERATIONS):
            jacobian = self._jacobian(guess)
            known, gradient = jacobian.T @ jacobian, jacobian.T @ now
            while damping < 1e9:
                step = np.linalg.solve(known + damping * np.diag(np.diag(known)), -gradient)
                after = self._problem.changed(guess, step.astype(np.float64))
                then = self._residuals(after)
                if then @ then < now @ now:
                    break
                damping *= 10
            else:
                return guess
            gained = float(now @ now - then @ then)
            guess, now, damping = after, then, max(damping / 10, 1e-9)
            if gained < 1e-5 * float(now @ now):
                break
        return guess

    def _residuals(self, guess: Guess) -> Vector:
        corners = [
            white @ self._problem.residuals(view, guess)
            for white, view in zip(self._white, self._views, strict=True)
        ]
        return np.concatenate([*corners, self._problem.prior(guess)])

    def _jacobian(self, guess: Guess) -> NDArray[np.float64]:
        corners = [
            white @ self._problem.jacobian(view, guess)
            for white, view in zip(self._white, self._views, strict=True)
        ]
        offsets = self._problem.size - 12
        prior = np.hstack((np.zeros((offsets, 12)), np.eye(offsets) / OFFSET_SPREAD))
        return np.vstack([*corners, prior])

    def _whitening(self, guess: Guess) -> list[NDArray[np.float64]]:
        """Return the weights of each view, smaller for large errors, which would distort the fit."""
        strange = np.array([self.strangeness(view, guess) for view in self._views])
        shares = np.minimum(1.0, 2 * max(float(np.median(strange)), 1.0) / np.maximum(strange, 1e-9))
        return [share * self._whitened(view, guess) for share, view in zip(shares, self._views, strict=True)]

    def _trimmed_likelihood(self) -> float:
        """Return the log-likelihood of the views without the least likely tenth."""
        each = []
        for view in self._views:
            weight = self._whitened(view, self.guess)
            white = weight @ self._problem.residuals(view, self.guess)
            each.append(float(np.log(np.diag(weight)).sum()) - 0.5 * float(white @ white))
        return sum(sorted(each)[math.ceil(len(each) / 10) :])

    def _whitened(self, view: HandEyeMeasurement, guess: Guess) -> NDArray[np.float64]:
        """Return the (2 n, 2 n) matrix that makes a view's residuals independent and of unit variance."""
        moved = self._problem.by_readings(view, guess) * self.spread
        covariance = self._pixel**2 * np.eye(len(moved)) + moved @ moved.T
        return np.linalg.inv(np.linalg.cholesky(covariance)).astype(np.float64)


def _best_fit(problem: Problem, views: Sequence[HandEyeMeasurement], start: Guess, pixel: float) -> _Fit:
    """Return the most likely fit over the noise of joint readings."""
    fits = (_Fit(problem, views, start, pixel, spread) for spread in READING_SPREADS)
    return max(fits, key=lambda fit: fit.likelihood)


def _start(problem: Problem, views: Sequence[HandEyeMeasurement]) -> tuple[Guess, float, str]:
    """Return the best of OpenCV's closed-form solutions, the noise of corners in pixels, and its method."""
    arrangement, calibration = problem.arrangement, problem.calibration
    none = [
        np.zeros(0 if chain is None else len(chain.low)) for chain in (arrangement.camera, arrangement.target)
    ]
    still = Guess(np.eye(4), np.eye(4), *none)
    tools, targets, squares, freedom = [], [], 0.0, 0
    for view in views:
        found, turn, place = cv2.solvePnP(
            view.points, view.pixels, calibration.matrix, calibration.pinhole_distortion
        )
        if not found:
            raise CalibrationError("a view shows the target so that no pose fits it; leave it out")
        targets.append(geometry.pose(geometry.rotation_from_vector(turn.ravel()), place.ravel()))
        seen, _ = cv2.projectPoints(
            view.points, turn, place, calibration.matrix, calibration.pinhole_distortion
        )
        squares += float(np.sum((np.asarray(seen).reshape(-1, 2) - view.pixels) ** 2))
        freedom += 2 * len(view.points) - 6
        # The pose of the camera's mount in the frame of the target's.
        tools.append(
            geometry.inverse(camera_from_target(arrangement, still, view.camera_angles, view.target_angles))
        )
    best, least, chosen = None, math.inf, ""
    for name, method in _METHODS.items():
        try:
            rotation, place = cv2.calibrateHandEye(
                [tool[:3, :3] for tool in tools],
                [tool[:3, 3] for tool in tools],
                [target[:3, :3] for target in targets],
                [target[:3, 3] for target in targets],
                method=method,
            )
        except cv2.error:
            continue
        camera = geometry.pose(rotation, np.ravel(place))
        if not geometry.is_pose(camera):
            continue
        for tool, target in zip(tools, targets, strict=True):
            held = tool @ camera @ target
            poses = [geometry.inverse(each @ camera) @ held for each in tools]
            residuals = map(problem.residuals_at, views, poses)
            error = float(np.median([root_mean_square(each) for each in residuals]))
            if error < least:
                best, least, chosen = Guess(camera, held, *none), error, name
    if best is None:
        raise CalibrationError(_TOO_LITTLE)
    return best, max(math.sqrt(squares / max(freedom, 1)), LEAST_NOISE), chosen
