"""Giving a camera an IP address: what is proposed, and what is sent in which order."""

from dataclasses import replace
from typing import ClassVar

import pytest

from grabbergui.core.errors import SourceNotFoundError, TransportError
from grabbergui.core.identity import DeviceInfo
from grabbergui.driver.gige import address_commands, device, interfaces
from grabbergui.models.ip_address import IpAddressModel, has_address
from patience import PATIENCE

CAMERA = DeviceInfo(
    "gige:GV01", bus="GigE Vision", address="10.0.0.7", hardware_id="00:30:53:0a:0b:0c", interface="eth9"
)


@pytest.fixture
def host(monkeypatch):
    """A computer with one card."""
    cards = [interfaces.Interface("eth9", "192.168.5.2", "255.255.255.0")]
    monkeypatch.setattr(interfaces, "interfaces", lambda: cards)
    return cards


@pytest.fixture
def sent(monkeypatch):
    """The addresses that the camera gets; `fails` are the errors of the next attempts to open it."""
    calls = []

    class Device:
        fails: ClassVar[list[Exception]] = []

        def __init__(self, name):
            self.name = name

        def open(self, access):
            if self.fails:
                raise self.fails.pop(0)

        def close(self):
            calls.append("closed")

    monkeypatch.setattr(device, "GigeDevice", Device)
    monkeypatch.setattr(address_commands, "force_ip", lambda command: calls.append(command.ip))
    monkeypatch.setattr(
        address_commands, "keep_address", lambda device, *what: calls.append((device.name, *what))
    )
    calls.clear()
    return calls, Device.fails


def outcome(model, *what, keep):
    messages = []
    model.done.connect(lambda text: messages.append(("done", text)))
    model.failed.connect(lambda text: messages.append(("failed", text)))
    model.set(*what, keep=keep)
    assert model.wait(PATIENCE)
    return messages


def test_only_gige_cameras_with_a_mac_have_an_address():
    assert has_address(CAMERA)
    assert not has_address(replace(CAMERA, hardware_id="")) and not has_address(replace(CAMERA, bus="USB3"))


@pytest.mark.parametrize(
    ("present", "proposed"),
    [("10.0.0.7", "192.168.5.7"), ("192.168.5.9", "192.168.5.9"), ("10.0.0.2", "192.168.5.3"),
     ("10.0.0.0", "192.168.5.1"), ("10.0.0.255", "192.168.5.1")],
)  # fmt: skip
def test_an_address_in_the_subnet_of_the_card_is_proposed(host, present, proposed):
    assert IpAddressModel(replace(CAMERA, address=present)).proposal() == (proposed, "255.255.255.0")


def test_without_its_card_the_present_address_is_proposed(host):
    assert IpAddressModel(replace(CAMERA, interface="gone")).proposal() == ("10.0.0.7", "255.255.255.0")


def test_until_power_off_only_force_ip_is_sent(host, sent):
    messages = outcome(IpAddressModel(CAMERA), "192.168.5.7", "255.255.255.0", "", keep=False)
    assert sent[0] == ["192.168.5.7"]
    assert messages == [("done", "The camera has the address 192.168.5.7 until it is switched off.")]


def test_to_keep_it_the_camera_is_opened_there_once_it_answers(host, sent):
    calls, fails = sent
    fails += [SourceNotFoundError("not yet"), TransportError("nor now")]
    messages = outcome(IpAddressModel(CAMERA), "192.168.5.7", "255.255.255.0", "192.168.5.1", keep=True)
    assert calls == [
        "192.168.5.7", "closed", "closed",
        ("192.168.5.7", "192.168.5.7", "255.255.255.0", "192.168.5.1"), "closed",
    ]  # fmt: skip
    assert messages[0][0] == "done" and "also after its next start" in messages[0][1]


def test_a_present_address_is_kept_without_force_ip(host, sent):
    outcome(IpAddressModel(CAMERA), "10.0.0.7", "255.255.255.0", "", keep=True)
    assert sent[0][0][0] == "10.0.0.7"


@pytest.mark.parametrize("what", [("10.0.0.300", "255.0.0.0"), ("10.0.0.9", "255.0.255.0"), ("", "")])
def test_a_wrong_address_is_refused_before_anything_is_sent(host, sent, what):
    ((kind, _),) = outcome(IpAddressModel(CAMERA), *what, "", keep=False)
    assert kind == "failed" and sent[0] == []
