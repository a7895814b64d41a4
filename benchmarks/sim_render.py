"""How fast the simulated sensor renders a full picture (2448×2048) on one core, per pixel format.

    python benchmarks/sim_render.py [FORMAT…]
"""

import sys
import time

import cv2
import numpy as np

from grabbergui.core.pfnc import CONVERTIBLE, Family, by_name
from grabbergui.driver.sim.registers import SENSOR_HEIGHT, SENSOR_WIDTH
from grabbergui.driver.sim.sensor import Sensor
from grabbergui.driver.sim.settings import FrameSettings, Optics

FRAMES = 20


def measure(sensor, pixel_format):
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


def main():
    cv2.setNumThreads(1)
    formats = [by_name(name) for name in sys.argv[1:]] or CONVERTIBLE
    sensor = Sensor()
    for pixel_format in formats:
        seconds = measure(sensor, pixel_format)
        print(f"{pixel_format.name:20} {seconds * 1e3:6.2f} ms of CPU  {1 / seconds:7.0f} frames/s")


if __name__ == "__main__":
    main()
