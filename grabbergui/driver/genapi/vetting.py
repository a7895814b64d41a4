"""Checks a camera's description, which is untrusted text, before GenApi parses it.

Real descriptions have junk before the first tag, padding after the last, or no XML declaration at all, and
characters of another encoding than the declared one (`core.device_text`).

GenApi runs in this process and holds the GIL. So this module first bounds the cost of loading the description
and of reading a feature, and rewrites what would crash the program: divisions of 64-bit integers (`formulas`)
and increments that are not positive. The limits are several times what 131 published
descriptions need; docs/decisions/0002-vet-descriptions-before-genapi.md has the figures.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from html import escape  # the one in xml.sax would import http and ssl
from xml.parsers import expat

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.genapi.formulas import without_traps
from grabbergui.driver.genapi.mending import mended

MOST_NODES = 30_000
"Nodes and enumeration entries; 3,200 are known."
MOST_REFERENCES = 200_000
"From node to node; 12,500 are known."
MOST_ENTRIES = 4_096
"Entries of one enumeration; 331 are known."
DEEPEST_XML = 32
"Levels of nested elements."
LONGEST_CHAINS = {"pFeature": 16, "pSelected": 16, "": 128}
"""Length of a chain of references, of one kind and of any; 5, 4 and 88 are known.

GenApi's cost grows with its square, for features and selectors with its cube."""
MOST_BRANCHES = 1_000
"""Branches of the feature tree, counted wherever a category is listed; 70 are known.

GenApi's cost grows with their square."""
MOST_EVALUATIONS = 100_000
"Uncached nodes computed to read one feature; 1,800 are known."

_DECLARATION = re.compile(r"^<\?xml.*?\?>", re.DOTALL)
_REFERENCE = re.compile(r"p[A-Z]\w*$")
_PASSIVE = frozenset({"pAlias", "pCastAlias", "pPort"})
"References that GenApi does not follow when it computes."
_NOT_COMPUTED = _PASSIVE | {"pFeature", "pSelected", "pInvalidator"}
_FORMULAS = frozenset({"Formula", "FormulaTo", "FormulaFrom", "Expression"})
_INTEGER_FORMULAS = frozenset({"IntSwissKnife", "IntConverter"})
_FLOATS = frozenset({"Float", "Converter", "SwissKnife"})
_NO_NODES = frozenset({"pVariable", "Constant", "Expression"})
"Elements with a Name that are parts of a formula, not nodes."
_BREAKS = str.maketrans({"\t": "&#9;", "\n": "&#10;", "\r": "&#13;"})
"An XML parser reads each of them in an attribute as a space."


@functools.lru_cache(maxsize=4)
def vetted(xml: str) -> str:
    """Return the description in a form that is safe for GenApi, with the same features; cached.

    Raises RemoteProtocolError if it is not well-formed or beyond the limits.
    """
    # The text is decoded already; another encoding in its declaration would make GenApi read other text.
    xml = '<?xml version="1.0" encoding="utf-8"?>' + mended(_DECLARATION.sub("", xml, count=1))
    reader = _DescriptionReader(xml.encode())
    _require_bounded_chains(reader.nodes)
    _require_bounded_tree(reader.nodes)
    _require_bounded_reading(reader.nodes)
    _require_whole_increments(reader.nodes)
    return reader.rewritten().decode()


@dataclass
class _Node:
    kind: str
    references: list[tuple[str, str]] = field(default_factory=list)
    "Element and the name in it; `entry` for the parts of an enumeration or a structure."
    names: list[str] = field(default_factory=list)
    "Names that formulas may use."
    uncached: bool = False
    increment: bool = False
    "Whether it has an increment of its own."
    entries: int = 0


@dataclass(frozen=True)
class _Element:
    name: str
    attributes: dict[str, str]
    begin: int
    "Offset of its opening tag, in bytes."


