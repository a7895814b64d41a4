"""The simulated GigE Vision camera on real sockets."""

import itertools
import os
import socket
import struct
import threading
import time
from contextlib import ExitStack, closing

import numpy as np
import pytest

from grabbergui import sources
from grabbergui.core.errors import SourceUnavailableError
from grabbergui.driver.gige.gvcp import (
    Ack,
    CommandCode,
    PacketResend,
    ReadReg,
    Status,
    WriteReg,
    encode_command,
)
from grabbergui.driver.gige.gvcp_messages import Action
from grabbergui.driver.gige.gvsp import Leader
from grabbergui.driver.gige.identity import ForceIp, Identity, encode_discovery
from grabbergui.driver.gige.packet_header import PacketFormat, PacketHeader
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import EventSelector, TestPattern
from grabbergui.driver.sim.gige.faults import GigeFaults
from grabbergui.driver.sim.gige.server import GigeCamera, serve
from patience import PATIENCE, until

_numbers = itertools.count(1)
CCP, MCP, MCDA, SCP, SCPS, SCDA, SCSP = 0xA00, 0xB00, 0xB10, 0xD00, 0xD04, 0xD18, 0xD1C
LOCALHOST = 0x7F000001
SMALL = {
    reg.WIDTH: 256,
    reg.HEIGHT: 64,
    reg.FRAME_RATE: 100.0,
    reg.EXPOSURE_TIME: 1000.0,
    reg.TEST_PATTERN: int(TestPattern.GREY_HORIZONTAL_RAMP),
}
RAMP = bytes(range(256)) * 64


def free_address():
    """An address of the loopback net that no other test or person is likely to use."""
    return f"127.78.{os.getpid() % 250 + 1}.{next(_numbers)}"


class Host:
    """A GigE Vision host of a few lines."""

    def __init__(self, address):
        self.address = address
        self.control = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.control.settimeout(PATIENCE)
        self.stream = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.stream.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self.stream.bind(("127.0.0.1", 0))
        self.stream.settimeout(PATIENCE)
        self.req_id = 0

    def close(self):
        self.control.close()
        self.stream.close()

    def ask(self, request):
        self.req_id += 1
        self.control.sendto(
            encode_command(request.CODE, request.payload(), self.req_id), (self.address, 3956)
        )
        while True:
            ack = Ack.decode(self.control.recv(2048))
            if ack.ack_id == self.req_id:
                return ack

    def write(self, *writes):
        ack = self.ask(WriteReg(writes))
        assert ack.status == 0, hex(ack.status)

    def read(self, address):
        request = ReadReg((address,))
        return request.decode_ack(self.ask(request).payload)[0]

    def start(self):
        port = self.stream.getsockname()[1]
        self.write((CCP, 2), (SCDA, LOCALHOST), (SCP, port), (SCPS, 1500))
        self.write((reg.ACQUISITION_START.address, 1))

    def packets(self, until=PacketFormat.TRAILER):
        """Datagrams with their headers, up to one of this format."""
        while True:
            datagram = self.stream.recv(65535)
            header = PacketHeader.decode(datagram)
            yield header, datagram
            if header.format == until:
                return


@pytest.fixture
def stage():
    """Makes cameras and hosts, and clears them away."""
    with ExitStack() as stack:

        def make(power_on=None, **options):
            camera = GigeCamera(free_address(), power_on=SMALL | (power_on or {}), **options)
            stack.callback(camera.close)
            host = Host(camera.address)
            stack.callback(host.close)
            return camera, host

        yield make
    assert not [thread for thread in threading.enumerate() if "127.78." in thread.name]


def image(packets, stride=1464):
    data = bytearray(256 * 64)
    for header, datagram in packets:
        if header.format == PacketFormat.PAYLOAD and not header.failed:
            body = datagram[header.size :]
            start = (header.packet_id - 1) * stride
            data[start : start + len(body)] = body
    return bytes(data)


def test_a_frame_arrives_whole(stage):
    _, host = stage()
    host.start()
    packets = list(host.packets())
    assert [header.packet_id for header, _ in packets] == list(range(14))
    assert {header.block_id for header, _ in packets} == {1}
    assert image(packets) == RAMP


