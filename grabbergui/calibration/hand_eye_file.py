"""Hand–eye results in a file of the robot: plain YAML, with poses as ROS's static transforms have them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.calibration.hand_eye import HandEyeResult
from grabbergui.core.errors import UsageError


def save(result: HandEyeResult, path: Path) -> None:
    """Write a result. Raises OSError."""
    metres, radians = result.uncertainty
    content = {
        "camera": _pose_entry(result.camera),
        "target": _pose_entry(result.target),
        "camera_joint_offsets": [float(value) for value in result.camera_offsets],
        "target_joint_offsets": [float(value) for value in result.target_offsets],
        "uncertainty": {"metres": metres, "degrees": math.degrees(radians)},
        "covariance": [[float(value) for value in row] for row in result.covariance],
        "reading_spread": result.reading_spread,
        "rms_pixels": result.rms,
    }
    header = "# Hand–eye calibration: metres and radians; rotations are quaternions x y z w.\n"
    path.write_text(header + yaml.safe_dump(content, sort_keys=False, default_flow_style=None), "utf-8")


def load(path: Path) -> HandEyeResult:
    """Read a result. Raises UsageError for a file that holds none, OSError."""
    try:
        content = yaml.safe_load(path.read_text("utf-8", "replace"))
    except yaml.YAMLError as error:
        raise UsageError(f"{path} is no YAML: {error}") from error
    if not isinstance(content, dict):
        raise UsageError(f"{path} holds no hand–eye calibration; `calibration.hand_eye_file` writes one")
    return HandEyeResult(
        _pose(content, "camera", path),
        _pose(content, "target", path),
        _numbers(content, "camera_joint_offsets", None, path),
        _numbers(content, "target_joint_offsets", None, path),
        _numbers(content, "covariance", (6, 6), path),
        float(_numbers(content, "rms_pixels", (), path)),
        (),
        float(_numbers(content, "reading_spread", (), path)),
    )


def _pose_entry(pose: Pose) -> dict[str, list[float]]:
    return {
        "translation": [float(value) for value in pose[:3, 3]],
        "rotation": list(geometry.quaternion_from_rotation(pose[:3, :3])),
    }


def _pose(content: dict[str, Any], key: str, path: Path) -> Pose:
    entry = content.get(key)
    if not isinstance(entry, dict):
        raise UsageError(f"{path} has no {key} with a translation and a rotation")
    rotation = geometry.rotation_from_quaternion(*map(float, _numbers(entry, "rotation", (4,), path)))
    pose = geometry.pose(rotation, _numbers(entry, "translation", (3,), path))
    if not geometry.is_pose(pose):
        raise UsageError(f"{path}: the rotation of {key} is no quaternion")
    return pose


def _numbers(content: dict[str, Any], key: str, shape: tuple[int, ...] | None, path: Path) -> Vector:
    """Return an entry's finite numbers; of any length if `shape` is None."""
    try:
        numbers = np.asarray(content[key], np.float64)
    except (KeyError, TypeError, ValueError) as error:
        raise UsageError(f"{path} has no numbers under {key}") from error
    fits = numbers.ndim == 1 if shape is None else numbers.shape == shape
    if not fits or not np.isfinite(numbers).all():
        size = "a list" if shape is None else "×".join(map(str, shape)) or "one number"
        raise UsageError(f"{path}: {key} must be {size} of finite numbers")
    return numbers
