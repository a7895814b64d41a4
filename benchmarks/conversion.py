"""Unpacking, converting and reducing images, per pixel format, compared with OpenCV.

python -m benchmarks conversion [--seconds 0.15] [--without-numba]
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from functools import partial

import cv2
import numpy as np

from benchmarks import _document
from benchmarks._results import Goal, Section, Table, machine
from grabbergui.core import compiled_loops, pixels
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import FORMATS, Family, PixelFormat

WIDTH, HEIGHT = 2448, 2048
VIEW = (1200, 1000)
"Approximate size of the image view on a full-HD screen."

METHOD = """{width}×{height} pixels of noise on one core; the shortest of many runs counts. *Peer* is the
least possible work: a plain copy if only bytes move, otherwise OpenCV's own conversion of 8-bit pixels that
are already unpacked. *For the view* is what the window needs: the image is reduced to {columns}×{rows}
before its colour is computed. Measured with numba (the extra `fast`); `--without-numba` measures the slower
ways."""

MEASURED = {
    *("Mono8", "Mono10", "Mono10p", "Mono12", "Mono12p", "Mono12Packed", "Mono14p", "Mono16", "RGB8", "BGR8"),
    *("RGBa8", "BGRa8", "YUV422_8", "YUV422_8_UYVY", "YCbCr601_422_8", "YCbCr709_422_8", "YCbCr2020_422_8"),
}
"One format of each layout, besides Bayer."
UNPACKING = "10 to 14 packed bits unpacked in at most 2 × a plain copy"
PACKED_BAYER = "RGB from packed Bayer in at most 2 × OpenCV's conversion of 8 bits"
YUV = "RGB from YUV 4:2:2 in at most 1.5 × OpenCV's conversion"
GOALS = {UNPACKING: 2.0, PACKED_BAYER: 2.0, YUV: 1.5}
"Goals with compiled loops (the extra `fast`); the worst format of each kind counts."
_ONE_OF_EACH = ("", "RG")
"The Bayer orders differ only in a constant, so one is measured."


def measure(argv: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks conversion", description=__doc__)
    parser.add_argument("--seconds", type=float, default=0.15, help="spent on each figure")
    parser.add_argument("--without-numba", action="store_true", help="as it is without the extra `fast`")
    options = parser.parse_args(argv)
    seconds = options.seconds
    cv2.setNumThreads(1)
    compiled_loops.disable(options.without_numba)
    compiled_loops.wait()
    before, rows = machine(), []
    worst = dict.fromkeys(GOALS, ("", 0.0))
    for pixel_format in FORMATS:
        if not pixel_format.convertible:
            continue
        if pixel_format.family is Family.BAYER and pixel_format.order not in _ONE_OF_EACH:
            continue
        if pixel_format.name not in MEASURED and pixel_format.family is not Family.BAYER:
            continue
        frame = random_frame(pixel_format, WIDTH, HEIGHT)
        peer_name, peer = peer_of(frame)
        raw = best_ms(partial(pixels.to_raw, frame), seconds)
        rgb = best_ms(partial(pixels.to_rgb, frame), seconds)
        view = best_ms(partial(pixels.for_display, frame, size=VIEW), seconds)
        against = best_ms(peer, seconds)
        copied = best_ms(frame.payload.copy, seconds)
        for goal, ratio in _judged(pixel_format, raw / copied, rgb / against):
            worst[goal] = max(worst[goal], (pixel_format.name, ratio), key=lambda each: each[1])
        figures = [
            f"{raw:.2f} ms",
            f"{raw / copied:.1f}",
            f"{rgb:.1f} ms",
            peer_name,
            f"{against:.1f} ms",
            f"{rgb / against:.1f}",
        ]
        rows.append([pixel_format.name, *figures, f"{view:.1f} ms", per_second(view)])
    header = [
        "format",
        "unpacking",
        "× copy",
        "RGB",
        "peer",
        "peer's time",
        "RGB × peer",
        "for the view",
        "views/s",
    ]
    return Section(
        "Converting images",
        "python -m benchmarks conversion          # 15 seconds",
        METHOD.format(width=WIDTH, height=HEIGHT, columns=VIEW[0], rows=VIEW[1]),
        [Table(header, rows)],
        goals=[
            Goal(goal, f"{ratio:.1f} × ({name})", ratio <= GOALS[goal])
            for goal, (name, ratio) in worst.items()
        ],
        machine=before,
    )


def _judged(pixel_format: PixelFormat, unpacking: float, colour: float) -> list[tuple[str, float]]:
    """Return the goals that a format counts for, with its ratios."""
    found = []
    if pixel_format.packed and pixel_format.depth >= 10:
        found.append((UNPACKING, unpacking))
        if pixel_format.family is Family.BAYER:
            found.append((PACKED_BAYER, colour))
    if pixel_format.family is Family.YUV:
        found.append((YUV, colour))
    return found


def random_frame(pixel_format: PixelFormat, width: int, height: int) -> Frame:
    """Return noise of the right size; no conversion depends on the content."""
    size = pixel_format.image_bytes(width, height)
    payload = np.random.default_rng(0).integers(0, 256, size, np.uint8)
    return Frame(payload, width, height, pixel_format)


def peer_of(frame: Frame) -> tuple[str, Callable[[], object]]:
    """Return the name of a conversion to RGB by OpenCV or numpy to compare with, and the conversion."""
    shape, family, order = (frame.height, frame.width), frame.pixel_format.family, frame.pixel_format.order
    if order == "RGB":
        return "copy", frame.payload.copy
    if family is Family.RGB:
        code = {"BGR": cv2.COLOR_BGR2RGB, "RGBa": cv2.COLOR_RGBA2RGB, "BGRa": cv2.COLOR_BGRA2RGB}[order]
        data = frame.payload.reshape(*shape, -1)
        return "cv2.cvtColor", lambda: cv2.cvtColor(data, code)
    if family is Family.YUV:
        code = cv2.COLOR_YUV2RGB_YUYV if order == "YUYV" else cv2.COLOR_YUV2RGB_UYVY
        data = frame.payload.reshape(*shape, 2)
        return "cv2 (studio range)", lambda: cv2.cvtColor(data, code)
    data = np.zeros(shape, np.uint8)
    if family is Family.BAYER:
        return "cv2 Bayer, 8 bit", lambda: cv2.cvtColor(data, cv2.COLOR_BayerRGGB2RGB)
    return "cv2 grey, 8 bit", lambda: cv2.cvtColor(data, cv2.COLOR_GRAY2RGB)


def best_ms(function: Callable[[], object], seconds: float) -> float:
    """Return the shortest of the runs that fit into `seconds`, in milliseconds; at least three."""
    function()
    best, runs, end = float("inf"), 0, time.perf_counter() + seconds
    while runs < 3 or time.perf_counter() < end:
        start = time.perf_counter()
        function()
        best, runs = min(best, time.perf_counter() - start), runs + 1
    return best * 1e3


def per_second(milliseconds: float) -> str:
    """Return frames per second, or a dash if there is nothing to do."""
    return f"{1e3 / milliseconds:.0f}" if milliseconds > 0.01 else "–"


if __name__ == "__main__":
    print(_document.markdown(measure()))
