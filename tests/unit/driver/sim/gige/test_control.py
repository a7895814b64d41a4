"""GVCP as a device speaks it: datagrams and time in, datagrams out."""

import io
import struct
import zipfile

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grabbergui.driver.gige.bootstrap import BootstrapRegister, GvcpCapability
from grabbergui.driver.gige.gvcp import (
    Ack,
    CommandCode,
    PacketResend,
    ReadMem,
    ReadReg,
    WriteMem,
    WriteReg,
    encode_command,
)
from grabbergui.driver.gige.gvcp_messages import Action, Event
from grabbergui.driver.gige.identity import ForceIp, Identity, encode_discovery
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige import registers as gev
from grabbergui.driver.sim.gige.control import SLOW_COMMAND_S, ControlResponder
from grabbergui.driver.sim.model import CameraModel
from patience import PATIENCE

HOST, OTHER = ("127.0.0.1", 40000), ("127.0.0.1", 40001)
CCP, SCP, SCPS = 0xA00, 0xD00, 0xD04
PENDING_ACK = 0x0089


class Device:
    """A control channel with shorthands."""

    def __init__(self):
        model = CameraModel()
        memory = gev.make_bootstrap(model, "127.0.0.7", "255.0.0.0", b"\x02GB\x00\x00\x07")
        self.resends, self.tests = [], []
        self.channel = ControlResponder(
            model,
            memory,
            largest_packet=9000,
            on_resend=self.resends.append,
            on_test_packet=lambda size, channel: self.tests.append((channel, size)),
        )
        self.model = model
        self.now = 100.0
        self.req_id = 0

    def send(self, command, payload=b"", source=HOST, flags=1, req_id=None):
        self.req_id = req_id or self.req_id + 1
        datagram = encode_command(command, payload, self.req_id, flags)
        return self.channel.receive(datagram, source, self.now)

    def ask(self, command, payload=b"", source=HOST, flags=1, req_id=None):
        """The one acknowledge."""
        (out,) = self.send(command, payload, source, flags, req_id)
        assert out.to == source
        ack = Ack.decode(out.datagram)
        assert ack.ack_id == self.req_id and ack.acknowledge == command + 1
        return ack

    def request(self, request, source=HOST):
        return self.ask(request.CODE, request.payload(), source)

    def write(self, address, value, source=HOST):
        return self.request(WriteReg(((address, value),)), source).status

    def read(self, address, source=HOST):
        return self.request(ReadReg((address,)), source)

    def value(self, address):
        return ReadReg((address,)).decode_ack(self.read(address).payload)[0]


@pytest.fixture
def device():
    return Device()


@pytest.fixture
def controlled(device):
    assert device.write(CCP, 2) == 0
    return device


def test_discovery_answers_with_the_first_registers(device):
    (out,) = device.channel.receive(encode_discovery(), OTHER, 0.0)
    ack = Ack.decode(out.datagram)
    identity = Identity.decode(ack.payload)
    assert (ack.acknowledge, len(ack.payload)) == (3, 248)
    assert (identity.vendor, identity.model, identity.serial) == ("grabbergui", "Simulated camera", "SIM001")
    assert (identity.ip, identity.subnet_mask, identity.mac) == (
        "127.0.0.7",
        "255.0.0.0",
        "02:47:42:00:00:07",
    )
    assert identity.spec_version == (2, 0)


@pytest.mark.parametrize(
    ("capability", "register"),
    [
        (GvcpCapability.SCHEDULED_ACTION, BootstrapRegister.SCHEDULED_ACTIONS),
        (GvcpCapability.IEEE1588, 0x096C),
        (GvcpCapability.LINK_SPEED, BootstrapRegister.LINK_SPEED),
        (GvcpCapability.PENDING_ACK, BootstrapRegister.PENDING_TIMEOUT_MS),
        (GvcpCapability.PRIMARY_APPLICATION, BootstrapRegister.PRIMARY_APPLICATION_IP),
        (GvcpCapability.ACTION, BootstrapRegister.ACTION_SIGNALS),
    ],
)
def test_what_the_camera_announces_it_has(device, capability, register):
    assert device.value(BootstrapRegister.GVCP_CAPABILITY) & capability
    assert device.read(register).status == 0


