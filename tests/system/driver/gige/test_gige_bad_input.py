"""Cameras that lie, strangers that send: refused in one line, or dropped and counted; over real sockets."""

from __future__ import annotations

import itertools
import os
import queue
import socket
import threading
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace

import pytest

from grabbergui import sources
from grabbergui.core.errors import GrabberError, TransportError
from grabbergui.core.grabber import ConnectionState, FrameGrabber
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.gige import discovery
from grabbergui.driver.gige.bootstrap import FIRST_URL, SECOND_URL
from grabbergui.driver.gige.device import GigeDevice
from grabbergui.driver.gige.gvcp import Ack, CommandCode
from grabbergui.driver.gige.gvsp import Leader, Trailer
from grabbergui.driver.gige.identity import DISCOVERY_REQ_ID, Identity
from grabbergui.driver.gige.interfaces import Interface
from grabbergui.driver.gige.packet_header import PacketFormat, PacketHeader
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige import registers as gev
from grabbergui.driver.sim.gige.server import GigeCamera
from grabbergui.driver.sim.model import CameraModel
from patience import PATIENCE, until

_numbers = itertools.count(1)
MONO8 = 0x01080001


@pytest.fixture
def simulated() -> Iterator[GigeCamera]:
    power_on = {reg.WIDTH: 64, reg.HEIGHT: 48, reg.FRAME_RATE: 50.0, reg.EXPOSURE_TIME: 1000.0}
    address = f"127.87.{os.getpid() % 250 + 1}.{next(_numbers)}"
    with closing(GigeCamera(address, power_on=power_on)) as camera:
        yield camera


@pytest.fixture
def grabber(simulated: GigeCamera) -> Iterator[FrameGrabber]:
    with closing(sources.create(f"gige:{simulated.address}")) as grabber:
        yield grabber


def lie_about_payload(camera: GigeCamera, size: int | None) -> None:
    """Let the camera say that its images have so many bytes, whatever they have; None: the truth again."""
    read = CameraModel.read.__get__(camera.model)

    def lying(address: int, length: int) -> bytes:
        if size is not None and address == reg.PAYLOAD_SIZE.address:
            return size.to_bytes(length, "big")
        return bytes(read(address, length))

    camera.model.read = lying  # type: ignore[method-assign]


def test_images_larger_than_announced_are_refused_and_the_camera_stays_usable(
    simulated: GigeCamera, grabber: FrameGrabber, caplog: pytest.LogCaptureFixture
) -> None:
    lie_about_payload(simulated, 1000)
    grabber.open()
    frames = grabber.open_queue()
    grabber.start()
    until(lambda: grabber.statistics().incomplete >= 5)
    assert grabber.statistics().frames == 0
    assert caplog.text.count("does not fit") == 1, "one warning"
    assert grabber.write_feature("ExposureTime", 1500.0).value == 1500.0
    lie_about_payload(simulated, None)
    grabber.stop()
    grabber.start()
    assert frames.get(PATIENCE).complete


@pytest.mark.parametrize("size", [2**31, 2**32 - 1])
def test_a_payload_beyond_reason_takes_no_memory(
    size: int, simulated: GigeCamera, grabber: FrameGrabber
) -> None:
    lie_about_payload(simulated, size)
    grabber.open()
    with pytest.raises(TransportError, match=f"frames of {size} bytes; check PayloadSize"):
        grabber.start()
    assert not grabber.streaming


def test_a_stranger_cannot_put_images_into_the_stream(grabber: FrameGrabber) -> None:
    grabber.open()
    assert isinstance(grabber, DeviceGrabber) and isinstance(grabber.device, GigeDevice)
    frames = grabber.open_queue(60)
    grabber.start()
    frames.get(PATIENCE)
    target = (grabber.device._link.local_address, grabber.device._stream.channels[0].port)
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as stranger:
        stranger.bind(("127.0.0.66", 0))
        for block in range(60000, 60200):
            leader = Leader(1, 5, MONO8, 64, 48).encode()
            stranger.sendto(PacketHeader(PacketFormat.LEADER, block, 0).encode() + leader, target)
            stranger.sendto(PacketHeader(PacketFormat.PAYLOAD, block, 1).encode() + bytes(1464), target)
            stranger.sendto(
                PacketHeader(PacketFormat.TRAILER, block, 4).encode() + Trailer(1, 48).encode(), target
            )
    ids = [frames.get(PATIENCE).frame_id for _ in range(20)]
    assert max(ids) < 1000 and ids == sorted(ids)
    statistics = grabber.statistics()
    assert (statistics.incomplete, statistics.lost) == (0, 0)
    until(lambda: grabber.statistics().packets_ignored >= 600)


def test_a_flood_of_answers_to_a_search_takes_no_memory() -> None:
    class Flood:
        """A socket at which ever other cameras answer."""

        count = 0

        def recvfrom(self, size: int) -> tuple[bytes, tuple[str, int]]:
            self.count += 1
            mac = self.count.to_bytes(6, "big").hex(":")
            ip = f"10.0.{self.count // 250}.{self.count % 250}"
            identity = Identity(mac=mac, ip=ip, vendor="x" * 30)
            ack = Ack(0, CommandCode.DISCOVERY + 1, DISCOVERY_REQ_ID, identity.encode())
            return ack.encode(), (ip, 3956)

    asked, flood = discovery.Search(), Flood()
    for _ in range(discovery.MAX_DEVICES + 500):
        asked._take(flood, Interface("eth0", "10.0.0.2"))  # type: ignore[arg-type]
    assert len(asked._found) == discovery.MAX_DEVICES


