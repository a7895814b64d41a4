"""Payload bytes to arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from grabbergui.core.frame import Frame


def to_raw(frame: Frame) -> NDArray[Any]:
    """Interim."""
    n = frame.width * frame.height
    return frame.payload[:n].reshape(frame.height, frame.width)


def to_mono(frame: Frame) -> NDArray[np.uint8]:
    """Interim."""
    return to_raw(frame)


def to_rgb(frame: Frame) -> NDArray[np.uint8]:
    """Interim."""
    return np.repeat(to_raw(frame)[:, :, None], 3, axis=2)
