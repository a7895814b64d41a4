import logging
import threading
import time

import pytest

from grabbergui.core.errors import GrabberError
from grabbergui.models.features.worker import FeatureWorker
from patience import PATIENCE


@pytest.fixture
def worker():
    worker = FeatureWorker("test")
    yield worker
    assert worker.close(5.0)


@pytest.fixture
def gate(worker):
    """Holds the worker inside a first job, so that what follows must wait; set it to release the worker."""
    entered, gate = threading.Event(), threading.Event()
    worker.submit(lambda: (entered.set(), gate.wait(PATIENCE)))
    assert entered.wait(PATIENCE)
    yield gate
    gate.set()


def threads():
    return {thread.name for thread in threading.enumerate()}


def test_jobs_run_in_order_on_one_other_thread(worker):
    calls = []
    for number in range(20):
        worker.submit(lambda number=number: calls.append((number, threading.current_thread().name)))
    assert worker.close()
    assert calls == [(number, "test") for number in range(20)]


def test_done_gets_the_result_on_the_worker(worker):
    answers = []
    worker.submit(lambda: 5, done=lambda value: answers.append((value, threading.current_thread().name)))
    assert worker.close()
    assert answers == [(5, "test")]


def test_a_newer_job_replaces_a_waiting_one_of_its_key_and_goes_to_the_end(worker, gate):
    calls = []
    worker.submit(lambda: calls.append("first"), key="exposure", done=lambda _: calls.append("answered"))
    worker.submit(lambda: calls.append("gain"), key="gain")
    worker.submit(lambda: calls.append("no key"))
    worker.submit(lambda: calls.append("second"), key="exposure")
    gate.set()
    assert worker.close()
    assert calls == ["gain", "no key", "second"]


def test_a_file_that_the_system_refuses_is_named_without_talk_of_an_internal_error(worker, tmp_path, caplog):
    errors = []
    path = tmp_path / ("long" * 100)
    worker.submit(path.exists, failed=lambda error: errors.append(str(error)))
    worker.submit(path.read_bytes, failed=lambda error: errors.append(str(error)))
    assert worker.close()
    assert errors == [f"{path}: File name too long"] * 2
    assert not caplog.records


def test_a_running_job_is_not_replaced(worker):
    entered, gate, calls = threading.Event(), threading.Event(), []
    worker.submit(lambda: (entered.set(), gate.wait(PATIENCE), calls.append(1)), key="same")
    assert entered.wait(PATIENCE)
    worker.submit(lambda: calls.append(2), key="same")
    gate.set()
    assert worker.close()
    assert calls == [1, 2]


def test_a_delayed_job_lets_others_pass(worker):
    calls, done = [], threading.Event()
    worker.submit(lambda: calls.append("later"), delay=PATIENCE)
    worker.submit(lambda: calls.append("at once"), done=lambda _: done.set())
    assert done.wait(PATIENCE)
    assert calls == ["at once"]


def test_a_delayed_job_runs_no_sooner(worker):
    calls, done = [], threading.Event()
    start = time.monotonic()
    worker.submit(lambda: calls.append(time.monotonic() - start), delay=0.05, done=lambda _: done.set())
    assert done.wait(PATIENCE)
    assert calls[0] >= 0.05


def test_closing_cuts_delays_short_and_keeps_the_order(worker):
    calls = []
    worker.submit(lambda: calls.append("delayed"), delay=60)
    worker.submit(lambda: calls.append("delayed more"), delay=90)
    assert worker.close()
    assert calls == ["delayed", "delayed more"]


def test_a_grabber_error_goes_to_failed(worker):
    errors = []
    error = GrabberError("Gain=99: out of range")

    def refuse():
        raise error

    worker.submit(refuse, done=lambda _: errors.append("done"), failed=errors.append)
    assert worker.close()
    assert errors == [error]


def test_a_bug_is_logged_and_reported_and_the_thread_survives(worker, caplog):
    errors, calls = [], []
    with caplog.at_level(logging.ERROR):
        worker.submit(lambda: 1 / 0, failed=errors.append)
        worker.submit(lambda: 1, done=lambda _: 1 / 0, failed=errors.append)
        worker.submit(lambda: 1 / 0, failed=lambda _: 1 / 0)
        worker.submit(lambda: calls.append("alive"))
        assert worker.close()
    assert calls == ["alive"]
    assert [type(error) for error in errors] == [GrabberError, GrabberError]
    assert "ZeroDivisionError" in str(errors[0])
    assert "ZeroDivisionError" in caplog.text


def test_closing_finishes_waiting_jobs_and_refuses_new_ones(worker, gate):
    calls = []
    assert worker.submit(lambda: calls.append("waiting"))
    gate.set()
    assert worker.close()
    assert not worker.submit(lambda: calls.append("late"))
    assert calls == ["waiting"]


def test_a_job_may_close_its_worker(worker):
    answers = []
    worker.submit(lambda: worker.close(), done=answers.append)
    assert worker.close()
    assert answers == [False]


def test_closing_reports_a_job_that_does_not_end(worker, gate):
    assert not worker.close(0.01)
    assert "test" in threads()
    gate.set()
    assert worker.close()
    assert "test" not in threads()
