"""What every test runs under. Its presence makes the modules of this folder importable from them."""

import os
import signal

from hypothesis import HealthCheck, settings

# No test looks for cameras beyond this machine, or needs a display.
os.environ["GRABBERGUI_INTERFACES"] = "lo"
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

# Who starts programs in the background lets them ignore Ctrl+C, and all that they start.
signal.signal(signal.SIGINT, signal.default_int_handler)

# How long an example takes says how busy the machine is; pytest's own limit finds what hangs.
settings.register_profile("patient", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("patient")

pytest_plugins = ["peers"]
