"""Show a live image with Matplotlib: python matplotlib_live.py sim:scene."""

import sys

import grabbergui

with grabbergui.open(sys.argv[1] if len(sys.argv) > 1 else "sim:scene") as camera:
    grabbergui.live_view(camera)  # until its window is closed
