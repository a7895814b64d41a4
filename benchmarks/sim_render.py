"""Rate at which the simulated sensor renders its whole image (4096×2160) on one core, by pixel format.

python -m benchmarks sim_render [--formats Mono8 …]
"""

from __future__ import annotations

import argparse
import time

import cv2
import numpy as np

from benchmarks import _document
from benchmarks._results import Goal, Section, Table, machine
from grabbergui.core.pfnc import FORMATS, Family, PixelFormat, by_name
from grabbergui.driver.sim.registers import SENSOR_HEIGHT, SENSOR_WIDTH
from grabbergui.driver.sim.sensor import Sensor
from grabbergui.driver.sim.settings import FrameSettings, Optics

FRAMES = 20
RATE = 21.0
METHOD = """The whole sensor, {width}×{height} pixels, of the moving studio scene with exposure, gain, black
level and noise, on one core: the least that the source costs a benchmark with the simulated camera. Still
test patterns cost one copy of the image."""


def seconds_of_cpu(sensor: Sensor, pixel_format: PixelFormat) -> float:
    """Return the CPU seconds of rendering one image."""
    ratios = (1.0, 1.0, 1.0) if pixel_format.family is Family.MONO else (1.6, 1.0, 1.3)
    settings = FrameSettings(
        SENSOR_WIDTH, SENSOR_HEIGHT, 0, 0, pixel_format, Optics(ratios=ratios), 10_000.0, 6.0, 2.0
    )
    out = np.empty(settings.image_bytes, np.uint8)
    sensor.render(settings, 0, 0, out)
    start = time.process_time()
    for frame_id in range(FRAMES):
        sensor.render(settings, frame_id, frame_id * 33_000_000, out)
    return (time.process_time() - start) / FRAMES


def measure(arguments: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks sim_render", description=__doc__)
    parser.add_argument("--formats", nargs="+", help="all by default")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    before = machine()
    sensor, rows, taken = Sensor(), [], {}
    shown = [pixel_format for pixel_format in FORMATS if pixel_format.convertible]
    chosen = [by_name(name) for name in options.formats] if options.formats else shown
    for pixel_format in chosen:
        if not options.formats and pixel_format.family is Family.BAYER and pixel_format.order != "RG":
            continue
        seconds = taken[pixel_format.name] = seconds_of_cpu(sensor, pixel_format)
        share = f"{seconds * RATE:.0%}"
        rows.append([pixel_format.name, f"{seconds * 1e3:.1f} ms", f"{1 / seconds:.0f}", share])
    asked = f"8.8 MP at {RATE:g} frames per second with less than a quarter of a core"
    goals = [
        Goal(f"{asked}: {name}", f"{taken[name] * RATE:.0%}", taken[name] * RATE < 0.25)
        for name in ("Mono8", "BayerRG8")
        if name in taken
    ]
    return Section(
        "The simulated sensor",
        "python -m benchmarks sim_render          # a few seconds",
        METHOD.format(width=SENSOR_WIDTH, height=SENSOR_HEIGHT),
        [Table(["format", "CPU per image", "images/s", f"share of a core at {RATE:g}/s"], rows)],
        goals=goals,
        machine=before,
    )


if __name__ == "__main__":
    print(_document.markdown(measure()))
