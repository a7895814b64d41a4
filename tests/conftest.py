"""Fixtures of every test. Its presence makes the modules of this folder importable from them."""

import contextlib
import gc
import logging
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

import isolation
import slowest

# No test looks for cameras beyond this machine, or needs a display.
os.environ["GRABBERGUI_INTERFACES"] = "lo"
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
# As in the program (`grabbergui.__main__`), before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# A shell's background job ignores Ctrl+C and `nohup` the hang-up, and so would all programs that tests start.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)

# How long an example takes says how busy the machine is; pytest's own limit finds what hangs.
settings.register_profile("patient", deadline=None, suppress_health_check=[HealthCheck.too_slow])
# The same examples in every run, so that a failure is of the change that shows it;
# `pytest --hypothesis-profile exploring` looks for more.
settings.register_profile("steady", settings.get_profile("patient"), derandomize=True)
settings.register_profile("few", settings.get_profile("steady"), max_examples=20)  # make mutants
settings.register_profile("exploring", settings.get_profile("patient"), max_examples=1000)
settings.load_profile("steady")

COMPILING = "compile loops"
"The name of the thread of `core.compiled_loops`."

pytest_plugins = ["peers"]

if isolation.WORKER:
    isolation.enter_own_namespaces()
else:
    isolation.begin_run()


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_collection() -> Iterator[None]:
    """Pause garbage collection while tests are collected, because all their objects stay."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the slow tests first; the next free worker takes the next test."""
    items[:] = slowest.first(items)


def pytest_collection_finish() -> None:
    """Exclude the collected tests from garbage collection, without a search: nearly all of them stay."""
    gc.freeze()


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_teardown() -> Iterator[None]:
    """Delete the windows that the test has closed, and collect garbage, as no event loop does it now.

    Otherwise, each new style sheet would be applied to the windows of all earlier tests. What is logged does
    not depend on them either: a command or a window's log that stays open would let more through.
    """
    yield
    logging.getLogger().setLevel(logging.WARNING)
    logging.getLogger("grabbergui").setLevel(logging.NOTSET)
    qt = sys.modules.get("PyQt5.QtCore")
    if qt is not None and (app := qt.QCoreApplication.instance()) is not None:
        qt.QCoreApplication.sendPostedEvents(None, qt.QEvent.DeferredDelete)
        garbage = sys.modules["grabbergui.ui.garbage"]
        app.findChild(garbage.GuiThreadCollector).collect()


@pytest.fixture(scope="session")
def qapp() -> Any:
    """Return the application as the program makes it; it collects garbage in the GUI thread only."""
    from grabbergui.ui.application import application

    return application()


@pytest.fixture
def qtbot(qapp: Any, request: pytest.FixtureRequest) -> Any:
    """Return pytest-qt's robot, as patient as all other tests."""
    from patient_bot import PatientBot

    return PatientBot(request)


@pytest.hookimpl(wrapper=True)
def pytest_report_to_serializable() -> Iterator[None]:
    """Make a report with invalid UTF-8 in its output or log sendable; xdist would abort the run."""
    return isolation.sendable((yield))


def pytest_unconfigure() -> None:
    """End the programs that all workers share, in the process that began the run, which outlives them."""
    if not isolation.WORKER:
        isolation.end_run()


def pytest_runtest_logreport() -> None:
    """Wait after each phase of a test for a thread that imports modules: pytest iterates over all of them."""
    for thread in threading.enumerate():
        if thread.name == COMPILING:
            thread.join()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """Return the number of workers for `-n auto`: as many as can be isolated from each other."""
    return isolation.workers_allowed()


@contextlib.contextmanager
def _full_disk() -> Iterator[None]:
    import resource  # not on Windows

    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (3, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.fixture
def full_disk() -> Callable[[], AbstractContextManager[None]]:
    """Return a context in which no file grows beyond three bytes; pytest's own report may be a file, too."""
    return _full_disk