class _DescriptionReader:
    """One pass over the XML: the graph of its nodes, and the replacements in the text."""

    def __init__(self, data: bytes) -> None:
        self.nodes: dict[str, _Node] = {}
        self._data = data
        self._edits: list[tuple[int, int, str]] = []
        "Offsets of an element and of its closing tag, and the text that replaces what is between."
        self._formulas: list[tuple[_Element, int, str, _Node]] = []
        "Checked at the end, when all names that they may use are known."
        self._helpers: list[str] = []
        "Nodes to add."
        self._references = 0
        self._open: list[_Element] = []
        self._within: list[tuple[int, str]] = []
        "Depth and name of the nodes around the current element."
        self._text: list[str] = []
        self._end = 0
        self._parser = expat.ParserCreate("utf-8")
        self._parser.buffer_text = True
        self._parser.StartElementHandler = self._on_start
        self._parser.EndElementHandler = self._on_end
        self._parser.CharacterDataHandler = self._text.append
        try:
            self._parser.Parse(data, True)
        except expat.ExpatError as error:
            raise RemoteProtocolError(f"the camera's description is no well-formed XML: {error}") from error

    def rewritten(self) -> bytes:
        """Return the text with all replacements."""
        for element, end, formula, node in self._formulas:
            safe = without_traps(formula, node.names)
            if safe != formula:
                self._replace(element, end, safe)
        if self._helpers:
            self._edits.append((self._end, self._end, "".join(self._helpers)))
        pieces: list[bytes] = []
        position = 0
        for begin, end, text in sorted(self._edits):
            pieces += (self._data[position:begin], text.encode())
            position = end
        return b"".join((*pieces, self._data[position:]))

    def _on_start(self, tag: str, attributes: dict[str, str]) -> None:
        element = _Element(tag.rpartition(":")[2], attributes, self._parser.CurrentByteIndex)
        self._open.append(element)
        if len(self._open) > DEEPEST_XML:
            raise _beyond(f"its elements are nested more than {DEEPEST_XML} deep")
        name = attributes.get("Name")
        if name is not None and element.name not in _NO_NODES:
            self.nodes.setdefault(name, _Node(element.name))
            if len(self.nodes) > MOST_NODES:
                raise _beyond(f"it has more than {MOST_NODES} nodes")
            if self._within:
                self._add_entry(self._within[-1][1], name)
            self._within.append((len(self._open), name))
        self._text.clear()

    def _add_entry(self, owner: str, name: str) -> None:
        node = self.nodes[owner]
        node.references.append(("entry", name))
        node.entries += 1
        if node.entries > MOST_ENTRIES:
            raise _beyond(f"{owner} has more than {MOST_ENTRIES} entries")

    def _on_end(self, _tag: str) -> None:
        element, text = self._open[-1], "".join(self._text)
        self._text.clear()
        if self._within:
            depth, name = self._within[-1]
            if depth == len(self._open):
                self._within.pop()
            else:
                self._note(name, element, text)
        self._open.pop()
        if not self._open:
            self._end = self._parser.CurrentByteIndex

    def _note(self, name: str, element: _Element, text: str) -> None:
        """Record a child element of a node."""
        node, end = self.nodes[name], self._parser.CurrentByteIndex
        if "Name" in element.attributes:
            node.names.append(element.attributes["Name"])
        self._refer(node, element.name, text.strip())
        for key, value in element.attributes.items():
            self._refer(node, key, value)  # <pIndex pOffset="…">
        if element.name == "Cachable":
            node.uncached |= text.strip() == "NoCache"
        elif element.name in ("Inc", "pInc"):
            node.increment = True
            if node.kind == "Integer":
                self._make_positive(name, element, end, text.strip())
        elif element.name in _FORMULAS and node.kind in _INTEGER_FORMULAS:
            self._formulas.append((element, end, text, node))

    def _refer(self, node: _Node, element: str, target: str) -> None:
        if _REFERENCE.match(element):
            node.references.append((element, target))
            self._references += 1
            if self._references > MOST_REFERENCES:
                raise _beyond(f"its nodes have more than {MOST_REFERENCES} references")

    def _make_positive(self, name: str, element: _Element, end: int, text: str) -> None:
        """Replace an increment that may be 0: GenApi divides by it when a float above it is written."""
        if element.name == "Inc":
            if _integer(text) <= 0:
                self._replace(element, end, "1")
            return
        helper = f"{name}_PositiveIncrement"
        self._replace(element, end, helper)
        self._helpers.append(
            f'<IntSwissKnife{_attribute("Name", helper)}><pVariable Name="INC">{escape(text)}</pVariable>'
            "<Formula>(INC &gt; 0) ? INC : 1</Formula></IntSwissKnife>"
        )

    def _replace(self, element: _Element, end: int, text: str) -> None:
        if end > element.begin:  # an empty <Inc/> remains: GenApi refuses it
            attributes = "".join(_attribute(key, value) for key, value in element.attributes.items())
            self._edits.append((element.begin, end, f"<{element.name}{attributes}>{escape(text)}"))


