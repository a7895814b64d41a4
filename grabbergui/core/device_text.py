"""Text as devices store it: registers of fixed length, and XML that may not be in the encoding it declares.

Every byte that can be read as a character is. UTF-8 is recognised by its form; single bytes that are not part
of it are read as Windows-1252, the superset of ISO 8859-1 in which such names and units were typed (`°C`).
"""

from __future__ import annotations

import codecs
import re

REPLACEMENT = "\N{REPLACEMENT CHARACTER}"
_FALLBACK = "grabbergui-single-bytes"

_MARKS = (
    (codecs.BOM_UTF32_LE, "utf-32-le"),
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
_START, _WIDE, _EBCDIC = "<?xml", ((4, "utf-32"), (2, "utf-16")), "cp037"
"The begin of a declaration; the encodings in which it has other bytes than in ASCII (XML 1.0, appendix F)."
_SEVEN_BITS = ("hz", "iso2022")
"Encodings that use no bytes but those of ASCII."
_EXCLUDED = ("ascii", "utf-7", "utf-8-sig", "idna", "punycode", "unicode-escape", "raw-unicode-escape")
_DECLARED = re.compile(r"<\?xml[^>]{0,200}?encoding\s*=\s*[\"']([A-Za-z][\w.:-]{0,40})[\"']", re.ASCII)
_NO_XML = re.compile("[\0-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")
"Characters that XML 1.0 excludes."


def text_of(data: bytes) -> str:
    """Return bytes as text. Never raises; only a character that the end cuts off is replaced by U+FFFD."""
    return data.decode("utf-8", _FALLBACK)


def text_field(data: bytes) -> str:
    """Return a register's text: up to the first zero, without unprintable characters and outer blanks."""
    text = text_of(data.split(b"\0", 1)[0])
    return "".join(character for character in text if character.isprintable()).strip()


def xml_text(data: bytes) -> str:
    """Return an XML document as text, which may have other text around it; its declaration stays in it.

    Accepts every encoding that a byte order mark or the declaration names and Python knows. A document that
    is UTF-8 is read as such whatever it declares. Characters that no XML may contain are left out.
    """
    return _NO_XML.sub("", _decoded(data))


def _decoded(data: bytes) -> str:
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            return data[len(mark) :].decode(encoding, "replace")
    data = data.removeprefix(codecs.BOM_UTF8)
    begin = data.find(_START.encode())
    if begin < 0 and (found := _wide(data)) is not None:
        begin, encoding = found
        return data[begin:].decode(encoding, "replace")
    encoding = _declared(data[begin : begin + 300].decode("ascii", "replace"), "ascii")
    try:
        text = data.decode()
        return data.decode(encoding) if encoding.startswith(_SEVEN_BITS) and data.isascii() else text
    except UnicodeDecodeError:
        return data.decode(encoding, _FALLBACK)


def _wide(data: bytes) -> tuple[int, str] | None:
    """Find a declaration in an encoding that is no superset of ASCII; return its offset and the encoding."""
    for size, name in _WIDE:
        at = data.find(_START.encode(f"{name}-le")[: 1 - size])
        if at >= 0:
            zeros = size - 1  # of a big-endian character
            big = at % size == zeros and data[at - zeros : at] == bytes(zeros)
            return (at - zeros, f"{name}-be") if big else (at, f"{name}-le")
    at = data.find(_START.encode(_EBCDIC))
    return None if at < 0 else (at, _declared(data[at : at + 300].decode(_EBCDIC), _EBCDIC))


def _declared(head: str, family: str) -> str:
    """Return Python's name of the encoding in a declaration, which must have the letters of `family`.

    Returns UTF-8, or the `family` if it is EBCDIC, where there is none that Python knows.
    """
    usual = "utf-8" if family == "ascii" else family
    declared = _DECLARED.search(head)
    if declared is None:
        return usual
    try:
        name = codecs.lookup(declared[1]).name
        fits = _START.encode(name) == _START.encode(family)  # a LookupError if it is no encoding of text
    except (LookupError, UnicodeError):
        return usual
    return name if fits and name not in _EXCLUDED else usual


def _single_bytes(error: UnicodeError) -> tuple[str, int]:
    """Handle bytes that the codec cannot read (see `codecs.register_error`)."""
    if not isinstance(error, UnicodeDecodeError):
        raise error
    begin, end, data = error.start, error.end, error.object
    if end == len(data) and error.reason == "unexpected end of data" and not data[:begin].isascii():
        return REPLACEMENT, end  # a register is too short for the last character of its UTF-8
    return "".join(_character(byte) for byte in data[begin:end]), end


def _character(byte: int) -> str:
    try:
        return bytes((byte,)).decode("cp1252")
    except UnicodeDecodeError:  # five bytes of it have no meaning
        return chr(byte)


codecs.register_error(_FALLBACK, _single_bytes)
