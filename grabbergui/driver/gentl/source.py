"""`gentl:` sources: `gentl:/path/producer.cti` (its first camera), `gentl:/path/producer.cti#CAMERA`.

The file may be named without its folder where GENICAM_GENTL64_PATH leads to it; `gentl:` alone means the
first producer there. CAMERA is a GenTL id, a serial number or a user-defined name.
"""

from __future__ import annotations

import logging
from pathlib import Path

from grabbergui.core.errors import GrabberError, MissingFileError, SourceNotFoundError
from grabbergui.core.grabber import DeviceInfo, FrameGrabber
from grabbergui.core.uri import NoOptions, SourceUri, read_options
from grabbergui.driver.camera import Camera
from grabbergui.driver.gentl.device import GentlDevice
from grabbergui.driver.gentl.producer import SEARCH_PATH, Producer, installed_producers

log = logging.getLogger(__name__)


def create(uri: SourceUri) -> FrameGrabber:
    """The camera that a URI names, not yet opened. Raises UsageError, SourceNotFoundError."""
    read_options(NoOptions, uri)
    file, _, name = uri.name.partition("#")
    path = _producer_file(file)
    return Camera(GentlDevice(path, name, DeviceInfo(str(uri), bus="GenTL", address=name)))


def discover(timeout: float) -> list[DeviceInfo]:
    """Every camera of the producers that the environment names; without any nothing is loaded."""
    found: list[DeviceInfo] = []
    for path in installed_producers():
        try:
            producer = Producer.acquire(path)
            try:
                found += [camera.device for camera in producer.cameras(int(timeout * 1000))]
            finally:
                producer.release()
        except GrabberError as error:
            log.warning("%s", error)
    return found


def _producer_file(file: str) -> Path:
    if file and Path(file).is_file():
        return Path(file)
    installed = installed_producers()
    for path in installed:
        if not file or path.name == file:
            return path
    missing = MissingFileError if file else SourceNotFoundError
    known = ", ".join(str(path) for path in installed) or "no .cti file"
    raise missing(
        f"there is no GenTL producer{f' {file}' if file else ''}; {SEARCH_PATH} leads to {known}. "
        "Give the file's whole path, as in gentl:/opt/vendor/producer.cti"
    )
