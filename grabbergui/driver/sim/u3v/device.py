"""The simulated camera as a USB3 Vision device, independent of the USB implementation.

A front (in process, USB/IP, FunctionFS) passes on control requests, commands and halts, and fetches from the
three IN pipes.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass

from grabbergui.core.component import PayloadType as FrameContent
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.core.frame import BufferPool
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import EVENT_ID_BASE, EventSelector, TransportLayer
from grabbergui.driver.sim.memory import Refusal, RegisterRefusedError
from grabbergui.driver.sim.model import CameraModel, FramePlan
from grabbergui.driver.sim.u3v.pipe import InPipe
from grabbergui.driver.sim.u3v.registers import (
    CONTROL_IN,
    EVENT_IN,
    LONGEST_TRANSFER,
    PACKET_SIZE,
    STREAM_IN,
    Descriptors,
    U3vRegisters,
    UsbIdentity,
)
from grabbergui.driver.u3v.bootstrap import Eirm
from grabbergui.driver.u3v.gencp import (
    FLAG_ACKNOWLEDGE,
    HEADER_SIZE,
    CommandId,
    Event,
    Packet,
    Status,
    parse_read_memory,
    parse_write_memory,
    reserved_and_value,
)
from grabbergui.driver.u3v.stream_protocol import Leader, Trailer, TransferPlan, U3vPayloadType

TRANSFERS_AHEAD = 4
"Transfers left in the stream pipe at which the next frame is rendered."

_STATUS = {refusal: Status[refusal.name] for refusal in Refusal}


_IDENTITY = (
    reg.DEVICE_VENDOR_NAME,
    reg.DEVICE_MODEL_NAME,
    reg.DEVICE_SERIAL_NUMBER,
    reg.DEVICE_VERSION,
    reg.DEVICE_USER_ID,
)
"Registers with the strings of `UsbIdentity`, in its order."
_PAYLOAD_TYPES = {
    FrameContent.CHUNK: U3vPayloadType.CHUNK,
    FrameContent.GENDC: U3vPayloadType.GENDC_CONTAINER,
}
"Other kinds than one image that USB3 Vision knows."


@dataclass
class U3vFaults:
    """Faults on request; 0 means never."""

    stall_every: int = 0
    "Frames after which the stream endpoint halts in the middle of one."
    short_every: int = 0
    "Frames of which one is sent with half its payload and the status of discarded data."
    early_every: int = 0
    "Every n-th frame ends early and reports its size in the trailer, like compressed frames."
    unplug_after_frames: int = 0
    unplug_after_commands: int = 0
    ignore_every: int = 0
    "Commands of which one is not answered."
    pending_every: int = 0
    "Commands of which one is put off by a pending acknowledge before its answer."


class U3vRefusedError(Exception):
    """A refusal with a status of USB3 Vision's own."""

    def __init__(self, status: Status) -> None:
        super().__init__(status.name)
        self.status = status


