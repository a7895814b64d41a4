"""Descriptions as devices store them: plain, or as the one file of a ZIP archive, padded with zeros."""

from __future__ import annotations

import io
import zipfile
import zlib

from grabbergui.core.errors import RemoteProtocolError

MAX_XML_BYTES = 64 << 20
"Of a description unzipped; the largest known ones are below 4 MiB."
ZIP_SIGNATURE = b"PK\3\4"
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
"GenICam's. Of the others zipfile does not bound what comes out of one piece."


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
            method = archive.getinfo(names[0]).compress_type
            if method not in _METHODS:
                raise RemoteProtocolError(
                    f"the zipped description is compressed by method {method}; GenICam has only deflate (8)"
                )
            with archive.open(names[0]) as member:
                # What the archive says about its sizes may be a lie, so count what comes out.
                xml = member.read(MAX_XML_BYTES + 1)
    # The last three are zipfile's words for versions, encryption and offsets that it cannot follow.
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, ValueError) as error:
        raise RemoteProtocolError(f"the zipped description is damaged: {error}") from error
    if len(xml) > MAX_XML_BYTES:
        raise RemoteProtocolError(f"the zipped description grows beyond {MAX_XML_BYTES} bytes")
    return xml.rstrip(b"\0")
