"""A camera's description as the node map wants it.

Real dumps have junk before the first tag, padding behind the last, or no XML declaration at all.
"""

from __future__ import annotations

import re

from grabbergui.core.errors import RemoteProtocolError

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


def clean_xml(data: bytes) -> str:
    """The XML text alone. Raises RemoteProtocolError for what is no GenICam description.

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
