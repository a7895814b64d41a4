"""The simulated camera's description, `camera.xml`, and the registers in it.

It is the only list of registers: their addresses, kinds, ranges and choices are read from it here, and
`registers` gives names to those that the camera's model uses.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Container, Iterator, Mapping
from functools import cache
from importlib import resources
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from grabbergui.driver.sim.memory import Register, RegisterKind, RegisterValue

_FEATURES_HERE = b"    <!-- features of the transport -->\n"
_END = b"</RegisterDescription>"

_SCHEMA = "{http://www.genicam.org/GenApi/Version_1_1}"
_PORT = "Device"
"The port that leads to registers; chunks and events have ports of their own."
_FEATURE_KINDS = ("Integer", "Float", "Boolean", "Enumeration", "Command")
_REGISTER_KINDS = {
    ("IntReg", 4): RegisterKind.UINT32,
    ("IntReg", 8): RegisterKind.INT64,
    ("FloatReg", 8): RegisterKind.FLOAT64,
}
_BUFFER = "Register"
"A node of plain bytes."
_SUFFIX = "Reg"
"Ends the name of a feature's register; a string is its register itself."

PowerOn = RegisterValue | tuple[RegisterValue, ...]
"A register's value after power-on, or one for each entry of its selector."


@cache
def camera_xml() -> bytes:
    """Return the description that all transports share."""
    return resources.files(__package__).joinpath("camera.xml").read_bytes()


def zipped(name: str, xml: bytes) -> bytes:
    """Return an archive with a description, the same bytes every time."""
    archive = io.BytesIO()
    member = zipfile.ZipInfo(name, (2024, 1, 1, 0, 0, 0))
    with zipfile.ZipFile(archive, "w") as opened:
        opened.writestr(member, xml, zipfile.ZIP_DEFLATED)
    return archive.getvalue()


def with_transport(features: tuple[str, ...], nodes: bytes) -> bytes:
    """Return the description with a transport's features, listed in TransportLayerControl, and nodes."""
    listed = b"".join(b"    <pFeature>%s</pFeature>\n" % name.encode() for name in features)
    return camera_xml().replace(_FEATURES_HERE, listed).replace(_END, nodes + _END)


class DescribedRegisters:
    """The registers in `camera.xml`, by the name of their feature."""

    def __init__(
        self,
        power_on: Mapping[str, PowerOn],
        limits: Mapping[str, tuple[float | None, float]],
        saved: Container[str],
    ) -> None:
        """Read the description.

        `power_on`: what registers hold after power-on, by feature; others hold 0, or no text. `limits`: the
        smallest and largest values if the description computes them or has none. `saved`: features in user
        sets in addition to those marked Streamable.
        """
        self._power_on = power_on
        self._limits = limits
        self._saved = saved
        root = ElementTree.fromstring(camera_xml())
        self._nodes = {node.get("Name", ""): node for node in root}
        self._feature_of = {
            _text(node, "pValue"): node
            for node in root
            if _tag(node) in _FEATURE_KINDS and _text(node, "pValue")
        }
        "By the register that holds its value."
        self._registers = {
            name.removesuffix(_SUFFIX): tuple(self._instances(name.removesuffix(_SUFFIX), node))
            for name, node in self._nodes.items()
            if _text(node, "pPort") == _PORT and _tag(node) != _BUFFER
        }

    def __iter__(self) -> Iterator[Register]:
        """Give every register."""
        for instances in self._registers.values():
            yield from instances

    def one(self, name: str) -> Register:
        """Return the register of a feature without selector."""
        (register,) = self._registers[name]
        return register

    def each(self, name: str) -> tuple[Register, ...]:
        """Return the registers of a feature, one for each entry of its selector, in their order."""
        return self._registers[name]

    def buffer(self, name: str) -> tuple[int, int]:
        """Return address and length of a node of plain bytes."""
        node = self._nodes[name]
        return int(_text(node, "Address"), 0), int(_text(node, "Length"))

    def _instances(self, name: str, node: Element) -> Iterator[Register]:
        index = node.find(f"{_SCHEMA}pIndex")
        offset, count = 0, 1
        if index is not None:
            offset = int(index.get("Offset", "0"))
            count = len(_choices(self._feature_of[index.text or ""]) or ())
        defaults = self._power_on.get(name)
        for which in range(count):
            default = defaults[which] if isinstance(defaults, tuple) else defaults
            yield self._register(name, node, which, offset * which, default)

    def _register(
        self, name: str, node: Element, which: int, offset: int, default: RegisterValue | None
    ) -> Register:
        length = int(_text(node, "Length"))
        kind = _REGISTER_KINDS.get((_tag(node), length), RegisterKind.STRING)
        writable = _text(node, "AccessMode") == "RW"
        # A feature that is converted from its register (Gain from GainRaw) has no bearing on its range.
        feature = self._feature_of.get(name + _SUFFIX, node)
        minimum, maximum = self._limit(feature, "Min"), self._limit(feature, "Max")
        if name in self._limits:
            smallest, maximum = self._limits[name]
            minimum = minimum or smallest or 0.0
        if default is None:
            default = "" if kind is RegisterKind.STRING else 0
        return Register(
            f"{name}[{which}]" if which else name,
            int(_text(node, "Address"), 0) + offset,
            kind,
            length,
            default,
            writable,
            minimum,
            maximum,
            step=int(_text(feature, "Inc") or 1) if kind is not RegisterKind.FLOAT64 else 1,
            choices=_choices(feature),
            saved=writable and (name in self._saved or _text(feature, "Streamable") == "Yes"),
        )

    def _limit(self, feature: Element, end: str) -> float | None:
        """Return one end (`Min`, `Max`) of a feature's range, which another register may hold."""
        if constant := _text(feature, end):
            return float(constant)
        holder = self._feature_of.get(_text(feature, f"p{end}"))
        return None if holder is None else self._limit(holder, end)


def _choices(feature: Element) -> frozenset[int] | None:
    """Return the only values that an enumeration or a switch takes; None for other features."""
    if _tag(feature) == "Boolean":
        return frozenset({int(_text(feature, "OffValue")), int(_text(feature, "OnValue"))})
    entries = feature.findall(f"{_SCHEMA}EnumEntry")
    return frozenset(int(_text(entry, "Value"), 0) for entry in entries) if entries else None


def _tag(node: Element) -> str:
    return node.tag.removeprefix(_SCHEMA)


def _text(node: Element, tag: str) -> str:
    return node.findtext(_SCHEMA + tag, "")
