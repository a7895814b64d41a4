"""A widget as a screen reader knows it: Qt's own QAccessibleInterface, which PyQt does not wrap.

The interface is called through its table of virtual functions, as `qaccessible.h` of Qt 5 declares them.
"""

import ctypes
from functools import cache
from pathlib import Path
from typing import NamedTuple

import PyQt5
from PyQt5 import sip

PLACE_OF_TEXT, PLACE_OF_ROLE = 12, 15
"Places of `text` and `role` among the virtual functions."
NAME = 0
"QAccessible::Name."

ROLES = {
    0x2A: "editable text", 0x29: "static text", 0x2B: "push button", 0x2C: "check box", 0x2D: "radio button",
    0x2E: "combo box", 0x33: "slider", 0x34: "spin box", 0x21: "list", 0x18: "table", 0x24: "tree",
    0x0A: "client", 0x25: "page tab", 0x38: "button menu", 0x39: "button drop-down", 0x14: "grouping",
    0x10: "pane", 0x0C: "menu item", 0x28: "graphic",
}  # fmt: skip
"By the numbers of QAccessible::Role."


class Heard(NamedTuple):
    """The words that are read aloud."""

    name: str
    role: str


@cache
def _query():
    (library,) = (Path(PyQt5.__file__).parent / "Qt5" / "lib").glob("libQt5Gui.so.5")
    query = ctypes.CDLL(str(library))._ZN11QAccessible24queryAccessibleInterfaceEP7QObject
    query.restype, query.argtypes = ctypes.c_void_p, [ctypes.c_void_p]
    return query


def hear(widget):
    """Ask Qt for a widget's accessible name and role; None where a screen reader learns nothing from it."""
    interface = _query()(sip.unwrapinstance(widget))
    if not interface:
        return None
    functions = ctypes.cast(
        ctypes.cast(interface, ctypes.POINTER(ctypes.c_void_p))[0], ctypes.POINTER(ctypes.c_void_p)
    )
    role = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p)(functions[PLACE_OF_ROLE])(interface)
    text = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int)
    string = ctypes.c_void_p()
    text(functions[PLACE_OF_TEXT])(ctypes.addressof(string), interface, NAME)
    return Heard(_text(string.value), ROLES.get(role, hex(role)))


def _text(data):
    """A QString's characters: its QArrayData has a size behind 4 bytes, and an offset behind 16."""
    size = ctypes.c_int.from_address(data + 4).value
    offset = ctypes.c_ssize_t.from_address(data + 16).value
    return ctypes.string_at(data + offset, 2 * size).decode("utf-16-le")
