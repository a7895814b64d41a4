"""The report's part about this computer: versions, network interfaces, answers to discovery, `doctor`."""

from __future__ import annotations

import importlib.metadata
import platform
import socket
import time
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from typing_extensions import override

from grabbergui import __version__, doctor
from grabbergui.driver.gige.discovery import FoundDevice, Search
from grabbergui.driver.gige.interfaces import Interface, interfaces

_PACKAGES = ("genicam", "numpy", "opencv-python-headless", "PyQt5", "pyusb", "libusb1", "linuxpy", "rclpy")
_SEARCH_TIME = 1.0


def versions() -> dict[str, Any]:
    """Return time and versions of program, system and libraries."""
    found: dict[str, Any] = {
        "time": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
        "grabbergui": __version__,
        "python": platform.python_version(),
        "system": platform.platform(),
    }
    for package in _PACKAGES:
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            continue
    return found


class Listing(Search):
    """A search that keeps the answers of each interface."""

    def __init__(self) -> None:
        super().__init__()
        self.answers: dict[tuple[str, tuple[str, ...]], FoundDevice] = {}

    @override
    def _take(
        self,
        asker: socket.socket,
        interface: Interface,
        until: Callable[[FoundDevice], bool] | None = None,
    ) -> FoundDevice | None:
        device = super()._take(asker, interface, until)
        if device is not None and device.key in self._found:  # a flood fills neither
            self.answers[interface.ip, device.key] = device
        return device


def network() -> dict[str, Any]:
    """Return the interfaces, and each camera's answer to discovery on each of them."""
    search = Listing()
    search.run(_SEARCH_TIME)
    return {
        "interfaces": [asdict(interface) for interface in interfaces()],
        "discovery": [
            {"interface": device.interface.name, "ip": device.ip, **asdict(device.identity)}
            for device in search.answers.values()
        ],
    }


def findings() -> list[dict[str, str]]:
    """Return the findings of `doctor`."""
    return [
        {"level": finding.level.value, "text": finding.text, "remedy": finding.remedy}
        for finding in doctor.check()
    ]
