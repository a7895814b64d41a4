"""Signals that end a server: the first is a wish, one a moment later the same, a later one an order."""

import signal
import threading

import pytest

from grabbergui.cli import process
from patience import PATIENCE


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_sets_the_event_and_another_at_once_is_the_same(number):
    with process.stop_on_signals() as stop:
        assert not stop.is_set()
        signal.raise_signal(number)
        signal.raise_signal(signal.SIGINT)

        assert stop.is_set()


def test_who_insists_is_obeyed(monkeypatch):
    monkeypatch.setattr(process, "SAME", -1.0)
    with process.stop_on_signals() as stop, pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
        assert stop.is_set()
        signal.raise_signal(signal.SIGINT)


def test_a_signal_waits_until_genapi_is_left():
    """An exception out of a port's read, which GenApi called, would crash it."""
    from grabbergui import sources
    from grabbergui.driver.genapi.port import RegisterPort

    interrupted = []
    read = RegisterPort.read

    def interrupting(port, address, length):
        if not interrupted:
            interrupted.append(address)
            signal.raise_signal(signal.SIGINT)
        return read(port, address, length)

    grabber = sources.create("sim:")
    with pytest.MonkeyPatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(RegisterPort, "read", interrupting)
        with process.raising_on_signals():
            grabber.open()
            threading.Event().wait(PATIENCE)
    assert interrupted
    grabber.close()


@pytest.mark.parametrize("guard", [process.stop_on_signals, process.raising_on_signals])
def test_the_end_of_the_terminal_stays_ignored_where_nohup_wants_it(guard):
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with guard():
            assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


def test_afterwards_signals_act_as_before():
    before = signal.getsignal(signal.SIGTERM)
    with process.stop_on_signals():
        assert signal.getsignal(signal.SIGTERM) is not before

    assert signal.getsignal(signal.SIGTERM) is before
