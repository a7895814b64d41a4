"""A camera made of a report, as a GigE Vision device on UDP; for `grabbergui simulate --gige --twin`.

Registers that make a device work on a network (its address, the privilege, heartbeat, stream and message
channels) work as those of the simulated camera, beginning with the recorded values. All others are the
recorded memory: with the original's refusals, its order of bytes, and the time that its answers took.
"""

from __future__ import annotations

import struct
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import cast

from typing_extensions import override

from grabbergui.core.errors import DeviceStatusError, GrabberError
from grabbergui.driver.gige import bootstrap
from grabbergui.driver.gige.bootstrap import BIG_ENDIAN_MODE, GvcpCapability, ip_number
from grabbergui.driver.gige.gvcp import CommandCode, CommandHeader, Status
from grabbergui.driver.gige.interfaces import Interface
from grabbergui.driver.sim.camera_xml import zipped
from grabbergui.driver.sim.gige import registers as gev
from grabbergui.driver.sim.gige.control import Address, ControlResponder, OutgoingDatagram, Refused
from grabbergui.driver.sim.gige.deviations import Deviations
from grabbergui.driver.sim.gige.faults import GigeFaults
from grabbergui.driver.sim.gige.server import GIGABIT, GigeCamera
from grabbergui.driver.sim.memory import Register, RegisterMemory, RegisterRefusedError, RegisterValue
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.twin.model import TwinModel
from grabbergui.driver.twin.report_file import CameraReport

XML_ADDRESS = 0xC000_0000
"Where the zipped description is, out of the way of the original's registers."
_WORD = struct.Struct(">I")
_IDENTITY_NUMBERS = 0x48
"Bytes of numbers at the beginning of an answer to DISCOVERY; the rest is text."

_WORKING = frozenset(
    (
        gev.CURRENT_IP,
        gev.SUBNET_MASK,
        gev.MAC_HIGH,
        gev.MAC_LOW,
        *gev.IN_FLASH,
        gev.HEARTBEAT_TIMEOUT,
        gev.TIMESTAMP_CONTROL,
        gev.GVCP_CONFIGURATION,
        gev.GVSP_CONFIGURATION,
        gev.SWITCHOVER_KEY,
        gev.CCP,
        gev.PRIMARY_PORT,
        gev.PRIMARY_IP,
        gev.MCP,
        gev.MCDA,
        gev.MCTT,
        gev.MCRC,
        gev.MCSP,
        *(
            register
            for channel in gev.CHANNELS
            for register in (channel.scp, channel.scps, channel.scpd, channel.scda, channel.scsp)
        ),
    )
)
_CHANNELS = tuple(register for channel in gev.CHANNELS for register in (channel.scp, channel.scda))
_RESET = (gev.CCP, gev.PRIMARY_PORT, gev.PRIMARY_IP, gev.MCP, gev.MCDA, *_CHANNELS)
"Registers that tell of the program that had control while the report was made."
_TICKS = (bootstrap.BootstrapRegister.TICK_FREQUENCY_HIGH, bootstrap.BootstrapRegister.TICK_FREQUENCY_LOW)


class TwinOnWire(TwinModel):
    """A twin whose time stamps are ticks of the original's clock, as leaders carry them."""

    def __init__(self, report: CameraReport) -> None:
        super().__init__(report)
        self._reversed = report.numbers and report.little_endian
        "Whether recorded words are numbers, while the memory is little-endian."
        recorded = (*report.bootstrap, *report.registers)
        self._words = {each.address for each in recorded if each.length == 4 and not each.address % 4}
        self.on_event = None
        self.on_reset = None
        high, low = (self.number(address, 0) for address in _TICKS)
        self._ticks_per_second = (high << 32 | low) or gev.TICKS_PER_SECOND

    def number(self, address: int, default: int) -> int:
        """Return the number in a recorded register of the standard, or a default if there is none."""
        for each in self.report.bootstrap:
            if each.address == address and each.length == 4 and each.data is not None:
                little = self.report.little_endian and not self.report.numbers
                return int.from_bytes(each.data, "little" if little else "big")
        return default

    def turned(self, address: int, data: bytes) -> bytes:
        """Turn words between the form of the record and that of the camera's memory."""
        if not self._reversed:
            return data
        turned = bytearray(data)
        for at in range(0, len(data) - 3, 4):
            if len(data) == 4 or address + at in self._words:
                turned[at : at + 4] = turned[at : at + 4][::-1]
        return bytes(turned)

    @override
    def _stamp(self, count: int) -> int:
        return super()._stamp(count) * self._ticks_per_second // gev.TICKS_PER_SECOND


