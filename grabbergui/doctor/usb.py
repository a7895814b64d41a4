"""Checks for USB3 Vision: permissions, and memory of the kernel for transfers."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from grabbergui.core.environment import program, sudo_command
from grabbergui.core.errors import GrabberError
from grabbergui.doctor.findings import Finding, good, note, problem
from grabbergui.doctor.mending import as_administrator
from grabbergui.setup.udev_rule import UDEV_RULES, installed_udev_rule

USBFS_MEMORY = Path("/sys/module/usbcore/parameters/usbfs_memory_mb")
WANTED_USBFS_MB = 256
"""Eight frames of 32 MB in flight."""


def check_usb() -> Iterator[Finding]:
    """The udev rule, transfer memory and cameras of USB3 Vision."""
    yield from udev_rule(UDEV_RULES)
    yield from transfer_memory(USBFS_MEMORY)
    yield from usb_cameras()


def udev_rule(folder: Path) -> Iterator[Finding]:
    """Check whether users may open cameras."""
    rule = installed_udev_rule(folder)
    if rule is not None:
        yield good(f"the udev rule {rule} lets users open USB3 Vision cameras")
    elif os.name == "posix" and folder.parent.is_dir():
        yield note(
            "no udev rule lets users open USB3 Vision cameras",
            sudo_command("setup", "udev"),
            as_administrator(*program(), "setup", "udev"),
        )


def transfer_memory(place: Path) -> Iterator[Finding]:
    """Check the kernel's limit for transfers in flight, 16 MB by default."""
    try:
        limit = int(place.read_text())
    except (OSError, ValueError):
        return
    if 0 < limit < WANTED_USBFS_MB:
        yield note(
            f"the kernel grants {limit} MB to USB transfers of all programs; large frames need more",
            f"echo {WANTED_USBFS_MB} | sudo tee {place}",
            as_administrator("sh", "-c", f"echo {WANTED_USBFS_MB} > {place}"),
        )
    else:
        yield good("the kernel grants enough memory to USB transfers")


def usb_cameras() -> Iterator[Finding]:
    """List the cameras found."""
    from grabbergui.driver.u3v import device

    try:
        found = device.discover(1.0)
    except GrabberError as error:
        yield problem(f"looking for USB3 Vision cameras failed: {error}", "check the cable and the udev rule")
        return
    for info in found:
        if info.note:
            yield problem(f"{info.title} is seen but cannot be used: {info.note}", "see above")
        else:
            yield good(f"{info.title} on USB ({info.address})")
    if not found:
        yield note("no USB3 Vision camera is plugged in")
