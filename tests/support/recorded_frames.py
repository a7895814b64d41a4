"""Frames of every pixel format, recorded to files of every kind."""

import numpy as np

from grabbergui.core import pfnc
from grabbergui.core.frame import Frame
from grabbergui.core.identity import DeviceInfo
from grabbergui.recording.kinds import MOVIE_KINDS, RecordingKind
from grabbergui.recording.recorder import create_writer

INFO = DeviceInfo("sim:", vendor="V", model="M", serial="1")
START = 1_700_000_000_000_000_000
STEP = 20_000_000
NAMES = {
    RecordingKind.BAG: "bag",
    RecordingKind.PNG: "images",
    RecordingKind.TIFF: "images",
    **dict.fromkeys(MOVIE_KINDS, "movie.mp4"),
    RecordingKind.MCAP: "messages.mcap",
    RecordingKind.STACK: "stack.tiff",
    RecordingKind.NUMPY: "array.npy",
}


def made(name, index, width=48, height=32):
    """Return a frame of random pixels in the named pixel format, received `STEP` ns after the one before."""
    pixel_format = pfnc.by_name(name)
    rng = np.random.default_rng(index)
    payload = rng.integers(0, 256, pixel_format.image_bytes(width, height), np.uint8)
    if pixel_format.bits_per_pixel == 16 and pixel_format.depth < 16:
        payload = (payload.view("<u2") & (1 << pixel_format.depth) - 1).view(np.uint8)
    return Frame(
        payload,
        width,
        height,
        pixel_format,
        frame_id=index + 7,
        timestamp_ns=1000 + index,
        received_ns=START + index * STEP,
        offset_x=4,
    )


def written(kind, path, frames):
    """Write a recording of some frames and return its path."""
    writer = create_writer(kind, path, INFO)
    for frame in frames:
        writer.write(frame)
    writer.close()
    writer.close()
    return path
