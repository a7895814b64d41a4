"""A small name server for machines without YARP: `yarp name`, `yarp connect` and `yarp read` use it.

It keeps names in memory only. Like YARP's it listens on one TCP port, speaks the line protocol, and is a
port itself, so that it can be pinged and asked in text or binary.
"""

from __future__ import annotations

import logging
import threading

from grabbergui.config.allowed_addresses import EVERYBODY, AllowedAddresses
from grabbergui.core.errors import TransportError
from grabbergui.net.yarp.os import sockets, web_page
from grabbergui.net.yarp.os.admin import PortCommands
from grabbergui.net.yarp.os.configuration import DEFAULT_NAMESPACE, authentication_key
from grabbergui.net.yarp.os.name_database import NameDatabase
from grabbergui.net.yarp.os.names import DEFAULT_HOST, DEFAULT_PORT, PREFIX, Contact, contacts
from grabbergui.net.yarp.os.port import Port
from grabbergui.net.yarp.os.request import Reply, Request
from grabbergui.net.yarp.os.values import word

log = logging.getLogger(__name__)


class NameServer(Port):
    """Serves names until closed. Any thread."""

    sends = False

    def __init__(
        self,
        host: str = DEFAULT_HOST,
        port: int = DEFAULT_PORT,
        *,
        namespace: str = DEFAULT_NAMESPACE,
        allowed: AllowedAddresses = EVERYBODY,
    ) -> None:
        """Listen at `host`, 0.0.0.0 for all addresses of this machine. Port 0 means any free one."""
        super().__init__(namespace, bind=host, port=port, limit=1 << 16, allowed=allowed)
        self.key = authentication_key()
        self.commands = _Commands(self)
        self._database_lock = threading.Lock()
        self._database: NameDatabase | None = None

    def open(self) -> None:
        """Start. Raises TransportError where the port is taken."""
        super().open()
        log.info("name server %s at %s:%d", self.name, self.contact.host, self.contact.port)

    def _prepare(self) -> None:
        host = self.contact.host
        if host in ("0.0.0.0", "::"):
            host = _outward_address()
        self._database = NameDatabase(Contact(self.name, host, self.contact.port))

    def ask(self, command: str, asker: str) -> str:
        """Return the answer to one command, line ends included. `asker` is the IP address of the peer."""
        with self._database_lock:
            assert self._database, "the server was not opened"
            return self._database.answer(command, asker)

    def deliver(self, request: Request) -> Reply:
        """Answer a request in text or binary form, both with plain text."""
        items = [word(item) or str(item) for item in request.bottle()]
        if items[:1] == [PREFIX.strip()]:
            del items[0]
        return self.ask(" ".join(items), request.info.address[0])


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
        return web_page.encode_page(f"Name server {self._server.name}", lines)

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
