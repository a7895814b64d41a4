"""Opening and closing the stream channels of one device, and those that are received as one stream."""

from __future__ import annotations

import logging
import socket
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property

from grabbergui.core.errors import AccessDeniedError, GrabberError, TransportError, UsageError
from grabbergui.core.frame import BufferPool, Frame
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.driver.device import StreamRequest, check_payload_size
from grabbergui.driver.gige import gvsp
from grabbergui.driver.gige.bootstrap import (
    PACKET_SIZE_MASK,
    PORT_MASK,
    STREAM_CHANNELS_MASK,
    BootstrapRegister,
    GvcpCapability,
    GvspConfiguration,
    PacketSizeFlag,
    StreamChannel,
    ip_number,
    ip_text,
)
from grabbergui.driver.gige.device_memory import DeviceMemory
from grabbergui.driver.gige.interfaces import Interface, leave_through
from grabbergui.driver.gige.stream import recvmmsg
from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.batch_source import BatchSource
from grabbergui.driver.gige.stream.block import LEAST_STRIDE
from grabbergui.driver.gige.stream.datagram_source import DatagramSource, PlainSource
from grabbergui.driver.gige.stream.frame_builder import FrameBuilder
from grabbergui.driver.gige.stream.packet_delay import PacketDelayPolicy, settle_delay
from grabbergui.driver.gige.stream.packet_origin import PacketOrigin
from grabbergui.driver.gige.stream.packet_size import SMALLEST, UNKNOWN_SIZE, PacketSizePolicy, PacketSizer
from grabbergui.driver.gige.stream.receiver import StreamReceiver
from grabbergui.driver.gige.stream.resend import ResendPolicy
from grabbergui.driver.gige.stream.socket_group import widen
from grabbergui.driver.gige.stream.sockets import (
    buffer_bytes,
    is_multicast,
    join_multicast,
    kernel_bytes,
    listening_address,
    open_stream_socket,
    wanted_bytes,
)

log = logging.getLogger(__name__)

BURST_SHARE = 0.25
"Share of the socket's buffer that resent packets may take, which arrive in one burst."
READY_BUFFERS = 4
"Buffers allocated before the first packet, so that no packet waits for memory from the system."
ALL_CHANNELS = -1
"In place of a channel's index."


@dataclass(frozen=True)
class GigeOptions:
    """Options of one camera."""

    packet_size: PacketSizePolicy = field(default_factory=PacketSizePolicy)
    resend: ResendPolicy = field(default_factory=ResendPolicy)
    packet_delay: PacketDelayPolicy = field(default_factory=PacketDelayPolicy)
    multicast: str = ""
    "Multicast group of the stream, which others can join; empty for unicast to us."
    stream_channel: int = 0
    "Index of the stream channel to receive, or `ALL_CHANNELS`."
    batched: bool = True
    "Receive many datagrams in one system call, if the system supports it."
    pixels: str = "auto"
    "Byte order of pixels with more than 8 bits: `auto`, `little` or `big`."
    payload_size: int = 0
    "Bytes of the largest frame; 0 for the camera's PayloadSize."
    registers: str = "auto"
    "How registers of four bytes are accessed: `auto`, `memory` or `numbers`; see `quirks`."
    search_timeout: float = 1.0
    "Seconds within which a camera must answer a search for its name."


