"""Poses of cameras that look at a point, for the scenes of benchmarks and tests."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from grabbergui.calibration.geometry import Pose, pose


def looking_at(eye: ArrayLike, target: ArrayLike, up: ArrayLike = (0.0, 0.0, 1.0)) -> Pose:
    """Return the pose of a camera at `eye` (z forward, x right, y down) that looks at `target`."""
    position = np.asarray(eye, np.float64)
    forward = np.asarray(target, np.float64) - position
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, np.asarray(up, np.float64))
    right /= np.linalg.norm(right)
    return pose(np.column_stack((right, np.cross(forward, right), forward)), position)