def test_the_description_can_be_read(device):
    url = device.request(ReadMem(0x200, 512)).payload[4:].split(b"\0")[0].decode()
    name, address, size = url.removeprefix("Local:").split(";")
    data = b""
    while len(data) < int(size, 16):
        data += device.request(ReadMem(int(address, 16) + len(data), 512)).payload[4:]
    archive = zipfile.ZipFile(io.BytesIO(data[: int(size, 16)]))
    assert name.endswith(".zip") and archive.namelist()[0].endswith(".xml")
    assert b'Name="GevSCPSPacketSize"' in archive.read(archive.namelist()[0])


def test_the_user_name_is_the_same_register_in_both_spaces(controlled):
    controlled.request(WriteMem(0xE8, b"left".ljust(16, b"\0")))
    assert controlled.model.memory.get(reg.DEVICE_USER_ID) == "left"
    assert controlled.request(ReadMem(0xE8, 16)).payload[4:].rstrip(b"\0") == b"left"


def test_only_the_controller_writes(device):
    assert device.write(SCP, 5000) == 0x8006
    assert device.write(CCP, 2) == 0
    assert device.write(SCP, 5000) == 0
    assert device.write(SCP, 6000, OTHER) == 0x8006
    assert device.write(CCP, 2, OTHER) == 0x8006
    assert device.write(CCP, 0, OTHER) == 0x8006
    assert (device.value(SCP), device.value(CCP), device.value(0xA04)) == (5000, 2, 40000)


def test_exclusive_control_keeps_readers_out(device):
    device.write(CCP, 1)
    assert device.read(0x938, OTHER).status == 0x8006
    device.write(CCP, 2)
    assert device.read(0x938, OTHER).status == 0


def test_releasing_closes_the_stream(controlled):
    controlled.write(SCP, 5000)
    controlled.write(reg.ACQUISITION_START.address, 1)
    controlled.write(CCP, 0)
    assert not controlled.model.streaming
    assert (controlled.value(SCP), controlled.value(CCP)) == (0, 0)
    assert controlled.write(CCP, 2, OTHER) == 0


def test_control_expires_without_heartbeat(controlled):
    controlled.write(0x938, 1000)
    for _ in range(3):
        controlled.now += 0.9
        controlled.read(CCP)
        controlled.channel.poll(controlled.now)
    assert controlled.value(CCP) == 2
    controlled.now += 1.1
    controlled.read(CCP, OTHER)
    controlled.channel.poll(controlled.now)
    assert controlled.value(CCP) == 0


def test_control_that_was_taken_without_an_acknowledge_lasts_as_long(device):
    assert device.send(CommandCode.WRITEREG, WriteReg(((CCP, 2),)).payload(), flags=0) == []
    device.channel.poll(device.now + 1.0)
    assert device.channel.controlled
    device.channel.poll(device.now + 60.0)
    assert not device.channel.controlled


def test_the_heartbeat_can_be_switched_off(controlled):
    controlled.write(0x954, 1)
    controlled.now += 1000
    controlled.channel.poll(controlled.now)
    assert controlled.value(CCP) == 2


def test_several_registers_in_one_command(controlled):
    writes = WriteReg(((reg.WIDTH.address, 640), (reg.HEIGHT.address, 480), (reg.WIDTH.address, 13)))
    ack = controlled.request(writes)
    assert (ack.status, ack.payload) == (0x8002, b"\0\0\0\2")
    values = controlled.request(ReadReg((reg.WIDTH.address, reg.HEIGHT.address, 0x0))).payload
    assert struct.unpack(">3I", values) == (640, 480, 0x00020000)


@pytest.mark.parametrize(
    ("request_", "status"),
    [
        (ReadMem(0x100211, 4), 0x8005),
        (ReadMem(0x100210, 6), 0x8002),
        (ReadMem(0x100210, 600), 0x8002),
        (ReadMem(0xFFFFFF00, 4), 0x8003),
        (ReadReg((0x5000,)), 0x8003),
        (WriteReg(((0x0, 1),)), 0x8004),
        (WriteReg(((reg.EXPOSURE_TIME.address, 1),)), 0x8005),
        (WriteReg(((reg.TRIGGER_SOFTWARE[0].address, 1),)), 0x8006),
    ],
)
def test_refusals_have_their_status(controlled, request_, status):
    payload = (
        struct.pack(">IHH", request_.address, 0, request_.count) if isinstance(request_, ReadMem) else None
    )
    ack = controlled.ask(request_.CODE, payload or request_.payload())
    assert ack.status == status


