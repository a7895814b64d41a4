"""The guardian: when it stops a robot, the channels by which it does, and its process."""

import math
import os
import re
import signal
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace

import pytest

from benchmarks.servo.servo_guardian import running
from grabbergui.core.errors import SourceUnavailableError, TransportError
from grabbergui.servo.guardian_link import ALLOWED, GuardianLink, Verdict
from grabbergui.servo.monitor import Observation, SpeedLimits
from grabbergui.servo.stop_channel import Channel, ChannelThread
from grabbergui.servo.stop_scheduler import REPEATS, StopScheduler
from patience import PATIENCE, PROGRAM, until

SILENCE = 0.08


def test_a_moving_robot_s_program_that_falls_silent_makes_an_alarm():
    scheduler = StopScheduler(SILENCE)
    scheduler.beat(1.0, moving=True, stops=0)
    assert scheduler.due == pytest.approx(1.08)
    assert not scheduler.stop_due(1.07)
    assert scheduler.stop_due(1.08)
    assert scheduler.stops == 1
    assert "silent for 80 ms" in scheduler.why


def test_a_resting_robot_s_program_may_be_silent():
    scheduler = StopScheduler(SILENCE)
    scheduler.beat(1.0, moving=True, stops=0)
    scheduler.beat(1.02, moving=False, stops=0)
    assert math.isinf(scheduler.due)
    assert not scheduler.stop_due(100.0)


def test_an_alarm_is_repeated_for_what_was_still_on_its_way():
    scheduler = StopScheduler(SILENCE)
    scheduler.alarm(1.0, "the program ended")
    sent = []
    while scheduler.stopping:
        now = scheduler.due
        assert scheduler.stop_due(now)
        sent.append(now - 1.0)
    assert sent == pytest.approx(REPEATS)


def test_a_program_that_does_not_know_of_the_alarm_cannot_go_on_as_if_nothing_had_happened():
    scheduler = StopScheduler(SILENCE)
    scheduler.alarm(1.0, "silence")
    scheduler.beat(3.0, moving=True, stops=0)
    while scheduler.stopping:
        scheduler.stop_due(scheduler.due)
    assert math.isinf(scheduler.due)
    scheduler.beat(3.1, moving=True, stops=1)
    assert scheduler.due == pytest.approx(3.18)


class Recorded(Channel):
    """Remembers what it is asked to do; its first `failures` stops fail."""

    name = "/recorded"

    def __init__(self, failures=0):
        self.calls, self.failures = [], failures

    def prepare(self):
        self.calls.append("prepare")

    def stop(self):
        self.calls.append("stop")
        if self.calls.count("stop") <= self.failures:
            raise TransportError("it is being restarted")

    def close(self):
        self.calls.append("close")

    def reset(self):
        pass


def test_a_stop_that_fails_is_tried_again_until_it_gets_through():
    channel = Recorded(failures=2)
    thread = ChannelThread(channel)
    thread.stop()
    until(lambda: channel.calls.count("stop") == 2)
    assert thread.stopping
    until(lambda: not thread.stopping)
    assert channel.calls.count("stop") == 3
    thread.close()
    thread.join(time.monotonic() + PATIENCE)
    assert channel.calls[-1] == "close"


@pytest.mark.parametrize("failures", [0, 9])
def test_a_stop_is_sent_though_the_channel_is_closed_right_after_it(failures):
    channel = Recorded(failures)
    thread = ChannelThread(channel)
    until(lambda: channel.calls == ["prepare"])
    thread.stop()
    thread.close()
    thread.join(time.monotonic() + PATIENCE)
    assert channel.calls[:2] == ["prepare", "stop"]
    assert channel.calls[-1] == "close"


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


@pytest.fixture
def link():
    link = GuardianLink([], SILENCE)
    link.open()
    yield link
    link.close()


def test_it_ends_when_its_program_has_done(link):
    link.await_ready()
    assert link.beat(lambda: False) == ALLOWED
    pid = link.pid
    link.close()
    link.close()
    assert not running(pid)


def test_nothing_moves_after_release(link):
    link.await_ready()
    link.close()
    assert link.beat(lambda: True).for_good