def test_lost_packets_come_again(stage):
    camera, host = stage(faults=GigeFaults(loss=0.3, seed=5))
    host.start()
    until(lambda: camera.model.memory.integer(reg.TL_PARAMS_LOCKED) == 1)
    packets = list(host.packets())
    block = packets[0][0].block_id
    packets = [entry for entry in packets if entry[0].block_id == block]
    host.write((reg.ACQUISITION_STOP.address, 1))
    for _ in range(50):
        missing = set(range(1, 13)) - {header.packet_id for header, _ in packets}
        if not missing:
            break
        request = PacketResend(block, min(missing), max(missing))
        host.stream.sendto(request.encode(1), (host.address, 3956))
        host.stream.settimeout(0.1)
        try:
            while True:
                datagram = host.stream.recv(65535)
                header = PacketHeader.decode(datagram)
                if header.block_id == block:
                    packets.append((header, datagram))
        except TimeoutError:
            continue
    assert image(packets) == RAMP
    assert any(header.status == 0x0100 for header, _ in packets)


@pytest.mark.skipif(not hasattr(socket, "AF_PACKET"), reason="packet sockets are Linux's")
def test_a_packet_socket_sees_every_packet_as_it_leaves(stage):
    camera, host = stage()
    try:
        capture = socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(0x0800))
    except PermissionError:
        pytest.skip("a packet socket needs CAP_NET_RAW")
    with capture:
        capture.bind(("lo", 0))
        capture.settimeout(PATIENCE)
        host.start()
        list(host.packets())
        ours = socket.inet_aton(camera.address)
        sizes = []
        deadline = time.monotonic() + PATIENCE
        while sum(sizes) < 256 * 64 and time.monotonic() < deadline:  # until the first frame has passed
            datagram = capture.recv(65535)
            if datagram[12:16] == ours and datagram[9] == socket.IPPROTO_UDP:
                sizes.append(len(datagram))
    assert max(sizes) == 1500


def test_packets_that_did_not_leave_yet_are_not_sent_early(stage):
    _, host = stage(bandwidth=16_384.0)
    host.start()
    header, _ = next(iter(host.packets()))
    request = PacketResend(header.block_id, 10, 12)
    host.control.sendto(request.encode(99), (host.address, 3956))
    early = next(header for header, _ in host.packets() if header.status)
    assert (early.status, early.packet_id) == (Status.PACKET_NOT_YET_AVAILABLE, 10)


@pytest.mark.parametrize("bandwidth", [0.5, 10.0, 500e3, 125e6, 1e12])
def test_a_link_of_any_speed_keeps_values_in_their_ranges(bandwidth):
    address = free_address()
    with (
        closing(GigeCamera(address, bandwidth=bandwidth)),
        closing(sources.create(f"gige:{address}")) as camera,
    ):
        camera.open()
        for name in ("DeviceLinkThroughputLimit", "AcquisitionFrameRate"):
            feature = camera.feature(name)
            assert feature.minimum <= feature.value <= feature.maximum


def test_a_slow_link_does_not_delay_the_end(stage):
    camera, host = stage(bandwidth=10.0)
    host.start()
    next(host.packets())
    closing = threading.Thread(target=camera.close)
    closing.start()
    closing.join(PATIENCE)
    assert not closing.is_alive(), "the next packet would be due in 150 s"


def test_a_closed_channel_ends_a_frame(stage):
    _, host = stage(bandwidth=4096.0)  # three packets a second
    host.start()
    next(host.packets())
    host.write((SCP, 0))
    host.stream.settimeout(2.0)
    rest = []
    with pytest.raises(TimeoutError):
        rest.extend(header.packet_id for header, _ in host.packets())
    assert len(rest) < 12


def test_a_reopened_channel_begins_with_a_new_frame(stage):
    _, host = stage(bandwidth=65536.0)
    host.start()
    next(host.packets())
    host.write((reg.ACQUISITION_STOP.address, 1), (SCP, 0))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as again:
        again.bind(("127.0.0.1", 0))
        again.settimeout(PATIENCE)
        host.write((SCP, again.getsockname()[1]), (reg.ACQUISITION_START.address, 1))
        headers = [PacketHeader.decode(again.recv(65535)) for _ in range(3)]
    assert [(header.format, header.packet_id) for header in headers] == [
        (PacketFormat.LEADER, 0),
        (PacketFormat.PAYLOAD, 1),
        (PacketFormat.PAYLOAD, 2),
    ]


