"""Descriptions cleaned and loaded into GenApi without harm to the other threads, or to other programs.

Real dumps have junk before the first tag, padding behind the last, or no XML declaration at all.

GenApi's binding holds the GIL while it parses: 100 ms for a camera of 3,500 nodes, in which the window does
not answer. Four fifths of that are the XML itself, so a process of its own parses a large description, and
this process reads the result (`parse_cache`), also of descriptions that it loaded before.
"""

from __future__ import annotations

import functools
import re
import sys
import threading

from genicam import genapi

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.genapi.vetting import vetted

if sys.platform == "linux":
    from grabbergui.driver.genapi import parse_cache

LARGE = 300_000
"Characters of a description beyond which the detour is worth a process (0.15 s)."

_loading = threading.Lock()
"Also for small ones: while the cache is switched on, GenApi uses it for every description."


def load(xml: str) -> genapi.NodeMap:
    """A node map of this description, without a port. Any thread; one after another.

    Raises RemoteProtocolError for a description that `vetting` or GenApi's own process cannot stand, and what
    GenApi raises for one that it cannot use.
    """
    nodes = genapi.NodeMap()
    with _loading:
        if sys.platform == "linux" and len(xml) >= LARGE:
            with parse_cache.parsed(xml) as text:
                nodes.load_xml_from_string(text)
        else:
            nodes.load_xml_from_string(vetted(xml))
    return nodes


MAX_XML_BYTES = 64 * 1024 * 1024
"""Ten times the largest description known; more is a mistake or an attack."""

_START = re.compile(rb"<\?xml|<(?:\w+:)?RegisterDescription\b")
_ENTITIES = re.compile(rb"<!DOCTYPE|<!ENTITY")
_SPACED = re.compile(
    r"<(Visibility|AccessMode|ImposedAccessMode|Cachable|Sign|Endianess|Representation|DisplayNotation|Slope"
    r"|IsLinear|IsSelfClearing|Streamable|IsDeprecated|CacheChunkData|SwapEndianess)>\s*(\w+)\s*</"
)
"Elements whose text is one of a few words."
_SWAPPED = re.compile(r"(<Description>[^<]*</Description>)(\s*)(<ToolTip>[^<]*</ToolTip>)")


@functools.lru_cache(maxsize=4)
def clean_xml(data: bytes) -> str:
    """Return the XML text alone; the last few are kept, for cameras that are opened again.

    Raises RemoteProtocolError for anything but a GenICam description.

    Document type declarations are refused: GenICam has none, and entities can read files or explode.
    """
    if len(data) > MAX_XML_BYTES:
        raise RemoteProtocolError(
            f"the camera's description has {len(data)} bytes, allowed are {MAX_XML_BYTES}"
        )
    start = _START.search(data)
    if start is None:
        raise RemoteProtocolError("the camera's description is no GenICam XML: no RegisterDescription in it")
    body = data[start.start() :].rstrip(b"\0 \r\n\t")
    if _ENTITIES.search(body):
        raise RemoteProtocolError("the camera's description declares entities, which GenICam does not allow")
    end = body.rfind(b">")
    # Latin-1 comments under a UTF-8 declaration are common; names are ASCII.
    return _tidied(body[: end + 1].decode("utf-8", errors="replace"))


def _tidied(xml: str) -> str:
    """Without two slips against the schema that vendors' own viewers tolerate, and GenApi does not."""
    return _SWAPPED.sub(r"\3\2\1", _SPACED.sub(r"<\1>\2</", xml))


def port_name(xml: str) -> str:
    """The name of the port that leads to the camera's registers: `Device`, or the only one there is."""
    names = re.findall(r"<Port\s[^>]*?Name\s*=\s*[\"'](\w+)[\"']", xml)
    if "Device" in names or not names:
        return "Device"
    return str(names[0])
