"""Finds the webcams of this computer in the kernel's sysfs."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from linuxpy.video import device as v4l2

from grabbergui.core.device_text import text_field
from grabbergui.core.identity import DeviceInfo

if sys.platform != "linux":
    raise ImportError("Video4Linux is a part of Linux")

_SYS = Path("/sys/class/video4linux")


def find(folder: Path = _SYS) -> list[DeviceInfo]:
    """Return every device of this computer that captures video, in the order of their numbers."""
    try:
        names = sorted((entry.name for entry in folder.iterdir()), key=_number_of)
    except OSError:
        return []
    return [info for name in names if name.startswith("video") if (info := _info_of(folder / name))]


def _info_of(entry: Path) -> DeviceInfo | None:
    path = f"/dev/{entry.name}"
    try:
        fd = os.open(path, os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)
    except PermissionError:
        note = "may not be opened: add yourself to the group video"
        return DeviceInfo(f"v4l2:{path}", model=_read(entry / "name"), bus="V4L2", address=path, note=note)
    except OSError:
        return None
    try:
        capabilities = v4l2.read_capabilities(fd)
    except OSError:
        return None
    finally:
        os.close(fd)
    needed = v4l2.Capability.VIDEO_CAPTURE | v4l2.Capability.STREAMING
    if capabilities.device_caps & needed != needed:
        return None  # metadata, output, or a codec
    usb = (entry / "device").resolve().parent
    version = capabilities.version
    return DeviceInfo(
        uri=f"v4l2:{path}",
        vendor=_read(usb / "manufacturer"),
        model=text_field(capabilities.card),
        serial=_read(usb / "serial"),
        bus="V4L2",
        address=path,
        version=f"{version >> 16}.{version >> 8 & 255}.{version & 255}",
        hardware_id=text_field(capabilities.bus_info),
        interface=text_field(capabilities.driver),
    )


def _read(path: Path) -> str:
    try:
        return text_field(path.read_bytes())
    except OSError:
        return ""


def _number_of(name: str) -> tuple[int, str]:
    digits = name.removeprefix("video")
    return (int(digits) if digits.isdigit() else 1 << 30, name)
