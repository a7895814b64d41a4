"""Unpacking, converting and reducing pictures, per pixel format, beside what OpenCV needs for its own part.

All on one core. `peer` is the same run's time for the least anybody could do: a plain copy of the payload
where nothing but bytes move, and OpenCV's own conversion of ready unpacked 8-bit pixels for colour.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import cv2
import numpy as np

from grabbergui.core import pixels
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import CONVERTIBLE, Family, PixelFormat

WIDTH, HEIGHT = 2448, 2048
VIEW = (1200, 1000)
"The window's picture view on a full-HD screen, roughly."

_ONE_OF_EACH = ("", "RG")
"Bayer orders differ in a constant only: one is enough."


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks conversion", description=__doc__)
    parser.add_argument("--seconds", type=float, default=0.15, help="spent on each figure")
    seconds = parser.parse_args(argv).seconds
    megapixels = WIDTH * HEIGHT / 1e6
    cv2.setNumThreads(1)
    print(f"{WIDTH}×{HEIGHT}, {megapixels:.1f} MP, one core; view {VIEW[0]}×{VIEW[1]}")
    print(
        f"{'format':20}{'raw ms':>8}{'rgb ms':>8}{'ms/MP':>7}{'rgb fps':>9}{'peer ms':>9}{'ratio':>7}  "
        f"{'peer':18}{'view ms':>8}{'view fps':>10}"
    )
    for pixel_format in CONVERTIBLE:
        if pixel_format.family is Family.BAYER and pixel_format.order not in _ONE_OF_EACH:
            continue
        frame = random_frame(pixel_format, WIDTH, HEIGHT)
        peer_name, peer = peer_of(frame)
        raw = best_ms(lambda frame=frame: pixels.to_raw(frame), seconds)
        rgb = best_ms(lambda frame=frame: pixels.to_rgb(frame), seconds)
        view = best_ms(lambda frame=frame: pixels.for_display(frame, size=VIEW), seconds)
        against = best_ms(peer, seconds)
        print(
            f"{pixel_format.name:20}{raw:8.2f}{rgb:8.2f}{rgb / megapixels:7.2f}{per_second(rgb):>9}"
            f"{against:9.2f}{rgb / against:7.1f}  {peer_name:18}{view:8.2f}{per_second(view):>10}",
            flush=True,
        )


def random_frame(pixel_format: PixelFormat, width: int, height: int) -> Frame:
    """Noise of the right size: no conversion is quicker or slower for what the picture shows."""
    size = pixel_format.image_bytes(width, height)
    payload = np.random.default_rng(0).integers(0, 256, size, np.uint8)
    return Frame(payload, width, height, pixel_format)


def peer_of(frame: Frame) -> tuple[str, Callable[[], object]]:
    """What to compare a conversion to RGB with, and its name."""
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
    """The shortest of the runs that fit into `seconds`, in milliseconds; at least three."""
    function()
    best, runs, end = float("inf"), 0, time.perf_counter() + seconds
    while runs < 3 or time.perf_counter() < end:
        start = time.perf_counter()
        function()
        best, runs = min(best, time.perf_counter() - start), runs + 1
    return best * 1e3


def per_second(milliseconds: float) -> str:
    """Frames per second, or a dash where nothing is done at all."""
    return f"{1e3 / milliseconds:.0f}" if milliseconds > 0.01 else "–"


if __name__ == "__main__":
    main()