def test_the_callback_reports_sent_frames(stage):
    sent = []
    _, host = stage(on_sent=sent.append)
    host.start()
    blocks = [[header.block_id for header, _ in host.packets()][-1] for _ in range(3)]
    assert sent[:3] == blocks, "before its trailer leaves"


def test_packets_of_an_old_frame_are_unavailable(stage):
    _, host = stage()
    host.start()
    list(host.packets())
    host.write((reg.ACQUISITION_STOP.address, 1))
    host.stream.sendto(PacketResend(9999, 1, 3).encode(1), (host.address, 3956))
    found = next(header for header, _ in host.packets(None) if header.failed)
    assert (found.status, found.block_id, found.packet_id) == (0x800C, 9999, 1)


def test_the_stream_ends_with_its_controller(stage):
    camera, host = stage()
    host.start()
    host.write((0x938, 500))
    list(host.packets())
    until(lambda: not camera.control.controlled and not camera.model.streaming)
    assert host.read(SCP) == 0


def test_a_test_packet_arrives(stage):
    _, host = stage()
    host.write((CCP, 2), (SCDA, LOCALHOST), (SCP, host.stream.getsockname()[1]))
    host.write((SCPS, 0xC0000000 | 4000))
    assert len(host.stream.recv(65535)) == 4000 - 28
    assert host.read(SCPS) == 0x40000000 | 4000


def test_extended_ids_and_chunks(stage):
    _, host = stage({reg.CHUNK_MODE_ACTIVE: 1})
    host.write((CCP, 2), (0x960, 0x40000000))
    host.start()
    packets = list(host.packets())
    assert all(header.extended for header, _ in packets)
    leader, trailer = packets[0][1][20:], packets[-1][1][20:]
    assert leader[2:4] == trailer[2:4] == b"\x40\x01"
    assert struct.unpack(">I", trailer[8:12])[0] == 256 * 64 + 8 + 4 * 16
    assert packets[-2][1].endswith(struct.pack(">dII", 0.0, 0x1004, 8))


def test_events_come_over_the_message_channel(stage):
    _, host = stage()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as messages:
        messages.bind(("127.0.0.1", 0))
        messages.settimeout(PATIENCE)
        host.write((CCP, 2), (MCDA, LOCALHOST), (MCP, messages.getsockname()[1]))
        host.write(
            (reg.EVENT_NOTIFICATION[EventSelector.TEST].address, 1), (reg.TEST_EVENT_GENERATE.address, 1)
        )
        datagram, source = messages.recvfrom(2048)
        again = messages.recv(2048)
        ack = Ack(0, CommandCode.EVENTDATA + 1, struct.unpack(">H", datagram[6:8])[0])
        messages.sendto(ack.encode(), source)
    assert datagram == again
    assert datagram[:4].hex() == "420100c2"
    assert datagram[10:12] == b"\x90\x03"


def test_broadcasts_are_heard(stage):
    camera, _ = stage()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as seeker:
        seeker.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        seeker.bind(("127.0.0.1", 0))
        seeker.settimeout(PATIENCE)
        seeker.sendto(encode_discovery(), ("127.255.255.255", 3956))
        found = set()
        while camera.address not in found:
            answer, source = seeker.recvfrom(2048)
            found.add(source[0])
            if source[0] == camera.address:
                assert Identity.decode(Ack.decode(answer).payload).ip == camera.address


def test_force_ip_moves_the_camera(stage):
    camera, host = stage()
    target = free_address()
    host.control.sendto(ForceIp(camera.mac.hex(":"), target, "255.0.0.0").encode(3), (camera.address, 3956))
    answer, source = host.control.recvfrom(2048)
    assert Ack.decode(answer).status == 0 and source[0] == target
    host.address = target
    assert socket.inet_ntoa(struct.pack(">I", host.read(0x24))) == target
    host.start()
    assert image(host.packets()) == RAMP


