"""Interfaces, searches, names and packet sizes."""

from __future__ import annotations

import os
import selectors
import socket
import time
from collections.abc import Iterator
from contextlib import closing
from types import SimpleNamespace

import pytest

from grabbergui.core.errors import DeviceStatusError
from grabbergui.core.grabber import Access
from grabbergui.driver.device import StreamRequest
from grabbergui.driver.gige import discovery
from grabbergui.driver.gige.bootstrap import GvcpCapability, PacketSizeFlag, StreamChannel
from grabbergui.driver.gige.device import GigeDevice
from grabbergui.driver.gige.discovery import FoundDevice, discover
from grabbergui.driver.gige.gvcp import Ack, CommandCode
from grabbergui.driver.gige.identity import DISCOVERY_REQ_ID, NO_MAC, Identity
from grabbergui.driver.gige.interfaces import Interface
from grabbergui.driver.gige.stream.packet_size import TEST_TRIES, PacketSizePolicy, PacketSizer
from grabbergui.driver.sim.gige import registers as gev
from grabbergui.driver.sim.gige.server import GigeCamera

ETHERNET = Interface("eth0", "192.168.0.2", "255.255.255.0", 1500)
LINK_LOCAL = Interface("eth1", "169.254.7.9", "255.255.0.0", 9000)


def test_answers_that_are_none_find_nothing() -> None:
    assert discover(0.05, ["127.0.0.99"], broadcast=False) == []


class Answers:
    """Acknowledges of DISCOVERY as a search takes them, and its result."""

    def __init__(self) -> None:
        self.search = discovery.Search()

    def take(self, datagram: bytes, interface: Interface = ETHERNET) -> FoundDevice | None:
        with (
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asker,
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as device,
        ):
            asker.bind(("127.0.0.1", 0))
            device.sendto(datagram, asker.getsockname())
            return self.search._take(asker, interface)

    def hear(self, identity: Identity, interface: Interface = ETHERNET) -> FoundDevice | None:
        return self.take(
            Ack(0, CommandCode.DISCOVERY + 1, DISCOVERY_REQ_ID, identity.encode()).encode(), interface
        )

    @property
    def found(self) -> list[tuple[str, str]]:
        """Return address and interface of each device."""
        return sorted((each.ip, each.interface.name) for each in self.search._found.values())


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("mac", ["00:30:53:0a:0b:0c", NO_MAC])
def test_a_device_that_answers_on_two_interfaces_is_listed_on_the_one_in_its_subnet(
    order: int, mac: str
) -> None:
    answers, identity = Answers(), Identity(mac=mac, serial="7", ip="169.254.1.1")
    for interface in (ETHERNET, LINK_LOCAL)[::order]:
        answers.hear(identity, interface)
    assert answers.found == [("169.254.1.1", "eth1")]


@pytest.mark.parametrize("mac", ["00:30:53:0a:0b:0c", NO_MAC])
def test_devices_of_one_mac_or_serial_at_two_addresses_are_two(mac: str) -> None:
    answers = Answers()
    for ip in ("192.168.0.8", "192.168.0.9"):
        answers.hear(Identity(mac=mac, serial="7", ip=ip))
    assert answers.found == [("192.168.0.8", "eth0"), ("192.168.0.9", "eth0")]


def test_a_device_that_reports_no_address_is_at_that_of_its_answer() -> None:
    answers = Answers()
    answers.hear(Identity(serial="7"))
    assert answers.found == [("127.0.0.1", "eth0")]


@pytest.mark.parametrize(
    "ack",
    [
        Ack(0x8003, CommandCode.DISCOVERY + 1, DISCOVERY_REQ_ID, Identity().encode()),
        Ack(0, CommandCode.READMEM + 1, DISCOVERY_REQ_ID, Identity().encode()),
        Ack(0, CommandCode.DISCOVERY + 1, 7, Identity().encode()),
        Ack(0, CommandCode.DISCOVERY + 1, DISCOVERY_REQ_ID, bytes(100)),
    ],
    ids=["an error", "of another command", "of another request", "too short"],
)
def test_what_is_no_answer_to_the_search_is_ignored(ack: Ack) -> None:
    answers = Answers()
    assert answers.take(ack.encode()) is None and answers.found == []


def test_a_flood_of_answers_takes_no_more_memory_than_allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(discovery, "MAX_DEVICES", 2)
    answers = Answers()
    for number in range(5):
        answers.hear(Identity(serial=str(number), ip=f"192.168.0.{number + 10}"))
    assert [ip for ip, _ in answers.found] == ["192.168.0.10", "192.168.0.11"]


class Scps:
    """A device's SCPS register whose test packets pass a path of some width."""

    def __init__(self, current: int, path: int = 65535, *, fires: bool = True, largest: int = 9000) -> None:
        self.value, self.path, self.fires, self.largest = current, path, fires, largest

    def read_optional(self, register: int, otherwise: int = 0) -> int:
        return self.value

    def write_optional(self, register: int, value: int) -> bool:
        try:
            self.write_register(register, value)
        except DeviceStatusError:
            return False
        return True

    def write_register(self, register: int, value: int) -> None:
        assert register == 0x0D04
        size = value & 0xFFFF
        if size > self.largest:
            raise DeviceStatusError("too large", 0x8002)
        self.value = value & ~PacketSizeFlag.FIRE_TEST_PACKET
        if value & PacketSizeFlag.FIRE_TEST_PACKET and self.fires and size <= self.path:
            self.device.sendto(bytes(size - 28), self.host.getsockname())

    def settle(self, asked: str, interface: Interface, *, can_test: bool = True) -> int:
        sizer = PacketSizer(StreamChannel(0), self, interface)  # type: ignore[arg-type]
        self.host = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.device = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        with self.host, self.device:
            self.host.bind(("127.0.0.1", 0))
            self.device.bind(("127.0.0.6", 0))
            return sizer.settle(PacketSizePolicy.parse(asked), self.host, "127.0.0.6", can_test=can_test)


