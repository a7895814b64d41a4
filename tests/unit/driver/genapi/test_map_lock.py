"""Ctrl-C while GenApi works, in a program with Python's own handler: KeyboardInterrupt, and no harm."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator

import pytest

from grabbergui.driver.genapi.map_lock import HeldInterrupts
from patience import PATIENCE


@pytest.fixture(autouse=True)
def pythons_own_handler() -> Iterator[None]:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_the_outermost_block_raises_and_another_signal_is_the_same() -> None:
    interrupts = HeldInterrupts()
    interrupts.hold()
    interrupts.hold()
    signal.raise_signal(signal.SIGINT)
    signal.raise_signal(signal.SIGINT)
    interrupts.release()
    with pytest.raises(KeyboardInterrupt):
        interrupts.release()
    interrupts.hold()
    interrupts.release()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_another_handler_is_left_alone() -> None:
    heard: list[int] = []
    signal.signal(signal.SIGINT, lambda number, _: heard.append(number))
    interrupts = HeldInterrupts()
    interrupts.hold()
    signal.raise_signal(signal.SIGINT)
    assert heard == [signal.SIGINT]
    interrupts.release()


def test_a_handler_that_is_installed_inside_stays() -> None:
    def ours(number: int, frame: object) -> None: ...

    interrupts = HeldInterrupts()
    interrupts.hold()
    signal.signal(signal.SIGINT, ours)
    interrupts.release()
    assert signal.getsignal(signal.SIGINT) is ours


@pytest.mark.parametrize("call", [HeldInterrupts.hold, HeldInterrupts.release])
def test_other_threads_hold_nothing(call: Callable[[HeldInterrupts], None]) -> None:
    interrupts = HeldInterrupts()
    thread = threading.Thread(target=call, args=(interrupts,))
    thread.start()
    thread.join(PATIENCE)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    interrupts.hold()
    assert signal.getsignal(signal.SIGINT) is not signal.default_int_handler
    interrupts.release()