@dataclass
class TwinControl(ControlResponder):
    """Answers commands with the memory of a twin."""

    twin: TwinOnWire = field(kw_only=True)
    largest_arriving: int = 0xFFFF
    "Bytes of the largest test packet that arrived; larger ones are not sent."
    _silent: bool = False
    "Whether the original did not answer the present command."

    @override
    def _execute(
        self, header: CommandHeader, payload: bytes, source: Address, now: float
    ) -> list[OutgoingDatagram]:
        self._silent = False
        outgoing = super()._execute(header, payload, source, now)
        if self._silent:
            return []
        delay = self._answer_time(header.command, payload)
        return [out._replace(due=out.due + delay) for out in outgoing]

    def _answer_time(self, command: int, payload: bytes) -> float:
        if command == CommandCode.READREG:
            whole = payload[: len(payload) - len(payload) % 4]  # anything may arrive
            return max(
                (self.twin.memory.answer_time(at, 4) for (at,) in _WORD.iter_unpack(whole)), default=0.0
            )
        if command in (CommandCode.READMEM, CommandCode.WRITEREG, CommandCode.WRITEMEM) and len(payload) >= 8:
            length = int.from_bytes(payload[4:8], "big") if command == CommandCode.READMEM else 4
            return self.twin.memory.answer_time(int.from_bytes(payload[:4], "big"), length)
        return 0.0

    @override
    def _identity(self) -> bytes:
        """Return the first registers, numbers big-endian whatever the memory is."""
        content = bytearray(self.twin.memory.peek(0, bootstrap.IDENTITY_BYTES))
        for register in self.memory.registers_in(0, _IDENTITY_NUMBERS):
            content[register.address : register.end] = register.encode(self.memory.get(register))
        return bytes(content)

    @override
    def _pass_resend(self, payload: bytes, flags: int) -> None:
        if self.memory.integer(gev.GVCP_CAPABILITY) & GvcpCapability.PACKETRESEND:
            super()._pass_resend(payload, flags)

    @override
    def _read(self, address: int, length: int) -> bytes:
        if address % 4:
            raise Refused(Status.BAD_ALIGNMENT)
        if address >= XML_ADDRESS and self.twin.report.description:
            return self._own(self.memory.read, address, length)
        content = bytearray(self.twin.turned(address, self._own(self.twin.read, address, length)))
        for register in self._working(address, length):
            raw = self.deviations.number(register.encode(self.memory.get(register)))
            first, end = max(address, register.address), min(address + length, register.end)
            content[first - address : end - address] = raw[first - register.address : end - register.address]
        return bytes(content)

    @override
    def _write(self, address: int, data: bytes) -> None:
        if address % 4:
            raise Refused(Status.BAD_ALIGNMENT)
        if address != gev.CCP.address and self._source != self._controller:
            raise Refused(Status.ACCESS_DENIED)
        if len(data) == 4 and self._working(address, 4):
            self._own(self.memory.write, address, self.deviations.number(data))
        else:
            self._own(self.twin.write, address, self.twin.turned(address, data))

    @override
    def _set_packet_size(self, channel: int, value: RegisterValue) -> RegisterValue:
        if int(value) & bootstrap.PACKET_SIZE_MASK > self.largest_arriving:
            value = int(value) & ~int(bootstrap.PacketSizeFlag.FIRE_TEST_PACKET)
        return super()._set_packet_size(channel, value)

    def _working(self, address: int, length: int) -> list[Register]:
        return [each for each in self.memory.registers_in(address, length) if each in _WORKING]

    def _own(self, access: Callable[..., bytes | None], address: int, what: int | bytes) -> bytes:
        """Read or write. Raises Refused with the original's status; notes if it was silent."""
        try:
            return access(address, what) or b""
        except RegisterRefusedError as error:
            raise Refused(Status[error.reason.name]) from None
        except DeviceStatusError as error:
            raise Refused(error.status or Status.ERROR) from None
        except GrabberError:
            self._silent = True
            raise Refused(Status.ERROR) from None


