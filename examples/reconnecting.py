"""Continue after a pulled cable: python reconnecting.py gige:192.168.0.10 60."""

import sys
import time

import grabbergui

source, seconds = (*sys.argv[1:], *("sim:", "2")[len(sys.argv) - 1 :])

with grabbergui.open(source) as camera:
    camera.exposure_time = 5_000  # restored when the camera is back
    camera.on("lost", lambda why: print("lost:", why))
    camera.on("back", lambda how: print("back:", how))
    camera.start()
    end = time.monotonic() + float(seconds)
    while time.monotonic() < end:
        try:
            print("frame", camera.grab(timeout=1.0).frame_id)
        except grabbergui.GrabberError as error:
            print(error)
            time.sleep(1.0)
