"""Mends slips in a camera's description for which GenApi would refuse the camera as a whole.

GenApi checks the schema (GenICam GenApi 2.1, 2.8) and every reference, and gives up at the first fault. Here
a fault costs at most the node or the entry that has it, and often nothing:

- a formatter's line breaks and blanks around names, numbers and keywords are removed;
- an enumeration's entry whose name is no identifier (`UTC-12:00`) gets a legal one, and keeps its own as the
  symbol under which it is shown, read and written;
- keywords in other letter case are spelled as the schema does; a limit that is no integer of 64 bits, and an
  unknown keyword, are dropped, and a node whose value or address is none;
- ToolTip and Description and the rest of a node's head are put into the schema's order;
- the second of two nodes or entries of one name is dropped, an entry without a number, and an enumeration
  without entries;
- a reference to a node that does not exist, and one by which a node would depend on itself, is dropped where
  the schema allows that (a category's feature, a limit, a lock); otherwise the node is dropped that needs it.

Sans-I/O; any thread.
"""

from __future__ import annotations

import logging
import re
from collections import defaultdict
from collections.abc import Callable, Iterator
from xml.etree import ElementTree
from xml.etree.ElementTree import Element
from xml.parsers import expat

from grabbergui.driver.genapi.reference_cycles import cyclic_groups, dependency_order

log = logging.getLogger(__name__)

_ENTRIES = frozenset({"EnumEntry", "StructEntry"})
"Elements within a node that are like nodes themselves."
_TEXTS = frozenset({"ToolTip", "Description", "DisplayName", "DocuURL", "Unit", "Comment"})
"Elements with free text, from which blanks are removed only with a line break that a formatter added."
_HEAD = (
    "Extension",
    "ToolTip",
    "Description",
    "DisplayName",
    "Visibility",
    "DocuURL",
    "IsDeprecated",
    "EventID",
    "pIsImplemented",
    "pIsAvailable",
    "pIsLocked",
    "pBlockPolling",
    "ImposedAccessMode",
    "pError",
    "pAlias",
    "pCastAlias",
)
"The elements with which every node may begin, in the schema's order."
_ORDER = {name: place for place, name in enumerate(_HEAD)}
_OPTIONAL = frozenset({
    "pFeature", "pSelected", "pInvalidator", "pError", "pAlias", "pCastAlias", "pBlockPolling",
    "pIsImplemented", "pIsAvailable", "pIsLocked", "pMin", "pMax", "pInc", "pValueCopy",
})  # fmt: skip
"References without which their node still works."
_UNREAD = frozenset({"pSelected", "pInvalidator", "pError", "pAlias", "pCastAlias"})
"References that may form cycles among those by which nodes are read."
_Users = defaultdict[str, list[tuple[str, Element, Element]]]
"By the name of a node: those that refer to it, with the element that owns the reference, and the reference."
_REFERENCE = re.compile(r"p[A-Z]\w*$")
_SYMBOL = re.compile(r"[A-Za-z0-9]\w*$", re.ASCII)
"Names that GenApi accepts for an enumeration's entry."
_KEYWORDS = {
    element: {word.lower(): word for word in words}
    for elements, words in (
        (("Visibility",), ("Beginner", "Expert", "Guru", "Invisible")),
        (("AccessMode", "ImposedAccessMode"), ("RO", "RW", "WO")),
        (("Cachable",), ("NoCache", "WriteThrough", "WriteAround")),
        (("Sign",), ("Signed", "Unsigned")),
        (("Endianess",), ("LittleEndian", "BigEndian")),
        (
            ("Representation",),
            ("Linear", "Logarithmic", "Boolean", "PureNumber", "HexNumber", "IPV4Address", "MACAddress"),
        ),
        (("DisplayNotation",), ("Automatic", "Fixed", "Scientific")),
        (("Slope",), ("Increasing", "Decreasing", "Varying", "Automatic")),
        (("IsLinear", "IsSelfClearing", "Streamable", "IsDeprecated"), ("Yes", "No")),
    )
    for element in elements
}
_NEEDED_INTEGERS = frozenset({"Value", "Address", "Length", "LSB", "MSB", "Bit", "CommandValue"})
_OPTIONAL_INTEGERS = frozenset({"Min", "Max", "Inc", "PollingTime"})
_NO_INTEGERS = frozenset({"Float", "Converter", "SwissKnife", "String"})
"Kinds of nodes whose Value, Min, Max and Inc are no integers."
_INTEGER = re.compile(r"(0[xX][0-9a-fA-F]{1,40}|[+-]?[0-9]{1,40})$", re.ASCII)
_MOST_NAMED = 5
"Faults that one line of the log names."


