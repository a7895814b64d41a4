"""What every test runs under. Its presence makes the modules of this folder importable from them."""

import os

# No test looks for cameras beyond this machine, or needs a display.
os.environ["GRABBERGUI_INTERFACES"] = "lo"
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

pytest_plugins = ["peers"]
