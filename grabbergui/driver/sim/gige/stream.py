"""The stream channels of the simulated GigE Vision device: frames out, resends, `faults` on purpose."""

from __future__ import annotations

import logging
import socket
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from grabbergui.driver.gige.gvcp import PacketResend, Status
from grabbergui.driver.sim.gige.datagram_batch import DatagramBatch
from grabbergui.driver.sim.gige.faults import GigeFaults, PacketFaults
from grabbergui.driver.sim.gige.packets import FramePackets, test_packet, unavailable
from grabbergui.driver.sim.model import CameraModel, FramePlan

log = logging.getLogger(__name__)

REBOOT_S = 2.0
"Seconds for which a rebooting camera does not answer."
_POLL_S = 0.05
_KEPT_BYTES = 96 << 20
"Largest total size of the frames kept for resends."
_MOST_KEPT = 16
_MOST_RESENT = 4096
"Packets sent for one request."
_PACED_BATCH_S = 0.00025
"Pauses shorter than this are gathered: a system cannot sleep much more finely."
_CATCH_UP = 4
"Packets with a delay between them that may follow each other at once, after this computer was late."
_SEND_BUFFER = 4 << 20


@dataclass(frozen=True)
class StreamSettings:
    """Destination and size of one channel's packets."""

    host: str = ""
    port: int = 0
    "0 means that the channel is closed."
    packet_size: int = 1500
    delay_ns: int = 0
    "Pause between packets."
    extended: bool = False


