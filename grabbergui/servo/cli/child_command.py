"""A command of this program as a child process, whose lines are printed behind its name."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Sequence
from typing import IO

from grabbergui.core.errors import SourceUnavailableError
from grabbergui.core.visible_text import print_line

_END_S = 15.0
"Seconds that a command has to end: a window asks a camera, a robot is stopped."
_WITH_ITS_PARENT = """
import ctypes, os, signal, sys
if sys.platform == "linux":
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG
    if os.getppid() != int(sys.argv[1]):
        raise SystemExit(1)
os.execv(sys.executable, [sys.executable, "-m", "grabbergui", *sys.argv[2:]])
"""
"Runs the command, which Linux ends if the parent is killed. Arguments: the parent's id, the command."


class ChildCommand:
    """Runs `grabbergui` with arguments. Start it on the main thread, with whose end it ends."""

    def __init__(self, name: str, arguments: Sequence[str]) -> None:
        self.name = name
        self.lines: list[str] = []
        "All lines that it has printed."
        self._process = subprocess.Popen(
            [sys.executable, "-c", _WITH_ITS_PARENT, str(os.getpid()), *arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            encoding="utf-8",
            errors="replace",
            env={**os.environ, "PYTHONIOENCODING": "utf-8"},
        )
        self._readers = [
            threading.Thread(target=self._print, args=(lines,), name=f"lines of {name}", daemon=True)
            for lines in (self._process.stdout, self._process.stderr)
        ]
        for reader in self._readers:
            reader.start()

    @property
    def code(self) -> int | None:
        """The exit code; None while it runs."""
        return self._process.poll()

    def printed(self, start: str) -> bool:
        """Return whether it has printed a line that begins so.

        Raises SourceUnavailableError if it has ended without.
        """
        if any(line.startswith(start) for line in self.lines):
            return True
        if self.code is not None:
            raise SourceUnavailableError(f"{self.name} ended with exit code {self.code}: see its lines above")
        return False

    def end(self) -> None:
        """End it as Ctrl-C does, and wait for it. May be called twice."""
        if self.code is None:
            self._process.terminate()
        try:
            self._process.wait(_END_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        for reader in self._readers:
            reader.join()

    def _print(self, lines: IO[str]) -> None:
        with lines:
            for line in lines:
                self.lines.append(line := line.rstrip("\n"))
                print_line(f"{self.name}: {line}", flush=True)
