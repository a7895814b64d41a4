"""Save one image: python one_image.py gige:192.168.0.10."""

import sys

import cv2

import grabbergui

with grabbergui.open(sys.argv[1] if len(sys.argv) > 1 else "sim:colour") as camera:
    frame = camera.grab(ExposureTime=10_000)
    cv2.imwrite("image.png", cv2.cvtColor(frame.rgb(), cv2.COLOR_RGB2BGR))
    print(f"image.png: {frame.width}x{frame.height} {frame.pixel_format}, {camera.exposure_time:g} us")
