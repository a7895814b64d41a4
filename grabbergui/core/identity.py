"""A camera's identity: its properties before it is opened, and the comparison of two cameras.

No name (address, serial number, user name) identifies a camera. Addresses are reassigned, vendors reuse
serial numbers, and two cameras may have one user name. A camera therefore counts as the same one only if all
its reported properties agree.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import TypeVar

from grabbergui.core.errors import OtherCameraError
from grabbergui.core.visible_text import shortened

Found = TypeVar("Found")


MOST_NAME = 200
"Characters of each part of a display name."


@dataclass(frozen=True)
class DeviceInfo:
    """The properties of a source that are known before it is opened."""

    uri: str
    "The URI that opens exactly this source, e.g. `gige:GV01`."
    vendor: str = ""
    model: str = ""
    serial: str = ""
    bus: str = ""
    "`GigE Vision`, `USB3 Vision`, `YARP`, `ROS 2`, `Simulated`."
    address: str = ""
    "IP address, USB path, port or topic."
    user_name: str = ""
    "DeviceUserID, if set."
    version: str = ""
    hardware_id: str = ""
    "Unique for each device: the MAC address of GigE Vision, the GUID of USB3 Vision; lower case."
    interface: str = ""
    "The host's network interface or bus on which it was found."
    note: str = ""
    "Why it cannot be opened, or which program controls it, as display text; empty if it can be."

    @property
    def title(self) -> str:
        """The display name, distinct among cameras of a model: `left eye`, `Acme One 40012345`."""
        return " ".join(self._names(self.vendor, self.model))

    @property
    def short_title(self) -> str:
        """The display name without the vendor, for lists and tiles: `left eye`, `One 40012345`."""
        return " ".join(self._names(self.model))

    @property
    def mark(self) -> str:
        """The shortest distinct name, for little space: user name, serial number or address."""
        return self.user_name or self.serial or self.address or self.uri

    @property
    def file_name(self) -> str:
        """The short title as part of a file's name: `left-eye`, `One_40012345`."""
        name = "_".join(self._names(self.model))
        return "".join(c if c.isalnum() or c in "-_." else "-" for c in name).strip("-.")[:80]

    def _names(self, *kind: str) -> list[str]:
        """Return the user name; else `kind` and the serial number or address; else the URI.

        All display names of a source follow this rule.
        """
        if self.user_name:
            return [shortened(self.user_name, MOST_NAME)]
        kind = tuple(filter(None, kind))
        mark = self.serial or self.address
        names = [*kind, *([mark] if mark and mark not in kind else [])] if kind else [self.uri]
        return [shortened(name, MOST_NAME) for name in names]

    def as_dict(self) -> dict[str, str]:
        """All fields, for JSON."""
        return asdict(self)


def unit(info: DeviceInfo) -> tuple[str, ...]:
    """Return the properties of a camera that depend neither on its connection nor on its settings."""
    return (info.vendor, info.model, info.serial, info.hardware_id)


def describe(info: DeviceInfo) -> str:
    """Describe a camera with its distinguishing properties: `Acme One (serial 7, 00:30:53:0a:0b:0c)`."""
    maker = " ".join(part for part in (info.vendor, info.model) if part) or info.uri
    user_name = f"'{info.user_name}'" if info.user_name else ""
    serial = f"serial {info.serial}" if info.serial else ""
    details = ", ".join(part for part in (user_name, serial, info.hardware_id) if part)
    return f"{maker} ({details})" if details else maker


def differs(one: DeviceInfo, other: DeviceInfo) -> bool:
    """Return whether two descriptions contradict each other; an empty property contradicts nothing."""
    pairs = ((one.serial, other.serial), (one.hardware_id, other.hardware_id))
    return any(a and b and a.lower() != b.lower() for a, b in pairs)


def is_same(one: DeviceInfo, other: DeviceInfo) -> bool:
    """Return whether two sources of any kind lead to the same camera, as far as their properties tell."""
    if differs(one, other):
        return False
    by_hardware = bool(one.hardware_id and other.hardware_id)
    by_serial = bool(one.serial and other.serial) and one.model == other.model
    by_address = bool(one.address) and (one.bus, one.address) == (other.bus, other.address)
    return by_hardware or by_serial or by_address


def require_same(wanted: DeviceInfo, found: DeviceInfo) -> None:
    """Raise OtherCameraError unless `found` is the same camera as `wanted`."""
    if unit(found) != unit(wanted):
        place = found.address or found.uri
        raise OtherCameraError(
            f"another camera answers at {place}: {describe(found)}, but {describe(wanted)} is wanted; "
            "bring that one back, or connect again to use the other"
        )


def require_one(name: str, candidates: Sequence[DeviceInfo]) -> None:
    """Raise OtherCameraError if several cameras have one name. Each candidate's URI must be unique."""
    known = {info.uri: f"{info.uri}, {describe(info)}" for info in candidates}
    if len(known) > 1:
        text = " and ".join(known.values())
        raise OtherCameraError(f"'{name}' names {len(known)} cameras: {text}; write which one you mean")


def choose(
    name: str, answering: Sequence[Found], known: DeviceInfo | None, info_of: Callable[[Found], DeviceInfo]
) -> Found | None:
    """Return the camera to open of those that answer to a name, as all do to an empty one; None without.

    It is the first, or once a camera is `known` the same one. Raises OtherCameraError if another camera
    answers to the name, or several do.
    """
    if known is not None:
        same = [found for found in answering if not differs(info_of(found), known)]
        if name and answering and not same:
            require_same(known, info_of(answering[0]))
        answering = same
    if name:
        require_one(name, [info_of(found) for found in answering])
    return answering[0] if answering else None


def distinct_names(cameras: Iterable[Sequence[str]]) -> list[str]:
    """Return for each camera the first of its names that no other camera has; else its last name.

    `cameras` gives the names of each camera, in order of preference. Case and empty names are ignored.
    """
    named = [[name for name in names if name] for names in cameras]
    owners = Counter(name for names in named for name in {name.lower() for name in names})
    return [next((name for name in names if owners[name.lower()] == 1), names[-1]) for names in named]
