"""The GenICam XML: where a device says it is, and getting it from there.

The first URL, then the second: `Local:name.zip;address;length` in the device's memory (numbers in
hexadecimal), `File:` on this host. What comes from a device is not trusted: sizes are limited before
anything is read.
"""

from __future__ import annotations

import io
import logging
import re
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote, urlsplit

from grabbergui.core.errors import DeviceLostError, GrabberError, RemoteProtocolError, TransportError

log = logging.getLogger(__name__)

MAX_STORED_BYTES = 16 << 20
"Of a description in a device's memory."
MAX_XML_BYTES = 64 << 20
"Of a description unzipped; the largest known ones are below 4 MiB."

ZIP_SIGNATURE = b"PK\3\4"

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
    """Where a URL register points. Raises RemoteProtocolError for what cannot be followed."""
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
    """The XML behind the first URL that gives one; `read(address, length)` reads the device's memory.

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
    raise TransportError(f"the camera's description cannot be had: {reasons}")


def _fetch(location: LocalFile | Path, read: Callable[[int, int], bytes]) -> bytes:
    if isinstance(location, LocalFile):
        return unpack(read(location.address, location.length))
    if location.stat().st_size > MAX_STORED_BYTES:
        raise RemoteProtocolError(f"{location} has more than {MAX_STORED_BYTES} bytes")
    return unpack(location.read_bytes())


def unpack(stored: bytes) -> bytes:
    """The XML of what a device stores: unzipped where it is a ZIP archive, without trailing zeros.

    Raises RemoteProtocolError for a damaged archive, one without XML, or one that grows beyond all reason.
    """
    if not stored.startswith(ZIP_SIGNATURE):
        return stored.rstrip(b"\0")
    try:
        with zipfile.ZipFile(io.BytesIO(stored)) as archive:
            names = [name for name in archive.namelist() if name.lower().endswith(".xml")]
            if not names:
                raise RemoteProtocolError("the zipped description holds no .xml file")
            with archive.open(names[0]) as member:
                # What the archive says about its sizes may be a lie, so count what comes out.
                xml = member.read(MAX_XML_BYTES + 1)
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, ValueError) as error:
        raise RemoteProtocolError(f"the zipped description is damaged: {error}") from error
    if len(xml) > MAX_XML_BYTES:
        raise RemoteProtocolError(f"the zipped description grows beyond {MAX_XML_BYTES} bytes")
    return xml.rstrip(b"\0")