def test_one_that_was_killed_is_named_and_another_starts(link):
    link.await_ready()
    first = link.pid
    os.kill(first, signal.SIGKILL)
    verdict = until(lambda: (found := link.beat(lambda: False)) != ALLOWED and found)
    assert verdict == Verdict(f"the guardian has ended (process {first})", for_good=True)
    link.renew()
    assert link.pid != first
    assert link.beat(lambda: False) == ALLOWED


def test_of_several_who_go_on_at_once_one_starts_another(link, monkeypatch):
    started, start, end = [], subprocess.Popen, link._end

    def slowly():
        time.sleep(0.1)  # for the others to come
        end()

    def counted(*arguments, **options):
        started.append(start(*arguments, **options))
        return started[-1]

    link.await_ready()
    os.kill(link.pid, signal.SIGKILL)
    until(lambda: link.beat(lambda: False).for_good)
    monkeypatch.setattr(subprocess, "Popen", counted)
    monkeypatch.setattr(link, "_end", slowly)
    with ThreadPoolExecutor(3) as pool:
        for renewed in [pool.submit(link.renew) for _ in range(3)]:
            renewed.result(PROGRAM)
    assert [process.pid for process in started] == [link.pid]
    assert link.beat(lambda: False) == ALLOWED


def test_another_may_take_its_time_to_start_though_the_loop_goes_on_beating(link, monkeypatch):
    """On a busy machine a process takes longer to start than one that is well takes to answer."""
    link.close()
    clock = Clock()
    monkeypatch.setattr(link, "_clock", clock)
    link.open()
    clock.now += 3.0
    assert link.beat(lambda: True).why_not.endswith("has not answered yet")
    until(lambda: link.beat(lambda: True) == ALLOWED)


def test_a_robot_that_does_something_else_is_stopped_until_a_person_resumes(link):
    """The monitor runs in the guardian's process: a second program moved the arm by 593 mm."""
    link.await_ready()
    still = Observation(1.0, (0.0,) * 8, 1.0, (0.0,) * 8, limits=SpeedLimits(0.12, 0.6, 0.7))
    link.observe(still)
    link.observe(replace(still, now=1.02, time=1.02, measured=(0.1, *still.measured[1:])))
    verdict = until(lambda: (found := link.beat(lambda: True)).for_good and found)
    assert "the arm moves though that was not commanded: 5.73°" in verdict.why_not
    until(lambda: link.beat(lambda: False) == ALLOWED)  # the stop and its repeats are over
    link.renew()
    link.observe(replace(still, now=2.0, time=2.0, measured=(0.1, *still.measured[1:])))
    assert link.beat(lambda: True) == ALLOWED


def test_one_that_hangs_is_named_and_another_starts(link):
    link.await_ready()
    first = link.pid
    os.kill(first, signal.SIGSTOP)
    verdict = until(lambda: (found := link.beat(lambda: False)) != ALLOWED and found)
    assert verdict == Verdict("the guardian is late")
    verdict = until(lambda: (found := link.beat(lambda: False)).for_good and found)
    assert "does not answer" in verdict.why_not
    link.renew()
    assert not running(first)


@pytest.mark.parametrize(("gap", "for_good"), [(0.5, False), (5.0, True)])
def test_only_after_a_short_silence_it_goes_on_by_itself(gap, for_good):
    clock = Clock()
    link = GuardianLink([], SILENCE, clock=clock)
    link.open()
    try:
        until(lambda: link.beat(lambda: True) == ALLOWED)
        until(lambda: link._read(clock.now) or link._report.stops)  # as if it were frozen, and read all later
        clock.now += gap
        verdict = link.beat(lambda: True)
        assert "silent for 80 ms" in verdict.why_not
        assert verdict.for_good is for_good
        until(lambda: link.beat(lambda: True) == ALLOWED)
    finally:
        link.close()


def test_nothing_moves_until_a_stop_that_was_asked_for_is_over(link):
    link.await_ready()
    os.kill(link.pid, signal.SIGSTOP)  # so that it cannot be done at once
    link.stop()
    assert link.beat(lambda: True) == Verdict("the guardian is stopping the robot")
    os.kill(link.pid, signal.SIGCONT)
    until(lambda: link.beat(lambda: True) == ALLOWED)


def test_a_stop_while_it_starts_is_not_lost(link):
    """It arrived along with the list of channels, and nothing moved for 20 s."""
    link.stop()
    link.await_ready()
    until(lambda: link.beat(lambda: True) == ALLOWED)