def test_unknown_commands_are_not_implemented(device):
    datagram = struct.pack(">BBHHH", 0x42, 1, 0x0F00, 0, 9)
    (out,) = device.channel.receive(datagram, HOST, 0.0)
    assert out.datagram == struct.pack(">HHHH", 0x8001, 0x0F01, 0, 9)


def test_without_the_flag_there_is_no_acknowledge(controlled):
    assert controlled.send(CommandCode.WRITEREG, WriteReg(((SCP, 7000),)).payload(), flags=0) == []
    assert controlled.value(SCP) == 7000


def test_a_repeated_command_is_answered_but_not_executed_again(controlled):
    controlled.write(reg.TRIGGER_MODE[0].address, 1)
    controlled.write(reg.ACQUISITION_START.address, 1)
    trigger = WriteReg(((reg.TIMESTAMP_LATCH.address, 1),)).payload()
    first = controlled.send(CommandCode.WRITEREG, trigger, req_id=77)
    latched = controlled.model.memory.get(reg.TIMESTAMP_LATCH_VALUE)
    again = controlled.send(CommandCode.WRITEREG, trigger, req_id=77)
    assert again[0].datagram == first[0].datagram
    assert controlled.model.memory.get(reg.TIMESTAMP_LATCH_VALUE) == latched


def test_a_slow_command_is_announced_where_the_host_wants_it(controlled):
    controlled.write(reg.USER_SET_SELECTOR.address, 1)
    save = WriteReg(((reg.USER_SET_SAVE.address, 1),)).payload()
    assert len(controlled.send(CommandCode.WRITEREG, save)) == 1
    controlled.write(0x954, 2)
    pending, final = controlled.send(CommandCode.WRITEREG, save)
    assert Ack.decode(pending.datagram).acknowledge == PENDING_ACK
    assert Ack.decode(final.datagram).acknowledge == 0x83
    assert final.due == pytest.approx(controlled.now + SLOW_COMMAND_S)


def test_the_clock_can_be_latched_by_its_bootstrap_register(controlled):
    controlled.write(0x944, 2)
    value = controlled.value(0x948) << 32 | controlled.value(0x94C)
    assert value == controlled.model.memory.get(reg.TIMESTAMP_LATCH_VALUE) > 0


def test_ptp_has_one_switch_in_both_spaces(controlled):
    controlled.write(0x954, 0x80002)
    assert controlled.model.memory.get(reg.PTP_ENABLE) == 1
    assert controlled.value(0x96C) == 9
    controlled.write(reg.PTP_ENABLE.address, 0)
    assert (controlled.value(0x954), controlled.value(0x96C)) == (2, 3)


@pytest.mark.parametrize(("asked", "held"), [(1500, 1500), (1502, 1500), (100, 576), (60_000, 9000)])
def test_packet_sizes_are_rounded_and_bounded(controlled, asked, held):
    controlled.write(SCPS, asked)
    assert controlled.value(SCPS) == held


def test_a_test_packet_follows_the_acknowledge(controlled):
    controlled.write(SCPS, 0xC0000000 | 2000)
    assert controlled.tests == []
    controlled.channel.run_deferred()
    assert controlled.tests == [(0, 2000)]
    assert controlled.value(SCPS) == 0x40000000 | 2000


def test_resend_requests_come_from_any_port_and_are_not_acknowledged(controlled):
    request = PacketResend(3, 4, 5)
    assert controlled.channel.receive(request.encode(1), OTHER, 0.0) == []
    assert controlled.resends == [request]


def test_force_ip_is_for_its_mac_and_not_while_controlled(device):
    moved = []
    device.channel.on_force_ip = lambda ip, netmask: bool(moved.append((ip, netmask)) or True)
    foreign = ForceIp("02:00:00:00:00:01", "127.0.0.8").encode(5)
    assert device.channel.receive(foreign, HOST, 0.0) == []
    meant = ForceIp("02:47:42:00:00:07", "127.0.0.8", "255.0.0.0")
    (out,) = device.channel.receive(meant.encode(6), HOST, 0.0)
    assert Ack.decode(out.datagram).status == 0
    assert moved == [("127.0.0.8", "255.0.0.0")]
    device.write(CCP, 2)
    (out,) = device.channel.receive(meant.encode(7), HOST, 0.0)
    assert Ack.decode(out.datagram).status == 0x8006


