"""Fetches the description that a camera names.

A URL names the description: `Local:name.zip;address;length` in the device's memory (numbers in hexadecimal),
or `File:` on this host. Data from a device is not trusted: sizes are checked before anything is read, and
files are read only below a folder that the user chose.
"""

from __future__ import annotations

import io
import logging
import os
import re
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote, urlsplit
from xml.parsers import expat

from grabbergui.core.errors import (
    DeviceLostError,
    GrabberError,
    RemoteProtocolError,
    TransportError,
    UsageError,
)
from grabbergui.core.regular_files import read_bounded

log = logging.getLogger(__name__)


MAX_XML_BYTES = 64 << 20
"Size limit of an unzipped description; the largest known are below 4 MiB."
_ZIP_SIGNATURE = b"PK\3\4"
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
"The methods that GenICam allows. For others zipfile does not bound what one read may unpack."


MAX_STORED_BYTES = 16 << 20
"Size limit of a description in a device's memory or in a file."
FOLDER_VARIABLE = "GRABBERGUI_DESCRIPTIONS"
"Environment variable: the folder below which `File:` descriptions may be read."

_LOCAL = re.compile(
    r"local:/*(?P<name>[^;]*);\s*(?:0x)?(?P<address>[0-9a-f]{1,16})\s*;\s*(?:0x)?(?P<length>[0-9a-f]{1,16})\s*(?:\?.*)?$",
    re.IGNORECASE,
)
_LOCAL_HEADER = struct.Struct("<26xHH")
"Header of a member of an archive, up to the lengths of its name and of its extra field."


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
        return LocalFile(match["name"].strip(), int(match["address"], 16), length)
    if url.strip().lower().startswith("file:"):
        try:
            path = unquote(urlsplit(url.strip()).path)
        except ValueError as error:  # "File://[" begins an IPv6 address that never ends
            raise RemoteProtocolError(f"'{url}' is no URL: {error}") from error
        if "\0" in path:
            raise RemoteProtocolError(f"'{url}' has a zero byte in its path")
        return Path(path)
    raise RemoteProtocolError(f"the camera names its description '{url}'; only Local: and File: can be read")


def fetch_description(urls: Iterable[str], read: Callable[[int, int], bytes]) -> bytes:
    """Return the XML behind the first URL that works; `read(address, length)` reads the device's memory.

    Raises TransportError with the problem of each URL.
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
    return unpack(read_file(location))


def read_file(path: Path) -> bytes:
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
    try:
        return read_bounded(path, MAX_STORED_BYTES, "description")
    except UsageError as error:
        raise RemoteProtocolError(str(error)) from error


def unpack(stored: bytes) -> bytes:
    """Return the XML of a stored description, unzipped if it is a ZIP archive, without trailing zeros.

    Raises RemoteProtocolError for a damaged archive, one without XML, or one beyond MAX_XML_BYTES.
    """
    if not stored.startswith(_ZIP_SIGNATURE):
        return stored.rstrip(b"\0")
    try:
        with zipfile.ZipFile(io.BytesIO(stored)) as archive:
            names = [name for name in archive.namelist() if name.lower().endswith(".xml")]
            if not names:
                raise RemoteProtocolError("the zipped description holds no .xml file")
            method = archive.getinfo(names[0]).compress_type
            if method not in _METHODS:
                raise RemoteProtocolError(
                    f"the zipped description is compressed by method {method}; GenICam has only deflate (8)"
                )
            try:
                with archive.open(names[0]) as member:
                    # The sizes in the archive may be false, so count the bytes that come out.
                    xml = member.read(MAX_XML_BYTES + 1)
            except zipfile.BadZipFile as error:
                xml = _without_checksum(stored, archive.getinfo(names[0]))
                if not parses(xml):
                    raise
                log.warning("the zipped description has a wrong checksum but parses: %s", error)
    # zipfile raises RuntimeError for encryption and unknown versions, ValueError for impossible offsets.
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, ValueError) as error:
        raise RemoteProtocolError(f"the zipped description is damaged: {error}") from error
    if len(xml) > MAX_XML_BYTES:
        raise RemoteProtocolError(f"the zipped description grows beyond {MAX_XML_BYTES} bytes")
    return xml.rstrip(b"\0")


def _without_checksum(stored: bytes, member: zipfile.ZipInfo) -> bytes:
    """Return a member of an archive whose CRC need not fit; at most MAX_XML_BYTES and one more.

    Raises RemoteProtocolError, zlib.error.
    """
    if len(stored) < member.header_offset + _LOCAL_HEADER.size:
        raise RemoteProtocolError("the zipped description is cut off")
    name, extra = _LOCAL_HEADER.unpack_from(stored, member.header_offset)
    begin = member.header_offset + _LOCAL_HEADER.size + name + extra
    packed = stored[begin : begin + member.compress_size]
    if member.compress_type == zipfile.ZIP_STORED:
        return packed
    return zlib.decompressobj(-zlib.MAX_WBITS).decompress(packed, MAX_XML_BYTES + 1)


def parses(xml: bytes) -> bool:
    """Return whether bytes are a well-formed document without entities of its own."""
    if len(xml) > MAX_XML_BYTES or b"<!ENTITY" in xml:
        return False
    try:
        expat.ParserCreate().Parse(xml[max(xml.find(b"<"), 0) :].rstrip(b"\0"), True)
    except expat.ExpatError:
        return False
    return True
