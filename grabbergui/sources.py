"""Which kinds of source there are, and how each is found and opened.

The only place that knows every kind; it imports each on demand, so that one whose packages are missing
costs nothing and hinders no other.
"""

from __future__ import annotations

import importlib
import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from types import ModuleType
from typing import cast

from grabbergui.core.errors import GrabberError, SourceUnavailableError, UsageError
from grabbergui.core.grabber import DeviceInfo, FrameGrabber
from grabbergui.core.uri import SourceUri

log = logging.getLogger(__name__)

_KINDS: dict[str, str] = {
    "sim": "grabbergui.driver.sim.source",
    "gige": "grabbergui.driver.gige.source",
    "u3v": "grabbergui.driver.u3v.source",
    "gentl": "grabbergui.driver.gentl.source",
    "aravis": "grabbergui.driver.aravis.source",
    "yarp": "grabbergui.net.yarp.source",
    "ros2": "grabbergui.net.ros2.source",
    "file": "grabbergui.recording.playback",
}
"""Scheme to the module with `create(uri) -> FrameGrabber` and `discover(timeout) -> list[DeviceInfo]`."""


def schemes() -> list[str]:
    """The kinds of source that a URI can name."""
    return list(_KINDS)


def parse(uri: str) -> SourceUri:
    """A URI of a kind that there is. Raises UsageError."""
    return _known(SourceUri.parse(uri))


def create(uri: str | SourceUri) -> FrameGrabber:
    """The grabber that a URI names, not yet opened.

    Raises UsageError for a malformed URI or unknown kind, SourceUnavailableError where the kind needs
    something this machine lacks.
    """
    parsed = parse(uri) if isinstance(uri, str) else _known(uri)
    opener = cast(Callable[[SourceUri], FrameGrabber], _load(parsed.scheme).create)
    return opener(parsed)


def discover(timeout: float = 1.0) -> list[DeviceInfo]:
    """Every source found within `timeout` seconds, all kinds at once; a kind that fails finds none."""
    with ThreadPoolExecutor(len(_KINDS)) as pool:
        found = pool.map(lambda scheme: _discover(scheme, timeout), _KINDS)
        return [info for infos in found for info in infos]


def discover_kind(scheme: str, timeout: float = 1.0) -> list[DeviceInfo]:
    """Every source of one kind found within `timeout` seconds; none where that kind fails."""
    return _discover(scheme, timeout)


def _known(uri: SourceUri) -> SourceUri:
    if uri.scheme not in _KINDS:
        known = ", ".join(f"{scheme}:" for scheme in _KINDS)
        raise UsageError(f"'{uri}' is of no known kind; there are {known}")
    return uri


def _discover(scheme: str, timeout: float) -> list[DeviceInfo]:
    try:
        finder = cast(Callable[[float], list[DeviceInfo]], _load(scheme).discover)
        return finder(timeout)
    except GrabberError as error:
        log.info("looking for %s: sources: %s", scheme, error)
    except OSError as error:
        log.warning("looking for %s: sources: %s", scheme, error)
    return []


def _load(scheme: str) -> ModuleType:
    try:
        return importlib.import_module(_KINDS[scheme])
    except ImportError as error:
        raise SourceUnavailableError(f"{scheme}: sources need a package that is missing: {error}") from error
