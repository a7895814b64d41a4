"""Which program uses a USB device, read from folders as Linux has them."""

from __future__ import annotations

import os

import pytest

from grabbergui.driver.u3v.users import UNKNOWN, user_of


@pytest.fixture
def system(tmp_path):
    """A computer's folders, with a camera at `2-1.4`, address 7."""

    class System:
        root = tmp_path

        def bind(self, interface, driver):
            folder = tmp_path / "sys/bus/usb/devices" / interface
            folder.mkdir(parents=True, exist_ok=True)
            (folder / "driver").symlink_to(f"/sys/bus/usb/drivers/{driver}")

        def run(self, process, name, *files):
            folder = tmp_path / "proc" / str(process)
            (folder / "fd").mkdir(parents=True)
            (folder / "comm").write_text(f"{name}\n")
            for number, file in enumerate(files):
                (folder / "fd" / str(number)).symlink_to(file)

        def user(self, place="2-1.4"):
            return user_of(place, 2, 7, tmp_path)

    return System()


def test_the_program_that_has_claimed_an_interface_is_named(system):
    system.bind("2-1.4:1.0", "usbfs")
    system.run(41, "bash", "/dev/null")
    system.run(42, "viewer", "/dev/null", "/dev/bus/usb/002/007")
    assert system.user() == "viewer, PID 42"


def test_a_device_that_is_only_open_is_free(system):
    """Programs that list cameras open them for a moment."""
    system.bind("2-1.4:1.0", "uvcvideo")
    system.run(42, "lister", "/dev/bus/usb/002/007")
    assert system.user() == ""


def test_another_device_on_the_bus_does_not_count(system):
    system.bind("2-1:1.0", "usbfs")
    system.run(42, "viewer", "/dev/bus/usb/002/006")
    assert system.user() == ""


def test_of_another_users_program_only_the_claim_is_seen(system):
    system.bind("2-1.4:1.2", "usbfs")
    assert system.user() == UNKNOWN


def test_our_own_claim_is_no_other_program(system):
    system.bind("2-1.4:1.0", "usbfs")
    system.run(os.getpid(), "grabbergui", "/dev/bus/usb/002/007")
    assert system.user() == ""


def test_without_these_folders_nothing_is_known(system):
    assert system.user() == ""