class StreamSender:
    """Renders frames and sends them to each open channel, on a thread of its own.

    Answers requests from any thread.
    """

    def __init__(
        self,
        model: CameraModel,
        address: str,
        faults: GigeFaults,
        bandwidth: float,
        *,
        segmentation: bool,
        on_sent: Callable[[int], None],
    ) -> None:
        """With `segmentation`, the kernel splits large sends into packets if it supports that.

        `on_sent` is called with a block's id when its last payload packet has left.
        """
        self.sent_bytes = 0
        "Payload bytes of frames that left, faults and all."
        self._model = model
        self._faults = faults
        self._packet_faults = PacketFaults(faults)
        self._bandwidth = bandwidth
        self._segmentation = segmentation
        self._on_sent = on_sent
        self._settings: list[StreamSettings] = []
        "By channel."
        self._batches: dict[int, DatagramBatch] = {}
        "Batch of each open channel; a channel that is closed and opened again gets another."
        self._kept: OrderedDict[int, dict[int, FramePackets]] = OrderedDict()
        "Frames by block id, as each channel sent them; their payload is the same."
        self._lock = threading.Lock()
        self._stopping = threading.Event()
        self._socket = _open_socket(address)
        self._thread = threading.Thread(target=self._run, name=f"stream of {address}", daemon=True)

    @property
    def port(self) -> int:
        """The UDP port packets come from."""
        return int(self._socket.getsockname()[1])

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def close(self) -> None:
        """Stop the thread, within a frame too, and close the socket."""
        self._stopping.set()
        self._model.wake()
        if self._thread.ident is not None:
            self._thread.join()
        self._socket.close()

    def move(self, address: str) -> None:
        """Send from another address. Only while the channel is closed."""
        with self._lock:
            self._socket.close()
            self._socket = _open_socket(address)

    def configure(self, settings: Sequence[StreamSettings]) -> None:
        """Set the destination of each channel's packets from the next frame on."""
        with self._lock:
            before = [(channel.host, channel.port) for channel in self._settings]
            if before != [(channel.host, channel.port) for channel in settings]:
                self._kept.clear()
            self._settings = list(settings)
            self._batches = {
                index: self._batch_to((channel.host, channel.port), self._batches.get(index))
                for index, channel in enumerate(settings)
                if channel.port
            }

    def _batch_to(self, destination: tuple[str, int], present: DatagramBatch | None) -> DatagramBatch:
        """Return the present batch if it leads there: a frame ends with the batch that it began with."""
        if present is not None and present.destination == destination:
            return present
        return DatagramBatch(self._socket, destination, segmentation=self._segmentation)

    def send_test_packet(self, size: int, channel: int = 0) -> None:
        """Send one datagram of `size` bytes with its IP header, to try whether it gets through."""
        self._send(test_packet(size), channel)

    def resend(self, request: PacketResend) -> None:
        """Resend packets, or answer that they are unavailable or not sent yet."""
        with self._lock:
            block = self._kept.get(request.block_id, {}).get(request.channel)
            if block is None:
                self._refuse(request, request.first, Status.PACKET_UNAVAILABLE)
                return
            sent = block.sent
            count = min(request.last + 1, sent, request.first + _MOST_RESENT) - request.first
            for index in self._packet_faults.order(max(count, 0)):
                self._send(block.packet(request.first + int(index)), request.channel)
            if request.last < sent:
                return
            if sent <= block.trailer_id:
                self._refuse(request, max(request.first, sent), Status.PACKET_NOT_YET_AVAILABLE)
            elif request.last != PacketResend.TO_THE_END:
                self._refuse(request, max(request.first, sent), Status.PACKET_UNAVAILABLE)

    def _refuse(self, request: PacketResend, packet_id: int, status: Status) -> None:
        self._send(unavailable(request.block_id, packet_id, request.extended, status), request.channel)

    def _send(self, datagram: bytes, channel: int) -> None:
        settings = self._settings[channel] if channel < len(self._settings) else StreamSettings()
        if settings.port:
            try:
                self._socket.sendto(datagram, (settings.host, settings.port))
            except OSError as error:
                log.debug("a stream packet was not sent: %s", error)

    def _run(self) -> None:
        while not self._stopping.is_set():
            plan = self._model.next_frame(_POLL_S)
            if plan is not None:
                self._stream(plan)

    def _stream(self, plan: FramePlan) -> None:
        with self._lock:
            batches, settings = self._batches, self._settings
            if plan.frame_id == 1:
                self._kept.clear()
            storage = self._oldest(plan.payload_bytes)
        used = self._model.render(plan, storage)
        stalled = 0 < self._faults.stall_after < plan.frame_id
        if not batches or stalled:
            return
        payload, trailing = storage[:used], self._faults.height_in_trailer
        blocks = {
            channel: FramePackets(
                plan, payload, settings[channel].packet_size, settings[channel].extended, trailing
            )
            for channel in batches
        }
        with self._lock:
            self._kept[next(iter(blocks.values())).block_id] = blocks
        self._stopping.wait(self._faults.delay)
        for channel, block in blocks.items():
            try:
                self._send_block(block, batches[channel], settings[channel], channel)
                self.sent_bytes += used
            except OSError as error:
                log.warning("frame %d was not sent: %s", plan.frame_id, error)

    def _oldest(self, size: int) -> np.ndarray:
        """Return memory for a frame: that of the oldest kept frame, or new memory within the limit."""
        room = max(min(_MOST_KEPT, _KEPT_BYTES // size), 2)
        if len(self._kept) >= room:
            _, blocks = self._kept.popitem(last=False)
            payload = next(iter(blocks.values())).payload
            base = payload.base if payload.base is not None else payload
            if isinstance(base, np.ndarray) and base.size == size:
                return base
        return np.empty(size, np.uint8)

    def _send_block(
        self, block: FramePackets, batch: DatagramBatch, settings: StreamSettings, channel: int
    ) -> None:
        """Send a frame, as long as its channel is open and leads to the same destination."""
        order = np.arange(block.payload_packets)
        leader = trailer = True
        if self._faults.disturbs_packets:
            with self._lock:
                order = self._packet_faults.order(block.payload_packets)
                leader, trailer = (len(self._packet_faults.order(1)) > 0 for _ in range(2))
        if self._batches.get(channel) is not batch:
            return
        if leader:
            self._send(block.leader(), channel)
        block.sent = 1
        headers, starts, sizes = block.headers, block.starts, block.sizes
        if self._faults.disturbs_packets:
            headers, starts, sizes = headers[order], starts[order], sizes[order]
        pause = settings.delay_ns * 1e-9
        late = max(_PACED_BATCH_S, _CATCH_UP * pause)
        if self._bandwidth:
            pause += settings.packet_size / self._bandwidth
        count = max(int(_PACED_BATCH_S / pause), 1) if pause else len(order)
        due = time.monotonic()
        for first in range(0, len(order), count):
            # A slow link takes minutes for a frame, and nobody may want the rest of it.
            if self._stopping.is_set() or self._batches.get(channel) is not batch:
                return
            part = slice(first, first + count)
            batch.send(headers[part], block.payload, starts[part], sizes[part])
            block.sent = int(order[part.stop]) + 1 if part.stop < len(order) else block.trailer_id
            if pause:
                # A link does not make up for lost time: after a late wake-up it goes on at its own pace. A
                # camera with a packet delay is never late, so a few packets are.
                due = max(due, time.monotonic() - late) + len(sizes[part]) * pause
                left = max(due - time.monotonic(), 0)
                if left < _POLL_S:  # more precise, and cheaper
                    time.sleep(left)
                else:
                    self._stopping.wait(left)
        if self._batches.get(channel) is not batch:
            return
        self._on_sent(block.block_id)
        if trailer:
            self._send(block.trailer(), channel)
        block.sent = block.trailer_id + 1


def _open_socket(address: str) -> socket.socket:
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sender.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
    sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(address))
    sender.bind((address, 0))
    return sender
