"""The plan, the events and the result of a hand–eye calibration as sentences in the user's language."""

from __future__ import annotations

import math

import numpy as np

from grabbergui.calibration.geometry import Pose
from grabbergui.models.language import driver_text, localized, translate
from grabbergui.models.markup import Markup, joined, markup
from grabbergui.servo.hand_eye.hand_eye_file import CameraMount
from grabbergui.servo.hand_eye.plan import RunPlan
from grabbergui.servo.hand_eye.run import SMALL_DEGREES, SPAN_DEGREES, Progress, Skip, Step
from grabbergui.servo.hand_eye.solver import FEWEST_VIEWS, HandEyeResult


def plan_text(plan: RunPlan, robot: str, *, nominal: bool = False) -> Markup:
    """Return what the robot will do as paragraphs; `nominal` if the camera is not calibrated."""
    text = translate("HandEye", "<b>{0} will move by itself</b> to {1} poses, one after another, for {2}.")
    robot = robot[:1].upper() + robot[1:]
    sentences: list[str] = [markup(text, robot, plan.views, duration_text(plan.seconds))]
    if plan.eye == "head":
        text = translate("HandEye", "The head turns at up to {0:.0f} °/s; the arm rests.")
        sentences.append(text.format(plan.fastest))
        text = translate("HandEye", "Pan stays within {0}° to {1}°, tilt within {2}° to {3}°.")
        ends = [signed(end, 0) for axis in zip(plan.low, plan.high, strict=True) for end in axis]
        sentences.append(text.format(*ends))
    else:
        text = translate(
            "HandEye", "The hand moves at up to {0:.0f} mm/s, first by {1} small moves of at most {2:.0f}°."
        )
        sentences.append(text.format(1e3 * plan.fastest, plan.small_moves, SMALL_DEGREES))
        text = translate("HandEye", "Each joint stays within {0:.0f}° of where it is now.")
        sentences.append(text.format(SPAN_DEGREES))
        text = translate(
            "HandEye", "The hand stays within x {0} to {1}, y {2} to {3}, z {4} to {5} m in the base."
        )
        ends = [signed(end, 2) for axis in zip(plan.low, plan.high, strict=True) for end in axis]
        sentences.append(text.format(*ends))
        text = translate("HandEye", "The robot's body is not known: only the workspace is checked.")
        if plan.clearance:
            text = translate("HandEye", "The arm keeps {0:.0f} mm away from body and configured obstacles.")
        sentences.append(text.format(1e3 * plan.clearance))
    if nominal:
        text = translate(
            "HandEye", "<b>The camera is not calibrated</b>: calibrate it first, or the result is rough."
        )
        sentences.append(Markup(text))
    sentences.append(
        translate("HandEye", "Space, Escape and the stop button stop it at once, from any of its windows.")
    )
    return joined(markup("<p>{0}</p>", localized(sentence)) for sentence in sentences)


def duration_text(seconds: float) -> str:
    """Return a rough duration."""
    if seconds < 55:
        return translate("HandEye", "about {0} s").format(max(5, 5 * round(seconds / 5)))
    return translate("HandEye", "about {0} min").format(max(1, round(seconds / 60)))


def progress_text(progress: Progress) -> str:
    """Return an event of a run as display text."""
    if progress.step is Step.MOVING:
        return translate("HandEye", "moving to pose {0}").format(progress.views + 1)
    if progress.step is Step.VIEW:
        return translate("HandEye", "pose {0} taken").format(progress.views)
    if progress.step is Step.COMPUTING:
        return translate("HandEye", "computing the result")
    if progress.known is not None:
        metres, radians = progress.known
        text = translate("HandEye", "known to {0:.1f} mm and {1:.2f}°")
        return localized(text.format(1e3 * metres, math.degrees(radians)))
    reason = driver_text(progress.detail) if progress.detail else skip_text(progress.skip)
    return translate("HandEye", "skipped: {0}").format(reason)


def skip_text(skip: Skip | None) -> str:
    """Return why a pose was skipped."""
    return {
        None: "",
        Skip.OBSTRUCTED: translate("HandEye", "the gate refuses it"),
        Skip.NOT_REACHED: translate("HandEye", "it was not reached"),
        Skip.NOT_SEEN: translate("HandEye", "the target is not seen reliably"),
        Skip.NOT_AT_REST: translate("HandEye", "the robot did not come to rest"),
    }[skip]


