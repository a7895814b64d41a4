"""The asynchronous queue over a libusb that only keeps account of its transfers."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

usb1 = pytest.importorskip("usb1", reason="python-libusb1 is not installed")

from grabbergui.driver.u3v import libusb_queue  # noqa: E402
from grabbergui.driver.u3v.block_assembler import Block, TransferKind, TransferRequest  # noqa: E402
from grabbergui.driver.u3v.enumeration import UsbCamera  # noqa: E402
from grabbergui.driver.u3v.libusb_queue import LibusbQueue  # noqa: E402
from grabbergui.driver.u3v.usb import BulkInterface  # noqa: E402


class CountedTransfer:
    """As usb1's; a completed one has filled its memory with `FILL`."""

    FILL = 7

    def __init__(self) -> None:
        self.set_up = 0
        self.closed = False
        self.submitted = False
        self._buffer: Any = None
        self._callback: Callable[[Any], None] = lambda _: None

    def setBulk(self, endpoint: int, buffer: Any, callback: Callable[[Any], None]) -> None:
        assert endpoint == 0x81 and not self.submitted
        self.set_up += 1
        self._buffer, self._callback = buffer, callback

    def submit(self) -> None:
        assert self.set_up and not self.closed and not self.submitted
        self.submitted = True

    def complete(self) -> None:
        self.submitted = False
        self._buffer[:] = bytes([self.FILL]) * len(self._buffer)
        self._callback(self)

    def getStatus(self) -> int:
        return int(usb1.TRANSFER_COMPLETED)

    def getActualLength(self) -> int:
        return len(self._buffer)

    def close(self) -> None:
        assert not self.submitted
        self.closed = True


class Bus:
    """Context, device and handle in one; events complete every transfer."""

    def __init__(self) -> None:
        self.transfers: list[CountedTransfer] = []

    def open(self) -> Bus:
        return self

    def getDeviceIterator(self, skip_on_error: bool) -> list[Bus]:
        return [self]

    def getBusNumber(self) -> int:
        return 1

    def getDeviceAddress(self) -> int:
        return 2

    def getTransfer(self) -> CountedTransfer:
        self.transfers.append(CountedTransfer())
        return self.transfers[-1]

    def handleEventsTimeout(self, timeout: float) -> None:
        for transfer in self.transfers:
            if transfer.submitted:
                transfer.complete()

    def __getattr__(self, name: str) -> Callable[..., None]:
        return lambda *_: None


@pytest.fixture
def bus(monkeypatch: pytest.MonkeyPatch) -> Bus:
    bus = Bus()
    monkeypatch.setattr(libusb_queue.usb1, "USBContext", lambda: bus)
    monkeypatch.setattr(libusb_queue.usb1, "loadLibrary", lambda _: None)
    return bus


@pytest.fixture
def queue(bus: Bus) -> LibusbQueue:
    camera = SimpleNamespace(bus=1, address=2, info=SimpleNamespace(title="camera"))
    stream = SimpleNamespace(number=0, endpoint_in=0x81)
    return LibusbQueue(None, cast(UsbCamera, camera), cast(BulkInterface, stream), 8)  # type: ignore[arg-type]


def receive(queue: LibusbQueue, memory: np.ndarray[Any, np.dtype[np.uint8]]) -> None:
    memory[:] = 0
    assert queue.submit(TransferRequest(TransferKind.PAYLOAD, Block(memory, dropped=False), memory))
    completion = queue.wait(1.0)
    assert completion is not None and completion.length == len(memory)
    assert (memory == CountedTransfer.FILL).all()


def test_a_transfer_is_set_up_once_for_a_piece_of_memory(queue: LibusbQueue, bus: Bus) -> None:
    buffers = np.zeros((3, 1024), np.uint8)

    for _ in range(5):
        for buffer in buffers:
            receive(queue, buffer)
            receive(queue, buffer[:512])

    assert [transfer.set_up for transfer in bus.transfers] == [1] * 6


def test_requests_into_the_same_memory_have_a_transfer_each(queue: LibusbQueue, bus: Bus) -> None:
    scratch = np.zeros(1024, np.uint8)  # what frames without a buffer go into

    for _ in range(3):
        for _ in range(4):
            queue.submit(TransferRequest(TransferKind.PAYLOAD, Block(scratch, dropped=True), scratch))
        assert [queue.wait(1.0) is not None for _ in range(4)] == [True] * 4

    assert sum(not transfer.closed for transfer in bus.transfers) == 1


def test_transfers_of_memory_that_is_not_used_again_are_closed(
    queue: LibusbQueue, bus: Bus, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(libusb_queue, "MOST_PREPARED", 4)
    buffers = np.zeros((10, 1024), np.uint8)

    for buffer in buffers:
        receive(queue, buffer)

    assert [transfer.closed for transfer in bus.transfers] == [True] * 6 + [False] * 4


def test_close_leaves_no_transfer_open(queue: LibusbQueue, bus: Bus) -> None:
    for buffer in np.zeros((3, 1024), np.uint8):
        receive(queue, buffer)

    queue.close()

    assert bus.transfers and all(transfer.closed for transfer in bus.transfers)