class Answers:
    """A socket with answers to a search: many forged ones, and at their end that of an honest camera."""

    def __init__(self, *, forged: int, sources: int) -> None:
        self._left = [
            (Identity(mac=number.to_bytes(6, "big").hex(":"), ip=f"10.0.1.{number % 250}"), number % sources)
            for number in range(1, forged + 1)
        ]
        self._left.append((Identity(mac="02:00:00:00:00:01", ip="10.0.0.9", serial="HONEST"), -1))
        self._left.reverse()

    def recvfrom(self, size: int) -> tuple[bytes, tuple[str, int]]:
        identity, source = self._left.pop()
        ack = Ack(0, CommandCode.DISCOVERY + 1, DISCOVERY_REQ_ID, identity.encode())
        return ack.encode(), (identity.ip if source < 0 else f"10.0.9.{source}", 3956)


@pytest.mark.parametrize("sources", [1, 20, 250])
def test_an_honest_camera_is_found_among_forged_answers(sources: int) -> None:
    """By its name always; in a list of all unless the answers come from very many addresses."""
    card = Interface("eth0", "10.0.0.2", "255.255.0.0")
    for by_name in (True, False):
        search, answers = discovery.Search(), Answers(forged=10_000, sources=sources)
        for _ in range(10_001):
            search._take(
                answers,  # type: ignore[arg-type]
                card,
                (lambda device: device.answers_to("honest")) if by_name else None,
            )
        found = [device.identity.serial for device in search._found.values()]
        assert ("HONEST" in found) is (by_name or sources * discovery.MOST_AT_ONE_ADDRESS < 1024)
        assert len(found) <= discovery.MAX_DEVICES + 1


def test_answers_of_others_to_our_commands_are_not_taken(
    simulated: GigeCamera, grabber: FrameGrabber
) -> None:
    """Acknowledges with every id, from another address, while we ask."""
    grabber.open()
    assert isinstance(grabber, DeviceGrabber) and isinstance(grabber.device, GigeDevice)
    link = grabber.device._link
    assert link is not None
    target = link._socket.getsockname()
    stopping = threading.Event()

    def shout() -> None:
        with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as stranger:
            stranger.bind(("127.0.0.66", 0))
            for req_id in itertools.cycle(range(1, 400)):
                if stopping.is_set():
                    return
                stranger.sendto(Ack(0x8006, CommandCode.READREG + 1, req_id, b"").encode(), target)

    states: queue.Queue[ConnectionState] = queue.Queue()
    grabber.connection_changed.connect(lambda state, why: states.put(state))
    thread = threading.Thread(target=shout)
    thread.start()
    try:
        for value in range(20):
            assert grabber.write_feature("ExposureTime", 1000.0 + value).value == 1000.0 + value
    finally:
        stopping.set()
        thread.join()
    assert states.empty()


@pytest.mark.parametrize(
    ("url", "says"),
    [
        ("Local:a.xml;200000;FFFFFFFF", "announces 4294967295 bytes"),
        ("Local:a.xml;FFFFFFF0;1000", "32-bit address space"),
        ("Local:a.xml;700000;1000", "INVALID_ADDRESS"),
        ("http://vendor.example/a.xml", "only Local: and File:"),
        ("", "URL registers are empty"),
    ],
)
def test_an_unavailable_description_is_reported_in_one_line(
    url: str, says: str, simulated: GigeCamera, grabber: FrameGrabber
) -> None:
    memory = simulated.control.memory
    for field in (FIRST_URL, SECOND_URL):
        memory._values[field.address] = url
    with pytest.raises(TransportError, match=says) as error:
        grabber.open()
    assert "\n" not in str(error.value)
    until(lambda: not simulated.control.controlled)


@pytest.mark.parametrize(
    "xml",
    [
        b'<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]>'
        b"<RegisterDescription>&a;</RegisterDescription>",
        b'<?xml version="1.0"?><RegisterDescription><not closed',
        b'<?xml version="1.0"?><RegisterDescription/>',
        b"PK\3\4 an archive that ends here",
        b"no xml at all",
        b"",
    ],
)
def test_a_description_that_cannot_be_used_is_refused_and_control_given_back(
    xml: bytes, simulated: GigeCamera, grabber: FrameGrabber
) -> None:
    memory = simulated.control.memory
    memory._blocks = [(gev.XML_ADDRESS, xml.ljust(4096, b"\0"))]
    url = f"Local:a.xml;{gev.XML_ADDRESS:x};1000"
    for field in (FIRST_URL, SECOND_URL):
        memory._values[field.address] = url
    before = set(threading.enumerate())
    with pytest.raises(GrabberError):
        grabber.open()
    until(lambda: not simulated.control.controlled)
    assert set(threading.enumerate()) <= before, "a thread is left"


def test_a_name_full_of_control_characters_is_shown_without_them(simulated: GigeCamera) -> None:
    memory = simulated.control.memory
    memory.on_read(gev.USER_NAME, lambda: "\x1b[31mred\x07\n")
    found = discovery.ask(simulated.address, 2)
    assert found is not None
    assert replace(found.info(), uri="").user_name == "[31mred"