def mended(xml: str) -> str:
    """Return the description with its slips mended; the same text if it has none or is not well-formed."""
    root = _parsed(xml)
    if root is None:
        return xml
    description = _Description(root)
    description.mend()
    if not description.changed:
        return xml
    if description.faults:
        others = len(description.faults) - _MOST_NAMED
        log.warning(
            "the camera's description has faults: %s%s",
            "; ".join(description.faults[:_MOST_NAMED]),
            f"; and {others} more" if others > 0 else "",
        )
    try:
        return ElementTree.tostring(root, encoding="unicode")
    except RecursionError:
        return xml  # nested too deep, for which vetting refuses it


def _parsed(xml: str) -> Element | None:
    """Return the root; prefixes stay parts of the names, and comments are left out."""
    builder = ElementTree.TreeBuilder()
    parser = expat.ParserCreate("utf-8")
    parser.buffer_text = True
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.data
    try:
        parser.Parse(xml.encode(), True)
    except expat.ExpatError:
        return None
    return builder.close()


class _Description:
    """The nodes of one description, while they are mended."""

    def __init__(self, root: Element) -> None:
        self.changed = False
        self.faults: list[str] = []
        "Dropped elements, each with the reason."
        self._root = root
        self._nodes: dict[str, Element] = {}
        self._parents: dict[str, Element] = {}
        self._empty: list[str] = []
        "Enumerations without entries."
        self._known: set[str] = set()
        "Names that references may use."
        self._dropped: defaultdict[Element, set[Element]] = defaultdict(set)
        "By parent; they are removed at the end, because removing one takes time in proportion to all."

    def mend(self) -> None:
        """Mend all that can be mended."""
        for parent, node in list(_nodes(self._root)):
            self._trim(node)
            if _tag(node) == "StructReg":  # its entries are the nodes
                self._known.update(entry.get("Name", "") for entry in node)
            name = node.get("Name") or f"{_tag(node)} {len(self._nodes)}"
            self._sort_head(node)
            if reason := self._mend_values(name, node):
                self._drop(parent, node, reason)
                continue
            if name in self._nodes:
                self._drop(parent, node, f"{name} is described twice")
                continue
            self._nodes[name], self._parents[name] = node, parent
            self._known.add(name)
            if _tag(node) == "Enumeration":
                self._mend_entries(name, node)
        self._resolve()
        for parent, dropped in self._dropped.items():
            parent[:] = [child for child in parent if child not in dropped]
            self.changed = True

    def _drop(self, parent: Element, child: Element, reason: str) -> None:
        dropped = self._dropped[parent]
        if child not in dropped:
            dropped.add(child)
            self.faults.append(reason)

    def _trim(self, node: Element) -> None:
        """Remove blanks that no value has, from the text of a node's elements."""
        for child in node:
            kind = _tag(child)
            if kind in _ENTRIES and _tag(node) not in _ENTRIES:
                self._trim(child)
            elif not len(child) and child.text and (child.text[0].isspace() or child.text[-1].isspace()):
                free = kind in _TEXTS or (kind == "Value" and _tag(node) == "String")
                text = child.text.strip()
                if not free or "\n" in child.text[: child.text.find(text)] or not text:
                    child.text, self.changed = text, True

    def _sort_head(self, node: Element) -> None:
        places = [_ORDER[_tag(child)] for child in node if _tag(child) in _ORDER]
        if places != sorted(places):
            node[:] = sorted(node, key=lambda child: _ORDER.get(_tag(child), len(_ORDER)))
            self.changed = True

    def _mend_values(self, name: str, node: Element) -> str:
        """Mend keywords and numbers; return why the node cannot be used, or nothing."""
        whole = _tag(node) not in _NO_INTEGERS
        for child in node:
            kind, text = _tag(child), child.text or ""
            if not text and kind in _KEYWORDS:
                continue  # GenApi takes its default
            if (words := _KEYWORDS.get(kind)) is not None:
                word = words.get(text.lower(), "")
                if not word and kind == "AccessMode":
                    return f"{name} has the access mode {text}"
                if not word:
                    self._drop(node, child, f"{name} has the {kind} {text}")
                elif word != text:
                    child.text, self.changed = word, True
            elif (kind in _NEEDED_INTEGERS or kind in _OPTIONAL_INTEGERS) and whole and not _is_integer(text):
                if kind in _NEEDED_INTEGERS:
                    return f"{name} has the {kind} '{text}', which is no integer"
                self._drop(node, child, f"{name} has the {kind} '{text}', which is no integer")
        return ""

    def _mend_entries(self, name: str, enumeration: Element) -> None:
        entries = [child for child in enumeration if _tag(child) == "EnumEntry"]
        legal = {entry.get("Name", "") for entry in entries}
        found: set[str] = set()
        for entry in entries:
            self._sort_head(entry)
            symbol = entry.get("Name", "")
            if symbol in found or not _has_number(entry):
                reason = f"has two entries {symbol}" if symbol in found else f"has no number for {symbol}"
                self._drop(enumeration, entry, f"{name} {reason}")
                continue
            found.add(symbol)
            if not _SYMBOL.match(symbol):
                self._rename(entry, symbol, legal)
            self._known.add(f"EnumEntry_{name}_{entry.get('Name')}")
        if not found:
            self._empty.append(name)

    def _rename(self, entry: Element, symbol: str, taken: set[str]) -> None:
        """Give an entry a legal name, and keep its own as the symbol."""
        base = name = "E" + re.sub(r"\W", "_", symbol, flags=re.ASCII)
        number = 1
        while name in taken:
            number += 1
            name = f"{base}_{number}"
        taken.add(name)
        entry.set("Name", name)
        self.changed = True
        if any(_tag(child) == "Symbolic" for child in entry):
            return
        last = max((at for at, child in enumerate(entry) if _tag(child) != "IsSelfClearing"), default=-1)
        element = Element(entry.tag.replace("EnumEntry", "Symbolic"))
        element.text = symbol
        entry.insert(last + 1, element)

    def _resolve(self) -> None:
        """Drop references to missing nodes and cycles of references, and the nodes that need them."""
        users: _Users = defaultdict(list)
        for name, node in self._nodes.items():
            for owner, child, target in _references(node):
                users[target].append((name, owner, child))
        missing = [target for target in users if target not in self._known]
        for name in self._empty:
            self._drop(self._parents[name], self._nodes.pop(name), f"{name} has no entries")
            missing.append(name)
        self._drop_users(missing, users)
        for chosen in (lambda kind: kind not in _UNREAD, "pSelected".__eq__):
            self._drop_users(self._break_cycles(chosen), users)

    def _drop_users(self, missing: list[str], users: _Users) -> None:
        while missing:
            target = missing.pop()
            for name, owner, child in users.pop(target, ()):
                if name not in self._nodes:
                    continue
                if _tag(child) in _OPTIONAL:
                    self._drop(owner, child, f"{name} refers to {target or 'nothing'}, which is missing")
                else:
                    self._drop(self._parents[name], self._nodes.pop(name), f"{name} needs {target}")
                    missing.append(name)

    def _break_cycles(self, chosen: Callable[[str], bool]) -> list[str]:
        """Drop references of the `chosen` kinds until no node depends on itself; return dropped nodes.

        A node is dropped only if no reference in its cycle can be.
        """
        uses = {
            name: [
                (owner, child, target)
                for owner, child, target in _references(node)
                if chosen(_tag(child)) and target in self._nodes and child not in self._dropped.get(owner, ())
            ]
            for name, node in self._nodes.items()
        }
        without = []
        for group in cyclic_groups({name: {target for *_, target in used} for name, used in uses.items()}):
            members, needs = set(group), {name: set[str]() for name in group}
            optional = []
            for name in group:
                for owner, child, target in uses[name]:
                    if target in members and _tag(child) in _OPTIONAL:
                        optional.append((name, owner, child, target))
                    elif target in members:
                        needs[name].add(target)
            places = {name: place for place, name in enumerate(dependency_order(needs))}
            for name in members - places.keys():
                self._drop(self._parents[name], self._nodes.pop(name), f"{name} needs itself")
                without.append(name)
            for name, owner, child, target in optional:
                if name in places and places.get(target, -1) >= places[name]:
                    self._drop(owner, child, f"{name} depends on itself through {target}")
        return without


