"""A small name server for machines without YARP: `yarp name`, `yarp connect` and `yarp read` use it.

It keeps names in memory only. Like YARP's it listens on one TCP port, speaks the line protocol, and is a
port itself, so that it can be pinged and asked in text or binary. `NameDatabase` does no I/O.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from grabbergui.config.allowed_addresses import EVERYBODY, AllowedAddresses
from grabbergui.core.errors import GrabberError, TransportError
from grabbergui.net.yarp.os import sockets
from grabbergui.net.yarp.os.admin import PortCommands
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.bottle_text import quoted
from grabbergui.net.yarp.os.configuration import (
    DEFAULT_HOST,
    DEFAULT_NAMESPACE,
    DEFAULT_PORT,
    authentication_key,
)
from grabbergui.net.yarp.os.contact import Contact, contacts
from grabbergui.net.yarp.os.inputs import Reply, Request
from grabbergui.net.yarp.os.name_client import END, PREFIX, NameClient
from grabbergui.net.yarp.os.port import Port
from grabbergui.net.yarp.os.target import PORT_NAME_LIMIT
from grabbergui.net.yarp.os.values import word
from grabbergui.net.yarp.os.web_page import encode_page

PORTS_LIMIT: Final = 5_000
"""Largest number of registered ports; YARP has no limit. Listing that many takes about 20 ms."""

ASKER_LIMIT: Final = 4_000
"""Largest number of ports registered from one address, so that names are left for others."""

PROPERTY_BYTES: Final = 4096
"""Largest size of all properties of one port."""
_WORD_LIMIT: Final = 255
"""Characters of a host's or carrier's name."""

_ANY: Final = ("...", "-1", "0", "")
_FALLBACK: Final = Contact("fallback", "224.2.1.1", 10000, "mcast")

_HELP: Final = (
    "Here are some ways to use the name server:",
    "+ help",
    "+ list [$prefix]",
    "+ register $portname",
    "+ register $portname $carrier $ipAddress $portNumber",
    "  (if you want a field set automatically, write '...')",
    "+ unregister $portname",
    "+ query $portname",
    "+ set $portname $property $value",
    "+ get $portname $property",
    "+ check $portname $property",
    "+ route $port1 $port2",
    "+ runners",
    "  (to get a list of the yarprun ports)",
)
log = logging.getLogger(__name__)


class NameDatabase:
    """Names and their contacts, in memory only."""

    def __init__(self, own: Contact) -> None:
        self.own = own
        "The server itself."
        self._contacts: dict[str, Contact] = {own.name: own, _FALLBACK.name: _FALLBACK}
        self._askers: dict[str, str] = {}
        self._properties: dict[str, dict[str, set[str]]] = {}
        self._own = (own.name, _FALLBACK.name)
        self._next_port = own.port + 2
        self._next_name = 1
        self._next_group = 1

    def answer(self, command: str, asker: str) -> str:
        """Return the reply to one command, line ends included; `asker` is the sender's address."""
        words = command.split()
        if words[:1] == ["bot"]:
            return _as_text(self.bot(words[1:], asker)) + "\r\n"
        if words[:1] == ["announce"]:
            return "[ok]\r\n"
        lines = self._lines(words, asker) if words else []
        return "".join(f"{line}\r\n" for line in (*lines, END))

    def _lines(self, words: list[str], asker: str) -> list[str]:
        verb, *arguments = words
        first, second, third = [*arguments, "", "", ""][:3]
        match verb:
            case "register":
                contact = self._register(arguments, asker)
                return [contact.encode()] if contact else []
            case "unregister":
                self._unregister(first)
            case "query":
                return [self._contacts[first].encode()] if first in self._contacts else []
            case "list":
                return [contact.encode() for contact in self._list(first)]
            case "set" if first in self._contacts and second:
                return self._set(first, second, arguments[2:])
            case "get" if first in self._contacts and second:
                return [self._shown(first, second)]
            case "check" if first in self._contacts and second:
                present = third in self._properties.get(first, {}).get(second, ())
                return [f"port {first} property {second} value {third} present {str(present).lower()}"]
            case "route":
                return [f"port {first} route {second} = tcp:/{second}"]
            case "gc":
                return ["garbage collection done."]
            case "help":
                return list(_HELP)
        return []

    def _register(self, arguments: list[str], asker: str) -> Contact | None:
        name, carrier, host, port = [*arguments, "...", "...", "...", "..."][:4]
        if name in self._own:  # remains ours; the answer contains its address
            return self._contacts[name]
        if not arguments or (name != "..." and not name.startswith("/")):
            return None
        if len(name) > PORT_NAME_LIMIT or len(carrier) > _WORD_LIMIT or len(host) > _WORD_LIMIT:
            return None
        if name not in self._contacts and self._full(asker):
            return None
        if name == "...":
            name = f"/tmp/port/{self._next_name}"
            self._next_name += 1
        carrier = "tcp" if carrier in _ANY else carrier
        if host in _ANY:
            host = self._group() if carrier == "mcast" else asker
        number = int(port) if port.isascii() and port.isdigit() and len(port) < 6 else 0
        contact = Contact(name, host, number if 0 < number < 65536 else self._port(), carrier)
        self._contacts[name] = contact
        self._askers[name] = asker
        self._properties.pop(name, None)
        return contact

    def _full(self, asker: str) -> bool:
        """Return whether the limit of names is reached, for all or for this address."""
        if len(self._contacts) < ASKER_LIMIT:
            return False
        return len(self._contacts) >= PORTS_LIMIT or list(self._askers.values()).count(asker) >= ASKER_LIMIT

    def _unregister(self, name: str) -> None:
        if name not in self._own:
            for book in (self._contacts, self._askers, self._properties):
                book.pop(name, None)

    def _port(self) -> int:
        """Return an unassigned port number."""
        taken = {contact.port for contact in self._contacts.values()}
        while True:
            number, self._next_port = self._next_port, self._next_port + 1
            if self._next_port > 65535:
                self._next_port = 1025
            if number not in taken:
                return number

    def _group(self) -> str:
        number, self._next_group = self._next_group, self._next_group % 250 + 1
        return f"224.1.1.{number}"

    def _list(self, prefix: str) -> list[Contact]:
        below = prefix.rstrip("/") + "/"
        names = sorted(self._contacts)
        return [
            self._contacts[name] for name in names if not prefix or name == prefix or name.startswith(below)
        ]

    def _set(self, name: str, key: str, values: list[str]) -> list[str]:
        keys = self._properties.setdefault(name, {})
        size = sum(len(word) for other, words in keys.items() if other != key for word in (other, *words))
        if size + sum(map(len, (key, *values))) <= PROPERTY_BYTES:
            keys[key] = set(values)
        return [self._shown(name, key)]

    def _shown(self, name: str, key: str) -> str:
        values = sorted(self._properties.get(name, {}).get(key, ()))
        return f"port {name} property {key} = {' '.join(values)}"

    def bot(self, words: list[str], asker: str) -> list[Contact] | Contact | None:
        """Carry out a `bot` command; return a list's contacts, or the one asked for, None if not known."""
        verb, name = [*words, "", ""][:2]
        if verb == "list":
            return self._list(name)
        if verb == "register":
            return self._register(words[1:], asker)
        contact = self._contacts.get(name)
        if verb == "unregister":
            self._unregister(name)
        return contact