def test_one_that_is_closed_while_it_starts_stops_nobody(capfd):
    """It took the end for a crash: a second program, which was refused, stopped the robot of the first."""
    link = GuardianLink([], SILENCE)
    link.open()
    link.close()
    assert capfd.readouterr().err == ""


NOTING = """
import pathlib, sys
from grabbergui.servo import guardian

class Noting(guardian.Channel):
    name = "noting"

    def __init__(self, path):
        self.path = pathlib.Path(path)

    def prepare(self):
        pass

    close = prepare

    def stop(self):
        with self.path.open("a") as file:
            file.write("stop ")

if __name__ == "__main__":
    guardian.KINDS["noting"] = "noting:Noting"
    guardian.main()
"""


def test_a_terminal_that_takes_no_text_holds_up_no_stop(monkeypatch, tmp_path):
    """After Ctrl-S, or behind a pager: it printed its alarm, waited for good, and never repeated the stop."""
    program, noted, start = tmp_path / "noting.py", tmp_path / "noted", subprocess.Popen
    program.write_text(NOTING)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    reader, full = os.pipe()
    os.set_blocking(full, False)
    with suppress(BlockingIOError):
        while True:
            os.write(full, bytes(4096))
    os.set_blocking(full, True)
    monkeypatch.setattr(
        subprocess,
        "Popen",
        lambda command, **options: start([command[0], str(program)], stderr=full, **options),
    )
    link = GuardianLink([{"kind": "noting", "path": str(noted)}], SILENCE)
    link.open()
    process = link._process
    try:
        link.await_ready()
        process.stdin.close()  # as if this program had died
        assert process.wait(PATIENCE) == 0
        assert noted.read_text().split() == ["stop"] * len(REPEATS)
    finally:
        os.close(reader)
        os.close(full)
        process.kill()
        link._end()


LOUD = """
from grabbergui.servo import guardian

class Loud(guardian.Channel):
    name = "loud"

    def prepare(self):
        print("[INFO] [1763.2] [rcl]: a library's message", flush=True)

    stop = close = prepare

if __name__ == "__main__":
    guardian.KINDS["loud"] = "loud:Loud"
    guardian.main()
"""


def test_what_libraries_print_in_its_process_is_not_taken_for_its_reports(monkeypatch, tmp_path):
    """ROS logs to standard output where RCUTILS_LOGGING_USE_STDOUT is set."""
    program, start = tmp_path / "loud.py", subprocess.Popen
    program.write_text(LOUD)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.setattr(
        subprocess, "Popen", lambda command, **options: start([command[0], str(program)], **options)
    )
    link = GuardianLink([{"kind": "loud"}], SILENCE)
    link.open()
    try:
        link.await_ready()
        link.stop()
        until(lambda: link.beat(lambda: False) == ALLOWED)
    finally:
        link.close()


def test_one_that_sends_no_reports_is_an_emergency_not_an_exception(monkeypatch):
    start = subprocess.Popen
    monkeypatch.setattr(
        subprocess,
        "Popen",
        lambda command, **options: start([command[0], "-c", "print('hello'); input(); input()"], **options),
    )
    link = GuardianLink([], SILENCE)
    link.open()
    try:
        verdict = until(lambda: (found := link.beat(lambda: False)).why_not.count("hello") and found)
        assert verdict.for_good
        assert f"(process {link.pid}) sent" in verdict.why_not
    finally:
        link.close()


def test_one_whose_stop_never_ends_is_not_awaited_for_ever(link):
    link.await_ready()
    link._asked += 1  # as of a stop that it never got
    with pytest.raises(SourceUnavailableError, match="is stopping the robot"):
        link.await_ready(0.2)


def test_what_it_could_not_stop_must_not_move():
    link = GuardianLink(
        [{"kind": "yarp stream", "port": "/nobody", "nameserver": "127.0.0.1:1", "stop": "stop"}], 0.08
    )
    link.open()
    pattern = r"could not stop the robot: /nobody.*127\.0\.0\.1:1"

    def refused():
        with pytest.raises(SourceUnavailableError) as refusal:
            link.await_ready(0.5)
        return re.search(pattern, str(refusal.value))

    try:
        until(refused)
    finally:
        link.close()
