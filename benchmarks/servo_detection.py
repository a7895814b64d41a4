"""How long detection takes in a frame: ArUco at several sizes with and without reduction, and heads.

    python -m benchmarks servo_detection
"""

import argparse
import statistics
import time

import cv2
import numpy as np

from grabbergui.core.calibration import Calibration
from grabbergui.servo.aruco import ArucoFinder
from grabbergui.servo.desk import single_threaded
from grabbergui.servo.heads import CascadeFinder

SIZES = (("640×480", 640, 480), ("1080p", 1920, 1080), ("8.8 MP", 4096, 2160))
REPEATS = 15


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python -m benchmarks servo_detection", description=__doc__)
    parser.parse_args(arguments)
    single_threaded()
    for name, width, height in SIZES:
        calibration = Calibration.from_field_of_view(width, height, 60)
        grey = busy_picture(width, height)
        for title, finder in (
            ("ArUco, reduced search", ArucoFinder("4X4_50", 0.1, calibration)),
            ("ArUco, full picture", ArucoFinder("4X4_50", 0.1, calibration, search_pixels=1 << 30)),
            ("heads", CascadeFinder(calibration)),
        ):
            found = len(finder.detect(grey))
            print(f"{name:8} {title:24} {median_ms(finder, grey):7.1f} ms   {found} found")


def median_ms(finder, grey):
    times = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        finder.detect(grey)
        times.append(1e3 * (time.perf_counter() - began))
    return statistics.median(times)


def busy_picture(width, height):
    """Six markers, a twelfth of the width each, before clouds, lines and noise."""
    random = np.random.default_rng(1)
    clouds = cv2.resize(random.integers(60, 190, (24, 32), np.uint8), (width, height))
    for _ in range(60):
        ends = random.integers(0, (width, height), (2, 2))
        cv2.line(clouds, tuple(map(int, ends[0])), tuple(map(int, ends[1])), int(random.integers(0, 255)), 3)
    side = width // 12
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    for index in range(6):
        x, y = side + index * (width - 2 * side) // 6, height // 4 + (index % 3) * height // 5
        clouds[y - side // 5 : y + side + side // 5, x - side // 5 : x + side + side // 5] = 235
        clouds[y : y + side, x : x + side] = cv2.aruco.generateImageMarker(dictionary, 15 + index, side)
    noise = random.normal(0, 3, (height, width)).astype(np.float32)
    return np.clip(cv2.GaussianBlur(clouds, (0, 0), 0.8) + noise, 0, 255).astype(np.uint8)


if __name__ == "__main__":
    main()
