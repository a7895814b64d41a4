"""Scheduling of processes that must be in time beside other programs: the guardian, the servo loop.

With eight busy programs on two cores, an ordinary thread woke up to 150 ms late; one with real-time priority,
at most 1 ms. Linux grants that priority to root, to programs with CAP_SYS_NICE, and to users with an `rtprio`
limit (`/etc/security/limits.conf`, or `LimitRTPRIO=` of a systemd unit).
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Callable
from pathlib import Path

REALTIME = 10
"""Priority in SCHED_RR: ahead of every ordinary thread, behind the kernel's own."""
NICE = -10
"""Nice value where real-time priority is refused."""
_MCL_CURRENT, _MCL_ONFAULT = 1, 4
"Flags of `mlockall(2)`: pages that are mapped now stay in memory from their first use on."


def run_first() -> str:
    """Schedule all threads of this process ahead of other programs.

    Threads and processes that start later inherit the priority. Call it after a slow start: a real-time
    thread that computes holds up everything else on its core. Never raises. Return what was refused, and
    which limit would permit it; empty if the priority was granted.
    """
    if sys.platform != "linux":
        return "this system grants ordinary programs no real-time priority"
    if _for_each_thread(lambda thread: os.sched_setscheduler(thread, os.SCHED_RR, os.sched_param(REALTIME))):
        return ""
    refused = f"real-time priority {REALTIME} is not permitted (ulimit -r)"
    if _for_each_thread(lambda thread: os.setpriority(os.PRIO_PROCESS, thread, NICE)):
        return f"{refused}, nice {NICE} is"
    return f"{refused}, nor is nice {NICE} (ulimit -e)"


def run_as_others() -> None:
    """Schedule all threads of this process like other programs' again."""
    if sys.platform == "linux":
        _for_each_thread(lambda thread: os.sched_setscheduler(thread, os.SCHED_OTHER, os.sched_param(0)))


def single_threaded() -> None:
    """Let OpenCV compute on the threads that call it, in a process that should be in time on a busy computer.

    Its workers wait for each other without sleeping. Where other programs want the cores too, that takes more
    time from all of them than a second core gives.
    """
    import cv2  # the guardian has no use for it

    cv2.setNumThreads(1)


def lock_memory() -> str:
    """Keep the memory of this process from being swapped out. Never raises; return why it was refused."""
    if sys.platform != "linux":
        return "this system locks no memory of ordinary programs"
    if ctypes.CDLL(None).mlockall(_MCL_CURRENT | _MCL_ONFAULT):
        return "locked memory is not permitted (ulimit -l)"
    return ""


def _for_each_thread(change: Callable[[int], None]) -> bool:
    """Change every thread of this process by its kernel id. Return whether that was permitted."""
    for thread in Path("/proc/self/task").iterdir():
        try:
            change(int(thread.name))
        except PermissionError:
            return False
        except ProcessLookupError:
            pass  # it has just ended
    return True
