"""Is this camera fit for work? Opens it, sets it, looks at its frames; exit code 0 means yes.

    grabbergui gui gige:192.168.0.10 --offscreen --script check_camera.py

Without a source it tries the simulated camera.
"""

# ruff: noqa: F821  (`app` is the window's)

app.wait_for_source(otherwise="sim:")

dark = app.wait_for_frames().rgb().mean()
exposure = app.get("ExposureTime")
app.set("ExposureTime", min(exposure.value * 2, exposure.maximum))
bright = app.wait_for_frames(5).rgb().mean()
assert bright > dark, f"twice the exposure made it no brighter: {dark:.0f} before, {bright:.0f} now"

app.wait_for_frames(30)
lost = app.grabber.statistics().lost
if lost:
    print(f"{lost} frames were lost")
    app.end(3)

app.set("ExposureTime", exposure.value)
app.screenshot("camera.png")
print(f"{app.grabber.info.title}: {dark:.0f} → {bright:.0f}, nothing lost")
