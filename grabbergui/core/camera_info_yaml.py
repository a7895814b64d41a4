"""The little of YAML that camera_info files are made of.

Mappings by indentation, one or two levels deep; plain and quoted scalars; lists of numbers in brackets,
which may go on over several lines, or in lines that begin with a dash. Anything else is refused.
"""

from __future__ import annotations

import re
from typing import Any

from grabbergui.core.errors import UsageError

_ENTRY = re.compile(r"( *)([A-Za-z_][\w.-]*) *:(?: +(.*))?")
_INTEGER = re.compile(r"[-+]?\d{1,18}", re.ASCII)
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", re.ASCII)


def read(text: str, where: str) -> dict[str, Any]:
    """Keys to numbers, text, lists of scalars, or one more such mapping. Raises UsageError with the line."""
    values: dict[str, Any] = {}
    inner: dict[str, Any] | None = None
    lines = enumerate(text.splitlines(), 1)
    target, key = values, ""
    for number, raw in lines:
        line = raw.split(" #")[0].rstrip()
        if not line.strip() or line.lstrip().startswith("#") or line in ("---", "..."):
            continue
        if line.startswith("%YAML"):
            continue
        if line.lstrip().startswith("- ") and key:
            items = target[key] if isinstance(target.get(key), list) else []
            target[key] = [*items, _scalar(line.lstrip()[2:])]
            continue
        match = _ENTRY.fullmatch(line)
        if not match:
            raise UsageError(f"{where}, line {number}: '{line.strip()[:60]}' is not 'key: value'")
        indentation, key, value = match[1], match[2], (match[3] or "").strip()
        if indentation and inner is None:
            raise UsageError(f"{where}, line {number}: '{key}' is indented below nothing")
        target = inner if indentation and inner is not None else values
        if not value or value.startswith("!!"):
            if indentation:
                target[key] = []  # a list in dashes follows, or nothing
            else:
                inner = values[key] = {}
            continue
        while value.startswith("[") and "]" not in value:
            try:
                value += " " + next(lines)[1].split(" #")[0].strip()
            except StopIteration:
                raise UsageError(f"{where}, line {number}: the list of '{key}' has no end") from None
        target[key] = _list(value) if value.startswith("[") else _scalar(value)
    return values


def write(values: dict[str, Any]) -> str:
    """The text of such a mapping."""
    lines = []
    for key, value in values.items():
        if isinstance(value, dict):
            lines.append(f"{key}:")
            lines += [f"  {name}: {_text(inner)}" for name, inner in value.items()]
        else:
            lines.append(f"{key}: {_text(value)}")
    return "\n".join(lines) + "\n"


def _list(text: str) -> list[Any]:
    inside = text[1 : text.index("]")].strip()
    return [_scalar(part.strip()) for part in inside.split(",") if part.strip()]


def _scalar(text: str) -> int | float | str:
    text = text.strip()
    if len(text) >= 2 and text[0] == text[-1] and text[0] in "\"'":
        return text[1:-1]
    if _INTEGER.fullmatch(text):
        return int(text)
    if _NUMBER.fullmatch(text):
        return float(text)
    return {".nan": float("nan"), ".inf": float("inf"), "-.inf": -float("inf")}.get(text.lower(), text)


def _text(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_text, value))}]"
    if isinstance(value, float):
        # YAML 1.1 takes 1e-05 for text: a number needs its point.
        text = repr(value)
        return text.replace("e", ".0e") if "e" in text and "." not in text else text
    if isinstance(value, str) and (not re.fullmatch(r"[A-Za-z_][\w./-]*", value)):
        return '"' + value.replace('"', "'") + '"'
    return str(value)
