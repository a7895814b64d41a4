"""Resets to ordinary priority, for a program whose parent runs with a raised one."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path


def run_as_others() -> None:
    """Reset all threads of this process to ordinary scheduling."""
    for thread in Path("/proc/self/task").iterdir():
        with contextlib.suppress(ProcessLookupError):  # it has just ended
            os.sched_setscheduler(int(thread.name), os.SCHED_OTHER, os.sched_param(0))
