"""The address that a camera keeps: registers, the command, and what the simulated camera makes of it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import closing

import pytest

from grabbergui import sources
from grabbergui.cli import main
from grabbergui.core.errors import TransportError, UsageError
from grabbergui.core.grabber import Access
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.gige import discovery
from grabbergui.driver.gige.address_commands import (
    check_addresses,
    force_ip,
    keep_address,
    read_configuration,
)
from grabbergui.driver.gige.bootstrap import IpConfigurationBit
from grabbergui.driver.gige.device import GigeDevice
from grabbergui.driver.gige.identity import ForceIp
from grabbergui.driver.sim.gige import registers as gev
from grabbergui.driver.sim.gige.server import GigeCamera

NET = f"127.86.{os.getpid() % 250 + 1}"


@pytest.fixture
def camera() -> Iterator[GigeCamera]:
    with closing(GigeCamera(f"{NET}.1")) as camera:
        yield camera


def test_an_address_is_kept_and_forgotten(camera: GigeCamera, capsys: pytest.CaptureFixture[str]) -> None:
    source = f"gige:{NET}.1"
    assert main(["persistent-ip", source, f"{NET}.9", "255.255.255.0", f"{NET}.254"]) == 0
    assert f"its persistent address, then DHCP, then a link-local address ({NET}.9" in capsys.readouterr().out
    memory = camera.control.memory
    assert memory.integer(gev.IP_CONFIGURATION) == 7
    assert not camera.control.controlled

    assert main(["persistent-ip", source, "--forget"]) == 0
    assert "at power-on: DHCP, then a link-local address\n" in capsys.readouterr().out
    assert memory.integer(gev.IP_CONFIGURATION) == 6
    assert main(["persistent-ip", source]) == 0
    assert capsys.readouterr().out.startswith(
        f"grabbergui Simulated camera (serial {camera.serial}, {camera.mac.hex(':')}): "
    )


def test_the_same_is_in_the_cameras_features(camera: GigeCamera) -> None:
    with closing(sources.create(f"gige:{NET}.1")) as grabber:
        grabber.open()
        grabber.write_feature("GevPersistentIPAddress", 0x7F000063)
        grabber.write_feature("GevPersistentSubnetMask", 0xFF000000)
        grabber.write_feature("GevCurrentIPConfigurationPersistentIP", True)
        assert isinstance(grabber, DeviceGrabber)
        configuration = read_configuration(grabber.device)
    assert (configuration.persistent_ip, configuration.persistent_mask) == ("127.0.0.99", "255.0.0.0")
    assert configuration.ways == 7


def test_a_camera_that_keeps_its_address_has_it_after_a_restart() -> None:
    with closing(GigeCamera(f"{NET}.2")) as camera:
        with closing(GigeDevice(f"{NET}.2")) as device:
            device.open(Access.CONTROL)
            keep_address(device, f"{NET}.20", "255.0.0.0")
        camera.cut_power()
        found = None
        for _ in range(100):
            found = found or discovery.ask(f"{NET}.20", 0.1)
        assert found is not None and found.ip == f"{NET}.20"
        assert camera.address == f"{NET}.20"
        assert discovery.ask(f"{NET}.2", 0.1) is None


def test_a_camera_that_cannot_keep_one_reports_it(camera: GigeCamera) -> None:
    (supported,) = (r for r in gev._REGISTERS if r.name == "supported IP configuration")
    camera.control.memory.set(supported, 6)
    with closing(GigeDevice(f"{NET}.1")) as device:
        device.open(Access.CONTROL)
        with pytest.raises(TransportError, match="DHCP give it one"):
            keep_address(device, f"{NET}.9", "255.0.0.0")
        assert IpConfigurationBit.PERSISTENT not in read_configuration(device).ways


@pytest.mark.parametrize(
    "addresses",
    [
        ("192.168.0", "255.255.255.0"),
        ("192.168.0.10", "255.0.255.0"),
        ("192.168.0.10", "24"),
        ("192.168.0.10", "0.0.0.255"),
        ("192.168.0.0", "255.255.255.0"),
        ("192.168.0.255", "255.255.255.0"),
        ("239.1.1.1", "255.255.255.0"),
        ("0.0.0.0", "0.0.0.0"),
        ("192.168.0.10", "255.255.255.0", "192.168.1.1"),
    ],
)
def test_addresses_that_make_no_sense_are_refused(addresses: tuple[str, ...]) -> None:
    with pytest.raises(UsageError):
        check_addresses(*addresses)


@pytest.mark.parametrize(
    "addresses", [("192.168.1",), ("192.168.0.10", "24"), ("192.168.0.10", "255.255.255.0", "10.0.0.1")]
)
def test_no_camera_is_forced_to_an_address_that_makes_no_sense(addresses: tuple[str, ...]) -> None:
    with pytest.raises(UsageError):
        force_ip(ForceIp("02:00:00:00:00:01", *addresses))


@pytest.mark.parametrize(
    "arguments", [["sim:"], ["gige:127.0.0.1", "1.2.3.4", "--forget"], ["gige:127.0.0.1", "1.2.3.400"]]
)
def test_wrong_usage_reaches_no_camera(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["persistent-ip", *arguments]) == 2
    assert capsys.readouterr().err.startswith("grabbergui: ")
