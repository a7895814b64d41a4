"""The GenICam description: found through the manifest, read from the device's memory, unzipped."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Callable

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.stored_description import unpack
from grabbergui.driver.u3v.bootstrap import ManifestEntry, best_description

log = logging.getLogger(__name__)

MOST_ENTRIES = 64
LARGEST_STORED = 16 << 20
"Bytes; the largest descriptions have two million, unzipped."


def read_description(read: Callable[[int, int], bytes], manifest_address: int) -> bytes:
    """The XML of a device whose memory `read(address, length)` gives.

    Raises RemoteProtocolError for a manifest or file that makes no sense, and what `read` raises.
    """
    count = int.from_bytes(read(manifest_address, 8), "little")
    if not 0 < count <= MOST_ENTRIES:
        raise RemoteProtocolError(f"the manifest announces {count} files; 1 to {MOST_ENTRIES} make sense")
    size = ManifestEntry.FORMAT.size
    first = manifest_address + 8
    entries = [ManifestEntry.decode(read(first + index * size, size)) for index in range(count)]
    entry = best_description(entries)
    if not 0 < entry.size <= LARGEST_STORED:
        raise RemoteProtocolError(f"the manifest announces a description of {entry.size} bytes")
    stored = read(entry.address, entry.size)
    if any(entry.sha1) and hashlib.sha1(stored, usedforsecurity=False).digest() != entry.sha1:
        log.warning("the description's SHA-1 is not the one in the manifest; it is used all the same")
    return unpack(stored)
