"""Settings files as other programs and editors leave them: their characters, and formats that are not read.

GenApi's persistence format is common to pylon (`.pfs`), IDS peak (`.cset`) and others; `files` reads it.
Formats of other viewers are recognised, so that the refusal names the format and the way out.
"""

from __future__ import annotations

import codecs
import re

_UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
_CONTROLS = re.compile(r"[\x00-\x08\x0b\x0e-\x1f]")


def text_of(content: bytes) -> str | None:
    """Return the text of a file in UTF-8, UTF-16, or else Windows' Latin-1 (cp1252); None if it is no text.

    One byte of Latin-1, such as a degree sign in a comment, must not cost the settings in the file.
    """
    text = _decoded(content)
    return None if text is None or _CONTROLS.search(text) else text


def _decoded(content: bytes) -> str | None:
    try:
        if content.startswith(_UTF16):
            return content.decode("utf-16")
        if content[1:2] == b"\0" or content[:1] == b"\0":  # without a byte order mark; files begin with ASCII
            return content.decode("utf-16-be" if content[:1] == b"\0" else "utf-16-le")
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return None if content.startswith(_UTF16) else content.decode("cp1252", "replace")


_FORMATS = (
    (r"<CameraSettings\b", "the XML of Allied Vision's Vimba"),
    (r"<PropertyList\b|<propertyList\b", "the XML of Balluff's mvIMPACT Acquire"),
    (r"<puregev\b", "the XML of Pleora's eBUS"),
    (
        r"^[ \t]*\[Versions\][\s\S]{0,400}^[ \t]*\[Sensor\]|^[ \t]*ueye_api",
        "an .ini file of IDS's uEye Cockpit",
    ),
    (r"^[ \t]*\[Board\][\s\S]*^[ \t]*\[(Feature|Stream|Control)", "a .ccf file of Teledyne DALSA's Sapera"),
    (r'^[ \t]*\{[\s\S]{0,4000}"(properties|device|ic4)"\s*:', "JSON of The Imaging Source's programs"),
    (r"^[ \t]*<\?xml|^[ \t]*<[A-Za-z]", "XML"),
    (r"^[ \t]*\{", "JSON"),
)
"The beginning of formats that are refused, as regular expressions, and their names."


def format_name(text: str) -> str:
    """Return the name of a format that is not read; empty if it is not known."""
    start = text[:8000]
    return next((name for pattern, name in _FORMATS if re.search(pattern, start, re.MULTILINE)), "")