@pytest.mark.parametrize(
    "asked, scps, interface, size",
    [
        ("auto", Scps(1500), LINK_LOCAL, 9000),
        ("auto", Scps(1500, path=8500), LINK_LOCAL, 8228),
        ("auto", Scps(9000), ETHERNET, 1500),
        ("auto", Scps(576, fires=False), ETHERNET, 576),
        ("auto", Scps(9000, fires=False), ETHERNET, 1500),
        ("keep", Scps(9000), ETHERNET, 9000),
        ("1402", Scps(9000), ETHERNET, 1400),
        ("9000", Scps(1500), ETHERNET, 1500),
        ("auto", Scps(1440, largest=0), ETHERNET, 1440),
        ("1400", Scps(9000, largest=0), ETHERNET, 9000),
    ],
)
def test_packet_sizes_fit_the_path(asked: str, scps: Scps, interface: Interface, size: int) -> None:
    assert scps.settle(asked, interface) == size
    assert scps.value == size, "no flag stays behind"


def test_the_byte_order_of_pixels_stays_as_it_is() -> None:
    scps = Scps(1500 | PacketSizeFlag.BIG_ENDIAN_PIXELS)
    assert scps.settle("auto", LINK_LOCAL) == 9000
    assert scps.value == 9000 | PacketSizeFlag.BIG_ENDIAN_PIXELS


def test_without_test_packets_nothing_is_tried() -> None:
    scps = Scps(1400)
    assert scps.settle("auto", LINK_LOCAL, can_test=False) == 1400


@pytest.fixture
def wired(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[GigeCamera, GigeDevice]]:
    """A camera that does not say that its test packets hold a pattern, as if behind a network card."""
    card = Interface("eth0", "127.0.0.1", mtu=9000)
    monkeypatch.setattr("grabbergui.driver.gige.device.interface_of", lambda ip: card)
    address = f"127.90.{os.getpid() % 250 + 1}.1"
    with closing(GigeCamera(address)) as camera, closing(GigeDevice(address)) as device:
        capability = gev.GVCP_CAPABILITY
        camera.control.memory.set(capability, int(capability.default) & ~GvcpCapability.TEST_DATA)
        device.open(Access.CONTROL)
        yield camera, device


def test_any_camera_is_asked_for_test_packets(wired: tuple[GigeCamera, GigeDevice]) -> None:
    _, device = wired
    device.open_stream(StreamRequest(65536), lambda frame: None)
    assert device._stream.channels[0].packet_size == 9000


def test_one_that_sends_none_is_asked_once(wired: tuple[GigeCamera, GigeDevice]) -> None:
    camera, device = wired
    asked: list[int] = []
    camera.control.on_test_packet = lambda size, channel: asked.append(size)
    for _ in range(2):
        device.open_stream(StreamRequest(65536), lambda frame: None)
        assert device._stream.channels[0].packet_size == 1500
        device.close_stream()
    assert asked == sorted(asked, reverse=True) and asked.count(1500) == TEST_TRIES


def test_an_interface_that_comes_up_during_a_search_is_searched_too(monkeypatch: pytest.MonkeyPatch) -> None:
    lo = Interface("lo", "127.0.0.1", "255.0.0.0", 65535, True)
    looks = iter([[], [lo], [lo]])
    address = f"127.88.{os.getpid() % 250 + 1}.1"
    with closing(GigeCamera(address)):
        monkeypatch.setattr(discovery, "interfaces", lambda: next(looks))
        begun = time.monotonic()
        found = discovery.Search([address]).run(8.0, until=lambda device: device.ip == address)
    assert address in [device.ip for device in found]
    assert time.monotonic() - begun >= 4.0, "nobody heard the first question, half-way comes the second"


def test_a_program_that_was_held_up_asks_again_and_waits_for_the_answers(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    lo = Interface("lo", "127.0.0.1", "255.0.0.0", 65535, True)
    looks = iter([[], [lo]])
    clock = SimpleNamespace(monotonic=time.monotonic)

    class HeldUpOnce(selectors.DefaultSelector):  # type: ignore[misc, valid-type]
        def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
            if clock.monotonic is time.monotonic:  # longer than the whole search takes
                clock.monotonic = lambda: time.monotonic() + 100.0
                return []
            return super().select(timeout)  # type: ignore[no-any-return]

    address = f"127.87.{os.getpid() % 250 + 1}.1"
    with closing(GigeCamera(address)):
        monkeypatch.setattr(discovery, "interfaces", lambda: next(looks))
        monkeypatch.setattr(discovery.selectors, "DefaultSelector", HeldUpOnce)
        monkeypatch.setattr(discovery, "time", clock)
        found = discovery.Search([address]).run(8.0, until=lambda device: device.ip == address)
    assert address in [device.ip for device in found]


def test_a_camera_anywhere_on_the_loopback_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    lo = Interface("lo", "127.0.0.1", "255.0.0.0", 65535, True)
    monkeypatch.setattr(discovery, "interfaces", lambda: [lo])
    address = f"127.89.{os.getpid() % 250 + 1}.1"
    with closing(GigeCamera(address)):
        found = discovery.Search().run(8.0, until=lambda device: device.ip == address)
    assert address in [device.ip for device in found]
