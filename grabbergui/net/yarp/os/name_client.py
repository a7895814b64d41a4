"""Client of the name server: contacts of ports, its address, requests, and a thread that keeps a name."""

from __future__ import annotations

import ipaddress
import logging
import os
import re
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from grabbergui.config import config_folders, parse_ini
from grabbergui.core.errors import (
    RemoteProtocolError,
    ResourceExhaustedError,
    SourceNotFoundError,
    SourceUnavailableError,
    TransportError,
    UsageError,
)
from grabbergui.core.regular_files import read_bounded
from grabbergui.net.yarp.os import sockets
from grabbergui.net.yarp.os.carrier import NAME_SER, Header, Message, Reply, check_port_name, literal_address
from grabbergui.net.yarp.os.connection import Connection
from grabbergui.net.yarp.os.link import Link

log = logging.getLogger(__name__)

END = "*** end of message"
"""The line that ends every answer but those to `bot` and `announce`."""

PREFIX = "NAME_SERVER "
DEFAULT_HOST, DEFAULT_PORT = "127.0.0.1", 10000
DEFAULT_NAMESPACE = "/root"

_LINE = re.compile(r"registration name (\S+) ip (\S+) port (\d{1,5}) type (\S+)")


# -- contacts ------------------------------------------------------------------------------------
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


# -- YARP's configuration ------------------------------------------------------------------------
def namespace() -> str:
    """Return the namespace, which is also the name server's own name; the first of several."""
    words = (os.environ.get("YARP_NAMESPACE") or _read("yarp_namespace.conf")).split()
    return words[0] if words else DEFAULT_NAMESPACE


def name_server() -> Contact | None:
    """Return the name server that the configuration names. Raises UsageError if it names none properly."""
    name = namespace()
    file_name = "yarp.conf" if name == DEFAULT_NAMESPACE else _safe(name) + ".conf"
    text = _read(file_name)
    if not text.strip():
        return None
    if text.lstrip().startswith("["):
        section = _section(text, "name")
        host, port = section.get("host", ""), section.get("port", str(DEFAULT_PORT))
    else:
        host, port = [*text.split(), str(DEFAULT_PORT)][:2]
    try:
        return parse_address(f"{host}:{port}", name)
    except UsageError as error:
        problem = f"'{host} {port}' is no address of a name server; `yarp conf HOST PORT` writes one"
        raise UsageError(f"{_path(file_name)}: {problem}") from error


def parse_address(text: str, name: str = DEFAULT_NAMESPACE) -> Contact:
    """Return the server at `HOST`, `HOST:PORT` or `[HOST]:PORT`. Raises UsageError."""
    match = re.fullmatch(r"(\[[^\]]+\]|[^:\s]+)(?::(\d{1,5}))?", text.strip())
    port = int(match[2] or DEFAULT_PORT) if match else 0
    if not match or not 0 < port < 65536:
        raise UsageError(f"'{text}' is no address of a name server, write HOST:PORT")
    return Contact(name, match[1].strip("[]"), port)


def authentication_key() -> bytes | None:
    """Return the key of `auth.conf`; None where ports need none."""
    return _section(_read("auth.conf"), "auth").get("key", "").encode() or None


def require_authentication() -> None:
    """Raise UsageError if there is no key, so that no port is open to everybody."""
    if authentication_key() is None:
        folders = ", ".join(str(folder) for folder in config_folders())
        raise UsageError(
            "--require-authentication: no key; write a file auth.conf with the lines `[AUTH]` and "
            f"`key SECRET` into one of {folders}, on this machine and on every peer"
        )


_MAX_BYTES = 1 << 20
"Bytes of the largest file of YARP's configuration."


def _path(name: str) -> Path | None:
    """Return the place of a file of YARP's configuration. Raises SourceUnavailableError."""
    for path in (folder / name for folder in config_folders()):
        try:
            if path.is_file():
                return path
        except OSError as error:
            raise _unreadable(path, error) from error
    return None


def _read(name: str) -> str:
    """Return the text of a file of YARP's configuration; empty without one. Raises SourceUnavailableError."""
    path = _path(name)
    try:
        return read_bounded(path, _MAX_BYTES, "file of YARP").decode("utf-8", "replace") if path else ""
    except OSError as error:
        raise _unreadable(path, error) from error
    except UsageError as error:
        raise SourceUnavailableError(str(error)) from error


def _unreadable(path: Path | None, error: OSError) -> SourceUnavailableError:
    """Return the error to raise. A key that cannot be read must not mean that none is needed."""
    return SourceUnavailableError(f"{path} could not be read: {error.strerror or error}")


def _section(text: str, name: str) -> Mapping[str, str]:
    """Return a section's values, its name and keys in small letters."""
    for section in parse_ini(text, "YARP's configuration").values():
        if section.name.lower() == name:
            return {key.lower(): value for key, value in section.values.items()}
    return {}


# -- YARP's environment variables for the ports of a program --------------------------------------
def port_name(name: str) -> str:
    """Return the name of a port that the program calls `name`: YARP_RENAME_x, then YARP_PORT_PREFIX.

    For `/grabber/rpc` x is `grabber_rpc`. Raises UsageError for what names no port.
    """
    variables = {key: os.environ.get(key, "") for key in ("YARP_PORT_PREFIX", f"YARP_RENAME{_safe(name)}")}
    prefix, renamed = variables.values()
    try:
        return check_port_name(prefix + (renamed or name))
    except UsageError as error:
        causes = " and ".join(f"{key}={value}" for key, value in variables.items() if value)
        raise UsageError(f"{causes}: {error}" if causes else str(error)) from error


def port_number(name: str) -> int:
    """Return the TCP port for the port that the program calls `name`, 0 for any: YARP_PORTNUMBER_x."""
    variable = f"YARP_PORTNUMBER{_safe(name)}"
    text = os.environ.get(variable) or "0"
    number = int(text) if re.fullmatch(r"\d{1,5}", text, re.ASCII) else 65536
    if number > 65535:
        raise UsageError(f"{variable}={text} is no TCP port")
    return number


def registered_address() -> str:
    """Return the address under which to register ports if YARP_IP names one, otherwise an empty string.

    A beginning stands for this machine's first address with it. Raises UsageError.
    """
    wanted = os.environ.get("YARP_IP", "")
    if not wanted:
        return ""
    try:
        return str(ipaddress.ip_address(wanted))
    except ValueError:
        local = sockets.local_addresses()
    for address in local:
        if address.startswith(wanted):
            return address
    raise UsageError(f"YARP_IP={wanted} begins no address of this machine: {', '.join(local)}")


def _safe(name: str) -> str:
    """Return a name as it is part of variables and file names."""
    return re.sub(r"[^0-9A-Za-z]", "_", name)


# -- requests ------------------------------------------------------------------------------------
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
        "Of `auth.conf`; ports use it too."
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
            raise SourceUnavailableError(
                f"no YARP name server at {self._where}; start `yarpserver` or `grabbergui yarp-server`, let "
                f"`serve` run one with --with-name-server{hint}"
            ) from error
        link = Link(sock, Connection(opener=True))
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
