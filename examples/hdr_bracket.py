"""Merge three exposures into one HDR image: python hdr_bracket.py u3v:."""

import sys

import cv2
import numpy as np

import grabbergui

EXPOSURES = [2_000, 8_000, 32_000]

with grabbergui.open(sys.argv[1] if len(sys.argv) > 1 else "sim:colour") as camera:
    frames = camera.bracket(ExposureTime=EXPOSURES)  # each exposed with its own time
    images = [cv2.cvtColor(frame.rgb(), cv2.COLOR_RGB2BGR) for frame in frames]
    merged = cv2.createMergeMertens().process(images)
    cv2.imwrite("hdr.png", np.clip(merged * 255, 0, 255).astype(np.uint8))
    print("brightness", *(f"{image.mean():.0f}" for image in images), "merged into hdr.png")
