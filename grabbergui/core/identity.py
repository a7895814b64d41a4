"""A camera's identity: what is known of it before it is opened, and which names lead to the same one.

A name (address, serial number, user name) only leads to a camera. Addresses are given to other devices,
makers reuse serial numbers, and two cameras may be set to one user name; so a camera counts as the same only
if all that it says of itself is the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

from grabbergui.core.errors import OtherCameraError


@dataclass(frozen=True)
class DeviceInfo:
    """A source's properties that are known before it is opened."""

    uri: str
    "Opens exactly this source, e.g. `gige:GV01`."
    vendor: str = ""
    model: str = ""
    serial: str = ""
    bus: str = ""
    "`GigE Vision`, `USB3 Vision`, `YARP`, `ROS 2`, `Simulated`."
    address: str = ""
    "IP address, USB path, port or topic."
    user_name: str = ""
    "DeviceUserID, where set."
    version: str = ""
    hardware_id: str = ""
    "Unique for each device: the MAC address of GigE Vision, the GUID of USB3 Vision; lower case."
    interface: str = ""
    "The host's network interface or bus it was seen on."
    note: str = ""
    "Why it cannot be opened, as display text; empty if it can."

    @property
    def title(self) -> str:
        """The display name, unlike that of others of its model: `left eye`, `Acme One 40012345`."""
        return " ".join(self._names(self.vendor, self.model))

    @property
    def short_title(self) -> str:
        """The display name without the vendor, for lists and tiles: `left eye`, `One 40012345`."""
        return " ".join(self._names(self.model))

    @property
    def mark(self) -> str:
        """The shortest name that is its own, for narrow places: user name, serial number or address."""
        return self.user_name or self.serial or self.address or self.uri

    @property
    def file_name(self) -> str:
        """The short title as part of a file's name: `left-eye`, `One_40012345`."""
        name = "_".join(self._names(self.model))
        return "".join(c if c.isalnum() or c in "-_." else "-" for c in name).strip("-.")[:80]

    def _names(self, *kind: str) -> list[str]:
        """The user name; else the kind of camera and its serial number, or its address; else the URI.

        Every name of a source that a user reads follows this rule.
        """
        if self.user_name:
            return [self.user_name]
        kind = tuple(filter(None, kind))
        mark = self.serial or self.address
        return [*kind, *([mark] if mark and mark not in kind else [])] if kind else [self.uri]

    def as_dict(self) -> dict[str, str]:
        """All fields, for JSON."""
        return asdict(self)


def unit(info: DeviceInfo) -> tuple[str, ...]:
    """Return what stays with a camera wherever it is plugged in and however it is set."""
    return (info.vendor, info.model, info.serial, info.hardware_id)


def describe(info: DeviceInfo) -> str:
    """A camera with all that distinguishes it: `Acme One (serial 7, 00:30:53:0a:0b:0c)`."""
    maker = " ".join(part for part in (info.vendor, info.model) if part) or info.uri
    user_name = f"'{info.user_name}'" if info.user_name else ""
    serial = f"serial {info.serial}" if info.serial else ""
    details = ", ".join(part for part in (user_name, serial, info.hardware_id) if part)
    return f"{maker} ({details})" if details else maker


def differs(one: DeviceInfo, other: DeviceInfo) -> bool:
    """Whether two descriptions cannot be of one unit; what either leaves out is no contradiction."""
    pairs = ((one.serial, other.serial), (one.hardware_id, other.hardware_id))
    return any(ours and theirs and ours.lower() != theirs.lower() for ours, theirs in pairs)


def is_same(one: DeviceInfo, other: DeviceInfo) -> bool:
    """Whether two sources, of whatever kinds, lead to one camera, as far as they say who it is."""
    if differs(one, other):
        return False
    by_hardware = bool(one.hardware_id and other.hardware_id)
    by_serial = bool(one.serial and other.serial) and one.model == other.model
    by_address = bool(one.address) and (one.bus, one.address) == (other.bus, other.address)
    return by_hardware or by_serial or by_address


def require_same(wanted: DeviceInfo, found: DeviceInfo) -> None:
    """Raise OtherCameraError unless `found` is the unit that was `wanted`."""
    if unit(found) != unit(wanted):
        place = found.address or found.uri
        raise OtherCameraError(
            f"another camera answers at {place}: {describe(found)}, but {describe(wanted)} is wanted; "
            "bring that one back, or connect again to use the other"
        )


def require_one(name: str, candidates: Sequence[DeviceInfo]) -> None:
    """Raise OtherCameraError if several cameras answer to a name; each candidate's URI leads to it alone."""
    known = {info.uri: f"{info.uri}, {describe(info)}" for info in candidates}
    if len(known) > 1:
        text = " and ".join(known.values())
        raise OtherCameraError(f"'{name}' names {len(known)} cameras: {text}; write which one you mean")
