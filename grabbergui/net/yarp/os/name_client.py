"""Client of the name server: contacts of ports, its address, requests, and a thread that keeps a name."""

from __future__ import annotations

import logging
import time

from grabbergui.core.errors import (
    NoNameServerError,
    RemoteProtocolError,
    ResourceExhaustedError,
    SourceNotFoundError,
    SourceUnavailableError,
    TransportError,
)
from grabbergui.net.yarp.os import sockets
from grabbergui.net.yarp.os.carrier import NAME_SER
from grabbergui.net.yarp.os.configuration import (
    DEFAULT_HOST,
    DEFAULT_PORT,
    authentication_key,
    name_server,
    namespace,
    parse_address,
)
from grabbergui.net.yarp.os.connection import YarpConnection
from grabbergui.net.yarp.os.contact import Contact, contacts
from grabbergui.net.yarp.os.events import Header, Message, Reply
from grabbergui.net.yarp.os.link import Link
from grabbergui.net.yarp.os.target import check_port_name, literal_address

log = logging.getLogger(__name__)

END = "*** end of message"
"""The line that ends every answer but those to `bot` and `announce`."""

PREFIX = "NAME_SERVER "


Lines = list[str]
Contacts = list[Contact]
TIMEOUT = 5.0
_ELSEWHERE = (
    ", or say where it is, as none is configured: `yarp conf HOST PORT`, --nameserver HOST:PORT, or "
    "?nameserver=HOST:PORT behind a source"
)


class NameClient:
    """One name server. Any thread; each request opens a connection.

    All methods raise SourceUnavailableError where no name server answers, ResourceExhaustedError where this
    process has no descriptor left to ask it.
    """

    def __init__(self, server: Contact, key: bytes | None = None, *, configured: bool = True) -> None:
        self.server = server
        self.key = key
        "Key from `auth.conf`; ports use it too."
        self._configured = configured

    @classmethod
    def find(cls, address: str = "") -> NameClient:
        """Return the server at `HOST:PORT`, or else the one that YARP's configuration names.

        Without a configuration it is looked for where ours listens by default. Raises UsageError for a bad
        address, SourceUnavailableError for a configuration that cannot be read.
        """
        server = parse_address(address) if address else name_server()
        key = authentication_key()
        if server is None:
            ours = Contact(namespace(), DEFAULT_HOST, DEFAULT_PORT)
            return cls(ours, key, configured=False)
        return cls(server, key)

    def register(self, name: str, carrier: str = "tcp", ip: str | None = None, port: int = 0) -> Contact:
        """Register a port, replacing an older one. The server chooses the parts of the contact not given."""
        return self._one(f"register {_checked(name)} {carrier} {ip or '...'} {port or '...'}")

    def query(self, name: str) -> Contact:
        """Return where a port is; `tcp://HOST:PORT/` needs no server. Raises SourceNotFoundError."""
        if literal := literal_address(name):
            carrier, host, port = literal
            return Contact(name, host, port, carrier)
        found = contacts(self.ask(f"query {check_port_name(name)}"))
        if not found:
            raise SourceNotFoundError(f"the name server at {self._where} knows no port {name}")
        return found[0]

    def unregister(self, name: str) -> None:
        """Forget a port, known or not."""
        self.ask(f"unregister {check_port_name(name)}")

    def list(self, prefix: str = "") -> Contacts:
        """Return all ports, or those below a prefix, in alphabetic order."""
        return contacts(self.ask(f"list {prefix}".strip()))

    def set_property(self, name: str, key: str, *values: str) -> None:
        """Store a property of a port, such as `accepts`; users and tools read it."""
        self.ask(" ".join(("set", check_port_name(name), key, *values)))

    def property_of(self, name: str, key: str) -> str:
        """Return a property of a port as display text; empty without one."""
        return " ".join(self.ask(f"get {check_port_name(name)} {key}")).partition(" = ")[2]

    def announce(self, name: str) -> None:
        """Report that a registered port listens, so that persistent connections to it are made."""
        self.ask(f"announce {check_port_name(name)}")

    def ask(self, command: str) -> Lines:
        """Send a command; return the lines of the answer without the last, which ends it."""
        try:
            sock = sockets.connect(self.server.address, TIMEOUT, self.key)
        except ResourceExhaustedError:
            raise
        except TransportError as error:
            hint = "" if self._configured else _ELSEWHERE
            missing = NoNameServerError(
                f"no YARP name server at {self._where}; start `yarpserver` or `grabbergui yarp-server`, let "
                f"`serve` run one with --with-name-server{hint}"
            )
            missing.where = self._where
            raise missing from error
        link = Link(sock, YarpConnection(opener=True))
        try:
            link.send(Header(NAME_SER, ""))
            link.send(Message("d", text=f"{PREFIX}{command}"))
            answer = link.expect(Reply, time.monotonic() + TIMEOUT)
        except (TransportError, RemoteProtocolError) as error:
            raise SourceUnavailableError(
                f"the name server at {self._where} did not answer: {error}"
            ) from error
        finally:
            sock.close()
        return [line for line in answer.text.split("\r\n") if line != END]

    def _one(self, command: str) -> Contact:
        found = contacts(self.ask(command))
        if not found:
            raise SourceUnavailableError(f"the name server at {self._where} refused '{command}'")
        return found[0]

    @property
    def _where(self) -> str:
        return f"{self.server.host}:{self.server.port}"


def _checked(name: str) -> str:
    return name if name == "..." else check_port_name(name)
