"""Load settings from a file: python settings_from_file.py gige: camera.yaml."""

import sys

import grabbergui

source, path = (*sys.argv[1:], *("sim:", "camera.yaml")[len(sys.argv) - 1 :])

with grabbergui.open(source) as camera:
    if len(sys.argv) < 3:
        camera.save_settings(path)
        camera.gain = 6
    report = camera.load_settings(path)
    print(*report.lines(), sep="\n")
    sys.exit(0 if report.settled else 1)
