"""How a source is named everywhere: `sim:`, `gige:192.168.0.10`, `yarp:/grabber?carrier=mjpeg`."""

from __future__ import annotations

import ipaddress
import re
from dataclasses import dataclass, field
from urllib.parse import parse_qsl, quote, unquote, urlencode

from grabbergui.core.errors import UsageError

SIMULATED = "sim:"
"""The camera that is always there."""

_SCHEME = re.compile(r"[a-z][a-z0-9+.-]*", re.ASCII)
_PLAIN = "/:@,;+=~!$&'()*[]#"
"Signs that a name keeps as they are; a question mark, a blank or a percent sign would be misread."


@dataclass(frozen=True)
class SourceUri:
    """A kind of source, which one of that kind, and options."""

    scheme: str
    "`sim`, `gige`, `u3v`, `gentl`, `aravis`, `yarp`, `ros2`, `file`."
    name: str = ""
    "An address, serial number, port or topic; empty means the first found."
    options: dict[str, str] = field(default_factory=dict)

    @classmethod
    def parse(cls, text: str) -> SourceUri:
        """Read a URI as a user types it. Raises UsageError."""
        scheme, colon, rest = text.strip().partition(":")
        scheme = scheme.lower()
        if not colon or not _SCHEME.fullmatch(scheme):
            raise UsageError(f"'{text}' is no source; write its kind first, as in sim: or gige:192.168.0.10")
        # Two slashes are what people type out of habit; one begins a YARP port or a ROS topic.
        name, _, query = rest.removeprefix("//").partition("?")
        if query and "=" not in query:
            raise UsageError(f"'{text}': write options as ?name=value&name=value")
        return cls(scheme, unquote(name), dict(parse_qsl(query, keep_blank_values=True)))

    def __str__(self) -> str:
        query = "?" + urlencode(self.options) if self.options else ""
        slashes = "//" if self.name.startswith("//") else ""  # parsing takes two away
        return f"{self.scheme}:{slashes}{quote(self.name, safe=_PLAIN)}{query}"

    def option(self, name: str, default: str = "") -> str:
        """One option's text."""
        return self.options.get(name, default)


def is_ip_address(name: str) -> bool:
    """Whether a source's name is an IPv4 address, rather than a serial number or the like."""
    try:
        ipaddress.IPv4Address(name)
    except ValueError:
        return False
    return True
