"""Interactive shells on a terminal of their own, in which completion is tried as a user would."""

from __future__ import annotations

import os
import select
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path

from grabbergui.setup import completion_scripts
from patience import PROGRAM

COMPLETER = [sys.executable, "-m", "grabbergui"]
BASH_COMPLETION = Path("/usr/share/bash-completion/bash_completion")
KINDS = ("bash", "bash with its package", "zsh", "fish")


def missing(kind: str) -> str:
    """Return why a kind of shell cannot be tried here; empty if it can."""
    if kind == "bash with its package":
        return "" if BASH_COMPLETION.exists() else "the package bash-completion is not installed"
    return "" if shutil.which(kind) else f"{kind} is not installed"


class Shell:
    """A shell with the completion installed, in a folder where `grabbergui` writes down its arguments."""

    def __init__(self, kind: str, folder: Path, environment: dict[str, str]) -> None:
        name = kind.split()[0]
        home = folder / "home"
        environment = {
            **{key: os.environ[key] for key in ("PYTHONPATH", "LANG") if key in os.environ},
            "LC_ALL": "C.UTF-8",
            "HOME": str(home),
            "XDG_DATA_HOME": str(home / "data"),
            "XDG_CONFIG_HOME": str(home / "config"),
            "ZDOTDIR": str(home),
            "TERM": "xterm",
            "PATH": f"{folder / 'bin'}:{os.environ['PATH']}",
            **environment,
        }
        self.work = folder / "work"
        "Where the lines are typed."
        for each in (home, self.work, folder / "bin"):
            each.mkdir(parents=True)
        self._arguments = folder / "arguments"
        program = folder / "bin" / "grabbergui"
        program.write_text(
            f"#!/bin/sh\nprintf '%s\\0' \"$@\" end > {self._arguments}.new; "
            f"mv {self._arguments}.new {self._arguments}\n"
        )
        program.chmod(0o755)
        script = completion_scripts.install(name, COMPLETER, environment)
        command = self._configured(kind, home, script)
        import pty

        self._leader, follower = pty.openpty()
        self._process = subprocess.Popen(
            ["setsid", "--ctty", *command],
            stdin=follower,
            stdout=follower,
            stderr=follower,
            env=environment,
            cwd=self.work,
        )
        os.close(follower)
        self.shown = b""
        "All that the terminal was sent."

    def _configured(self, kind: str, home: Path, script: Path) -> list[str]:
        if kind == "zsh":
            (home / ".zshrc").write_text(
                f"fpath=({shlex.quote(str(script.parent))} $fpath); autoload -U compinit; compinit -u -D\n"
            )
            return ["zsh", "-d", "-i"]
        if kind == "fish":
            return ["fish", "--interactive", "--private"]
        load = BASH_COMPLETION if kind == "bash with its package" else script
        (home / ".bashrc").write_text(f"source {shlex.quote(str(load))}\nset -o histexpand\n")
        return ["bash", "--rcfile", str(home / ".bashrc"), "-i"]

    def run(self, typed: str) -> list[str]:
        """Type a line with tab keys in it, and Enter; return the arguments that the program then gets."""
        self._arguments.unlink(missing_ok=True)
        *parts, last = typed.split("\t")
        for part in parts:
            self._type(f"{part}\t")
        self._type(f"{last}\r")
        ends = time.monotonic() + PROGRAM
        while not self._arguments.exists():
            assert time.monotonic() < ends, self.shown
            self._read(0.05)
        *arguments, end = self._arguments.read_text("utf-8").removesuffix("\0").split("\0")
        assert end == "end"
        return arguments

    def _type(self, text: str) -> None:
        os.write(self._leader, text.encode())
        self._read(0.02)

    def _read(self, seconds: float) -> None:
        while select.select([self._leader], [], [], seconds)[0]:
            self.shown += os.read(self._leader, 65536)
            seconds = 0

    def close(self) -> None:
        """End it."""
        self._process.kill()
        self._process.wait()
        os.close(self._leader)