@pytest.fixture
def armed(controlled):
    for address, value in (
        (0x90C, 0x11),
        (0x9800, 0x22),
        (0x9804, 0x3),
        (reg.TRIGGER_MODE[0].address, 1),
        (reg.TRIGGER_SOURCE[0].address, 1),
        (reg.ACQUISITION_START.address, 1),
    ):
        assert controlled.write(address, value) == 0
    return controlled


@pytest.mark.parametrize(
    ("action", "acts"),
    [
        (Action(0x11, 0x22, 0x2), True),
        (Action(0x10, 0x22, 0x2), False),
        (Action(0x11, 0x21, 0x2), False),
        (Action(0x11, 0x22, 0x4), False),
    ],
)
def test_actions_are_for_those_whose_keys_fit(armed, action, acts):
    answered = armed.channel.receive(action.encode(9), OTHER, armed.now)
    assert bool(answered) == acts
    frame = armed.model.next_frame(0.1)
    assert (frame is not None) == acts


def test_a_scheduled_action_waits_and_a_late_one_reports_it(armed):
    at = armed.model.timestamp() + 1_000_000_000
    (out,) = armed.channel.receive(Action(0x11, 0x22, 1, at).encode(9), OTHER, armed.now)
    assert Ack.decode(out.datagram).status == 0
    assert armed.model.next_frame(PATIENCE).timestamp_ns == at
    (out,) = armed.channel.receive(Action(0x11, 0x22, 1, 5).encode(10), OTHER, armed.now)
    assert Ack.decode(out.datagram).status == 0x8016


def test_an_event_is_repeated_until_it_is_acknowledged(controlled):
    assert controlled.channel.send_event(0x9003, 7, 123, controlled.now) == []
    controlled.write(0xB10, 0x7F000001)
    controlled.write(0xB00, 6000)
    (out,) = controlled.channel.send_event(0x9003, 7, 123, controlled.now)
    assert out.to == ("127.0.0.1", 6000)
    header, payload = out.datagram[:8], out.datagram[8:]
    (event,) = Event.decode_all(CommandCode.EVENTDATA, payload, header[1])
    assert (event.event_id, event.timestamp, event.block_id) == (0x9003, 123, 7)
    assert struct.unpack(">qq", event.data) == (7, 123)
    assert controlled.channel.poll(controlled.now + 0.1) == []
    (again,) = controlled.channel.poll(controlled.now + 0.3)
    assert again.datagram == out.datagram
    ack = Ack(0, CommandCode.EVENTDATA + 1, struct.unpack(">H", header[6:8])[0]).encode()
    controlled.channel.receive(ack, ("127.0.0.1", 6000), controlled.now)
    assert controlled.channel.poll(controlled.now + 2) == []


def test_an_event_that_nobody_hears_is_given_up(controlled):
    controlled.write(0xB00, 6000)
    controlled.channel.send_event(0x9003, 7, 123, controlled.now)
    controlled.write(0x938, 60_000)
    repeats = sum(len(controlled.channel.poll(controlled.now + second)) for second in range(1, 20))
    assert repeats == 3


_fuzzed = Device()
_fuzzed.req_id = 5  # that of the commands below: what is asked between them must not look repeated


@settings(max_examples=300)
@given(st.binary(max_size=64))
def test_no_datagram_disturbs_the_device(datagram):
    assert isinstance(_fuzzed.channel.receive(datagram, HOST, 0.0), list)


@settings(max_examples=300)
@given(
    st.sampled_from([2, 4, 0x40, 0x80, 0x82, 0x84, 0x86, 0xC0, 0x100, 0x7777]),
    st.integers(0, 255),
    st.binary(max_size=60),
)
def test_no_command_disturbs_the_device(command, flags, payload):
    datagram = struct.pack(">BBHHH", 0x42, flags, command, len(payload), 5) + payload
    for out in _fuzzed.channel.receive(datagram, HOST, 0.0):
        ack = Ack.decode(out.datagram)
        assert out.to != HOST or ack.ack_id == 5
    assert _fuzzed.value(0) == 0x00020000  # it still says which GigE Vision it speaks
