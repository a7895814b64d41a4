"""Contacts of ports, and the line protocol of the name server. No I/O."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace

from grabbergui.core.errors import LocalProtocolError, UsageError

END = "*** end of message"
"""The line that ends every answer but those to `bot` and `announce`."""

PREFIX = "NAME_SERVER "
DEFAULT_HOST, DEFAULT_PORT = "127.0.0.1", 10000
NAME_LIMIT = 900
"""Characters of a port's name: with modifiers it still fits into a header."""

_LINE = re.compile(r"registration name (\S+) ip (\S+) port (\d+) type (\S+)")
_PORT_NAME = re.compile(r"/[^\s/]\S*")
_ADDRESS = re.compile(r"/?(?:([\w+.]+):)?//?([\w.\-]+|\[[0-9a-fA-F:]+\]):(\d+)/?", re.ASCII)


@dataclass(frozen=True)
class Contact:
    """Address of a port."""

    name: str
    host: str
    port: int
    carrier: str = "tcp"

    @property
    def address(self) -> tuple[str, int]:
        """Host and port in the form that sockets take."""
        return self.host, self.port

    def encode(self) -> str:
        """Return the registration line."""
        return f"registration name {self.name} ip {self.host} port {self.port} type {self.carrier}"

    @classmethod
    def decode(cls, line: str) -> Contact | None:
        """Read a registration line; None for any other."""
        match = _LINE.match(line)
        if not match or not 0 < int(match[3]) < 65536:
            return None
        return cls(match[1], match[2], int(match[3]), match[4])


@dataclass(frozen=True)
class Target:
    """The target of a connection: `/reader`, `udp://reader`, `fast_tcp+recv.bayer://reader`."""

    name: str
    "The port's name, or `//HOST:PORT` for one reached without a name server."
    carrier: str = "tcp"
    "With its modifiers."

    @classmethod
    def parse(cls, text: str, carrier: str = "") -> Target:
        """Read it in YARP's spellings; an explicit `carrier` counts more. Raises LocalProtocolError."""
        literal = literal_contact(text)
        if literal:
            return cls(f"//{literal.host}:{literal.port}", carrier or literal.carrier)
        prefix, found, rest = text.removeprefix("/").partition(":/")
        if found and "/" not in prefix:
            # Of the two slashes the second begins the name; three are what a careful writer types.
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


def modifiers_of(carrier: str) -> dict[str, str]:
    """Return the modifiers of a carrier: {"recv": "bayer"} of `tcp+recv.bayer`."""
    return {key: value for key, _, value in (part.partition(".") for part in carrier.split("+")[1:])}


def check_port_name(name: str) -> str:
    """Return the name, if a port may have it. Raises UsageError."""
    if not _PORT_NAME.fullmatch(name) or len(name) > NAME_LIMIT or '"' in name:
        raise UsageError(f"'{name}' cannot name a port; names begin with / and have no blanks")
    return name


def literal_contact(text: str) -> Contact | None:
    """Return the contact in `tcp://10.0.0.2:10003/`, which needs no name server; None for names."""
    match = _ADDRESS.fullmatch(text)
    if not match or not 0 < int(match[3]) < 65536:
        return None
    return Contact(text, match[2].strip("[]"), int(match[3]), match[1] or "tcp")


def finished(lines: list[str]) -> bool:
    """Return whether an answer is complete after these lines."""
    return bool(lines) and (lines[-1].startswith(("*", "[")) or lines[0].startswith(("port (", "ports")))


def contacts(lines: Iterable[str]) -> list[Contact]:
    """Return the registrations among the lines of an answer."""
    return [contact for contact in map(Contact.decode, lines) if contact]


def with_name(contact: Contact, name: str) -> Contact:
    """Return the same place under another name."""
    return replace(contact, name=name)
