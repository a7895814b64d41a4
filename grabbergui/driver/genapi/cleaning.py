"""Finds the XML text in a camera's description, and the name of its port."""

from __future__ import annotations

import functools
import re

from grabbergui.core.device_text import xml_text
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.description import MAX_XML_BYTES

_START = re.compile(r"<\?xml|<(?:\w+:)?RegisterDescription\b")
_ENTITIES = re.compile(r"<!DOCTYPE|<!ENTITY")


@functools.lru_cache(maxsize=4)
def clean_xml(data: bytes) -> str:
    """Return the XML text alone; cached for cameras that are reopened.

    Raises RemoteProtocolError for anything but a GenICam description, and for document type declarations:
    GenICam has none, and entities can read files or exhaust memory.
    """
    if len(data) > MAX_XML_BYTES:
        raise RemoteProtocolError(f"the camera's description has {len(data)} bytes, at most {MAX_XML_BYTES}")
    text = xml_text(data)
    start = _START.search(text)
    if start is None:
        raise RemoteProtocolError("the camera's description is no GenICam XML: no RegisterDescription in it")
    body = text[start.start() :].rstrip()
    if _ENTITIES.search(body):
        raise RemoteProtocolError("the camera's description declares entities, which GenICam does not allow")
    return body[: body.rfind(">") + 1]


def port_name(xml: str) -> str:
    """Return the name of the port that leads to the camera's registers: `Device`, or the first one."""
    # A tag contains no `<`. Without that limit a comment full of `<Port ` takes quadratic time.
    names = re.findall(r"<Port\s[^<>]*?Name\s*=\s*[\"'](\w+)[\"']", xml)
    if "Device" in names or not names:
        return "Device"
    return str(names[0])
