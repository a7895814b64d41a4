"""The cameras that Aravis sees."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from urllib.parse import quote

from grabbergui.core.grabber import DeviceInfo
from grabbergui.driver.aravis.library import load

# Aravis keeps one list for the whole process.
_list_lock = threading.Lock()


@dataclass(frozen=True)
class FoundCamera:
    """One entry of Aravis's list."""

    id: str
    "Vendor, model and serial number joined by hyphens: what Aravis opens it by."
    physical_id: str
    "MAC address or GUID."
    address: str
    vendor: str
    model: str
    serial: str
    protocol: str

    @property
    def address_or_id(self) -> str:
        """What leads to this camera alone: the address of one on the network, which may share its id."""
        return self.address if self.protocol == "GigEVision" and self.address else self.id

    def answers_to(self, name: str) -> bool:
        """Whether `name` is its id, address, serial number or MAC address."""
        known = (self.id, self.address, self.serial, self.physical_id)
        return name.lower() in [text.lower() for text in known if text]

    def info(self) -> DeviceInfo:
        """As a list of sources shows it."""
        return DeviceInfo(
            uri=f"aravis:{quote(self.id, safe=' :-_.')}",
            vendor=self.vendor,
            model=self.model,
            serial=self.serial,
            bus=f"{_BUS.get(self.protocol, self.protocol)} by Aravis",
            address=self.address,
            hardware_id=self.physical_id.lower() if self.protocol == "GigEVision" else "",
        )


_BUS = {"GigEVision": "GigE Vision", "USB3Vision": "USB3 Vision"}


def find_cameras() -> list[FoundCamera]:
    """All of them, on every interface; takes about a second. Raises SourceUnavailableError."""
    library = load()
    fields = ("id", "physical_id", "address", "vendor", "model", "serial_nbr", "protocol")
    with _list_lock:
        library.arv_update_device_list()
        return [
            FoundCamera(*(_text(getattr(library, f"arv_get_device_{field}")(index)) for field in fields))
            for index in range(library.arv_get_n_devices())
        ]


def _text(raw: bytes | None) -> str:
    return (raw or b"").decode("utf-8", "replace")