class SimulatedU3vDevice:
    """One camera with its endpoints. Fronts may call from any thread."""

    def __init__(
        self,
        model: CameraModel | None = None,
        *,
        faults: U3vFaults | None = None,
        alignment: int = 1,
        strict: bool = False,
        leader_space: int = 0,
    ) -> None:
        """Make a camera; `start` switches it on.

        `alignment` is that of the payload transfers, in bytes; a `strict` camera refuses a host that ignores
        it, as some real cameras do. Leaders and trailers are padded to `leader_space` bytes.
        """
        self.model = model or CameraModel()
        self.model.memory.set(reg.DEVICE_TL_TYPE, TransportLayer.USB3_VISION)
        self.faults = faults or U3vFaults()
        self.identity = UsbIdentity(*(str(self.model.memory.get(register)) for register in _IDENTITY))
        self.descriptors = Descriptors(self.identity)
        self.registers = U3vRegisters(self.model, self.identity, alignment, leader_space)
        self.registers.on_stream_control = self._on_stream_control
        self.registers.on_test_event = self._on_test_event
        self.model.on_event = self._on_model_event
        self.pipes = {CONTROL_IN: InPipe(), EVENT_IN: InPipe(), STREAM_IN: InPipe()}
        "By endpoint address."
        self.on_unplug: Callable[[], None] | None = None
        "Called when a fault unplugs the device; any thread."
        self.plugged = True
        self.frames_sent = 0
        "Since the device was plugged in."
        self.commands_seen = 0
        self._strict = strict
        self._leader_space = leader_space
        self._configuration = 0
        self._lock = threading.RLock()
        self._event_id = 0
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="u3v-camera", daemon=True)

    def start(self) -> None:
        """Switch the camera on."""
        self._thread.start()

    def stop(self) -> None:
        """Switch it off for good. May be called twice."""
        self.unplug()
        self._stopping.set()
        self.model.wake()
        if self._thread.ident is not None and self._thread is not threading.current_thread():
            self._thread.join()

    def unplug(self) -> None:
        """Pull the cable: every request fails, the acquisition ends."""
        with self._lock:
            if not self.plugged:
                return
            self.plugged = False
            for pipe in self.pipes.values():
                pipe.unplug()
            self.reset()
        if self.on_unplug is not None:
            self.on_unplug()

    def plug_in(self) -> None:
        """Plug the cable in again. Features keep their values; counters of faults are reset."""
        with self._lock:
            self.frames_sent = self.commands_seen = 0
            for pipe in self.pipes.values():
                pipe.plug_in()
            self.plugged = True

    def reset(self) -> None:
        """Switch streams and events off, as a USB reset or a leaving host does."""
        self.model.stop()
        self.registers.stream_enabled = self.registers.events_enabled = False
        for pipe in self.pipes.values():
            pipe.flush()

    def control_request(self, request_type: int, request: int, value: int, index: int) -> bytes | None:
        """Return the data (to be cut to the host's length) for a standard request; None is a stall."""
        if (request_type, request) == (0x80, 6):
            return self.descriptors.get(value >> 8, value & 0xFF)
        if (request_type, request) == (0x80, 8):
            return bytes((self._configuration,))
        if (request_type, request) == (0x00, 9) and value in (0, 1):
            self._configuration = value
            if not value:
                self.reset()
            return b""
        if (request_type, request) == (0x81, 10):
            return b"\0"
        if (request_type, request) in ((0x80, 0), (0x81, 0)):
            return b"\1\0" if request_type == 0x80 else b"\0\0"  # self-powered
        if request_type == 0x82 and request == 0:
            pipe = self.pipes.get(index & 0xFF)
            return bytes((int(pipe is not None and pipe.halted), 0))
        if request_type == 0x02 and request in (1, 3) and value == 0:
            return self._feature_halt(index & 0xFF, halt=request == 3)
        # SET_FEATURE and CLEAR_FEATURE of device and interface, SET_INTERFACE 0, SET_SEL, SET_ISOCH_DELAY
        if (request_type, request) in ((0, 1), (0, 3), (1, 1), (1, 3), (1, 11), (0, 0x30), (0, 0x31)):
            return b""
        return None

    def _feature_halt(self, endpoint: int, *, halt: bool) -> bytes:
        pipe = self.pipes.get(endpoint)
        if pipe is not None:
            if halt:
                pipe.set_halt()
            else:
                pipe.clear_halt()
        return b""

    def command(self, transfer: bytes) -> None:
        """Execute a transfer on the control OUT endpoint; its acknowledge goes into the IN pipe."""
        if not transfer:
            return
        with self._lock:
            self.commands_seen += 1
            if self.commands_seen == self.faults.unplug_after_commands:
                self.unplug()
                return
            if _due(self.commands_seen, self.faults.ignore_every):
                return
            try:
                command = Packet.decode(transfer)
            except RemoteProtocolError:
                answer = Packet(Status.INVALID_HEADER, 0, 0)
            else:
                if _due(self.commands_seen, self.faults.pending_every):
                    pending = Packet(0, CommandId.PENDING_ACK, command.request_id, reserved_and_value(200))
                    self.pipes[CONTROL_IN].put(pending.encode())
                answer = self._execute(command)
                if not command.flags & FLAG_ACKNOWLEDGE:
                    return
            self.pipes[CONTROL_IN].put(answer.encode())

    def _execute(self, command: Packet) -> Packet:
        acknowledge = command.command + 1
        status, data = Status.SUCCESS, b""
        try:
            if command.command == CommandId.READMEM:
                data = self._read(command.data)
            elif command.command == CommandId.WRITEMEM:
                data = self._write(command.data)
            else:
                status = Status.NOT_IMPLEMENTED
        except RegisterRefusedError as error:
            status = _STATUS[error.reason]
        except U3vRefusedError as error:
            status = error.status
        except RemoteProtocolError:
            status = Status.INVALID_PARAMETER
        return Packet(status, acknowledge & 0xFFFF, command.request_id, data)

    def _read(self, data: bytes) -> bytes:
        address, length = parse_read_memory(data)
        if not 0 < length <= LONGEST_TRANSFER - HEADER_SIZE:
            raise U3vRefusedError(Status.INVALID_PARAMETER)
        return self.registers.read(address, length)

    def _write(self, data: bytes) -> bytes:
        address, content = parse_write_memory(data)
        self.registers.write(address, content)
        return reserved_and_value(len(content))

    def _on_stream_control(self, enable: bool) -> None:
        pipe = self.pipes[STREAM_IN]
        if not enable:
            pipe.flush()
            return
        if pipe.halted:
            raise U3vRefusedError(Status.STREAM_ENDPOINT_HALTED)
        plan, needs = self.registers.plan, self.registers.requirements()
        if plan.payload_space < needs.payload_size or plan.transfer_count > 0x10000:
            raise U3vRefusedError(Status.STREAM_REGISTERS_INCONSISTENT)
        if self._strict and any(size % needs.alignment for size in set(plan.payload_sizes)):
            raise U3vRefusedError(Status.PAYLOAD_SIZE_NOT_ALIGNED)
        pipe.flush()

    def _on_model_event(self, event: EventSelector, frame_id: int, timestamp: int) -> None:
        # Big-endian, like all the camera's own registers in the description.
        data = frame_id.to_bytes(8, "big") + timestamp.to_bytes(8, "big")
        self._send_event(Event(EVENT_ID_BASE + event, timestamp, data))

    def _on_test_event(self) -> None:
        self._send_event(Event(Eirm.TEST_EVENT_ID, self.model.timestamp()))

    def _send_event(self, event: Event) -> None:
        pipe = self.pipes[EVENT_IN]
        if self.registers.events_enabled and pipe.wait_until_fewer(64, 0):
            self._event_id = self._event_id % 0xFFFF + 1
            pipe.put(event.encode(self._event_id))

    def _run(self) -> None:
        pool = BufferPool(0)
        pipe = self.pipes[STREAM_IN]
        while not self._stopping.is_set():
            if not pipe.wait_until_fewer(TRANSFERS_AHEAD, 0.1):
                continue
            frame = self.model.next_frame(0.1)
            if frame is None or not self.registers.stream_enabled:
                continue
            if pool.size != frame.payload_bytes:
                pool = BufferPool(frame.payload_bytes)
            buffer = pool.take()
            if buffer is None:
                continue
            length = self.model.render(frame, buffer)
            self._send(frame, buffer[:length].data)

    def _send(self, frame: FramePlan, payload: memoryview) -> None:
        with self._lock:
            if not self.registers.stream_enabled:
                return
            self.frames_sent += 1
            faults, number = self.faults, self.frames_sent
            pipe = self.pipes[STREAM_IN]
            transfers = self._transfers(frame, payload, self.registers.plan, number)
            if _due(number, faults.stall_every):
                pipe.put(*transfers[: len(transfers) // 2])
                pipe.set_halt()
                return
            pipe.put(*transfers)
        if number == faults.unplug_after_frames:
            pipe.wait_until_fewer(1, 5.0)
            self.unplug()

    def _transfers(
        self, frame: FramePlan, payload: memoryview, plan: TransferPlan, number: int
    ) -> list[bytes | memoryview]:
        settings = frame.settings
        kind = _PAYLOAD_TYPES.get(settings.payload_type, U3vPayloadType.IMAGE)
        if kind is U3vPayloadType.IMAGE and frame.chunk_values:
            kind = U3vPayloadType.IMAGE_EXTENDED_CHUNK
        leader = Leader(
            frame.frame_id - 1,
            kind,
            frame.timestamp_ns,
            settings.pixel_format.code,
            settings.width,
            settings.height,
            settings.offset_x,
            settings.offset_y,
        )
        status, height = Status.SUCCESS, settings.height
        announced = len(payload)
        if _due(number, self.faults.short_every):
            payload, status = payload[: len(payload) // 2], Status.DATA_DISCARDED
        elif _due(number, self.faults.early_every):
            height //= 2
            payload = payload[: len(payload) // 2]
            announced = len(payload)
        trailer = Trailer(leader.block_id, status, announced, height, 1)
        return [
            leader.encode(self._leader_space),
            *cut(payload, plan.payload_sizes),
            trailer.encode(kind, self._leader_space),
        ]


def cut(payload: memoryview, sizes: list[int]) -> list[bytes | memoryview]:
    """Divide a payload into transfers of the planned sizes; an empty packet ends a last one if necessary."""
    transfers: list[bytes | memoryview] = []
    position = 0
    for size in sizes:
        if position >= len(payload):
            break
        part = payload[position : position + size]
        position += size
        transfers.append(part)
        if len(part) < size and len(part) % PACKET_SIZE == 0:
            transfers.append(b"")
    return transfers


def _due(number: int, every: int) -> bool:
    return bool(every) and number % every == 0
