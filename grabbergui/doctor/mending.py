"""Remedies that the program can carry out itself, some with the rights of an administrator."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable

from grabbergui.core.errors import SourceUnavailableError

MOST_SECONDS = 120.0
"Seconds for the password to be typed and the command to end."
ASKS = "pkexec"
"Asks for the administrator's password in a dialog, and runs a command."


def as_administrator(*command: str) -> Callable[[], None] | None:
    """Return a function that runs a command as root, or None where that is not possible from here.

    The function waits for the command, and raises SourceUnavailableError if it fails or is refused.
    """
    if sys.platform == "win32":
        return None
    asks = () if os.geteuid() == 0 else (ASKS,)
    if asks and not shutil.which(ASKS):
        return None

    def run() -> None:
        try:
            done = subprocess.run(
                [*asks, *command], capture_output=True, text=True, timeout=MOST_SECONDS, check=False
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise SourceUnavailableError(f"{command[0]} could not be run: {error}") from error
        if done.returncode:
            reason = (done.stderr or done.stdout).strip() or "it was refused"
            raise SourceUnavailableError(f"{command[0]} failed: {reason}")

    return run