class TwinGigeCamera(GigeCamera):
    """One twin at one address; `close` ends it."""

    def __init__(
        self,
        address: str,
        report: CameraReport,
        *,
        faults: GigeFaults | None = None,
        bandwidth: float = GIGABIT,
        own_mac: bool = True,
    ) -> None:
        """Bind the address and begin to answer. Raises SourceUnavailableError if it is not available.

        With `own_mac` it has the MAC address in the report, which only one camera of a network may have.
        """
        self.report = report
        self._own_mac = own_mac
        self._twin: TwinOnWire | None = None
        super().__init__(
            address,
            faults=faults,
            deviations=Deviations(little_endian=report.little_endian),
            bandwidth=bandwidth,
        )

    @property
    @override
    def serial(self) -> str:
        return self.report.info.serial

    @override
    def close(self) -> None:
        super().close()
        if self._twin is not None:
            self._twin.close()

    @override
    def _make_model(self) -> CameraModel:
        if self._twin is not None:
            self._twin.close()
        self._twin = TwinOnWire(self.report)
        return cast("CameraModel", self._twin)  # it has what the channels use

    @override
    def _make_bootstrap(self, interface: Interface) -> RegisterMemory:
        twin = self._twin
        assert twin is not None
        memory = RegisterMemory(gev.NUMBERS)
        for register in gev.NUMBERS:
            # A report of another transport has none of them.
            memory.set(
                register, twin.number(register.address, 0 if self.report.bootstrap else int(register.default))
            )
        for register in _RESET:
            memory.set(register, 0)
        if not memory.integer(gev.HEARTBEAT_TIMEOUT):
            memory.set(gev.HEARTBEAT_TIMEOUT, gev.HEARTBEAT_TIMEOUT.default)
        if not memory.integer(gev.CHANNELS[0].scps):
            memory.set(gev.CHANNELS[0].scps, gev.CHANNELS[0].scps.default)
        mode = memory.integer(gev.DEVICE_MODE) & ~int(BIG_ENDIAN_MODE) or 1
        memory.set(gev.DEVICE_MODE, mode | (0 if self.report.little_endian else int(BIG_ENDIAN_MODE)))
        memory.set(gev.CURRENT_IP, ip_number(self.address))
        memory.set(gev.SUBNET_MASK, ip_number(interface.netmask))
        if not self._own_mac or not memory.integer(gev.MAC_LOW):
            memory.set(gev.MAC_HIGH, int.from_bytes(self.mac[:2], "big"))
            memory.set(gev.MAC_LOW, int.from_bytes(self.mac[2:], "big"))
        self._place_description(memory)
        return memory

    def _place_description(self, memory: RegisterMemory) -> None:
        """Put the description into the memory, and its place into the URLs that the original answered."""
        twin = self._twin
        if twin is None or not self.report.description:
            return
        archive = zipped("twin.xml", self.report.description)
        memory.add_block(XML_ADDRESS, archive)
        url = f"Local:twin.zip;{XML_ADDRESS:x};{len(archive):x}".encode()
        refused = {each.address for each in self.report.bootstrap if each.failure}
        for place in (bootstrap.FIRST_URL, bootstrap.SECOND_URL):
            if place.address not in refused:
                twin.write(place.address, url.ljust(place.length, b"\0"))
        if not self.report.bootstrap:
            info = self.report.info
            for place, text in (
                (bootstrap.VENDOR, info.vendor),
                (bootstrap.MODEL, info.model),
                (bootstrap.DEVICE_VERSION, info.version),
                (bootstrap.SERIAL_NUMBER, info.serial),
                (bootstrap.USER_NAME, info.user_name),
            ):
                twin.write(place.address, text.encode()[: place.length - 1].ljust(place.length, b"\0"))

    @override
    def _make_control(self, memory: RegisterMemory) -> ControlResponder:
        assert self._twin is not None
        control = TwinControl(self.model, memory, self._deviations, twin=self._twin)
        if tests := self.report.stream.packet_tests:
            control.largest_arriving = max((test.size for test in tests if test.arrived), default=0)
        return control


def serve(
    addresses: Sequence[str],
    report: CameraReport,
    *,
    faults: GigeFaults | None = None,
    bandwidth: float = GIGABIT,
    stop: threading.Event | None = None,
    ready: Callable[[str], None] = print,
) -> None:
    """Run the twin at each address until `stop` is set; see `sim.gige.server.serve`."""
    stop = stop or threading.Event()
    cameras: list[TwinGigeCamera] = []
    try:
        for address in addresses:
            cameras.append(
                TwinGigeCamera(address, report, faults=faults, bandwidth=bandwidth, own_mac=not cameras)
            )
            ready(f"GigE Vision camera {report.info.serial}, a twin, is at {address}")
        stop.wait()
    finally:
        for camera in cameras:
            camera.close()
