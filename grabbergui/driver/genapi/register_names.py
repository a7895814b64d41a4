"""The registers of a description by their names, whether features use them or not."""

from __future__ import annotations

from xml.etree import ElementTree

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.genapi.cleaning import clean_xml, port_name

_REGISTERS = frozenset({"IntReg", "MaskedIntReg", "FloatReg", "StringReg", "Register"})
"Elements of one register; `StructReg` has several, its entries."


def register_names(description: bytes) -> list[tuple[str, bool]]:
    """Return the registers of the camera itself, not of chunks and events, in the order of the description.

    With each name, whether it is a register of plain bytes, without a value. Raises RemoteProtocolError.
    """
    xml = clean_xml(description)
    port = port_name(xml)
    try:
        root = ElementTree.fromstring(xml)
    except ElementTree.ParseError as error:
        raise RemoteProtocolError(f"the camera's description is no well-formed XML: {error}") from error
    found = []
    for node in root.iter():
        kind = _kind(node)
        inside = {_kind(child): (child.text or "").strip() for child in node}
        if inside.get("pPort") != port:
            continue
        if kind == "StructReg":
            found += [(child.get("Name", ""), False) for child in node if _kind(child) == "StructEntry"]
        elif kind in _REGISTERS:
            found.append((node.get("Name", ""), kind == "Register"))
    return [(name, plain) for name, plain in found if name]


def _kind(node: ElementTree.Element) -> str:
    return str(node.tag).rpartition("}")[2]
