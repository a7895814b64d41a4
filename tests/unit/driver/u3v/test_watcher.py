"""The watching thread on a bus that has its moments."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from grabbergui.core.errors import TransportError
from grabbergui.driver.u3v import watcher
from grabbergui.driver.u3v.gencp import Event
from grabbergui.driver.u3v.usb import BulkInterface, EndpointHaltedError, UsbTimeoutError
from grabbergui.driver.u3v.watcher import ERRORS_IN_A_ROW, Watcher
from patience import until

EVENTS = BulkInterface(1, 0x82, 0, 1024)


class Handle:
    """Returns a given answer, then nothing more."""

    name = "camera"

    def __init__(self, *turns: Event | None) -> None:
        self.present = True
        self._turns = list(turns)

    def is_present(self) -> bool:
        return self.present

    def read_into(self, endpoint: int, interface: int, view: np.ndarray, timeout: float) -> int:
        if not self._turns:
            raise UsbTimeoutError("nothing")
        turn = self._turns.pop(0)
        if turn is None:
            raise TransportError("camera: USB error: Overflow")
        data = turn.encode(1)
        view[: len(data)] = np.frombuffer(data, np.uint8)
        return len(data)


class StallingHandle(Handle):
    """Stalls the endpoint at every read."""

    cleared = 0

    def read_into(self, endpoint: int, interface: int, view: np.ndarray, timeout: float) -> int:
        raise EndpointHaltedError("camera halted a USB endpoint")

    def clear_halt(self, endpoint: int) -> None:
        self.cleared += 1


Watch = Callable[[Handle], tuple[list[int], list[str]]]


@pytest.fixture
def watch(monkeypatch) -> Iterator[Watch]:
    monkeypatch.setattr(watcher, "EVENT_WAIT", 0.001)
    watchers: list[Watcher] = []

    def begin(handle: Handle) -> tuple[list[int], list[str]]:
        events: list[int] = []
        lost: list[str] = []
        watchers.append(
            Watcher(handle, EVENTS, 64, lambda number, _: events.append(number), lost.append, lambda: None)
        )
        return events, lost

    yield begin
    for one in watchers:
        one.stop()
    assert not [thread for thread in threading.enumerate() if thread.name == "u3v-watch"]


def test_disturbances_between_events_are_endured(watch: Watch) -> None:
    disturbed = [turn for number in range(ERRORS_IN_A_ROW + 3) for turn in (None, Event(number, 0))]
    events, lost = watch(Handle(*disturbed))
    until(lambda: len(events) == ERRORS_IN_A_ROW + 3)
    assert not lost


def test_too_many_in_a_row_are_a_dead_camera(watch: Watch) -> None:
    _, lost = watch(Handle(*[None] * (ERRORS_IN_A_ROW + 1)))
    until(lambda: lost)
    assert lost == ["camera: USB error: Overflow"]


def test_one_is_enough_if_the_camera_is_lost(watch: Watch) -> None:
    handle = Handle(None)
    handle.present = False
    _, lost = watch(handle)
    until(lambda: lost)
    assert lost == ["camera: USB error: Overflow"]


def test_an_endpoint_that_always_stalls_does_not_occupy_the_processor(
    watch: Watch, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(watcher, "EVENT_WAIT", 0.05)
    handle = StallingHandle()
    begun = time.monotonic()
    _, lost = watch(handle)
    until(lambda: handle.cleared >= 6)
    assert handle.cleared <= (time.monotonic() - begun) / 0.05 + 1
    assert not lost
