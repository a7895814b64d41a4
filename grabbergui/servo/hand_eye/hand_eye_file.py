"""The file of a hand–eye calibration: plain YAML, with poses as in ROS's static transforms."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.calibration.opencv_yaml import read_yaml, text_of
from grabbergui.core.environment import write_whole
from grabbergui.core.errors import UsageError
from grabbergui.core.shell_words import shell_word
from grabbergui.servo.hand_eye.solver import HandEyeResult

_LONGEST_LIST = 100
"Longest list of numbers in a file; more than a robot has joints."


@dataclass(frozen=True, eq=False)
class CameraMount:
    """The link that carries the camera, by its names in tf."""

    eye: str
    "`head`, `hand` or `fixed`."
    mount: str
    "The frame that the camera is mounted on."
    frame: str
    "The camera's optical frame."
    turned: Pose = field(default_factory=lambda: np.eye(4))
    "The pose of the kinematic chain's tool in `mount`."

    def on_mount(self, camera: Pose) -> Pose:
        """Return the pose of the camera in `mount`."""
        placed: Pose = self.turned @ camera
        return placed


def static_transform_command(result: HandEyeResult, placement: CameraMount) -> str:
    """Return the command that publishes the camera's pose on tf."""
    placed = placement.on_mount(result.camera)
    x, y, z = placed[:3, 3]
    turn = geometry.quaternion_from_rotation(placed[:3, :3])
    axes = " ".join(f"--q{axis} {value:.6f}" for axis, value in zip("xyzw", turn, strict=True))
    return (
        f"ros2 run tf2_ros static_transform_publisher --x {x:.6f} --y {y:.6f} --z {z:.6f} {axes} "
        f"--frame-id {shell_word(placement.mount)} --child-frame-id {shell_word(placement.frame)}"
    )


def save(result: HandEyeResult, path: Path, placement: CameraMount | None = None) -> None:
    """Write a result, with the names of the frames if `placement` is given. Raises OSError."""
    metres, radians = result.uncertainty
    content: dict[str, Any] = {}
    if placement is not None:
        content["eye"] = placement.eye
        content["transform"] = {
            "frame_id": placement.mount,
            "child_frame_id": placement.frame,
            **_pose_entry(placement.on_mount(result.camera)),
        }
    content |= {
        "camera": _pose_entry(result.camera),
        "target": _pose_entry(result.target),
        "camera_joint_offsets": [float(value) for value in result.camera_offsets],
        "target_joint_offsets": [float(value) for value in result.target_offsets],
        "uncertainty": {"metres": metres, "degrees": math.degrees(radians)},
        "covariance": [[float(value) for value in row] for row in result.covariance],
        "reading_spread": result.reading_spread,
        "rms_pixels": result.rms,
        "method": result.method,
    }
    header = "# Hand–eye calibration: metres and radians; rotations are quaternions x y z w.\n"
    write_whole(path, header + yaml.safe_dump(content, sort_keys=False, default_flow_style=None))


def placement(path: Path) -> CameraMount | None:
    """Read the link that carries the camera; None if the file has none. Raises UsageError, OSError."""
    content = _content(path)
    entry = content.get("transform")
    if entry is None:
        return None
    names = [content.get("eye")]
    names += [entry.get(key) for key in ("frame_id", "child_frame_id")] if isinstance(entry, dict) else [None]
    if not all(isinstance(name, str) for name in names):
        raise UsageError(f"{path}: eye, or frame_id and child_frame_id of transform, are no names")
    turned = _pose(content, "transform", path) @ geometry.inverse(_pose(content, "camera", path))
    eye, mount, frame = map(str, names)
    return CameraMount(eye, mount, frame, turned)


def load(path: Path) -> HandEyeResult:
    """Read a result. Raises UsageError for a file without one, OSError."""
    content = _content(path)
    return HandEyeResult(
        _pose(content, "camera", path),
        _pose(content, "target", path),
        _numbers(content, "camera_joint_offsets", None, path),
        _numbers(content, "target_joint_offsets", None, path),
        _numbers(content, "covariance", (6, 6), path),
        float(_numbers(content, "rms_pixels", (), path)),
        (),
        float(_numbers(content, "reading_spread", (), path)),
        _name(content, "method", path),
    )


def _content(path: Path) -> dict[str, Any]:
    content = read_yaml(text_of(path), str(path))
    if not content:
        raise UsageError(f"{path} holds no hand–eye calibration; `grabbergui hand-eye` writes one")
    return content


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
    entry = content.get(key)
    if not _is_small(entry):
        raise UsageError(f"{path} has no numbers under {key}")
    try:
        numbers = np.asarray(entry, np.float64)
    except (ValueError, OverflowError) as error:
        raise UsageError(f"{path} has no numbers under {key}") from error
    fits = numbers.ndim == 1 if shape is None else numbers.shape == shape
    if not fits or not np.isfinite(numbers).all():
        size = "a list" if shape is None else "×".join(map(str, shape)) or "one number"
        raise UsageError(f"{path}: {key} must be {size} of finite numbers")
    return numbers


def _is_small(entry: object, dimensions: int = 2) -> bool:
    """Return whether an entry is a number or short lists of numbers, as aliases can make lists huge."""
    if not isinstance(entry, list):
        return isinstance(entry, int | float)
    short = dimensions > 0 and len(entry) <= _LONGEST_LIST
    return short and all(_is_small(each, dimensions - 1) for each in entry)


def _name(content: dict[str, Any], key: str, path: Path) -> str:
    entry = content.get(key, "")
    if not isinstance(entry, str):
        raise UsageError(f"{path}: {key} is no name")
    return entry