def _as_text(found: list[Contact] | Contact | None) -> str:
    """Return the reply to a `bot` command as a Bottle's text; directly, since lists are long."""
    if isinstance(found, list):
        return " ".join(("ports", *(f"({_as_text(contact)})" for contact in found)))
    if found is None:
        return 'port (error -2 "port not known")'
    name, host, carrier = map(quoted, (found.name, found.host, found.carrier))
    return f"port (name {name}) (ip {host}) (port_number {found.port}) (carrier {carrier})"


def _as_bottle(found: list[Contact] | Contact | None) -> Bottle:
    """Return the same reply in binary form."""
    if isinstance(found, list):
        return Bottle(["ports", *map(_as_bottle, found)])
    if found is None:
        return Bottle(["port", ["error", -2, "port not known"]])
    name, host = Bottle(["name", found.name]), Bottle(["ip", found.host])
    port, carrier = Bottle(["port_number", found.port]), Bottle(["carrier", found.carrier])
    return Bottle(["port", name, host, port, carrier])


class NameServer(Port):
    """Serves names until closed. Any thread."""

    sends = False
    limit = 1 << 16
    obeys_environment = False

    def __init__(
        self,
        host: str = DEFAULT_HOST,
        port: int = DEFAULT_PORT,
        *,
        namespace: str = DEFAULT_NAMESPACE,
        allowed: AllowedAddresses = EVERYBODY,
    ) -> None:
        """Listen at `host`, 0.0.0.0 for all addresses of this machine. Port 0 means any free one."""
        super().__init__(namespace, bind=host, port=port, allowed=allowed)
        self.key = authentication_key()
        self.commands = _Commands(self)
        self._database_lock = threading.Lock()
        self._database: NameDatabase | None = None

    def open(self) -> None:
        """Start. Raises TransportError where the port is taken."""
        try:
            super().open()
        except TransportError as error:
            if self._runs_already():
                host, port = self._address
                raise TransportError(
                    f"a YARP name server runs at {host}:{port} already: use that one, or choose another port"
                ) from error
            raise
        log.info("name server %s at %s:%d", self.name, self.contact.host, self.contact.port)

    def _runs_already(self) -> bool:
        """Return whether a name server answers at our address."""
        server = Contact(self.name, *self._address)
        try:
            return NameClient(server, self.key).query(self.name).name == self.name
        except GrabberError:
            return False

    def _prepare(self) -> None:
        host = self.contact.host
        if host in ("0.0.0.0", "::"):
            host = _outward_address()
        self._database = NameDatabase(Contact(self.name, host, self.contact.port))

    def ask(self, command: str, asker: str) -> str:
        """Return the answer to one command, line ends included. `asker` is the IP address of the peer."""
        with self._open_database() as database:
            return database.answer(command, asker)

    @contextmanager
    def _open_database(self) -> Iterator[NameDatabase]:
        with self._database_lock:
            assert self._database, "the server was not opened"
            yield self._database

    def deliver(self, request: Request) -> Reply:
        """Answer a request in text or binary form: `bot` with a Bottle, all others with plain text."""
        items = [word(item) or str(item) for item in request.bottle()]
        if items[:1] == [PREFIX.strip()]:
            del items[0]
        asker = request.info.address[0]
        if items[:1] != ["bot"]:
            return self.ask(" ".join(items), asker)
        with self._open_database() as database:
            return _as_bottle(database.bot(items[1:], asker))


class _Commands(PortCommands):
    """Commands of a port, and requests to the name server in the same forms."""

    def __init__(self, server: NameServer) -> None:
        super().__init__(server, images=False)
        self._server = server

    def line(self, command: str) -> list[str]:
        """Answer one line, which may be a request to the name server."""
        if command.startswith(PREFIX):
            return self._ask(command.removeprefix(PREFIX))
        return super().line(command)

    def page(self) -> bytes:
        """Return a page with all registered names."""
        known = contacts(self._ask("list"))
        lines = [f"{one.name} at {one.carrier}://{one.host}:{one.port}/" for one in known]
        return encode_page(f"Name server {self._server.name}", lines)

    def answer_name_query(self, line: str, asker: str) -> str:
        """Answer a line of YARP's own name client."""
        return self._server.ask(line.removeprefix(PREFIX), asker)

    def _ask(self, command: str) -> list[str]:
        return self._server.ask(command, self._server.contact.host).splitlines()


def _outward_address() -> str:
    try:
        return sockets.local_address_towards("192.0.2.1", 9)
    except TransportError:
        return "127.0.0.1"
