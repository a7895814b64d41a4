"""A camera's identity and GenICam XML, read from its memory over whichever transport or library reads it.

The identity comes from the bootstrap registers: GigE Vision 2.x, section 28 (0x0000 to 0x00F7); GenCP 1.3,
section 4 (ABRM). The XML is behind GigE Vision's first URL, then the second: `Local:name.zip;address;length`
in the device's memory (numbers in hexadecimal), `File:` on this host. Data from a device is not trusted:
sizes are limited before anything is read, and only files below a folder that the user named are.
"""

from __future__ import annotations

import logging
import os
import re
import stat
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from urllib.parse import unquote, urlsplit

from grabbergui.core.errors import DeviceLostError, GrabberError, RemoteProtocolError, TransportError
from grabbergui.core.identity import DeviceInfo
from grabbergui.driver.device import DataLayout, unpack
from grabbergui.driver.gige.bootstrap import IDENTITY_BYTES
from grabbergui.driver.gige.discovery import NO_MAC
from grabbergui.driver.gige.gvcp_messages import Identity
from grabbergui.driver.u3v.bootstrap import STRING_SIZE, Abrm, string

log = logging.getLogger(__name__)

_ABRM_STRINGS = {
    "vendor": Abrm.MANUFACTURER_NAME,
    "model": Abrm.MODEL_NAME,
    "version": Abrm.DEVICE_VERSION,
    "serial": Abrm.SERIAL_NUMBER,
    "user_name": Abrm.USER_DEFINED_NAME,
}


def with_identity(info: DeviceInfo, layout: DataLayout, read: Callable[[int, int], bytes]) -> DeviceInfo:
    """Return `info` with what the registers of an open camera say of it; fields they leave empty stay.

    `read` takes an address and a length in bytes. Raises what it raises, RemoteProtocolError.
    """
    if layout is DataLayout.GIGE_VISION:
        identity = Identity.decode(read(0, IDENTITY_BYTES))
        said = {name: getattr(identity, name) for name in _ABRM_STRINGS}
        said["hardware_id"] = identity.mac if identity.mac != NO_MAC else ""
    else:
        said = {name: string(read(address, STRING_SIZE)) for name, address in _ABRM_STRINGS.items()}
    return replace(info, **{name: text for name, text in said.items() if text})


MAX_STORED_BYTES = 16 << 20
"Of a description in a device's memory, or in a file."
FOLDER_VARIABLE = "GRABBERGUI_DESCRIPTIONS"
"The environment variable that names the folder whose files `File:` may mean."

_LOCAL = re.compile(
    r"local:/*\s*(?P<name>[^;]*?)\s*;\s*(?:0x)?(?P<address>[0-9a-f]{1,16})\s*;\s*(?:0x)?(?P<length>[0-9a-f]{1,16})\s*(?:\?.*)?$",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class LocalFile:
    """A description in the device's own memory."""

    name: str
    address: int
    length: int
    "Bytes."


def parse_url(url: str) -> LocalFile | Path:
    """Parse a URL register. Raises RemoteProtocolError for a URL that cannot be read."""
    if match := _LOCAL.match(url.strip()):
        length = int(match["length"], 16)
        if not 0 < length <= MAX_STORED_BYTES:
            raise RemoteProtocolError(
                f"'{url}' announces {length} bytes, at most {MAX_STORED_BYTES} are read"
            )
        return LocalFile(match["name"], int(match["address"], 16), length)
    if url.strip().lower().startswith("file:"):
        return Path(unquote(urlsplit(url.strip()).path))
    raise RemoteProtocolError(f"the camera names its description '{url}'; only Local: and File: can be read")


def fetch_description(urls: list[str], read: Callable[[int, int], bytes]) -> bytes:
    """Return the XML behind the first URL that works; `read(address, length)` reads the device's memory.

    Raises TransportError naming what was wrong with each URL.
    """
    problems = []
    for url in urls:
        if not url:
            continue
        try:
            return _fetch(parse_url(url), read)
        except DeviceLostError:
            raise
        except (GrabberError, OSError) as error:
            log.info("description at '%s': %s", url, error)
            problems.append(f"{url}: {error}")
    reasons = "; ".join(problems) or "its URL registers are empty"
    raise TransportError(f"the camera's description cannot be read: {reasons}")


def _fetch(location: LocalFile | Path, read: Callable[[int, int], bytes]) -> bytes:
    if isinstance(location, LocalFile):
        return unpack(read(location.address, location.length))
    return unpack(_read_file(location))


def _read_file(path: Path) -> bytes:
    """Read a regular file below the user's folder. Raises RemoteProtocolError for others, OSError."""
    folder = os.environ.get(FOLDER_VARIABLE)
    if not folder:
        raise RemoteProtocolError(
            f"the camera names {path}, a file of this computer; "
            f"if you trust it, set {FOLDER_VARIABLE} to its folder"
        )
    path = path.resolve()
    if not path.is_relative_to(Path(folder).resolve()):
        raise RemoteProtocolError(f"{path} is not below {folder}, the folder that {FOLDER_VARIABLE} names")
    # Not to wait for the other end of a FIFO.
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
    with os.fdopen(handle, "rb") as file:
        if not stat.S_ISREG(os.fstat(handle).st_mode):
            raise RemoteProtocolError(f"{path} is no regular file")
        content = file.read(MAX_STORED_BYTES + 1)
    if len(content) > MAX_STORED_BYTES:
        raise RemoteProtocolError(f"{path} has more than {MAX_STORED_BYTES} bytes")
    return content
