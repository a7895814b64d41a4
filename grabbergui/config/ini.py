"""The `.ini` dialect of YARP: `key value` lines in `[sections]`.

A value is what follows the key on its line; quotes around it are dropped. Lines starting with `//` or `#` are
comments. A section may be introduced as `[group name]`, which YARP uses for lists of groups; both words then
name it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from grabbergui.core.errors import UsageError

_ENTRY = re.compile(r"([^\s=]+)(?:\s*=\s*|\s+|$)(.*)")
"""`key value`, and `key = value` for those used to other dialects."""
MAX_BYTES = 1024 * 1024
"""A configuration longer than this is something else."""


@dataclass
class Section:
    """The keys of one section, in order."""

    name: str
    "Empty for what stands before the first section."
    values: dict[str, str] = field(default_factory=dict)


def parse(text: str, where: str = "configuration") -> dict[str, Section]:
    """Read a file's text. Raises UsageError naming `where` and the line."""
    if len(text) > MAX_BYTES:
        raise UsageError(f"{where}: {len(text)} bytes is too long for a configuration")
    sections = {"": Section("")}
    current = sections[""]
    for number, line in enumerate(text.splitlines(), 1):
        line = line.strip()
        if not line or line.startswith(("//", "#", ";")):
            continue
        if line.startswith("["):
            if not line.endswith("]") or not line[1:-1].strip():
                raise UsageError(f"{where}, line {number}: '{line}' is no section; write [name]")
            name = " ".join(line[1:-1].split())
            current = sections.setdefault(name, Section(name))
            continue
        match = _ENTRY.fullmatch(line)
        if not match:
            raise UsageError(f"{where}, line {number}: '{line}' has no key; write: key value")
        current.values[match[1]] = _unquoted(match[2])
    return sections


def _unquoted(value: str) -> str:
    if len(value) >= 2 and value[0] == value[-1] and value[0] in "\"'":
        return value[1:-1]
    return value