def _attribute(name: str, value: str) -> str:
    return f' {name}="{escape(value).translate(_BREAKS)}"'


def _beyond(reason: str) -> RemoteProtocolError:
    return RemoteProtocolError(f"the camera's description cannot be used: {reason}")


def _integer(text: str) -> int:
    try:
        return int(text, 0)
    except ValueError:
        return 0


def _require_bounded_chains(nodes: dict[str, _Node]) -> None:
    for kind, most in LONGEST_CHAINS.items():
        follows = kind.__eq__ if kind else lambda element: element not in _PASSIVE
        lengths = _folded(nodes, follows, lambda _node, below: 1 + max(below, default=-1))
        for name, length in lengths.items():
            if length > most:
                what = f"{kind} references" if kind else "references"
                raise _beyond(f"{length} {what} follow each other from {name}, at most {most} make sense")


def _require_bounded_tree(nodes: dict[str, _Node]) -> None:
    branches = _folded(nodes, "pFeature".__eq__, lambda node, below: (node.kind == "Category") + sum(below))
    for name, count in branches.items():
        if count > MOST_BRANCHES:
            raise _beyond(f"{name} leads to {count} categories, at most {MOST_BRANCHES} make sense")


def _require_bounded_reading(nodes: dict[str, _Node]) -> None:
    """Bound the cost of a read: GenApi computes an uncached value again for each node that needs it."""

    def cost(node: _Node, below: list[int]) -> int:
        # A cached value costs nothing here, so a node with a cost is uncached.
        return int(node.uncached or any(below)) + sum(below)

    for name, count in _folded(nodes, lambda element: element not in _NOT_COMPUTED, cost).items():
        if count > MOST_EVALUATIONS:
            raise _beyond(f"reading {name} computes {count} nodes, at most {MOST_EVALUATIONS} make sense")


def _require_whole_increments(nodes: dict[str, _Node]) -> None:
    """Refuse an increment that becomes 0: an integer truncates the increment of the float below it."""
    none, fraction, cut = 0, 1, 2

    def increment(node: _Node, below: list[int]) -> int:
        if node.kind not in _FLOATS:
            return cut if fraction in below and not node.increment else none
        if cut in below:
            raise _beyond("a float stands for an integer that stands for a float with an increment")
        return fraction if node.increment or fraction in below else none

    _folded(nodes, "pValue".__eq__, increment)


def _folded(
    nodes: dict[str, _Node],
    follows: Callable[[str], bool],
    combined: Callable[[_Node, list[int]], int],
) -> dict[str, int]:
    """Compute a number for each node with references from the numbers of its targets, without recursion.

    `follows`: whether an element counts as a reference. One reference of a cycle is ignored: GenApi refuses
    cycles itself.
    """
    targets = {
        name: [target for element, target in node.references if target in nodes and follows(element)]
        for name, node in nodes.items()
        if node.references
    }
    results: dict[str, int] = {}
    for start in targets:
        path, entered = [start], set[str]()
        while path:
            name = path[-1]
            if name not in results:
                below = targets.get(name, ())
                if name not in entered:
                    entered.add(name)
                    waiting = [target for target in below if target not in results and target not in entered]
                    if waiting:
                        path += waiting
                        continue
                known = [results[target] for target in below if target in results]
                results[name] = combined(nodes[name], known)
            path.pop()
    return results