class GigeStream:
    """One stream channel of an opened device, until closed."""

    def __init__(
        self,
        memory: DeviceMemory,
        device_ip: str,
        interface: Interface,
        options: GigeOptions,
        channel: int,
    ) -> None:
        """`interface` is the host's, on the way to the device. Nothing is done before `open`."""
        self._memory = memory
        self._device_ip = device_ip
        self._interface = interface
        self._options = options
        self._channel = StreamChannel(channel)
        self._tests_arrive = True
        "Whether test packets are worth a request; False once none of them came."
        self._origin = PacketOrigin(device_ip)
        "Whose packets the current stream takes."
        self._big_endian = False
        "Byte order of the pixels that the camera sends."
        self._receiver: StreamReceiver | None = None
        self._statistics = StreamStatistics()
        self.port = 0
        "The host's UDP port that frames arrive at; 0 before the stream was first opened."
        self.packet_size = 0
        "Bytes of a packet that the camera sends, IP and UDP headers included."

    def open(self, request: StreamRequest, deliver: Callable[[Frame], None], tick_frequency: int) -> None:
        """Start to receive. Raises TransportError, AccessDeniedError, and as registers do."""
        self.close()
        self._statistics = StreamStatistics()
        check_payload_size(request.payload_size)
        receiver = self._open_socket(request.payload_size)
        try:
            stride = gvsp.payload_stride(self.packet_size, extended=self._has_extended_ids())
            if stride < LEAST_STRIDE:
                raise TransportError(
                    f"the camera's packet size is {self.packet_size} bytes, which leaves {max(stride, 0)} for"
                    f" an image; write packet_size=auto, or {SMALLEST} or more"
                )
            pool = make_pool(request.payload_size)
            assembler = BlockAssembler(
                stride,
                request.payload_size,
                pool.take,
                self._resend_policy(pool, receiver),
                deliver_incomplete=request.deliver_incomplete,
                channel=self._channel.index,
            )
            builder = FrameBuilder(
                tick_frequency,
                big_endian=self._has_big_endian_pixels(request),
                channel=self._channel.index,
            )
            source = self._open_source(receiver, request.payload_size)
            self._receiver = StreamReceiver(receiver, self._device_ip, assembler, builder, deliver, source)
        except BaseException:
            receiver.close()
            raise
        if self._memory.writable:
            policy = self._options.packet_delay
            settle_delay(self._memory, self._channel, policy, self.packet_size, tick_frequency)

    def close(self) -> None:
        """Close the channel in the camera and stop receiving. May be called twice; never raises."""
        receiver, self._receiver = self._receiver, None
        if receiver is None:
            return
        if self._memory.writable:
            try:
                self._memory.write_register(self._channel.port, 0)
            except GrabberError as error:
                log.info("closing the stream channel: %s", error)
        receiver.stop()
        self._statistics = replace(receiver.statistics(), frame_rate=0.0, bandwidth=0.0)

    def statistics(self) -> StreamStatistics:
        """Return a snapshot of the current or the last stream. Any thread."""
        receiver = self._receiver
        return receiver.statistics() if receiver is not None else replace(self._statistics)

    @property
    def refusal(self) -> str:
        """Why frames that arrived were refused; empty if none was. Any thread."""
        receiver = self._receiver
        return receiver.refusal if receiver is not None else ""

    def _open_socket(self, payload_size: int) -> socket.socket:
        if not self._memory.writable:
            return self._listen_in(payload_size)
        group = self._options.multicast
        local = listening_address(group) if group else self._interface.ip
        receiver = open_stream_socket(local, payload_size, shared=bool(group))
        try:
            leave_through(receiver, self._interface)
            if group:
                join_multicast(receiver, group, self._interface.ip)
            self.port = receiver.getsockname()[1]
            destination = ip_number(group or self._interface.ip)
            if not self._memory.write_optional(self._channel.destination, destination):
                log.warning("the camera keeps its own destination of the stream: %s", self._destination())
            self._memory.write_register(self._channel.port, self.port)
            sizer = PacketSizer(self._channel, self._memory, self._interface)
            self.packet_size = sizer.settle(
                self._options.packet_size, receiver, self._device_ip, can_test=self._tests_arrive
            )
            self._tests_arrive = self._tests_arrive and sizer.tests_arrive
            self._big_endian = sizer.big_endian
            self._open_firewall(receiver)
            self._origin = PacketOrigin(self._device_ip, self._source_port(), sizer.source_port)
        except BaseException:
            receiver.close()
            raise
        return receiver

    def _has_big_endian_pixels(self, request: StreamRequest) -> bool:
        """Return the byte order of pixels: the user's choice, or what the camera announces in any way."""
        if self._options.pixels != "auto":
            return self._options.pixels == "big"
        if request.big_endian_pixels and not self._big_endian:
            log.info("pixels are taken as big-endian, although the camera's register SCPS does not say so")
        return self._big_endian or bool(request.big_endian_pixels)

    @cached_property
    def _version(self) -> int:
        """The major version of GigE Vision that the camera follows."""
        return self._memory.read_optional(BootstrapRegister.VERSION) >> 16

    def _has_extended_ids(self) -> bool:
        """Return whether the camera sends 64-bit block ids, which take twelve bytes of each packet."""
        if self._version < 2:
            return False  # the register came with GigE Vision 2.0
        configuration = self._memory.read_optional(BootstrapRegister.GVSP_CONFIGURATION)
        return bool(configuration & GvspConfiguration.EXTENDED_IDS)

    def _listen_in(self, payload_size: int) -> socket.socket:
        """Join the multicast stream that another controller opened."""
        group = self._destination()
        port = self._memory.read_register(self._channel.port) & PORT_MASK
        if not is_multicast(group) or not port:
            sends = f"sends its frames to {group} alone" if port else "sends no frames yet"
            raise AccessDeniedError(
                f"the camera {sends}, and only its controller may change that; close the other application"
                " or let it stream to a multicast group, 239.x.x.x"
            )
        receiver = open_stream_socket(listening_address(group), payload_size, port, shared=True)
        try:
            join_multicast(receiver, group, self._interface.ip)
            self.port = port
            register = self._memory.read_optional(self._channel.packet_size, UNKNOWN_SIZE)
            self.packet_size = register & PACKET_SIZE_MASK
            self._big_endian = bool(register & PacketSizeFlag.BIG_ENDIAN_PIXELS)
            self._origin = PacketOrigin(self._device_ip, self._source_port())
        except BaseException:
            receiver.close()
            raise
        return receiver

    def _destination(self) -> str:
        """Return the address that frames go to; 0.0.0.0 if the camera does not tell."""
        return ip_text(self._memory.read_optional(self._channel.destination))

    def _open_firewall(self, receiver: socket.socket) -> None:
        """Open a stateful firewall by a datagram to the port that frames are sent from."""
        if source_port := self._source_port():
            try:
                receiver.sendto(b"", (self._device_ip, source_port))
            except OSError as error:
                log.debug("opening the firewall: %s", error)

    def _source_port(self) -> int:
        """Return the port that the camera sends from; 0 if it does not report one."""
        return self._memory.read_optional(self._channel.source_port) & PORT_MASK

    def _open_source(self, receiver: socket.socket, payload_size: int) -> DatagramSource:
        options = self._options
        if not options.batched or not recvmmsg.available():
            return PlainSource(receiver, self._origin)
        # A datagram to a multicast group would arrive at each of the sockets.
        alone = self._memory.writable and not self._options.multicast
        more = widen(receiver, wanted_bytes(payload_size), self.packet_size) if alone else []
        return BatchSource(receiver, self._origin, more)

    def _resend_policy(self, pool: BufferPool, receiver: socket.socket) -> ResendPolicy:
        """Return the policy, limited to what the camera can do and the buffers hold."""
        can = bool(self._memory.capability & GvcpCapability.PACKETRESEND) and self._memory.writable
        burst = int(BURST_SHARE * buffer_bytes(receiver) / kernel_bytes(self.packet_size))
        # Incomplete blocks must not take the buffers that consumers need.
        max_blocks = min(self._options.resend.max_blocks, pool.limit // 2)
        return replace(
            self._options.resend,
            enabled=self._options.resend.enabled and can,
            max_blocks=max_blocks,
            max_unanswered=max(min(self._options.resend.max_unanswered, burst), 1),
        )


def make_pool(payload_size: int) -> BufferPool:
    """Return buffers for one stream, some of them allocated already."""
    pool = BufferPool(payload_size)
    ready = [pool.take() for _ in range(READY_BUFFERS)]
    del ready
    return pool


def tick_frequency(memory: DeviceMemory) -> int:
    """Read the frequency of the device's clock in Hz; 0 if it has none. Raises as register reads do."""
    high = memory.read_optional(BootstrapRegister.TICK_FREQUENCY_HIGH)
    return high << 32 | memory.read_optional(BootstrapRegister.TICK_FREQUENCY_LOW)


def chosen_channels(memory: DeviceMemory, wanted: int) -> Sequence[int]:
    """Return the indices that `wanted` means for this device. Raises UsageError, and as registers do."""
    if wanted == 0:
        return (0,)  # every streaming device has channel 0, even if its register claims otherwise
    count = memory.read_optional(BootstrapRegister.STREAM_CHANNELS, 1) & STREAM_CHANNELS_MASK
    if wanted == ALL_CHANNELS:
        return range(max(count, 1))
    if wanted >= count:
        has = "only stream channel 0" if count < 2 else f"stream channels 0 to {count - 1}"
        raise UsageError(f"stream_channel={wanted}: this camera has {has}; choose one of them, or all")
    return (wanted,)


class Streams:
    """One or several open streams. `Frame.stream_channel` is the channel that a frame arrived on."""

    def __init__(self, channels: Sequence[GigeStream]) -> None:
        """Take at least one channel."""
        self.channels = channels

    def open(self, request: StreamRequest, deliver: Callable[[Frame], None], tick_frequency: int) -> None:
        """Start to receive; `deliver` is never called twice at a time. Raises as `GigeStream.open`."""
        if len(self.channels) > 1:
            deliver = _one_at_a_time(deliver)
        try:
            for channel in self.channels:
                channel.open(request, deliver, tick_frequency)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Close every channel and stop receiving. May be called twice; never raises."""
        for channel in self.channels:
            channel.close()

    def statistics(self) -> StreamStatistics:
        """Return a snapshot of the sums of all channels. Any thread."""
        total, *others = (channel.statistics() for channel in self.channels)
        for other in others:
            for counter in fields(StreamStatistics):
                value = getattr(total, counter.name) + getattr(other, counter.name)
                setattr(total, counter.name, value)
        return total


def _one_at_a_time(deliver: Callable[[Frame], None]) -> Callable[[Frame], None]:
    lock = threading.Lock()

    def delivered(frame: Frame) -> None:
        with lock:
            deliver(frame)

    return delivered
