"""Is this camera fit for work? Opens it, sets it, looks at its frames; exit code 0 means yes.

    grabbergui gui --offscreen --script check_camera.py

`CAMERA` in the environment names another source than the simulated camera.
"""

import os

# ruff: noqa: F821  (`desk` is the window's)

desk.open(os.environ.get("CAMERA", "sim:"))

dark = desk.wait_for_frames().rgb().mean()
exposure = desk.get("ExposureTime")
desk.set("ExposureTime", min(exposure.value * 2, exposure.maximum))
bright = desk.wait_for_frames(5).rgb().mean()
assert bright > dark, f"twice the exposure made it no brighter: {dark:.0f} before, {bright:.0f} now"

desk.wait_for_frames(30)
lost = desk.grabber.statistics().lost
if lost:
    print(f"{lost} frames were lost")
    desk.end(3)

desk.set("ExposureTime", exposure.value)
desk.screenshot("camera.png")
print(f"{desk.grabber.info.title}: {dark:.0f} → {bright:.0f}, nothing lost")
