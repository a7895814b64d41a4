"""Checks for USB3 Vision: permissions and the kernel's memory for transfers."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from importlib import resources
from pathlib import Path

from grabbergui.core.errors import AccessDeniedError, GrabberError
from grabbergui.doctor.finding import Finding, good, note, problem

RULE_NAME = "70-grabbergui-u3v.rules"
RULES = Path("/etc/udev/rules.d")
USBFS_MEMORY = Path("/sys/module/usbcore/parameters/usbfs_memory_mb")
WANTED_USBFS_MB = 256
"""Eight frames of 32 MB in flight."""


def check() -> Iterator[Finding]:
    """All checks of this kind."""
    yield from udev_rule(RULES)
    yield from transfer_memory(USBFS_MEMORY)
    yield from cameras()


def udev_rule(folder: Path) -> Iterator[Finding]:
    """Whether users may open cameras."""
    if (folder / RULE_NAME).is_file():
        yield good(f"the udev rule {folder / RULE_NAME} lets users open USB3 Vision cameras")
    elif os.name == "posix" and folder.parent.is_dir():
        yield note("no udev rule lets users open USB3 Vision cameras", "sudo grabbergui doctor --fix-udev")


def transfer_memory(place: Path) -> Iterator[Finding]:
    """The kernel's limit for transfers in flight, 16 MB where nobody raised it."""
    try:
        limit = int(place.read_text())
    except (OSError, ValueError):
        return
    if 0 < limit < WANTED_USBFS_MB:
        yield note(
            f"the kernel grants {limit} MB to USB transfers of all programs; large frames need more",
            f"echo {WANTED_USBFS_MB} | sudo tee {place}",
        )
    else:
        yield good("the kernel grants enough memory to USB transfers")


def cameras() -> Iterator[Finding]:
    """Cameras seen."""
    from grabbergui.driver.u3v import source

    try:
        found = source.discover(1.0)
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


def install_udev_rule(folder: Path = RULES) -> Path:
    """Write the rule and let udev read it. Raises AccessDeniedError for who may not."""
    rule = (resources.files("grabbergui.resources") / "udev" / RULE_NAME).read_text("utf-8")
    target = folder / RULE_NAME
    try:
        folder.mkdir(parents=True, exist_ok=True)
        target.write_text(rule, "utf-8")
    except PermissionError as error:
        raise AccessDeniedError(
            f"{target} cannot be written by this user; run: sudo grabbergui doctor --fix-udev"
        ) from error
    udevadm = shutil.which("udevadm")
    if udevadm is not None:
        for arguments in (["control", "--reload"], ["trigger", "--subsystem-match=usb"]):
            # A container has no udev to tell; the rule is in place all the same.
            subprocess.run([udevadm, *arguments], check=False, capture_output=True, timeout=10)
    return target
