"""Asks a name server: where ports are, and that ours be known."""

from __future__ import annotations

import os
import time

from grabbergui.core.errors import (
    RemoteProtocolError,
    ResourceExhaustedError,
    SourceNotFoundError,
    SourceUnavailableError,
    TransportError,
)
from grabbergui.net.yarp.os import configuration, names, sockets
from grabbergui.net.yarp.os.carrier import NAME_SER, Header, Message, Reply
from grabbergui.net.yarp.os.connection import Connection
from grabbergui.net.yarp.os.link import Link
from grabbergui.net.yarp.os.names import DEFAULT_HOST, DEFAULT_PORT, Contact, check_port_name, literal_contact

Lines = list[str]
Contacts = list[Contact]
TIMEOUT = 5.0
_ELSEWHERE = (
    ", or say where it is, as none is configured: `yarp conf HOST PORT`, --nameserver HOST:PORT, or "
    "?nameserver=HOST:PORT behind a source"
)


class NameClient:
    """One name server. Any thread; every question is a connection of its own.

    All methods raise SourceUnavailableError where no name server answers, ResourceExhaustedError where this
    process has no descriptor left to ask it.
    """

    def __init__(self, server: Contact, key: bytes | None = None, *, configured: bool = True) -> None:
        self.server = server
        self.key = key
        "Of `auth.conf`; ports use it too."
        self._configured = configured

    @classmethod
    def find(cls, address: str = "") -> NameClient:
        """The server at `HOST:PORT`, or else the one that YARP's configuration names.

        Without a configuration it is looked for where one of ours listens unless told otherwise. Raises
        UsageError for a bad address.
        """
        server = configuration.parse_address(address) if address else configuration.name_server()
        key = configuration.authentication_key()
        if server is None:
            ours = Contact(configuration.namespace(), DEFAULT_HOST, DEFAULT_PORT)
            return cls(ours, key, configured=False)
        return cls(server, key)

    def register(self, name: str, carrier: str = "tcp", ip: str | None = None, port: int = 0) -> Contact:
        """Make a port known; the server chooses what is left open. Replaces what had the name before."""
        ip = ip or os.environ.get("YARP_IP") or "..."
        return self._one(f"register {_checked(name)} {carrier} {ip} {port or '...'}")

    def query(self, name: str) -> Contact:
        """Where a port is; `tcp://HOST:PORT/` needs no server. Raises SourceNotFoundError."""
        literal = literal_contact(name)
        if literal:
            return literal
        found = names.contacts(self.ask(f"query {check_port_name(name)}"))
        if not found:
            raise SourceNotFoundError(f"the name server at {self._where} knows no port {name}")
        return found[0]

    def unregister(self, name: str) -> None:
        """Forget a port, known or not."""
        self.ask(f"unregister {check_port_name(name)}")

    def list(self, prefix: str = "") -> Contacts:
        """All ports, or those below a prefix, in alphabetic order."""
        return names.contacts(self.ask(f"list {prefix}".strip()))

    def set_property(self, name: str, key: str, *values: str) -> None:
        """Note something about a port, `accepts` for instance; for people and tools."""
        self.ask(" ".join(("set", check_port_name(name), key, *values)))

    def announce(self, name: str) -> None:
        """Say that a registered port is listening, so that kept connections to it are made."""
        self.ask(f"announce {check_port_name(name)}")

    def ask(self, command: str) -> Lines:
        """Any command; the lines of the answer, without the one that ends it."""
        try:
            sock = sockets.connect(self.server.address, TIMEOUT, self.key)
        except ResourceExhaustedError:
            raise
        except TransportError as error:
            hint = "" if self._configured else _ELSEWHERE
            raise SourceUnavailableError(
                f"no YARP name server at {self._where}; start `yarpserver` or `grabbergui yarp-server`, let "
                f"`serve` run one with --with-name-server{hint}"
            ) from error
        link = Link(sock, Connection(opener=True))
        try:
            link.send(Header(NAME_SER, ""))
            link.send(Message("d", text=f"{names.PREFIX}{command}"))
            answer = link.expect(Reply, time.monotonic() + TIMEOUT)
        except (TransportError, RemoteProtocolError) as error:
            raise SourceUnavailableError(
                f"the name server at {self._where} did not answer: {error}"
            ) from error
        finally:
            sock.close()
        return [line for line in answer.text.split("\r\n") if line != names.END]

    def _one(self, command: str) -> Contact:
        found = names.contacts(self.ask(command))
        if not found:
            raise SourceUnavailableError(f"the name server at {self._where} refused '{command}'")
        return found[0]

    @property
    def _where(self) -> str:
        return f"{self.server.host}:{self.server.port}"


def _checked(name: str) -> str:
    return name if name == "..." else check_port_name(name)
