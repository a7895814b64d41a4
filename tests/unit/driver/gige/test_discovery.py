"""Interfaces, searches, names and packet sizes."""

from __future__ import annotations

import socket
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grabbergui.core.errors import TransportError, UsageError
from grabbergui.core.grabber import Access
from grabbergui.driver.gige import device, discovery
from grabbergui.driver.gige.device import GigeDevice
from grabbergui.driver.gige.discovery import FoundDevice
from grabbergui.driver.gige.identity import Identity
from grabbergui.driver.gige.interfaces import Interface, interface_of, interfaces
from grabbergui.driver.gige.stream.packet_size import PacketSizePolicy

ETHERNET = Interface("eth0", "192.168.0.2", "255.255.255.0", 1500)
LINK_LOCAL = Interface("eth1", "169.254.7.9", "255.255.0.0", 9000)


def test_the_loopback_is_among_the_interfaces() -> None:
    (loopback,) = [interface for interface in interfaces() if interface.ip == "127.0.0.1"]
    assert loopback.loopback and loopback.mtu > 1500 and loopback.netmask == "255.0.0.0"
    assert interface_of("127.0.0.5") == loopback


def test_aliases_and_links_without_flags_are_interfaces_and_those_that_are_down_are_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def address(ip: str, netmask: str | None = "255.255.255.0") -> SimpleNamespace:
        return SimpleNamespace(family=socket.AF_INET, address=ip, netmask=netmask)

    links = {
        "eth0": SimpleNamespace(isup=True, mtu=9000, flags="up,broadcast,running"),
        "eth1": SimpleNamespace(isup=True, mtu=1500, flags="broadcast"),
        "Ethernet": SimpleNamespace(isup=True, mtu=1400, flags=""),
        "Wi-Fi": SimpleNamespace(isup=False, mtu=1500, flags=""),
    }
    addresses = {
        "eth0": [SimpleNamespace(family=socket.AF_INET6, address="::1", netmask=None), address("10.0.0.1")],
        "eth0:1": [address("10.0.1.1")],
        "eth1": [address("10.0.2.1")],
        "Ethernet": [address("10.0.3.1", None)],
        "Wi-Fi": [address("10.0.4.1")],
        "removed": [address("10.0.5.1")],
    }
    monkeypatch.setattr("psutil.net_if_stats", lambda: links)
    monkeypatch.setattr("psutil.net_if_addrs", lambda: addresses)
    monkeypatch.delenv("GRABBERGUI_INTERFACES")
    assert interfaces() == [
        Interface("eth0", "10.0.0.1", "255.255.255.0", 9000),
        Interface("eth0:1", "10.0.1.1", "255.255.255.0", 9000),
        Interface("Ethernet", "10.0.3.1", "255.255.255.255", 1400),
    ]


def test_broadcast_is_worked_out_from_the_mask() -> None:
    assert ETHERNET.broadcast == "192.168.0.255" and LINK_LOCAL.broadcast == "169.254.255.255"


@pytest.mark.parametrize(
    "name", ["192.168.0.9", "SN-1", "sn-1", "00:30:53:0A:0b:0c", "0030530a0b0c", "Left Eye"]
)
def test_a_device_answers_to_all_its_names(name: str) -> None:
    device = FoundDevice(
        Identity(mac="00:30:53:0a:0b:0c", serial="SN-1", user_name="left eye"), "192.168.0.9", ETHERNET
    )
    assert device.answers_to(name) and not device.answers_to("SN-2")
    assert device.info().uri == "gige:SN-1" and device.info().note == ""


def test_a_device_without_name_is_not_found_by_an_empty_one() -> None:
    nobody = FoundDevice(Identity(), "192.168.0.9", ETHERNET)
    assert not nobody.answers_to("000000000000")
    assert nobody.info().uri == "gige:192.168.0.9"


def test_a_device_in_another_subnet_is_listed_with_the_remedy() -> None:
    info = FoundDevice(Identity(serial="7"), "10.1.2.3", ETHERNET).info()
    assert "10.1.2.3" in info.note and "force IP" in info.note and "eth0" in info.note


@pytest.mark.parametrize("name", ["10.1.2.3", "7"])
def test_opening_a_device_to_which_no_network_leads_names_the_remedy(
    monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    def unreachable(ip: str, interface: Interface | None) -> None:
        raise TransportError(f"no way to {ip}: Network is unreachable")

    found = FoundDevice(Identity(serial="7"), "10.1.2.3", ETHERNET)
    monkeypatch.setattr(discovery, "find", lambda name, timeout: found)
    monkeypatch.setattr(device, "ControlLink", unreachable)
    with pytest.raises(TransportError, match=r"no way to 10\.1\.2\.3.*force IP"):
        GigeDevice(name).open(Access.CONTROL)


@given(st.binary(min_size=248, max_size=248))
def test_any_identity_gives_a_uri(data: bytes) -> None:
    assert FoundDevice(Identity.decode(data), "192.168.0.9", ETHERNET).info().uri.startswith("gige:")


@pytest.mark.parametrize("text", ["1", "-5", "65536", "big"])
def test_senseless_packet_sizes_are_refused(text: str) -> None:
    with pytest.raises(UsageError, match="packet_size"):
        PacketSizePolicy.parse(text)
