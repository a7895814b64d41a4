"""Save an image every few seconds: python time_lapse.py gige: 10 360."""

import sys
import time

import cv2

import grabbergui

source, period, count = (*sys.argv[1:], *("sim:", "0.5", "4")[len(sys.argv) - 1 :])

with grabbergui.open(source) as camera:
    begun = time.monotonic()
    for number in range(int(count)):
        time.sleep(max(0.0, begun + number * float(period) - time.monotonic()))
        frame = camera.grab()
        cv2.imwrite(f"lapse-{number:05}.png", frame.mono())
        print(f"lapse-{number:05}.png at {frame.captured - begun:.2f} s")
