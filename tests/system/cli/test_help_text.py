"""The help of every command: an example that is accepted, a meaning for everything, no line too wide."""

import subprocess
import sys

from grabbergui.cli.guests import guest_commands
from patience import PROGRAM


def test_what_opens_no_camera_loads_neither_numpy_nor_opencv():
    code = """
import contextlib, sys
from grabbergui.cli import main
from grabbergui.cli.guests import guest_commands
light = ["setup", "list", "gui", "terminal", "simulate", "yarp-server", *guest_commands()]
for arguments in (["--version"], ["paths"], *([command, "--help"] for command in light)):
    with contextlib.suppress(SystemExit):
        main(arguments)
    print(arguments, *sorted({"numpy", "cv2", "psygnal"} & set(sys.modules)), file=sys.stderr)
import grabbergui.net.yarp.os.name_server
print("names", *sorted({"numpy", "cv2", "psygnal"} & set(sys.modules)), file=sys.stderr)
"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=PROGRAM
    )
    assert done.stderr.splitlines() == [
        "['--version']",
        "['paths']",
        "['setup', '--help']",
        "['list', '--help']",
        "['gui', '--help']",
        "['terminal', '--help']",
        "['simulate', '--help']",
        "['yarp-server', '--help']",
        *(f"['{command}', '--help']" for command in guest_commands()),
        "names",
    ]
