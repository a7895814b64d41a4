"""Where to connect to: a port's name, or an address with a carrier. No I/O."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

from grabbergui.core.errors import LocalProtocolError, UsageError
from grabbergui.net.yarp.os.carrier import modifiers_of

PORT_NAME_LIMIT: Final = 900
"""Characters of a port's name: with modifiers it still fits into a header."""

_PORT_NAME: Final = re.compile(r"/[^\s/]\S*")
_ADDRESS: Final = re.compile(r"/?(?:([\w+.]+):)?//?([\w.\-]+|\[[0-9a-fA-F:]+\]):(\d{1,5})/?", re.ASCII)


@dataclass(frozen=True)
class Target:
    """The target of a connection: `/reader`, `udp://reader`, `fast_tcp+recv.bayer://reader`."""

    name: str
    "The port's name, or `//HOST:PORT` for one reached without a name server."
    carrier: str = "tcp"
    "With its modifiers."

    @classmethod
    def parse(cls, text: str, carrier: str = "") -> Target:
        """Parse YARP's spellings; an explicit `carrier` takes precedence. Raises LocalProtocolError."""
        literal = literal_address(text)
        if literal:
            used, host, port = literal
            return cls(f"//{host}:{port}", carrier or used)
        prefix, found, rest = text.removeprefix("/").partition(":/")
        if found and "/" not in prefix:
            # The second of the two slashes begins the name; some users type three.
            return cls("/" + rest.lstrip("/"), carrier or prefix)
        if not _PORT_NAME.fullmatch(text):
            raise LocalProtocolError(f"'{text}' names no port; names begin with / and have no blanks")
        return cls(text, carrier or "tcp")

    @property
    def modifiers(self) -> dict[str, str]:
        """Those of the carrier."""
        return modifiers_of(self.carrier)

    def sender(self, name: str) -> str:
        """Return the sender's name with the modifiers, as the receiver wants to see them."""
        return " ".join((name, *(f"({key} {value or '1'})" for key, value in self.modifiers.items())))


def literal_address(text: str) -> tuple[str, str, int] | None:
    """Return carrier, host and port in `tcp://10.0.0.2:10003/`, which needs no name server; else None."""
    match = _ADDRESS.fullmatch(text)
    if not match or not 0 < int(match[3]) < 65536:
        return None
    return match[1] or "tcp", match[2].strip("[]"), int(match[3])


def check_port_name(name: str) -> str:
    """Return the name, if a port may have it. Raises UsageError."""
    if not _PORT_NAME.fullmatch(name) or len(name) > PORT_NAME_LIMIT or '"' in name:
        raise UsageError(f"'{name}' cannot name a port; names begin with / and have no blanks")
    return name
