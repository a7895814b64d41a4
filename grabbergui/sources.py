"""The kinds of source: finds and opens sources of every kind.

This is the only module that knows every kind. It imports each on demand, so that a missing package disables
only the kind that needs it.
"""

from __future__ import annotations

import importlib
import logging
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from enum import Enum
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, cast

from grabbergui.core.errors import GrabberError, SourceNotFoundError, SourceUnavailableError, UsageError
from grabbergui.core.missing_packages import explained
from grabbergui.core.uri import (
    DescriptionOption,
    GigeUriOptions,
    NoOptions,
    PlaybackOptions,
    Ros2Options,
    SimulatedOptions,
    SourceUri,
    TwinOptions,
    U3vOptions,
    YarpOptions,
    proposals,
    read_options,
)

if TYPE_CHECKING:
    from grabbergui.core.grabber import FrameGrabber
    from grabbergui.core.identity import DeviceInfo

log = logging.getLogger(__name__)


class SourceKind(str, Enum):
    """The kinds of source; the values are the schemes of their URIs."""

    SIM = "sim"
    GIGE = "gige"
    U3V = "u3v"
    GENTL = "gentl"
    ARAVIS = "aravis"
    V4L2 = "v4l2"
    YARP = "yarp"
    ROS2 = "ros2"
    FILE = "file"
    TWIN = "twin"
    RIG = "rig"

    @property
    def options(self) -> type[Any]:
        """The dataclass of this kind's options, from `core.uri`."""
        return _OPTIONS.get(self, NoOptions)

    @property
    def forms(self) -> tuple[tuple[str, str], ...]:
        """Examples of URIs without options and their meanings, the shortest first."""
        return _FORMS[self]


MODULES: dict[str, str] = {
    SourceKind.SIM: "grabbergui.driver.sim.device",
    SourceKind.GIGE: "grabbergui.driver.gige.device",
    SourceKind.U3V: "grabbergui.driver.u3v.device",
    SourceKind.GENTL: "grabbergui.driver.gentl.device",
    SourceKind.ARAVIS: "grabbergui.driver.aravis.device",
    SourceKind.V4L2: "grabbergui.driver.v4l2.device",
    SourceKind.YARP: "grabbergui.net.yarp.client",
    SourceKind.ROS2: "grabbergui.net.ros2.client",
    SourceKind.FILE: "grabbergui.recording.playback",
    SourceKind.TWIN: "grabbergui.driver.twin.device",
    SourceKind.RIG: "grabbergui.rig.source",
}
"""The module of each kind, with `create(uri) -> FrameGrabber` and `discover(timeout) -> list[DeviceInfo]`."""

_LINUX_ONLY = (SourceKind.V4L2,)

_OPTIONS: dict[SourceKind, type[Any]] = {
    SourceKind.SIM: SimulatedOptions,
    SourceKind.GIGE: GigeUriOptions,
    SourceKind.U3V: U3vOptions,
    SourceKind.GENTL: DescriptionOption,
    SourceKind.YARP: YarpOptions,
    SourceKind.ROS2: Ros2Options,
    SourceKind.FILE: PlaybackOptions,
    SourceKind.TWIN: TwinOptions,
}

_FORMS: dict[SourceKind, tuple[tuple[str, str], ...]] = {
    SourceKind.SIM: (
        ("sim:", "the built-in simulated camera"),
        ("sim:colour", "the same in colour"),
        ("sim:scene", "a simulated camera in a room, with a person who holds a marker"),
        ("sim:board", "a simulated camera that sees a calibration board"),
    ),
    SourceKind.GIGE: (
        ("gige:", "the first GigE Vision camera found"),
        ("gige:192.168.0.10", "by IP address"),
        ("gige:SERIAL", "by serial number; likewise MAC address or user-defined name"),
    ),
    SourceKind.U3V: (
        ("u3v:", "the first USB3 Vision camera found"),
        ("u3v:SERIAL", "by serial number; likewise GUID or bus and port, as in `1-2.3`"),
    ),
    SourceKind.GENTL: (
        ("gentl:", "the first camera of the first GenTL producer below GENICAM_GENTL64_PATH"),
        ("gentl:FILE", "the first camera of a producer, a .cti file"),
        ("gentl:FILE#CAMERA", "by GenTL id, serial number or user-defined name"),
    ),
    SourceKind.ARAVIS: (
        ("aravis:", "the first camera that Aravis finds"),
        ("aravis:192.168.0.10", "by IP address; likewise serial number or Aravis's id"),
    ),
    SourceKind.V4L2: (
        ("v4l2:", "the first webcam, or other video device of Linux"),
        ("v4l2:/dev/video2", "by path; likewise serial number, bus, or the model's name"),
    ),
    SourceKind.YARP: (("yarp:/PORT", "a frame grabber, or any port that sends images"),),
    SourceKind.ROS2: (("ros2:/TOPIC", "a served camera, or any image topic"),),
    SourceKind.FILE: (
        (
            "file:PATH",
            "a recording: a folder of images or of `ros2 bag`, a movie, .mcap, .db3, .tiff or .npy",
        ),
    ),
    SourceKind.TWIN: (("twin:FILE.zip", "a simulated camera made of a camera's report"),),
    SourceKind.RIG: (
        ("rig:FILE.yaml", "several cameras as one, from the file of a rig"),
        ("rig:FILE.mcap", "the recording of a rig"),
    ),
}


