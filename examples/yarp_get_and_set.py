"""Tune a camera that another computer serves on YARP: python yarp_get_and_set.py yarp:/grabber.

Serve one with `grabbergui serve sim: --yarp /grabber --with-name-server`.
"""

import sys

import grabbergui

with grabbergui.open(sys.argv[1] if len(sys.argv) > 1 else "yarp:/grabber") as camera:
    print("exposure time", camera.exposure_time, "gain", camera.gain)
    camera.gain = 6
    print("gain is now", camera.gain)
    for frame in camera.frames(5):
        print("frame", frame.frame_id, frame.rgb().shape)
