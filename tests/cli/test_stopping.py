"""Signals that end a server: the first is a wish, one a moment later the same, a later one an order."""

import signal

import pytest

from grabbergui.cli import stopping


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_sets_the_event_and_another_at_once_is_the_same(number):
    with stopping.stop_on_signals() as stop:
        assert not stop.is_set()
        signal.raise_signal(number)
        signal.raise_signal(signal.SIGINT)

        assert stop.is_set()


def test_who_insists_is_obeyed(monkeypatch):
    monkeypatch.setattr(stopping, "SAME", -1.0)
    with stopping.stop_on_signals() as stop, pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
        assert stop.is_set()
        signal.raise_signal(signal.SIGINT)


def test_afterwards_signals_act_as_before():
    before = signal.getsignal(signal.SIGTERM)
    with stopping.stop_on_signals():
        assert signal.getsignal(signal.SIGTERM) is not before

    assert signal.getsignal(signal.SIGTERM) is before
