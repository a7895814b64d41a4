"""The bootstrap registers of the simulated camera as a GigE Vision device."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from importlib import resources

from grabbergui.driver.gige import bootstrap
from grabbergui.driver.gige.bootstrap import (
    GvcpCapability,
    GvcpConfiguration,
    MessageCapability,
    StreamChannel,
    ip_number,
)
from grabbergui.driver.gige.identity import Identity
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.camera_xml import with_transport, zipped
from grabbergui.driver.sim.gige.deviations import Deviations
from grabbergui.driver.sim.memory import Register, RegisterKind, RegisterMemory
from grabbergui.driver.sim.model import CameraModel

XML_ADDRESS = 0x200000
XML_NAME = "grabbergui_simulated_camera"
TICKS_PER_SECOND = 1_000_000_000
LEAST_HEARTBEAT_MS = 500
SMALLEST_PACKET = 576

_CAPABILITY = (
    GvcpCapability.CONCATENATION
    | GvcpCapability.WRITEMEM
    | GvcpCapability.PACKETRESEND
    | GvcpCapability.EVENT
    | GvcpCapability.EVENTDATA
    | GvcpCapability.PENDING_ACK
    | GvcpCapability.ACTION
    | GvcpCapability.SCHEDULED_ACTION
    | GvcpCapability.IEEE1588
    | GvcpCapability.TEST_DATA
    | GvcpCapability.PRIMARY_APPLICATION
    | GvcpCapability.HEARTBEAT_DISABLE
    | GvcpCapability.SERIAL_NUMBER
    | GvcpCapability.USER_NAME
    | GvcpCapability.SWITCHOVER
    | 0x00100000  # unconditional action
    | 0x00440000  # extended status codes
    | GvcpCapability.LINK_SPEED
)
_STREAM_CAPABILITY = 0x80000000 | 0x40000000
"The camera reports its source port and supports 16-bit block ids."
_REGISTERS: list[Register] = []
"Every register of a number; `_register` adds it."
_R = bootstrap.BootstrapRegister
_FEATURES = (
    "GevStreamChannelCount",
    "GevStreamChannelSelector",
    "GevSCPSPacketSize",
    "GevSCPSDoNotFragment",
    "GevSCPSFireTestPacket",
    "GevSCPD",
    "GevGVSPExtendedIDMode",
    "GevHeartbeatTimeout",
    "GevCurrentIPAddress",
    "GevCurrentSubnetMask",
    "GevCurrentDefaultGateway",
    "GevCurrentIPConfigurationPersistentIP",
    "GevCurrentIPConfigurationDHCP",
    "GevCurrentIPConfigurationLLA",
    "GevPersistentIPAddress",
    "GevPersistentSubnetMask",
    "GevPersistentDefaultGateway",
    "GevMACAddress",
    "ActionDeviceKey",
    "ActionGroupKey",
    "ActionGroupMask",
)


def _register(
    name: str, address: int, default: int = 0, *, writable: bool = False, high: int = 0xFFFFFFFF
) -> Register:
    register = Register(name, address, RegisterKind.UINT32, 4, default, writable, 0, high)
    _REGISTERS.append(register)
    return register


def _field(name: str, field: bootstrap.Field, text: str = "", *, writable: bool = False) -> Register:
    return Register(name, field.address, RegisterKind.STRING, field.length, text, writable)


CURRENT_IP = _register("current IP", _R.CURRENT_IP)
SUBNET_MASK = _register("current subnet mask", _R.CURRENT_SUBNET_MASK)
GATEWAY = _register("current gateway", _R.CURRENT_GATEWAY)
IP_CONFIGURATION = _register(
    "current IP configuration", _R.CURRENT_IP_CONFIGURATION, 0x6, writable=True, high=0x7
)
PERSISTENT_IP = _register("persistent IP", _R.PERSISTENT_IP, writable=True)
PERSISTENT_MASK = _register("persistent subnet mask", _R.PERSISTENT_SUBNET_MASK, writable=True)
PERSISTENT_GATEWAY = _register("persistent gateway", _R.PERSISTENT_GATEWAY, writable=True)
IN_FLASH = (IP_CONFIGURATION, PERSISTENT_IP, PERSISTENT_MASK, PERSISTENT_GATEWAY)
"Registers that keep their values without power."
LINK_SPEED = _register("link speed", _R.LINK_SPEED, 10_000)
MAC_HIGH = _register("MAC high", _R.MAC_HIGH)
MAC_LOW = _register("MAC low", _R.MAC_LOW)
USER_NAME = _field("user name", bootstrap.USER_NAME, writable=True)
ACTION_DEVICE_KEY = _register("action device key", _R.ACTION_DEVICE_KEY, writable=True)
DEVICE_MODE = _register("device mode", _R.DEVICE_MODE)
GVCP_CAPABILITY = _register("GVCP capability", _R.GVCP_CAPABILITY, int(_CAPABILITY))
HEARTBEAT_TIMEOUT = _register("heartbeat timeout", _R.HEARTBEAT_TIMEOUT_MS, 3000, writable=True)
TIMESTAMP_CONTROL = _register("timestamp control", _R.TIMESTAMP_CONTROL, writable=True, high=3)
TIMESTAMP_HIGH = _register("latched timestamp high", _R.TIMESTAMP_HIGH)
TIMESTAMP_LOW = _register("latched timestamp low", _R.TIMESTAMP_LOW)
GVCP_CONFIGURATION = _register("GVCP configuration", _R.GVCP_CONFIGURATION, writable=True)
IEEE1588_STATUS = _register("IEEE 1588 status", 0x096C)
GVSP_CONFIGURATION = _register("GVSP configuration", _R.GVSP_CONFIGURATION, writable=True)
SWITCHOVER_KEY = _register("control switchover key", _R.CONTROL_SWITCHOVER_KEY, writable=True, high=0xFFFF)
CCP = _register("CCP", _R.CCP, writable=True)
PRIMARY_PORT = _register("primary application port", _R.PRIMARY_APPLICATION_PORT)
PRIMARY_IP = _register("primary application IP", _R.PRIMARY_APPLICATION_IP)
MCP = _register("MCP", _R.MCP, writable=True)
MCDA = _register("MCDA", _R.MCDA, writable=True)
MCTT = _register("MCTT", _R.MCTT_MS, 200, writable=True, high=10_000)
MCRC = _register("MCRC", _R.MCRC, 3, writable=True, high=20)
MCSP = _register("MCSP", _R.MCSP, bootstrap.GVCP_PORT)


@dataclass(frozen=True)
class ChannelRegisters:
    """The registers of one stream channel."""

    scp: Register
    scps: Register
    scpd: Register
    scda: Register
    scsp: Register

    @classmethod
    def of(cls, index: int) -> ChannelRegisters:
        """Return those of the channel `index`."""
        at = StreamChannel(index)
        return cls(
            _register(f"SCP{index}", at.port, writable=True),
            _register(f"SCPS{index}", at.packet_size, 1500, writable=True),
            _register(f"SCPD{index}", at.packet_delay, writable=True, high=1_000_000_000),
            _register(f"SCDA{index}", at.destination, writable=True),
            _register(f"SCSP{index}", at.source_port),
        )


CHANNELS = tuple(map(ChannelRegisters.of, range(2)))
"Each that is open gets every frame."
for _index in range(len(CHANNELS)):
    _register(f"SCC{_index}", 0x0D20 + 0x40 * _index)
    _register(f"SCCFG{_index}", 0x0D24 + 0x40 * _index, writable=True, high=0)
STREAM_CHANNELS = _register("stream channels", _R.STREAM_CHANNELS, len(CHANNELS))
ACTION_GROUP_KEY = _register("action group key", 0x9800, writable=True)
ACTION_GROUP_MASK = _register("action group mask", 0x9804, writable=True)

for _name, _address, _value in (
    ("version", _R.VERSION, 0x00020000),
    ("supported IP configuration", _R.SUPPORTED_IP_CONFIGURATION, 0x7),
    ("number of network interfaces", 0x0600, 1),
    ("message channels", _R.MESSAGE_CHANNELS, 1),
    ("action signals", _R.ACTION_SIGNALS, 1),
    ("active links", 0x0910, 1),
    ("scheduled actions that may wait", _R.SCHEDULED_ACTIONS, 1),
    ("stream capability", _R.STREAM_CAPABILITY, _STREAM_CAPABILITY),
    ("message capability", _R.MESSAGE_CAPABILITY, int(MessageCapability.SOURCE_PORT)),
    ("tick frequency high", _R.TICK_FREQUENCY_HIGH, 0),
    ("tick frequency low", _R.TICK_FREQUENCY_LOW, TICKS_PER_SECOND),
    ("pending timeout", _R.PENDING_TIMEOUT_MS, 1000),
):
    _register(_name, _address, _value)

NUMBERS = tuple(_REGISTERS)
"Every register of a number."


def description() -> bytes:
    """Return the description with GigE Vision's features."""
    nodes = resources.files(__package__).joinpath("gige.xml").read_bytes()
    return with_transport(_FEATURES, nodes)


