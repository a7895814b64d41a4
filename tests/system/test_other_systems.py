"""Windows and macOS: what is supported there works without the modules of POSIX and Linux."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from grabbergui import sources
from grabbergui.core.errors import SourceUnavailableError
from patience import PROGRAM

ROOT = Path(__file__).parents[2]
MISSING = {
    "win32": ("fcntl", "grp", "pwd", "resource", "termios", "tty", "pty", "syslog", "readline", "linuxpy"),
    "darwin": ("linuxpy", "spwd"),
}
"Modules that Python does not have there."
ABSENT = {
    "win32": {
        "os": ("fork", "register_at_fork", "sched_setscheduler", "getuid", "geteuid", "mkfifo", "getloadavg"),
        "signal": ("SIGHUP", "pthread_sigmask", "pthread_kill", "setitimer"),
        "socket": ("recvmsg_into", "MSG_DONTWAIT", "SO_REUSEPORT"),
    },
    "darwin": {"os": ("sched_setscheduler",), "socket": ("MSG_WAITFORONE",)},
}
"Names that its modules do not have there."
BLOCKED = """
import importlib, sys
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in MISSING:
            raise ModuleNotFoundError("No module named " + name, name=name)
sys.meta_path.insert(0, Finder())
for name in MISSING:
    sys.modules.pop(name, None)
for module, names in ABSENT.items():
    for name in names:
        vars(importlib.import_module(module)).pop(name, None)
sys.platform = PLATFORM
"""
LOADED_BEFORE = "numpy, cv2, psutil, av, genicam, subprocess, asyncio, multiprocessing, ctypes.util"
"They would take the system for another one."
JOBS = {
    "simulated camera": "with grabbergui.open(SMALL) as c: print(c.grab(ExposureTime=2000).rgb().shape)",
    "recording and playback": (
        "with grabbergui.open(SMALL) as c: c.record('run.mcap', frames=3).wait()\n"
        "with grabbergui.open('file:run.mcap') as c: print(c.grab().rgb().shape)"
    ),
    "settings": (
        "with grabbergui.open(SMALL) as c:\n"
        "    c.save_settings('a.yaml'); print(c.load_settings('a.yaml').settled)"
    ),
    "discovery": "print('sim:' in [info.uri for info in grabbergui.discover(0.3)])",
    "GigE Vision": (
        "from grabbergui.driver.sim.gige.server import GigeCamera\n"
        "simulated = GigeCamera('127.20.1.51')\n"
        "with grabbergui.open('gige:127.20.1.51?packet_size=keep') as c: print(c.grab().complete)\n"
        "simulated.close()"
    ),
    "command": "from grabbergui.cli import main; print(main(['get', SMALL, 'Gain']))",
}


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere all tests show it")
@pytest.mark.parametrize("platform", ["win32", "darwin"])
def test_it_works_without_the_modules_of_posix(
    platform: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not on the system itself: the public workflow tries it there."""
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    script = f"import {LOADED_BEFORE}\nPLATFORM, MISSING = {platform!r}, {MISSING[platform]!r}\n"
    script += f"ABSENT = {ABSENT[platform]!r}\n{BLOCKED}"
    script += "import grabbergui\nSMALL = 'sim:?width=64&height=48&fps=100&exposure=1000'\n"
    script += "\n".join(f"print({job!r}, end=': ')\n{text}" for job, text in JOBS.items())
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=PROGRAM
    )
    assert done.returncode == 0, done.stderr
    shown = dict(line.split(": ", 1) for line in done.stdout.splitlines() if ": " in line)
    assert shown == {
        "simulated camera": "(48, 64, 3)",
        "recording and playback": "(48, 64, 3)",
        "settings": "True",
        "discovery": "True",
        "GigE Vision": "True",
        "command": "Gain = 0 dB",
    }


def test_webcams_are_refused_elsewhere_with_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "win32")
    with pytest.raises(SourceUnavailableError, match="v4l2: sources exist on Linux only, and this is win32"):
        sources.create("v4l2:")
    assert sources.discover_kind("v4l2", 0.1) == []
