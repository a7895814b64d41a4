"""Receives the stream of a USB3 Vision camera in a thread: keeps requests in flight and delivers frames."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.component import PayloadType
from grabbergui.core.errors import DeviceLostError, GrabberError
from grabbergui.core.frame import BufferPool, Frame, FrameStatus, time_of_day
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.driver.device import FrameCounter
from grabbergui.driver.payload_contents import Contents, PayloadReader
from grabbergui.driver.u3v.block_assembler import Block, BlockAssembler
from grabbergui.driver.u3v.device_clock import DeviceClock
from grabbergui.driver.u3v.stream_protocol import Leader, TransferPlan, U3vPayloadType
from grabbergui.driver.u3v.transfer_queue import TransferOutcome, TransferQueue
from grabbergui.driver.u3v.watcher import ERRORS_IN_A_ROW

log = logging.getLogger(__name__)

BYTES_IN_FLIGHT = 8 << 20
"Half of Linux's default limit (usbfs_memory_mb = 16) for all transfers of all programs."
STREAM_WAIT = 0.1
"Seconds after which the receiving thread checks whether it should end."


class StreamReceiver:
    """Receives blocks on its own thread and delivers them as frames."""

    def __init__(
        self,
        queue: TransferQueue,
        plan: TransferPlan,
        packet_size: int,
        clock: DeviceClock,
        deliver: Callable[[Frame], None],
        on_lost: Callable[[str], None],
        *,
        deliver_incomplete: bool = False,
    ) -> None:
        """Start the thread and wait until the first requests are in flight."""
        self._queue = queue
        self._clock = clock
        self._deliver = deliver
        self._on_lost = on_lost
        self._deliver_incomplete = deliver_incomplete
        self._assembler = BlockAssembler(plan, lambda: self._pool.take(), packet_size)
        self._pool = BufferPool(self._assembler.buffer_size)
        self._reader = PayloadReader()
        self._counter = FrameCounter()
        self._errors = 0
        self._stopping = threading.Event()
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._run, name="u3v-stream", daemon=True)
        self._thread.start()
        self._ready.wait(2.0)

    def close(self) -> None:
        """End the thread and cancel its requests. Nothing is delivered after return."""
        self._stopping.set()
        self._queue.wake()
        if self._thread is not threading.current_thread():
            self._thread.join()

    def statistics(self) -> StreamStatistics:
        """Return a snapshot of the counters. Any thread."""
        snapshot = self._counter.statistics()
        snapshot.packets_ignored = self._assembler.ignored
        return snapshot

    def _run(self) -> None:
        try:
            self._fill()
            self._ready.set()
            while not self._stopping.is_set():
                self._step()
                self._fill()
        except GrabberError as error:
            if not self._stopping.is_set():
                if not isinstance(error, DeviceLostError):
                    log.error("the stream ended: %s", error)
                self._on_lost(str(error))
        finally:
            self._ready.set()
            self._queue.cancel()

    def _fill(self) -> None:
        """Submit as many requests as may be in flight; only one while out of step."""
        queue, assembler = self._queue, self._assembler
        while queue.held == 0 or (
            assembler.in_step and queue.held < queue.depth and queue.held_bytes < BYTES_IN_FLIGHT
        ):
            request = assembler.next_request()
            if not queue.submit(request):
                assembler.put_back(request)
                return

    def _step(self) -> None:
        completion = self._queue.wait(STREAM_WAIT)
        if completion is None:
            return
        if completion.outcome is not TransferOutcome.DONE:
            self._recover(completion.outcome)
            return
        self._errors = 0
        self._counter.counts.packets += 1
        was_in_step = self._assembler.in_step
        block = self._assembler.complete(completion.request, completion.length)
        if was_in_step and not self._assembler.in_step:
            log.debug("the stream is out of step; %d requests are discarded", self._queue.held)
            if self._queue.held:
                self._queue.cancel()
                self._assembler.give_up()
        if block is not None:
            self._finish(block)

    def _recover(self, outcome: TransferOutcome) -> None:
        """Restart after a stall or a bus error."""
        self._errors += 1
        self._counter.counts.packets_missing += 1
        self._queue.cancel()
        self._assembler.give_up()
        if self._errors > ERRORS_IN_A_ROW:
            raise DeviceLostError(
                f"{self._errors} USB transfers in a row {outcome.value}; the camera seems dead"
            )
        self._queue.reset_endpoint()

    def _finish(self, block: Block) -> None:
        assert block.leader is not None and block.trailer is not None
        self._counter.note_id(block.leader.block_id)
        if block.dropped:
            self._counter.counts.underruns += 1
            return
        complete = not block.missing and not block.trailer.status
        if complete:
            self._counter.note_complete(block.trailer.valid_payload_size)
        else:
            self._counter.counts.incomplete += 1
            if not self._deliver_incomplete:
                return
        try:
            self._deliver(self._frame(block, complete))
        except Exception:
            log.exception("a consumer of frames failed")

    def _frame(self, block: Block, complete: bool) -> Frame:
        leader, trailer = block.leader, block.trailer
        assert leader is not None and trailer is not None
        valid = min(trailer.valid_payload_size, len(block.buffer))
        width, height = leader.size_x, leader.size_y
        if leader.has_geometry and trailer.size_y is not None:
            height = trailer.size_y  # the actual one, of a line-scan camera or a variable height
        block.buffer[block.received : valid] = 0  # no pixels of an earlier frame
        captured_ns = self._clock.host_time(leader.timestamp, time.monotonic_ns())
        frame = Frame(
            payload=block.buffer[:valid],
            width=width,
            height=height,
            pixel_format=pfnc.by_code(leader.pixel_format),
            frame_id=leader.block_id,
            timestamp_ns=leader.timestamp,
            received_ns=time_of_day(captured_ns),
            captured=captured_ns / 1e9,
            status=FrameStatus.COMPLETE if complete else FrameStatus.INCOMPLETE,
            missing_bytes=block.missing,
            offset_x=leader.offset_x,
            offset_y=leader.offset_y,
            padding_x=leader.padding_x,
        )
        return frame if leader.has_geometry else self._contents(leader, frame.payload).frame(frame)

    def _contents(self, leader: Leader, payload: NDArray[np.uint8]) -> Contents:
        """Read a payload that is not a single image. An unknown kind becomes raw data."""
        if leader.payload_type == U3vPayloadType.GENDC_CONTAINER:
            return self._reader.container(payload)
        if leader.payload_type == U3vPayloadType.CHUNK:
            return self._reader.plain(PayloadType.CHUNK, payload)
        self._reader.warn_once(
            f"the camera sends an unknown kind of data (payload type 0x{leader.payload_type:04X}), handed on"
            " as raw data; let the camera send images, by ComponentEnable or GenDCStreamingMode"
        )
        return self._reader.plain(PayloadType.RAW_DATA, payload)
