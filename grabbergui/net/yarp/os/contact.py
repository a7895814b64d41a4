"""Contacts: where a port is, as the name server registers it."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

_LINE = re.compile(r"registration name (\S+) ip (\S+) port (\d{1,5}) type (\S+)")


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


def contacts(lines: Iterable[str]) -> list[Contact]:
    """Return the registrations among the lines of an answer."""
    return [contact for contact in map(Contact.decode, lines) if contact]
