"""Where frames sit on each other, from messages of `/tf_static`. No I/O."""

from __future__ import annotations

from typing import Any

import numpy as np

from grabbergui.calibration.geometry import Pose, pose, rotation_from_quaternion


class StaticFrames:
    """Fixed transforms between frames, from `tf2_msgs/TFMessage` on `/tf_static`."""

    def __init__(self) -> None:
        self._parents: dict[str, tuple[str, Pose]] = {}

    def take(self, message: Any) -> None:
        """Note a message's transforms."""
        for entry in message.transforms:
            place, turn = entry.transform.translation, entry.transform.rotation
            placed = pose(
                rotation_from_quaternion(turn.x, turn.y, turn.z, turn.w), (place.x, place.y, place.z)
            )
            if np.isfinite(placed).all():
                self._parents[entry.child_frame_id.lstrip("/")] = entry.header.frame_id.lstrip("/"), placed

    def of(self, child: str, ancestor: str) -> Pose | None:
        """Return the pose of a frame in one above it; None if it is not known."""
        placed, frame = pose(), child
        for _ in range(len(self._parents) + 1):
            if frame == ancestor:
                return placed
            if frame not in self._parents:
                return None
            frame, step = self._parents[frame]
            placed = step @ placed
        return None