def schemes() -> list[str]:
    """Return the schemes of URIs."""
    return [kind.value for kind in SourceKind]


def literal_file(uri: str) -> SourceUri | None:
    """Return the file or folder whose name is what follows `file:`, if there is one.

    Otherwise `50%20`, `?` and `#` in a name that a user types would be read as in other URIs.
    """
    scheme, colon, name = uri.strip().partition(":")
    if not colon or scheme.lower() != SourceKind.FILE.value or not name:
        return None
    with suppress(OSError, ValueError):  # too long for a name, or with a zero
        if Path(name).exists():
            return SourceUri(SourceKind.FILE.value, name)
    return None


def parse(uri: str) -> SourceUri:
    """Parse a URI of a known kind with options that it has. Raises UsageError."""
    parsed = _known(literal_file(uri) or SourceUri.parse(uri))
    read_options(SourceKind(parsed.scheme).options, parsed)
    return parsed


def create(uri: str | SourceUri) -> FrameGrabber:
    """Return the grabber for a URI, not yet opened.

    Raises UsageError for a malformed URI or unknown kind, SourceUnavailableError if the kind needs something
    that this computer lacks.
    """
    parsed = parse(uri) if isinstance(uri, str) else _known(uri)
    opener = cast("Callable[[SourceUri], FrameGrabber]", _load(parsed.scheme).create)
    return opener(parsed)


def named(text: str, timeout: float) -> str:
    """Return the URI of a source as users name it: a URI, or a serial number, name or address without a kind.

    The latter is searched among all kinds for `timeout` seconds. Raises UsageError if several have the name,
    SourceNotFoundError if none has.
    """
    name = text.strip()
    if not name or ":" in name or proposals(name):
        return text
    found = [info for info in discover(timeout) if name in (info.serial, info.user_name, info.address)]
    if not found:
        raise SourceNotFoundError(
            f"no source with the serial number, name or address '{name}' was found; `grabbergui list`"
            " shows all. If it does not answer a search, write its kind, as in gige:192.168.0.10"
        )
    if len(found) > 1:
        raise UsageError(f"several sources are called '{name}': write {' or '.join(i.uri for i in found)}")
    return found[0].uri


def discover(timeout: float = 1.0, longer: Mapping[str, float] | None = None) -> list[DeviceInfo]:
    """Return every source found within `timeout` seconds, searching all kinds in parallel.

    A kind whose search fails finds none. `longer` gives some schemes more seconds.
    """
    seconds = dict.fromkeys(schemes(), timeout) | dict(longer or {})
    # All kinds import this module, and their threads must not find it partially imported.
    importlib.import_module("grabbergui.core.grabber")
    with ThreadPoolExecutor(len(seconds)) as pool:
        found = pool.map(_discover, seconds.keys(), seconds.values())
        return [info for infos in found for info in infos]


def discover_kind(scheme: str, timeout: float = 1.0) -> list[DeviceInfo]:
    """Return every source of one kind found within `timeout` seconds; none if the search fails."""
    return _discover(scheme, timeout)


def _known(uri: SourceUri) -> SourceUri:
    if uri.scheme not in MODULES:
        known = ", ".join(f"{scheme}:" for scheme in schemes())
        raise UsageError(f"'{uri}' is of no known kind; there are {known}")
    return uri


def _discover(scheme: str, timeout: float) -> list[DeviceInfo]:
    try:
        finder = cast("Callable[[float], list[DeviceInfo]]", _load(scheme).discover)
        return finder(timeout)
    except GrabberError as error:
        log.info("looking for %s: sources: %s", scheme, error)
    except OSError as error:
        log.warning("looking for %s: sources: %s", scheme, error)
    return []


def _load(scheme: str) -> ModuleType:
    if scheme in _LINUX_ONLY and sys.platform != "linux":
        raise SourceUnavailableError(f"{scheme}: sources exist on Linux only, and this is {sys.platform}")
    try:
        return importlib.import_module(MODULES[scheme])
    except ImportError as error:
        raise SourceUnavailableError(f"{scheme}: sources cannot be used: {explained(error)}") from error
    except Exception as error:
        log.info("loading %s", MODULES[scheme], exc_info=True)
        raise SourceUnavailableError(
            f"{scheme}: sources need a package that is installed but broken"
            f" ({type(error).__name__}: {error}); install grabbergui again in a new environment"
        ) from error
