"""Read the settings of each frame from its chunk data: python chunks.py gige:."""

import sys

import grabbergui

with grabbergui.open(sys.argv[1] if len(sys.argv) > 1 else "sim:") as camera:
    for chunk in ("ExposureTime", "Gain", "Timestamp"):
        camera[f"ChunkEnable[ChunkSelector={chunk}]"] = True
    camera["ChunkModeActive"] = True
    camera["ExposureAuto"] = "Continuous"
    for frame in camera.frames(10):
        values = {name.removeprefix("Chunk"): value for name, value in frame.chunks.items()}
        print(frame.frame_id, values)
    camera["ExposureAuto"] = "Off"
    camera["ChunkModeActive"] = False
