"""Scheduling of what must be in time beside other programs: the guardian, threads that receive frames.

With eight busy programs on two cores, an ordinary thread woke up to 150 ms late; one with real-time priority,
at most 1 ms. Linux grants that priority to root, to programs with CAP_SYS_NICE, and to users with an `rtprio`
limit (`/etc/security/limits.conf`, or `LimitRTPRIO=` of a systemd unit).
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
"""Priority in SCHED_RR: ahead of every ordinary thread, behind the kernel's own."""
FRAMES = 5
"""Priority in SCHED_RR of a thread that receives frames: behind what stops a robot."""
NICE = -10
"""Nice value where real-time priority is refused."""
_MCL_CURRENT, _MCL_ONFAULT = 1, 4
"Flags of `mlockall(2)`: pages that are mapped now stay in memory from their first use on."
REVIEW = 0.1
"Seconds between two reviews of a `PromptThread`."
MOST_WORK = 0.25
"Share of a core that a thread with real-time priority may need."


class PromptThread:
    """Real-time priority for the calling thread as long as it mostly waits, so that it wakes without delay.

    A thread that computes gets ordinary priority: it would hold up everything else on its core. Threads and
    processes that it starts have ordinary priority. One thread.
    """

    def __init__(self) -> None:
        self.prompt = False
        "Whether the thread has real-time priority."
        self._permitted = sys.platform == "linux" and len(os.sched_getaffinity(0)) > 1
        self._reviewed, self._worked = time.monotonic(), time.thread_time()

    def review(self, now: float) -> bool:
        """Choose the priority by the share of a core that the thread took lately; return `prompt`.

        `now` is monotonic time. Cheap enough for every turn of a loop. Never raises.
        """
        if not self._permitted or now - self._reviewed < REVIEW:
            return self.prompt
        worked = time.thread_time()
        waits = worked - self._worked <= MOST_WORK * (now - self._reviewed)
        self._reviewed, self._worked = now, worked
        if waits != self.prompt:
            self._schedule(first=waits)
        return self.prompt

    def _schedule(self, *, first: bool) -> None:
        if sys.platform != "linux":
            return
        policy, priority = (os.SCHED_RR, FRAMES) if first else (os.SCHED_OTHER, 0)
        try:
            os.sched_setscheduler(0, policy | os.SCHED_RESET_ON_FORK, os.sched_param(priority))
        except OSError:
            self._permitted = False
        else:
            self.prompt = first


def prompt_threads_permitted() -> bool:
    """Return whether a thread of this process may have real-time priority; one that ends at once tries."""
    tried: list[bool] = []

    def attempt() -> None:
        thread = PromptThread()
        tried.append(thread.review(time.monotonic() + REVIEW))

    attempting = threading.Thread(target=attempt, name="priority check")
    attempting.start()
    attempting.join()
    return tried == [True]


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
