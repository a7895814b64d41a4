"""When threads run: real-time priority, socket timeouts that expire, rests between peers' costly requests.

The guardian and threads that receive frames must wake in time. With eight busy programs on two cores, an
ordinary thread woke up to 150 ms late; one with real-time priority, at most 1 ms. Linux grants that priority
to root, to programs with CAP_SYS_NICE, and to users with an `rtprio` limit (`/etc/security/limits.conf`, or
`LimitRTPRIO=` of a systemd unit).
"""

from __future__ import annotations

import ctypes
import os
import select
import signal
import socket
import struct
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

REALTIME = 10
"""SCHED_RR priority: above every ordinary thread, below the kernel's own."""
FRAMES = 5
"""SCHED_RR priority of a thread that receives frames: below the guardian, which stops a robot."""
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

    def __init__(self) -> None:
        self.realtime = False
        "Whether the thread has real-time priority."
        self._permitted = sys.platform == "linux" and len(os.sched_getaffinity(0)) > 1
        self._reviewed, self._worked = time.monotonic(), time.thread_time()

    def review(self, now: float) -> bool:
        """Choose the priority by the thread's recent share of a core; return `realtime`.

        `now` is monotonic time. Cheap enough for every iteration of a loop. Never raises.
        """
        if not self._permitted or now - self._reviewed < REVIEW:
            return self.realtime
        worked = time.thread_time()
        waits = worked - self._worked <= MOST_WORK * (now - self._reviewed)
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


# -- socket timeouts -----------------------------------------------------------------------------
# Python repeats a system call that a signal interrupted, and the kernel's timeout (SO_RCVTIMEO, SO_SNDTIMEO)
# starts again. With an interval timer of a shorter period (`signal.setitimer`, as profilers use it) it would
# never expire.
if sys.platform == "win32":

    def wait_readable(sock: socket.socket) -> int:
        """Return 0: Windows has no interval timers."""
        return 0

    wait_writable = wait_readable

else:
    _TIMEVAL = struct.Struct("@ll")

    def wait_readable(sock: socket.socket) -> int:
        """Wait until the socket is readable, or for its SO_RCVTIMEO, if a timer would interrupt `recv`.

        Returns flags for `recv`, which then does not wait. Returns 0 immediately if nothing interrupts it.
        """
        return _wait(sock, select.POLLIN, socket.SO_RCVTIMEO)

    def wait_writable(sock: socket.socket) -> int:
        """Wait in the same way for SO_SNDTIMEO; return flags for `send`."""
        return _wait(sock, select.POLLOUT, socket.SO_SNDTIMEO)

    def _wait(sock: socket.socket, event: int, option: int) -> int:
        if threading.get_ident() != threading.main_thread().ident:
            return 0  # only the main thread handles signals
        timers = (signal.ITIMER_REAL, signal.ITIMER_VIRTUAL, signal.ITIMER_PROF)
        next_signal = min([left for timer in timers if (left := signal.getitimer(timer)[0])], default=0.0)
        if not next_signal:
            return 0
        seconds, microseconds = _TIMEVAL.unpack(sock.getsockopt(socket.SOL_SOCKET, option, _TIMEVAL.size))
        limit = seconds + microseconds / 1e6
        if limit <= next_signal:
            return 0
        poll = select.poll()
        poll.register(sock.fileno(), event)
        poll.poll(limit * 1000)  # after a signal, Python waits for the remaining time only
        return socket.MSG_DONTWAIT


# -- rests between costly requests ---------------------------------------------------------------
REST: Final = 3.0
"""Seconds of rest after each second of work: peers' computing takes a quarter of a core at most."""

_FREE_SECONDS: Final = 0.002
"""Work shorter than this needs no rest."""

_QUEUES: Final = 64


class CostlyWork:
    """Lets peers' costly requests run one at a time, with rests: turns for the whole process.

    Python runs one thread at a time and changes between busy ones every 5 ms: eight peers whose requests only
    compute would leave the stream a ninth of the processor. No address has more than one place in the queue.
    Work that waits for the camera does not belong here.
    """

    def __init__(
        self,
        clock: Callable[[], float] = time.monotonic,
        work_clock: Callable[[], float] = time.thread_time,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._clock = clock
        self._work_clock = work_clock
        self._sleep = sleep
        self._turn = threading.Lock()
        self._next = 0.0
        "When the rest after the last turn is over."
        self._queues = [threading.Lock() for _ in range(_QUEUES)]
        "By address, so that one with many connections waits as long as one with a single connection."

    @contextmanager
    def turn(self, address: str) -> Iterator[None]:
        """Wait for a turn, and run the block in it. Any thread."""
        with self._queues[hash(address) % _QUEUES], self._turn:
            rest = self._next - self._clock()
            if rest > 0:
                self._sleep(rest)
            begun = self._work_clock()
            try:
                yield
            finally:
                spent = self._work_clock() - begun
                if spent > _FREE_SECONDS:
                    self._next = self._clock() + REST * spent


costly_work = CostlyWork()
"""The process's own."""
