"""Read two cameras side by side: python two_cameras.py gige:192.168.0.10 gige:192.168.0.11."""

import sys

import cv2
import numpy as np

import grabbergui

with grabbergui.open_all(sys.argv[1:] or ["sim:", "sim:colour"]) as cameras:
    for camera in cameras:
        camera.exposure_time = 5_000
    for left, right in cameras.frames(20):
        apart = 1000 * abs(left.captured - right.captured)
    images = [cv2.resize(frame.rgb(), (640, 480)) for frame in (left, right)]
    cv2.imwrite("both.png", np.hstack(images)[..., ::-1])
    print(f"both.png: the last two frames were exposed {apart:.1f} ms apart")