def _nodes(root: Element) -> Iterator[tuple[Element, Element]]:
    """Yield the nodes, with the description or the group that contains each."""
    parents = [root]
    while parents:
        parent = parents.pop()
        for child in parent:
            if _tag(child) == "Group":
                parents.append(child)
            else:
                yield parent, child


def _references(node: Element) -> Iterator[tuple[Element, Element, str]]:
    """Yield the element that owns each reference of a node, the reference, and the name in it."""
    for child in node:
        if _tag(child) in _ENTRIES and _tag(node) not in _ENTRIES:
            yield from _references(child)
        elif _REFERENCE.match(_tag(child)):
            yield node, child, child.text or ""
            for key, value in child.attrib.items():  # <pIndex pOffset="…">
                if _REFERENCE.match(key):
                    yield node, child, value


def _has_number(entry: Element) -> bool:
    for child in entry:
        if _tag(child) == "Value":
            return _is_integer(child.text or "")
    return False


def _is_integer(text: str) -> bool:
    """Return whether GenApi reads a text as an integer of 64 bits."""
    if not _INTEGER.match(text):
        return False
    value = int(text, 16) if text[:2] in ("0x", "0X") else int(text)
    return -(1 << 63) <= value < 1 << 63


def _tag(element: Element) -> str:
    """Return the name of an element without the prefix of its namespace."""
    return str(element.tag).rpartition(":")[2]
