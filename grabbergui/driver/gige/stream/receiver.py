"""The receiving thread: packets from a source to the assembler, finished frames to the consumer."""

from __future__ import annotations

import logging
import socket
import threading
import time
from collections.abc import Callable

from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import RateMeter, StreamStatistics
from grabbergui.core.scheduling import RealtimeThread
from grabbergui.driver.device import deliver_or_log
from grabbergui.driver.gige.bootstrap import GVCP_PORT
from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.datagram_source import DatagramSource
from grabbergui.driver.gige.stream.frame_builder import FrameBuilder

log = logging.getLogger(__name__)

IDLE_WAIT = 1.0
"Seconds that the thread waits for a datagram, unless a block has a timer or the stream is stopped."


class StreamReceiver:
    """Receives one stream until stopped."""

    def __init__(
        self,
        receiver: socket.socket,
        device_ip: str,
        assembler: BlockAssembler,
        builder: FrameBuilder,
        deliver: Callable[[Frame], None],
        source: DatagramSource,
    ) -> None:
        """Start the thread, which owns the socket. `deliver` is called on it and must return at once."""
        self._socket = receiver
        self._device = (device_ip, GVCP_PORT)
        self._assembler = assembler
        self._builder = builder
        self._deliver = deliver
        self._source = source
        self._rate = RateMeter()
        self._next_req_id = 1
        self._stopping = False
        self._thread = threading.Thread(target=self._run, name="gige-receiver", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the thread and close the socket; nothing is delivered any more on return."""
        self._stopping = True
        self._source.wake()
        if self._thread is not threading.current_thread():
            self._thread.join()
        self._source.close()
        self._socket.close()

    def statistics(self) -> StreamStatistics:
        """Return a snapshot. Any thread."""
        return self._assembler.statistics.snapshot(self._rate)

    @property
    def refusal(self) -> str:
        """Why frames that arrived were refused; empty if none was. Any thread."""
        return self._assembler.refusal

    def _run(self) -> None:
        assembler, thread = self._assembler, RealtimeThread()
        while not self._stopping:
            now = time.monotonic()
            thread.review(now)
            wait = min(assembler.timer() - now, IDLE_WAIT)
            try:
                self._source.receive(assembler, max(wait, 0.0))
            except OSError as error:
                if self._stopping:
                    return
                log.debug("stream socket: %s", error)
                time.sleep(0.01)
            assembler.handle_timer(time.monotonic())
            self._request_missing()
            if assembler.has_finished:
                self._deliver_finished()

    def _request_missing(self) -> None:
        for request in self._assembler.resend_requests():
            try:
                self._socket.sendto(request.encode(self._next_req_id), self._device)
            except OSError as error:
                log.debug("requesting lost packets: %s", error)
            self._next_req_id = self._next_req_id % 0xFFFF + 1

    def _deliver_finished(self) -> None:
        for block in self._assembler.finished():
            try:
                frame = self._builder.build(block)
            except Exception as error:  # without this thread nothing would arrive any more
                block.layout.warn_once("a block became no frame", f"{type(error).__name__}: {error}")
                continue
            if block.complete:
                self._rate.add(len(block.payload))
            deliver_or_log(self._deliver, frame)