def make_bootstrap(
    model: CameraModel, address: str, netmask: str, mac: bytes, deviations: Deviations | None = None
) -> RegisterMemory:
    """Make the bootstrap registers of a camera at an address; strings are the model's own."""
    deviations = deviations or Deviations()
    archive = deviations.store(zipped(f"{XML_NAME}.xml", deviations.describe(description())))
    url = f"Local:{XML_NAME}.zip;{XML_ADDRESS:x};{len(archive):x}"
    strings = {
        _field("vendor", bootstrap.VENDOR): reg.DEVICE_VENDOR_NAME,
        _field("model", bootstrap.MODEL): reg.DEVICE_MODEL_NAME,
        _field("version text", bootstrap.DEVICE_VERSION): reg.DEVICE_VERSION,
        _field("manufacturer info", bootstrap.MANUFACTURER_INFO): reg.DEVICE_MANUFACTURER_INFO,
        _field("serial number", bootstrap.SERIAL_NUMBER): reg.DEVICE_SERIAL_NUMBER,
        USER_NAME: reg.DEVICE_USER_ID,
    }
    first, second = deviations.urls or (url, url)
    urls = (
        _field("first URL", bootstrap.FIRST_URL, first),
        _field("second URL", bootstrap.SECOND_URL, second),
    )
    memory = RegisterMemory((*_REGISTERS, *strings, *urls))
    for mirror, original in strings.items():
        memory.on_read(mirror, partial(model.memory.get, original))
    memory.on_check(USER_NAME, lambda value: model.memory.set(reg.DEVICE_USER_ID, value))
    # The same switch as the feature PtpEnable, so its bit is the model's.
    memory.on_read(GVCP_CONFIGURATION, lambda: _with_ptp(model, int(memory.stored(GVCP_CONFIGURATION))))
    memory.on_written(GVCP_CONFIGURATION, lambda: _set_ptp(model, int(memory.stored(GVCP_CONFIGURATION))))
    memory.on_read(IEEE1588_STATUS, lambda: model.memory.integer(reg.PTP_STATUS))
    memory.set(DEVICE_MODE, deviations.device_mode)
    memory.set(GVCP_CAPABILITY, int(_CAPABILITY & ~deviations.absent))
    memory.set(CURRENT_IP, ip_number(address))
    memory.set(SUBNET_MASK, ip_number(netmask))
    memory.set(MAC_HIGH, int.from_bytes(mac[:2], "big"))
    memory.set(MAC_LOW, int.from_bytes(mac[2:], "big"))
    memory.add_block(XML_ADDRESS, archive)
    for register, shift in ((TIMESTAMP_HIGH, 32), (TIMESTAMP_LOW, 0)):
        memory.on_read(register, partial(_latched, model, shift))
    return memory


def _with_ptp(model: CameraModel, configuration: int) -> int:
    bit = int(GvcpConfiguration.IEEE1588)
    return configuration & ~bit | (bit if model.memory.integer(reg.PTP_ENABLE) else 0)


def _set_ptp(model: CameraModel, configuration: int) -> None:
    on = int(bool(configuration & GvcpConfiguration.IEEE1588))
    model.write(reg.PTP_ENABLE.address, reg.PTP_ENABLE.encode(on))


def _latched(model: CameraModel, shift: int) -> int:
    return model.memory.integer(reg.TIMESTAMP_LATCH_VALUE) >> shift & 0xFFFFFFFF


def identity(memory: RegisterMemory) -> bytes:
    """Return the DISCOVERY_ACK's payload: the first registers as they are."""
    return memory.read(0, Identity.FORMAT.size)