def test_a_stalled_stream_falls_silent_but_answers(stage):
    camera, host = stage(faults=GigeFaults(stall_after=2))
    host.start()
    list(host.packets())
    list(host.packets())
    host.stream.settimeout(0.3)
    with pytest.raises(TimeoutError):
        host.stream.recv(65535)
    assert host.read(CCP) == 2 and camera.model.streaming


def test_a_rebooting_camera_forgets(stage):
    camera, host = stage(faults=GigeFaults(reboot_after=0.5))
    first = camera.model
    host.write((CCP, 2), (reg.WIDTH.address, 512))
    until(lambda: camera.model is not first)
    until(lambda: host.read(reg.WIDTH.address) == 256)
    assert host.read(CCP) == 0


def test_a_reset_releases_control(stage):
    camera, host = stage()
    host.write((CCP, 2))
    assert camera.control.controlled
    host.write((reg.DEVICE_RESET.address, 1))
    until(lambda: not camera.control.controlled)


def test_a_delay_holds_answers_back(stage):
    _, host = stage(faults=GigeFaults(delay=0.1))
    start = time.monotonic()
    host.read(CCP)
    assert time.monotonic() - start >= 0.1


def test_an_address_that_is_not_ours_is_refused():
    with pytest.raises(SourceUnavailableError, match=r"192\.0\.2\.77"):
        GigeCamera("192.0.2.77")


def test_serving_several_cameras():
    addresses = [free_address(), free_address()]
    stop, reported = threading.Event(), []
    server = threading.Thread(
        target=serve, args=(addresses,), kwargs={"serial": "A7", "stop": stop, "ready": reported.append}
    )
    server.start()
    until(lambda: len(reported) == 2)
    stop.set()
    server.join(PATIENCE)
    assert not server.is_alive()
    assert reported == [
        f"GigE Vision camera {s} is at {a}" for s, a in zip(("A7", "A8"), addresses, strict=True)
    ]


def test_without_a_serial_number_each_camera_has_one_of_its_address_and_keeps_it():
    first, second = free_address(), free_address()
    identities = []
    for address in (first, second, first):
        with closing(GigeCamera(address)) as camera:
            identities.append((camera.serial, camera.mac))
    assert identities[0] == identities[2], "a restarted camera is the same"
    assert identities[0][0] != identities[1][0] and identities[0][1] != identities[1][1]


def test_serving_leaves_nothing_behind_when_an_address_cannot_be_had():
    ours = free_address()
    with pytest.raises(SourceUnavailableError, match=r"192\.0\.2\.77"):
        serve((ours, "192.0.2.77"), ready=lambda text: None)
    GigeCamera(ours).close()


def test_our_own_driver_through_a_bad_network(stage):
    camera, _ = stage(
        {reg.WIDTH: 640, reg.HEIGHT: 480}, faults=GigeFaults(loss=0.01, reorder=True, duplicate=True)
    )
    grabber = sources.create(f"gige:{camera.address}")
    grabber.open()
    try:
        assert grabber.write_feature("TestPattern", "GreyVerticalRamp").value == "GreyVerticalRamp"
        frames = grabber.open_queue(64)
        grabber.start()
        for _ in range(30):
            image = frames.get(PATIENCE).raw()
            assert np.array_equal(image[:, 0], np.arange(480) & 0xFF)
    finally:
        grabber.close()
    until(lambda: not camera.control.controlled)


def test_cameras_on_ptp_act_at_the_same_time(stage):
    pairs = [stage(), stage()]
    keys = ((0x90C, 1), (0x9800, 2), (0x9804, 1))
    trigger = ((reg.TRIGGER_MODE[0].address, 1), (reg.TRIGGER_SOURCE[0].address, 1))
    for _, host in pairs:
        host.write((CCP, 2), (reg.PTP_ENABLE.address, 1), *keys, *trigger)
        host.start()
    at = time.time_ns() + 100_000_000
    for camera, host in pairs:
        host.control.sendto(Action(1, 2, 1, at).encode(100), (camera.address, 3956))
        assert Ack.decode(host.control.recv(2048)).status == 0
    leaders = [Leader.decode(next(host.packets())[1][8:]) for _, host in pairs]
    assert [abs(leader.timestamp - at) < 1_000_000 for leader in leaders] == [True, True]
