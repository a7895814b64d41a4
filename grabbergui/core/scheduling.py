"""When threads run: real-time priority, as far as the system permits it.

The guardian and threads that receive frames or send them on must wake in time. With eight busy programs on
two cores, an ordinary thread woke up to 150 ms late; one with real-time priority, at most 1 ms. Linux grants
that priority to root, to programs with CAP_SYS_NICE, and to users with an `rtprio` limit
(`/etc/security/limits.conf`, or `LimitRTPRIO=` of a systemd unit).
"""

from __future__ import annotations

import ctypes
import os
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

REALTIME = 10
"""SCHED_RR priority: above every ordinary thread, below the kernel's own."""
FRAMES = 5
"""SCHED_RR priority of a thread that receives frames or sends them on: below the guardian, which stops a
robot."""
NICE = -10
"""Nice value if real-time priority is refused."""
_MCL_CURRENT, _MCL_ONFAULT = 1, 4
"Flags of `mlockall(2)`: currently mapped pages stay in memory from their first use on."
REVIEW = 0.1
"Seconds between two reviews of a `RealtimeThread`."
MOST_WORK = 0.25
"Share of a core that a thread with real-time priority may need."


class RealtimeThread:
    """Gives the calling thread real-time priority while it mostly waits, so that it wakes without delay.

    While it computes, it has ordinary priority, as it would block everything else on its core. Threads and
    processes that it starts have ordinary priority. Use from one thread.
    """

    def __init__(self, most_work: float = MOST_WORK) -> None:
        """`most_work` is the share of a core that the thread may need: little where there may be many."""
        self.realtime = False
        "Whether the thread has real-time priority."
        self._most_work = most_work
        self._permitted = sys.platform == "linux" and len(os.sched_getaffinity(0)) > 1
        self._reviewed, self._worked = time.monotonic(), time.thread_time()

    def review(self, now: float) -> bool:
        """Choose the priority by the thread's recent share of a core; return `realtime`.

        `now` is monotonic time. Cheap enough for every iteration of a loop. Never raises.
        """
        if not self._permitted or now - self._reviewed < REVIEW:
            return self.realtime
        worked = time.thread_time()
        waits = worked - self._worked <= self._most_work * (now - self._reviewed)
        self._reviewed, self._worked = now, worked
        if waits != self.realtime:
            self._schedule(realtime=waits)
        return self.realtime

    def _schedule(self, *, realtime: bool) -> None:
        if sys.platform != "linux":
            return
        policy, priority = (os.SCHED_RR, FRAMES) if realtime else (os.SCHED_OTHER, 0)
        try:
            os.sched_setscheduler(0, policy | os.SCHED_RESET_ON_FORK, os.sched_param(priority))
        except OSError:
            self._permitted = False
        else:
            self.realtime = realtime


def realtime_threads_permitted() -> bool:
    """Return whether threads of this process may have real-time priority, as tried by a short-lived one."""
    tried: list[bool] = []

    def attempt() -> None:
        thread = RealtimeThread()
        tried.append(thread.review(time.monotonic() + REVIEW))

    attempting = threading.Thread(target=attempt, name="priority check")
    attempting.start()
    attempting.join()
    return tried == [True]


def run_first() -> str:
    """Give all threads of this process real-time priority.

    Threads and processes that start later inherit it. Call this after a slow start, as a real-time thread
    that computes blocks everything else on its core. Never raises. Returns an empty text if the priority was
    granted, else what was refused and which limit would permit it.
    """
    if sys.platform != "linux":
        return "this system grants ordinary programs no real-time priority"
    if _for_each_thread(lambda thread: os.sched_setscheduler(thread, os.SCHED_RR, os.sched_param(REALTIME))):
        return ""
    refused = f"real-time priority {REALTIME} is not permitted (ulimit -r)"
    if _for_each_thread(lambda thread: os.setpriority(os.PRIO_PROCESS, thread, NICE)):
        return f"{refused}, nice {NICE} is"
    return f"{refused}, nor is nice {NICE} (ulimit -e)"


def single_threaded() -> None:
    """Let OpenCV compute on the calling threads only, for processes with deadlines on a busy computer.

    Its worker threads wait for each other without sleeping. If other programs need the cores too, this costs
    all of them more time than a second core saves.
    """
    import cv2  # the guardian does not need it

    cv2.setNumThreads(1)


def lock_memory() -> str:
    """Keep the memory of this process from being swapped out.

    Never raises. Returns why it was refused; empty if it was not.
    """
    if sys.platform != "linux":
        return "this system does not lock the memory of ordinary programs"
    if ctypes.CDLL(None).mlockall(_MCL_CURRENT | _MCL_ONFAULT):
        return "locked memory is not permitted (ulimit -l)"
    return ""


def _for_each_thread(change: Callable[[int], None]) -> bool:
    """Call `change` with the kernel id of every thread of this process; return whether it was permitted."""
    for thread in Path("/proc/self/task").iterdir():
        try:
            change(int(thread.name))
        except PermissionError:
            return False
        except ProcessLookupError:
            pass  # it has just ended
    return True
