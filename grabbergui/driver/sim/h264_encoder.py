"""Encodes the simulated camera's images as an H.264 stream, one access unit an image."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

KEY_PERIOD = 10
"Images from key frame to key frame."
_OPTIONS = {"tune": "zerolatency", "preset": "ultrafast", "profile": "baseline", "g": str(KEY_PERIOD)}


class H264Encoder:
    """Encodes the images of one acquisition after another. One thread."""

    def __init__(self) -> None:
        self._encoder: Any = None
        self._shape: tuple[int, ...] = ()

    def encode(self, frame_id: int, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the access unit of an image, (height, width) grey or (height, width, 3) R G B."""
        import av

        if frame_id == 1 or self._encoder is None or image.shape != self._shape:
            self._shape = image.shape
            self._encoder = av.CodecContext.create("libx264", "w")
            self._encoder.height, self._encoder.width = image.shape[:2]
            self._encoder.pix_fmt = "yuv420p"
            self._encoder.time_base = Fraction(1, 30)
            self._encoder.options = dict(_OPTIONS)
        kind = "rgb24" if image.ndim == 3 else "gray"
        frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(image), format=kind).reformat(
            format="yuv420p"
        )
        frame.pts = frame_id
        return np.frombuffer(b"".join(bytes(packet) for packet in self._encoder.encode(frame)), np.uint8)
