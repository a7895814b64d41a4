"""Descriptions from files, for cameras whose own cannot be had or used.

Some cameras name a web page as the place of their description, or have a damaged one. The user gives a file
(`description=FILE`), which is kept for all cameras of that vendor and model in
`XDG_DATA_HOME/grabbergui/descriptions`.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from grabbergui.core import environment
from grabbergui.core.errors import (
    DeviceLostError,
    GrabberError,
    MissingFileError,
    RemoteProtocolError,
    TransportError,
    UsageError,
)
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.regular_files import read_bounded
from grabbergui.driver.description import MAX_STORED_BYTES, unpack
from grabbergui.driver.device import Device

log = logging.getLogger(__name__)

HINT = (
    "if you have its description as a file, from its maker or another program, give it as ?description=FILE"
)
"""Ends the message about a camera whose description cannot be used."""

Used = TypeVar("Used")


def used(device: Device, file: str, use: Callable[[bytes], Used]) -> tuple[bytes, Used]:
    """Return the description of an open camera and the result of `use`, which raises RemoteProtocolError.

    That of `file` if one is given, or else the camera's own, or else the one given for its model.
    Raises UsageError, MissingFileError, TransportError, RemoteProtocolError.
    """
    if file:
        xml = _read(environment.find_file(environment.expanded(file), "description"))
        result = use(xml)
        _keep(device.info, xml)
        return xml, result
    try:
        xml = device.description()
        return xml, use(xml)
    except DeviceLostError:
        raise
    except (TransportError, RemoteProtocolError) as error:
        kept = kept_for(device.info)
        if kept is None or not kept.is_file():
            raise type(error)(f"{error}; {HINT}") from error
        log.warning("%s: %s; %s is used, which was given before", device.info.title, error, kept)
        xml = _read(kept)
        return xml, use(xml)


def kept_for(info: DeviceInfo) -> Path | None:
    """Return where the description given for a camera's model is kept; None for one without names."""
    if not info.model:
        return None
    name = re.sub(r"[^\w.-]+", "_", f"{info.vendor}-{info.model}")
    return environment.data_home() / "grabbergui" / "descriptions" / f"{name[:200]}.xml"


def _read(path: Path) -> bytes:
    try:
        return unpack(read_bounded(path, MAX_STORED_BYTES, "description"))
    except OSError as error:
        raise MissingFileError(f"the description {path} cannot be read: {error.strerror or error}") from error
    except RemoteProtocolError as error:
        raise UsageError(f"{path}: {error}") from error


def _keep(info: DeviceInfo, xml: bytes) -> None:
    path = kept_for(info)
    if path is None:
        return
    try:
        if path.is_file() and read_bounded(path, MAX_STORED_BYTES, "description") == xml:
            return
        path.parent.mkdir(parents=True, exist_ok=True)
        environment.write_whole(path, xml)
    except (OSError, GrabberError) as error:
        log.warning("the description is not kept for other cameras of this model: %s", error)
    else:
        log.info("the description is kept for cameras of this model: %s", path)
