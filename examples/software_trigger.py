"""Trigger an image by software: python software_trigger.py gige:."""

import sys
import time

import grabbergui

with grabbergui.open(sys.argv[1] if len(sys.argv) > 1 else "sim:") as camera:
    for _ in range(5):
        fired = time.monotonic()
        frame = camera.trigger()
        late = 1000 * (frame.captured - fired)
        print(f"frame {frame.frame_id} was exposed {late:.1f} ms after the call")
    camera["TriggerMode"] = "Off"
