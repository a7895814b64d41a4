"""The GenICam XML: its place as the device reports it, and fetching it.

The first URL, then the second: `Local:name.zip;address;length` in the device's memory (numbers in
hexadecimal), `File:` on this host. Data from a device is not trusted: sizes are limited before
anything is read, and only files below a folder that the user named are.
"""

from __future__ import annotations

import logging
import os
import re
import stat
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote, urlsplit

from grabbergui.core.errors import DeviceLostError, GrabberError, RemoteProtocolError, TransportError
from grabbergui.driver.device import unpack

log = logging.getLogger(__name__)

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
