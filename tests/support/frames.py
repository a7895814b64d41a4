"""Frames made of arrays."""

import numpy as np

from grabbergui.core import pfnc
from grabbergui.core.frame import Frame


def frame_of(pixels, pixel_format="Mono8", frame_id=1):
    """Return a frame with these raw data: (h, w) or (h, w, n); 16-bit values little-endian."""
    height, width = pixels.shape[:2]
    payload = np.ascontiguousarray(pixels).view(np.uint8).reshape(-1)
    return Frame(payload, width, height, pfnc.by_name(pixel_format), frame_id)
