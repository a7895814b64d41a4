"""Listen to a camera's own events: python events.py gige:."""

import sys
import time

import grabbergui

with grabbergui.open(sys.argv[1] if len(sys.argv) > 1 else "sim:") as camera:
    camera.on("event", print)
    camera.on("change", lambda names: print("changed:", *sorted(names)[:3]))
    camera["EventNotification[EventSelector=ExposureEnd]"] = "On"
    camera.exposure_time = 5_000
    for frame in camera.frames(5):
        print("frame", frame.frame_id)
    time.sleep(0.2)
