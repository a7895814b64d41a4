"""Camera descriptions made from a fuzzer's bytes, and a camera behind them."""

from __future__ import annotations

from collections.abc import Callable
from xml.sax.saxutils import escape

from fuzz._input import Input

HEAD = """<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription xmlns="http://www.genicam.org/GenApi/Version_1_1" ModelName="F" VendorName="F"
 ToolTip="" StandardNameSpace="None" SchemaMajorVersion="1" SchemaMinorVersion="1" SchemaSubMinorVersion="0"
 MajorVersion="1" MinorVersion="0" SubMinorVersion="0" ProductGuid="1" VersionGuid="1">
<Port Name="Device"/>"""
TOKENS = (
    *("A", "B", "TO", "FROM", "0", "1", "2", "7", "0x10", "1.5", "SGN(", "NEG(", "SQRT(", " "),
    *("+", "-", "*", "/", "%", "**", "&", "|", "^", "~", "<<", ">>", "=", "<>", "<", ">", "<=", ">="),
    *("&&", "||", "?", ":", "(", ")", "(0-1)", "(1<<63)", " / ", " % ", "(A / B)", "(A % B)"),
)
NUMBERS = ("0", "1", "-1", "5", "9223372036854775807", "-9223372036854775808", "0x7F", "4096", "0.5")
MOST_NODES = 64


def formula(source: Input, tokens: int = 12) -> str:
    """Tokens in any order, most often one that means something."""
    return "".join(TOKENS[source.number(1) % len(TOKENS)] for _ in range(source.number(1) % tokens + 1))


def description(source: Input) -> str:
    """Return a description of up to 64 nodes that refer to each other in any way."""
    count = source.number(1) % MOST_NODES + 1
    nodes = [_KINDS[source.number(1) % len(_KINDS)](source, f"N{index}", count) for index in range(count)]
    features = "".join(f"<pFeature>N{index}</pFeature>" for index in range(count))
    return f'{HEAD}<Category Name="Root">{features}</Category>{"".join(nodes)}</RegisterDescription>'


class Registers:
    """A camera whose memory repeats a few bytes."""

    def __init__(self, content: bytes) -> None:
        self._content = bytearray(content or b"\0")

    def read(self, address: int, length: int) -> bytes:
        """Return bytes of the repetition."""
        begin = address % len(self._content)
        return bytes((self._content * (length // len(self._content) + 2))[begin : begin + length])

    def write(self, address: int, data: bytes) -> None:
        """Store what fits."""
        begin = address % len(self._content)
        self._content[begin : begin + len(data)] = data[: len(self._content) - begin]


def _node(source: Input, count: int) -> str:
    return f"N{source.number(1) % count}"


def _value(source: Input) -> str:
    return NUMBERS[source.number(1) % len(NUMBERS)]


def _maybe(source: Input, element: str, count: int) -> str:
    """Return a reference, a constant or nothing."""
    choice = source.number(1) % 3
    if choice == 0:
        return ""
    return f"<p{element}>{_node(source, count)}</p{element}>" if choice == 1 else (
        f"<{element}>{_value(source)}</{element}>"
    )  # fmt: skip


def _conditions(source: Input, count: int) -> str:
    names = ("pIsImplemented", "pIsAvailable", "pIsLocked")
    chosen = source.number(1)
    return "".join(
        f"<{name}>{_node(source, count)}</{name}>"
        for bit, name in enumerate(names)
        if chosen >> bit & 33 == 33
    )


def _number(kind: str) -> Callable[[Input, str, int], str]:
    def node(source: Input, name: str, count: int) -> str:
        value = _maybe(source, "Value", count) or "<Value>5</Value>"
        limits = "".join(_maybe(source, element, count) for element in ("Min", "Max", "Inc"))
        return f'<{kind} Name="{name}">{_conditions(source, count)}{value}{limits}</{kind}>'

    return node


def _register(kind: str) -> Callable[[Input, str, int], str]:
    def node(source: Input, name: str, count: int) -> str:
        address = f"<Address>{source.number(1)}</Address>"
        if source.number(1) % 4 == 0:
            address += f"<pAddress>{_node(source, count)}</pAddress>"
        length = (4, 8)[source.number(1) % 2]
        cached = ("NoCache", "WriteThrough", "WriteAround")[source.number(1) % 3]
        sign = f"<Sign>{('Signed', 'Unsigned')[source.number(1) % 2]}</Sign>" if kind == "IntReg" else ""
        return (
            f'<{kind} Name="{name}">{_conditions(source, count)}{address}<Length>{length}</Length>'
            f"<AccessMode>RW</AccessMode><pPort>Device</pPort><Cachable>{cached}</Cachable>{sign}"
            f"<Endianess>BigEndian</Endianess></{kind}>"
        )

    return node


def _knife(kind: str) -> Callable[[Input, str, int], str]:
    def node(source: Input, name: str, count: int) -> str:
        variables = "".join(
            f'<pVariable Name="{letter}">{_node(source, count)}</pVariable>' for letter in "AB"
        )
        if kind.endswith("Knife"):
            formulas, value = f"<Formula>{escape(formula(source))}</Formula>", ""
        else:
            formulas = "".join(
                f"<{way}>{escape(formula(source))}</{way}>" for way in ("FormulaTo", "FormulaFrom")
            )
            value = f"<pValue>{_node(source, count)}</pValue>"
        return f'<{kind} Name="{name}">{_conditions(source, count)}{variables}{formulas}{value}</{kind}>'

    return node


def _enumeration(source: Input, name: str, count: int) -> str:
    entries = "".join(
        f'<EnumEntry Name="{name}E{value}"><Value>{value}</Value></EnumEntry>' for value in (0, 1)
    )
    return f'<Enumeration Name="{name}">{entries}<pValue>{_node(source, count)}</pValue></Enumeration>'


def _boolean(source: Input, name: str, count: int) -> str:
    return f'<Boolean Name="{name}"><pValue>{_node(source, count)}</pValue></Boolean>'


_KINDS: tuple[Callable[[Input, str, int], str], ...] = (
    *(_number(kind) for kind in ("Integer", "Float")),
    *(_register(kind) for kind in ("IntReg", "FloatReg", "IntReg")),
    *(_knife(kind) for kind in ("IntSwissKnife", "SwissKnife", "IntConverter", "Converter")),
    _enumeration,
    _boolean,
)