def ended_text(problem: str, views: int) -> str:
    """Return how a run without a result ended, and what the user can do."""
    if views >= FEWEST_VIEWS:
        text = translate(
            "HandEye", "{0}. The robot stands still. {1} poses were taken: compute from them, or start again"
        )
    else:
        text = translate("HandEye", "{0}. The robot stands still. Poses taken: {1}; needed: {2}. Start again")
    return text.format(problem, views, FEWEST_VIEWS)


def result_rows(result: HandEyeResult, placement: CameraMount) -> list[tuple[str, str]]:
    """Return the names and values of a result, the values as HTML."""
    camera, covariance = placement.on_mount(result.camera), _on_mount(result, placement)
    spread = np.sqrt(np.diag(covariance))
    metres, radians = result.uncertainty
    used = sum(not math.isnan(error) for error in result.errors)
    places = [
        with_spread(1e3 * value, 1e3 * off, 1) for value, off in zip(camera[:3, 3], spread[:3], strict=True)
    ]
    turns = [
        with_spread(value, math.degrees(off), 2)
        for value, off in zip(roll_pitch_yaw(camera), spread[3:], strict=True)
    ]
    rows: list[tuple[str, str]] = [
        (
            translate("HandEye", "Known to"),
            markup("<b>{0:.2f} mm, {1:.3f}°</b>", 1e3 * metres, math.degrees(radians)),
        ),
        (translate("HandEye", "x, y, z (mm)"), joined(places, ",&nbsp; ")),
        (translate("HandEye", "Roll, pitch, yaw (°)"), joined(turns, ",&nbsp; ")),
        (
            translate("HandEye", "Residual"),
            translate("HandEye", "{0:.3f} px over {1} of {2} poses").format(
                result.rms, used, len(result.errors)
            ),
        ),
        (
            translate("HandEye", "Method"),
            translate("HandEye", "{0}, refined with all corners together").format(result.method or "OpenCV"),
        ),
    ]
    offsets = (result.camera_offsets, result.target_offsets)
    if any(part.any() for part in offsets):
        degrees = ", ".join(signed(math.degrees(offset), 2) for part in offsets for offset in part)
        rows.append((translate("HandEye", "Joint offsets"), f"{degrees}°"))
    return [(name, localized(text)) for name, text in rows]


def comparison_text(origin: str, metres: float, radians: float) -> str:
    """Return the difference from the transform in use; `origin` is the robot, its model, or a file."""
    where = {
        "robot": translate("HandEye", "the calibration in use"),
        "model": translate("HandEye", "the robot's model, which is in use"),
    }.get(origin, origin)
    text = translate("HandEye", "{0:.1f} mm and {1:.2f}° from {2}")
    return localized(text.format(1e3 * metres, math.degrees(radians), where))


def roll_pitch_yaw(pose: Pose) -> tuple[float, float, float]:
    """Return degrees about the fixed axes x, y, z, the convention of tf and URDF."""
    turn = pose[:3, :3]
    pitch = math.atan2(-turn[2, 0], math.hypot(turn[0, 0], turn[1, 0]))
    roll, yaw = math.atan2(turn[2, 1], turn[2, 2]), math.atan2(turn[1, 0], turn[0, 0])
    return math.degrees(roll), math.degrees(pitch), math.degrees(yaw)


def signed(value: float, decimals: int) -> str:
    """Return a number with a typographic minus sign, and without a sign if it rounds to zero."""
    text = f"{value:.{decimals}f}"
    return text.lstrip("-") if not float(text) else text.replace("-", "−")


def with_spread(value: float, spread: float, fewest: int) -> str:
    """Return value ± spread with decimals down to the spread's first digit, `fewest` to two more."""
    shown = -math.floor(math.log10(spread)) if spread > 0 else fewest
    decimals = min(max(shown, fewest), fewest + 2)
    return f"{signed(value, decimals)}\u00a0±\u00a0{spread:.{decimals}f}"


def _on_mount(result: HandEyeResult, placement: CameraMount) -> Pose:
    """Return the covariance of a result in the axes of the mount's frame."""
    turn = np.kron(np.eye(2), placement.turned[:3, :3])
    turned: Pose = turn @ result.covariance @ turn.T
    return turned
