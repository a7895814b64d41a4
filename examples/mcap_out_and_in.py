"""Record an MCAP file for ROS 2 and Foxglove, and read it: python mcap_out_and_in.py gige:."""

import sys
from pathlib import Path

import grabbergui

path = Path("recording.mcap")
path.unlink(missing_ok=True)
with grabbergui.open(sys.argv[1] if len(sys.argv) > 1 else "sim:") as camera:
    done = camera.record(path, frames=30).wait()
    print(f"{path}: {done.frames} frames, {done.dropped} dropped, {done.size / 1e6:.0f} MB")

with grabbergui.open(f"file:{path}") as recording:
    for frame in recording.frames(5):
        print(frame.frame_id, frame.raw().mean().round(1))
