"""Real-time priority: when it is asked for, and what a refusal says. Nothing here changes a priority."""

from __future__ import annotations

import os
import sys
import threading
import time

import pytest

from grabbergui.core import scheduling
from grabbergui.core.scheduling import (
    FRAMES,
    MOST_WORK,
    NICE,
    REALTIME,
    REVIEW,
    RealtimeThread,
    realtime_threads_permitted,
    run_first,
)

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="Linux schedules threads by these calls")
BEGIN = 1000.0


class Kernel:
    """Takes the requests for priorities of this process, and refuses some."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.asked: list[tuple[int, int, int]] = []
        "Thread (0 is the calling one), policy, priority."
        self.refused: type[OSError] | None = None
        self.nice: list[int] = []
        self.refuses_nice = False
        self.worked = 0.0
        monkeypatch.setattr(scheduling.os, "sched_setscheduler", self._schedule)
        monkeypatch.setattr(scheduling.os, "setpriority", self._renice)
        monkeypatch.setattr(scheduling.os, "sched_getaffinity", lambda process: {0, 1})
        monkeypatch.setattr(scheduling.time, "thread_time", lambda: self.worked)

    def _schedule(self, thread: int, policy: int, parameters: os.sched_param) -> None:
        if self.refused:
            raise self.refused("no")
        self.asked.append((thread, policy, parameters.sched_priority))

    def _renice(self, kind: int, thread: int, nice: int) -> None:
        if self.refuses_nice:
            raise PermissionError("no")
        assert kind == os.PRIO_PROCESS
        self.nice.append(nice)


@pytest.fixture
def kernel(monkeypatch: pytest.MonkeyPatch) -> Kernel:
    monkeypatch.setattr(scheduling.time, "monotonic", lambda: BEGIN)
    return Kernel(monkeypatch)


def test_a_thread_that_mostly_waits_gets_priority_and_one_that_computes_loses_it(kernel: Kernel) -> None:
    thread = RealtimeThread()
    assert not thread.review(BEGIN + REVIEW / 2) and not kernel.asked
    assert thread.review(BEGIN + 1)
    assert thread.review(BEGIN + 1 + REVIEW / 2)
    kernel.worked = MOST_WORK
    assert thread.review(BEGIN + 2), "just as much as it may"
    kernel.worked += MOST_WORK + 0.01
    assert not thread.review(BEGIN + 3)
    reset = os.SCHED_RESET_ON_FORK
    assert kernel.asked == [(0, os.SCHED_RR | reset, FRAMES), (0, os.SCHED_OTHER | reset, 0)]


def test_a_refusal_is_final(kernel: Kernel) -> None:
    kernel.refused = PermissionError
    thread = RealtimeThread()
    assert not thread.review(BEGIN + 1)
    kernel.refused = None
    assert not thread.review(BEGIN + 2) and not kernel.asked


def test_on_one_core_nothing_is_asked_for(kernel: Kernel, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scheduling.os, "sched_getaffinity", lambda process: {0})
    assert not RealtimeThread().review(BEGIN + 1) and not kernel.asked


@pytest.mark.parametrize("refused", [None, PermissionError])
def test_whether_it_is_permitted_is_tried_on_a_thread(kernel: Kernel, refused: type[OSError] | None) -> None:
    kernel.refused = refused
    assert realtime_threads_permitted() is (refused is None)


def test_all_threads_of_the_process_go_first(kernel: Kernel) -> None:
    assert run_first() == ""
    assert (threading.get_native_id(), os.SCHED_RR, REALTIME) in kernel.asked


def test_what_is_refused_is_named_with_the_limit(kernel: Kernel) -> None:
    kernel.refused = PermissionError
    assert run_first() == f"real-time priority {REALTIME} is not permitted (ulimit -r), nice {NICE} is"
    assert set(kernel.nice) == {NICE}
    kernel.refuses_nice = True
    assert run_first().endswith(f", nor is nice {NICE} (ulimit -e)")


def test_a_thread_that_has_just_ended_is_left_out(kernel: Kernel) -> None:
    kernel.refused = ProcessLookupError
    assert run_first() == ""


def test_another_system_grants_nothing(kernel: Kernel, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scheduling.sys, "platform", "win32")
    assert "this system grants" in run_first()
    assert "this system does not lock" in scheduling.lock_memory()
    assert not RealtimeThread().review(time.monotonic() + 1) and not kernel.asked


def test_the_share_of_a_core_counts_and_not_the_time(kernel: Kernel) -> None:
    thread = RealtimeThread()
    kernel.worked = 0.5 * MOST_WORK
    assert thread.review(BEGIN + 0.5)
    kernel.worked += 0.5 * MOST_WORK + 0.01
    assert not thread.review(BEGIN + 1.0)
