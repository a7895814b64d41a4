"""The doctor's checks find problems and name the remedies."""

import os

import pytest

from grabbergui.core.errors import AccessDeniedError
from grabbergui.doctor import gige
from grabbergui.doctor.findings import Level
from grabbergui.doctor.gige import (
    WANTED_RMEM,
    gige_cameras,
    packet_sizes,
    priority,
    receive_buffer,
    reverse_path,
)
from grabbergui.doctor.software import display
from grabbergui.doctor.usb import transfer_memory
from grabbergui.doctor.webcams import webcams
from grabbergui.driver.gige.interfaces import Interface
from grabbergui.setup.udev_rule import install_udev_rule


def only(findings):
    (finding,) = findings
    return finding


def sysctl(folder, name, value):
    place = folder.joinpath(*name.split("/"))
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_text(f"{value}\n")
    return folder


@pytest.mark.parametrize(("limit", "level"), [(212992, Level.NOTE), (WANTED_RMEM, Level.GOOD)])
def test_a_small_socket_buffer_is_reported(tmp_path, limit, level):
    finding = only(receive_buffer(sysctl(tmp_path, "core/rmem_max", limit)))

    assert finding.level is level
    assert ("net.core.rmem_max" in finding.remedy) == (level is Level.NOTE)


@pytest.mark.parametrize(("permitted", "level"), [(False, Level.NOTE), (True, Level.GOOD)])
def test_frames_that_may_come_late_are_reported(permitted, level):
    finding = only(priority(permitted=permitted))

    assert finding.level is level
    assert ("rtprio  10'" in finding.remedy) == (level is Level.NOTE)


def test_two_interfaces_in_one_subnet(tmp_path):
    one, other = Interface("eth0", "192.168.1.2"), Interface("eth1", "192.168.1.3")

    finding = only(gige.shared_networks([one, other]))

    assert finding.level is Level.PROBLEM and "eth1" in finding.remedy
    assert not list(gige.shared_networks([one, Interface("eth1", "192.168.2.3")]))


def test_packet_sizes():
    small, jumbo = packet_sizes([Interface("eth0", "10.0.0.1"), Interface("eth1", "10.1.0.1", mtu=9000)])

    assert small.level is Level.NOTE and "mtu 9000" in small.remedy
    assert jumbo.level is Level.GOOD


def test_a_strict_reverse_path_filter_is_noted(tmp_path):
    sysctl(tmp_path, "ipv4/conf/all/rp_filter", 0)
    sysctl(tmp_path, "ipv4/conf/eth0/rp_filter", 1)

    finding = only(reverse_path(tmp_path, [Interface("eth0", "10.0.0.1")]))

    assert "eth0" in finding.text and "rp_filter=2" in finding.remedy


def test_no_camera_names_the_port():
    assert "3956" in only(gige_cameras([])).remedy


def test_without_permission_to_install_the_command_is_shown(tmp_path, monkeypatch):
    def refuse(*_: object, **__: object) -> int:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("pathlib.Path.write_text", refuse)

    with pytest.raises(AccessDeniedError, match=r"sudo /.* setup udev"):
        install_udev_rule(tmp_path)


def test_usb_memory(tmp_path):
    place = tmp_path / "usbfs_memory_mb"
    place.write_text("16\n")
    assert str(place) in only(transfer_memory(place)).remedy
    place.write_text("1000\n")
    assert only(transfer_memory(place)).level is Level.GOOD
    assert not list(transfer_memory(tmp_path / "missing"))


def test_a_missing_display_is_noted():
    assert only(display({}, "linux")).level is Level.NOTE
    assert only(display({"DISPLAY": ":0"}, "linux")).level is Level.GOOD


def test_without_a_webcam_the_doctor_says_what_can_be_done(tmp_path):
    finding = only(webcams(tmp_path))
    assert finding.level is Level.NOTE and "sim:" in finding.remedy and "simulate --gige" in finding.remedy


def test_a_webcam_that_may_not_be_opened_is_a_problem(tmp_path, monkeypatch):
    (tmp_path / "video0").touch()
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    finding = only(webcams(tmp_path))
    assert (
        finding.level is Level.PROBLEM and "video0" in finding.text and "usermod -aG video" in finding.remedy
    )
