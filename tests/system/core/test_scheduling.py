"""Real-time priority for threads that mostly wait: given, taken back, not inherited."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable

import pytest

from grabbergui.core import scheduling
from grabbergui.core.scheduling import FRAMES, REALTIME, REVIEW, RealtimeThread, realtime_threads_permitted

linux = pytest.mark.skipif(sys.platform != "linux", reason="Linux schedules threads by these calls")
TURN = 2 * REVIEW
"Seconds between reviews here: sums of tenths may lack a rounding error to the next one."
permitted = pytest.mark.skipif(
    not realtime_threads_permitted(), reason="needs the right to real-time priority"
)


def on_own_thread(body: Callable[[], None]) -> None:
    """Run `body` on a thread whose priority it may change; pass on what it raises."""
    raised: list[BaseException] = []

    def run() -> None:
        try:
            body()
        except BaseException as error:
            raised.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    if raised:
        raise raised[0]


def policy() -> int:
    return os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK


@linux
@permitted
def test_a_waiting_thread_has_realtime_priority_and_a_computing_one_has_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    worked = 0.0
    monkeypatch.setattr(scheduling.time, "thread_time", lambda: worked)

    def body() -> None:
        nonlocal worked
        thread, now = RealtimeThread(), time.monotonic()
        assert not thread.review(now + REVIEW / 2), "too early to judge"
        now += TURN
        assert thread.review(now)
        assert policy() == os.SCHED_RR and os.sched_getparam(0).sched_priority == FRAMES < REALTIME
        worked += TURN * 0.08
        now += TURN
        assert thread.review(now), "a twelfth of a core is waiting"
        for _ in range(2):
            worked += TURN * 0.3
            now += TURN
            assert not thread.review(now)
            assert policy() == os.SCHED_OTHER
        now += TURN
        assert thread.review(now), "it waits again"

    on_own_thread(body)


@linux
@permitted
def test_neither_threads_nor_programs_inherit_it() -> None:
    def body() -> None:
        assert RealtimeThread().review(time.monotonic() + REVIEW)
        on_own_thread(lambda: inherited.append(policy()))
        program = subprocess.run(
            [sys.executable, "-c", "import os; print(os.sched_getscheduler(0))"],
            capture_output=True,
            text=True,
            check=True,
        )
        inherited.append(int(program.stdout))

    inherited: list[int] = []
    on_own_thread(body)
    assert inherited == [os.SCHED_OTHER, os.SCHED_OTHER]


@linux
def test_a_refused_priority_is_requested_only_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def refuse(*arguments: object) -> None:
        asked.append(arguments)
        raise PermissionError

    monkeypatch.setattr(scheduling.os, "sched_setscheduler", refuse)
    thread, now = RealtimeThread(), time.monotonic()
    assert not thread.review(now + REVIEW)
    assert not thread.review(now + 2 * REVIEW)
    assert len(asked) == 1
    assert not realtime_threads_permitted()


@linux
def test_a_computer_with_one_core_gets_no_realtime_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scheduling.os, "sched_getaffinity", lambda process: {0})
    assert not RealtimeThread().review(time.monotonic() + REVIEW)
