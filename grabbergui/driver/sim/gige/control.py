"""The control channel of the simulated GigE Vision device: GVCP in, GVCP out.

Takes datagrams with the time, gives datagrams with the time they are due; touches no socket and reads no
clock. One thread calls it.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.gige import bootstrap
from grabbergui.driver.gige.bootstrap import (
    ControlPrivilege,
    GvcpCapability,
    GvcpConfiguration,
    ip_number,
    ip_text,
)
from grabbergui.driver.gige.gvcp import (
    FLAG_ACK_REQUIRED,
    KEY,
    MAX_MEMORY,
    Ack,
    CommandCode,
    CommandHeader,
    PacketResend,
    ReadMem,
    ReadReg,
    Status,
    WriteMem,
    WriteReg,
    encode_pending_ack,
    encode_write_ack,
    split_command,
)
from grabbergui.driver.gige.gvcp_messages import Action, Event
from grabbergui.driver.gige.identity import ForceIp
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige import registers as gev
from grabbergui.driver.sim.gige.deviations import Deviations
from grabbergui.driver.sim.memory import Refusal, RegisterMemory, RegisterRefusedError, RegisterValue
from grabbergui.driver.sim.model import CameraModel

Address = tuple[str, int]

SLOW_COMMAND_S = 0.3
"Seconds that saving a user set takes, as if the camera wrote flash memory."

_STATUS = {refusal: Status[refusal.name] for refusal in Refusal}
_WRITES = (CommandCode.WRITEREG, CommandCode.WRITEMEM)
_FAILED = 0x8000
_ON_CONTROL = ControlPrivilege.EXCLUSIVE | ControlPrivilege.CONTROL


class OutgoingDatagram(NamedTuple):
    """A datagram to send."""

    due: float
    "Monotonic seconds; not before."
    datagram: bytes
    to: Address


@dataclass
class _UnheardEvent:
    datagram: bytes
    to: Address
    due: float
    left: int


class Refused(Exception):  # noqa: N818 - never an error of ours: the answer to a command
    """Ends the handling of a command; its status replaces success in the answer."""

    def __init__(self, status: int, payload: bytes = b"") -> None:
        super().__init__(status)
        self.status = status
        self.payload = payload


@dataclass
class ControlResponder:
    """Answers commands and holds who is in control."""

    model: CameraModel
    memory: RegisterMemory
    "Bootstrap registers and XML."
    deviations: Deviations = field(default_factory=Deviations)
    largest_packet: int = 65_532
    "Bytes, as SCPS counts; the interface's MTU."
    on_resend: Callable[[PacketResend], None] = lambda request: None
    on_test_packet: Callable[[int, int], None] = lambda size, channel: None
    "Called with the size of the IP datagram and the stream channel, after the acknowledge is on its way."
    on_stream_changed: Callable[[], None] = lambda: None
    "Called when the stream's destination, packet size or delay changed."
    on_force_ip: Callable[[str, str], bool] = lambda ip, netmask: False
    "Called with address and mask; whether the device has moved there."
    _controller: Address | None = None
    _heard: float = 0.0
    _source: Address = ("", 0)
    _last: tuple[tuple[Address, int, int], list[OutgoingDatagram]] | None = None
    _after: list[Callable[[], None]] = field(default_factory=list)
    _event_id: int = 0
    _unheard: dict[int, _UnheardEvent] = field(default_factory=dict)

    def __post_init__(self) -> None:
        memory = self.memory
        memory.on_check(gev.CCP, self._take_control)
        for index, channel in enumerate(gev.CHANNELS):
            memory.on_check(channel.scps, partial(self._set_packet_size, index))
        memory.on_check(gev.HEARTBEAT_TIMEOUT, lambda value: max(int(value), gev.LEAST_HEARTBEAT_MS))
        memory.on_check(gev.TIMESTAMP_CONTROL, self._control_timestamp)
        streams = (register for each in gev.CHANNELS for register in (each.scp, each.scda, each.scpd))
        for register in (*streams, gev.GVSP_CONFIGURATION):
            memory.on_written(register, lambda: self._after.append(self.on_stream_changed))

    def receive(self, datagram: bytes, source: Address, now: float) -> list[OutgoingDatagram]:
        """Answer one datagram. Never raises, however invalid the datagram is."""
        if not datagram or datagram[0] != KEY:
            self._hear_event_ack(datagram)
            return []
        try:
            header, payload = split_command(datagram)
        except RemoteProtocolError:
            return []
        if header.command == CommandCode.PACKETRESEND:
            self._pass_resend(payload, header.flags)
            return []
        if source == self._controller:
            self._heard = now
        key = (source, header.req_id, header.command)
        if self._last is not None and self._last[0] == key:
            # A repeated command is answered again and not executed again.
            return [out._replace(due=max(out.due, now)) for out in self._last[1]]
        outgoing = self._execute(header, payload, source, now)
        self._last = (key, outgoing)
        return outgoing

    def run_deferred(self) -> None:
        """Run the actions that must follow the acknowledge."""
        after, self._after = self._after, []
        for act in after:
            act()

    def after_ack(self, act: Callable[[], None]) -> None:
        """Schedule an action for after the acknowledge of the present command."""
        self._after.append(act)

    def poll(self, now: float) -> list[OutgoingDatagram]:
        """Let time pass: control expires, unheard events are repeated."""
        timeout = self.memory.integer(gev.HEARTBEAT_TIMEOUT) / 1000
        watched = not self.memory.integer(gev.GVCP_CONFIGURATION) & GvcpConfiguration.HEARTBEAT_DISABLE
        if self._controller is not None and watched and now - self._heard > timeout:
            self.release()
        repeated = []
        for req_id, event in list(self._unheard.items()):
            if event.due > now:
                continue
            if event.left == 0:
                del self._unheard[req_id]
                continue
            event.left -= 1
            event.due = now + self.memory.integer(gev.MCTT) / 1000
            repeated.append(OutgoingDatagram(now, event.datagram, event.to))
        return repeated

    def send_event(self, event_id: int, frame_id: int, timestamp: int, now: float) -> list[OutgoingDatagram]:
        """Return an event as a message, if the host has opened the message channel."""
        port = self.memory.integer(gev.MCP) & bootstrap.PORT_MASK
        if not port:
            return []
        self._event_id = self._event_id % 0xFFFF + 1
        data = struct.pack(">qq", frame_id, timestamp)
        event = Event(event_id, (frame_id - 1) % 0xFFFF + 1 if frame_id else 0, timestamp, data=data)
        datagram = event.encode(self._event_id)
        to = (ip_text(self.memory.integer(gev.MCDA)), port)
        wait = self.memory.integer(gev.MCTT) / 1000
        self._unheard[self._event_id] = _UnheardEvent(datagram, to, now + wait, self.memory.integer(gev.MCRC))
        return [OutgoingDatagram(now, datagram, to)]

    def release(self) -> None:
        """End control as the device does on time-out: streams and messages stop too."""
        self._controller = None
        closed = (gev.CCP, gev.SWITCHOVER_KEY, gev.PRIMARY_IP, gev.PRIMARY_PORT, gev.MCP)
        for register in (*closed, *(channel.scp for channel in gev.CHANNELS)):
            self.memory.set(register, 0)
        self._unheard.clear()
        self.model.stop()
        self.on_stream_changed()

    @property
    def controlled(self) -> bool:
        """Whether an application is in control."""
        return self._controller is not None

    def _hear_event_ack(self, datagram: bytes) -> None:
        try:
            ack = Ack.decode(datagram)
        except RemoteProtocolError:
            return
        if ack.acknowledge in (CommandCode.EVENT + 1, CommandCode.EVENTDATA + 1):
            self._unheard.pop(ack.ack_id, None)

    def _pass_resend(self, payload: bytes, flags: int) -> None:
        try:
            request = PacketResend.decode(payload, flags)
        except RemoteProtocolError:
            return
        if request.channel < len(gev.CHANNELS):
            self.on_resend(request)

    def _execute(
        self, header: CommandHeader, payload: bytes, source: Address, now: float
    ) -> list[OutgoingDatagram]:
        self._source = source
        executors: dict[int, Callable[[bytes, int], bytes | None]] = {
            CommandCode.DISCOVERY: lambda payload, flags: self._identity(),
            CommandCode.FORCEIP: self._force_ip,
            CommandCode.READREG: self._read_registers,
            CommandCode.WRITEREG: self._write_registers,
            CommandCode.READMEM: self._read_memory,
            CommandCode.WRITEMEM: self._write_memory,
            CommandCode.ACTION: self._act,
        }
        executor = executors.get(header.command)
        status: int = Status.SUCCESS
        answer: bytes | None = b""
        saving = header.command in _WRITES and payload[:4] == struct.pack(">I", reg.USER_SET_SAVE.address)
        try:
            if executor is None:
                raise Refused(Status.NOT_IMPLEMENTED)
            answer = executor(payload, header.flags)
        except Refused as refused:
            status, answer = refused.status, refused.payload
        except RemoteProtocolError:
            status, answer = Status.INVALID_HEADER, b""
        if self._source == self._controller:  # perhaps since this command
            self._heard = now
        if status & _FAILED and not answer and header.command in _WRITES:
            # Hosts do not look at it, but dissectors do.
            answer = encode_write_ack(0)
        if answer is None or not header.flags & FLAG_ACK_REQUIRED:
            return []
        ack = Ack(status, header.command + 1 & 0xFFFF, header.req_id, answer).encode()
        announced = self.memory.integer(gev.GVCP_CONFIGURATION) & GvcpConfiguration.PENDING_ACK
        if saving and status == Status.SUCCESS and announced:
            pending = encode_pending_ack(int(SLOW_COMMAND_S * 2000), header.req_id)
            return [
                OutgoingDatagram(now, pending, source),
                OutgoingDatagram(now + SLOW_COMMAND_S, ack, source),
            ]
        return [OutgoingDatagram(now, ack, source)]

    def _identity(self) -> bytes:
        return gev.identity(self.memory)

    def _force_ip(self, payload: bytes, flags: int) -> bytes | None:
        request = ForceIp.decode(payload)
        mac = (self.memory.integer(gev.MAC_HIGH) << 32 | self.memory.integer(gev.MAC_LOW)).to_bytes(6, "big")
        if request.mac.replace(":", "") != mac.hex():
            return None
        if self.controlled:
            raise Refused(Status.ACCESS_DENIED)
        if request.ip != "0.0.0.0" and not self.on_force_ip(request.ip, request.subnet_mask):
            raise Refused(Status.INVALID_PARAMETER)
        return b""

    def _read_registers(self, payload: bytes, flags: int) -> bytes:
        self._require_read()
        number = self.deviations.number
        return b"".join(number(self._read(address, 4)) for address in ReadReg.decode(payload).addresses)

    def _read_memory(self, payload: bytes, flags: int) -> bytes:
        request = ReadMem.decode(payload)
        self._require_read()
        if request.address % 4:
            raise Refused(Status.BAD_ALIGNMENT)
        if request.count % 4 or not 0 < request.count <= min(MAX_MEMORY, self.deviations.longest_access):
            raise Refused(Status.INVALID_PARAMETER)
        return ReadMem.encode_ack(request.address, self._read(request.address, request.count))

    def _write_registers(self, payload: bytes, flags: int) -> bytes:
        writes = WriteReg.decode(payload).writes
        for index, (address, value) in enumerate(writes):
            try:
                self._write(address, self.deviations.number(struct.pack(">I", value)))
            except Refused as refused:
                raise Refused(refused.status, encode_write_ack(index)) from None
        return encode_write_ack(len(writes))

    def _write_memory(self, payload: bytes, flags: int) -> bytes:
        request = WriteMem.decode(payload)
        if not self.memory.integer(gev.GVCP_CAPABILITY) & GvcpCapability.WRITEMEM:
            raise Refused(Status.NOT_IMPLEMENTED)
        if len(request.data) % 4 or len(request.data) > self.deviations.longest_access:
            raise Refused(Status.INVALID_PARAMETER)
        self._write(request.address, request.data)
        return encode_write_ack(len(request.data))

    def _act(self, payload: bytes, flags: int) -> bytes | None:
        action = Action.decode(payload, flags)
        memory = self.memory
        meant = (
            action.device_key == memory.integer(gev.ACTION_DEVICE_KEY)
            and action.group_key == memory.integer(gev.ACTION_GROUP_KEY)
            and action.group_mask & memory.integer(gev.ACTION_GROUP_MASK)
        )
        unconditional = memory.integer(gev.GVCP_CONFIGURATION) & GvcpConfiguration.UNCONDITIONAL_ACTION
        if not meant or not (self.controlled or unconditional):
            return None
        late = action.time is not None and action.time < self.model.timestamp()
        self.model.trigger_action(None if late else action.time)
        if late:
            raise Refused(Status.ACTION_LATE)
        return b""

    def _require_read(self) -> None:
        exclusive = self.memory.integer(gev.CCP) & ControlPrivilege.EXCLUSIVE
        if exclusive and self._source != self._controller:
            raise Refused(Status.ACCESS_DENIED)

    def _read(self, address: int, length: int) -> bytes:
        if address % 4:
            raise Refused(Status.BAD_ALIGNMENT)
        self._require_access(address, length)
        try:
            if self._is_feature(address):
                return self.deviations.read(self.model.memory, self.model.read, address, length)
            return self.deviations.read(self.memory, self.memory.read, address, length)
        except RegisterRefusedError as error:
            raise Refused(_STATUS[error.reason]) from None

    def _write(self, address: int, data: bytes) -> None:
        if address % 4:
            raise Refused(Status.BAD_ALIGNMENT)
        if address != gev.CCP.address and self._source != self._controller:
            raise Refused(Status.ACCESS_DENIED)
        self._require_access(address, len(data))
        if address in self.deviations.read_only:
            raise Refused(Status.WRITE_PROTECT)
        try:
            if self._is_feature(address):
                self.model.write(address, self.deviations.stored(self.model.memory, address, data))
            else:
                self.memory.write(address, self.deviations.stored(self.memory, address, data))
        except RegisterRefusedError as error:
            raise Refused(_STATUS[error.reason]) from None

    def _require_access(self, address: int, length: int) -> None:
        for register, status in self.deviations.refused.items():
            if address <= register < address + length:
                raise Refused(status)

    @staticmethod
    def _is_feature(address: int) -> bool:
        return reg.DEVICE_VENDOR_NAME.address <= address < gev.XML_ADDRESS

    def _take_control(self, value: RegisterValue) -> RegisterValue:
        wanted = int(value)
        if self._controller not in (None, self._source) and not self._is_offered(wanted):
            raise RegisterRefusedError(Refusal.ACCESS_DENIED, "another application has control")
        if not wanted & _ON_CONTROL:
            self.release()
            return 0
        self._controller = self._source
        self.memory.set(gev.PRIMARY_IP, ip_number(self._source[0]))
        self.memory.set(gev.PRIMARY_PORT, self._source[1])
        return wanted & (_ON_CONTROL | ControlPrivilege.SWITCHOVER)

    def _is_offered(self, wanted: int) -> bool:
        """Return whether the controlling application lets this request take control over."""
        memory = self.memory
        offered = memory.integer(gev.CCP) & ControlPrivilege.SWITCHOVER
        return bool(offered and wanted & _ON_CONTROL and wanted >> 16 == memory.integer(gev.SWITCHOVER_KEY))

    def _set_packet_size(self, channel: int, value: RegisterValue) -> RegisterValue:
        size = min(int(value) & bootstrap.PACKET_SIZE_MASK, self.largest_packet) & ~3
        size = max(size, gev.SMALLEST_PACKET)
        if int(value) & bootstrap.PacketSizeFlag.FIRE_TEST_PACKET:
            self._after.append(lambda: self.on_test_packet(size, channel))
        self._after.append(self.on_stream_changed)
        return int(value) & bootstrap.PacketSizeFlag.DO_NOT_FRAGMENT | size

    def _control_timestamp(self, value: RegisterValue) -> RegisterValue:
        # The model's own registers do it, so that both ways show the same.
        for bit, register in ((0x1, reg.TIMESTAMP_RESET), (0x2, reg.TIMESTAMP_LATCH)):
            if int(value) & bit:
                self.model.write(register.address, register.encode(1))
        return 0
