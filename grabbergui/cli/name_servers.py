"""`yarp-server`, and the YARP name server that a command needs: found, or run beside it."""

from __future__ import annotations

import argparse
import logging
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from grabbergui.cli.arguments import port
from grabbergui.cli.process import stop_on_signals
from grabbergui.config.allowed_addresses import EVERYBODY, AllowedAddresses
from grabbergui.core.errors import GrabberError, UsageError
from grabbergui.core.visible_text import print_line

if TYPE_CHECKING:
    from grabbergui.net.yarp.os.contact import Contact
    from grabbergui.net.yarp.os.name_client import NameClient
    from grabbergui.net.yarp.os.name_server import NameServer

log = logging.getLogger(__name__)
_NAME_SERVER = "127.0.0.1:10000"
"""The default address of our name server."""


def add_commands(commands: Any) -> None:
    """Add the parser."""
    parser = commands.add_parser(
        "yarp-server", help="run a small YARP name server", example="grabbergui yarp-server --host 0.0.0.0"
    )
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        help="the address to listen on; 0.0.0.0 for the whole network (127.0.0.1)",
    )
    parser.add_argument(
        "--port", type=port, default=10000, help="the TCP port to listen on; 0 takes a free one (10000)"
    )
    parser.add_argument("--namespace", default="/root", help="the server's own name (/root)")
    parser.add_argument(
        "--allow",
        action="append",
        default=[],
        metavar="ADDRESS",
        help="serve only this address or network, such as 10.0.0.0/24; repeatable",
    )
    parser.set_defaults(run=_serve_names)


def _serve_names(options: argparse.Namespace) -> int:
    from grabbergui.net.yarp.os.name_server import NameServer

    server = NameServer(
        options.host,
        options.port,
        namespace=options.namespace,
        allowed=AllowedAddresses.parse(options.allow),
    )
    with stop_on_signals() as stop, _running(server):
        stop.wait()
    return 0


def add_name_server_options(parser: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:
    """Add `--with-name-server` and `--nameserver`."""
    parser.add_argument(
        "--with-name-server", action="store_true", help=f"also run a YARP name server, at {_NAME_SERVER}"
    )
    parser.add_argument(
        "--nameserver",
        metavar="HOST:PORT",
        help="the name server (YARP's configuration), or the address of the one to run",
    )


@contextmanager
def named_server(address: str, *, ours: bool, allowed: AllowedAddresses = EVERYBODY) -> Iterator[NameClient]:
    """The name server at `HOST:PORT`, else the configured one.

    With `ours` one that runs within the block and answers the `allowed` addresses.

    Raises UsageError for an address that is none, SourceUnavailableError and TransportError.
    """
    from grabbergui.net.yarp.os.name_client import NameClient
    from grabbergui.net.yarp.os.name_server import NameServer

    if not ours:
        yield NameClient.find(address)
        return
    host, _, port = (address or _NAME_SERVER).rpartition(":")
    if not host or not (port.isascii() and port.isdigit()) or int(port) > 0xFFFF:
        raise UsageError(f"--nameserver {address}: write HOST:PORT")
    with _running(NameServer(host, int(port), allowed=allowed)) as contact:
        yield NameClient.find(f"{contact.host}:{contact.port}")


@contextmanager
def _running(server: NameServer) -> Iterator[Contact]:
    """Run a name server within the block; print and yield where it is."""
    server.open()
    try:
        contact = server.contact
        print_line(f"YARP name server {contact.name} is at {contact.host}:{contact.port}", flush=True)
        _warn_of_another(contact)
        yield contact
    finally:
        server.close()


def _warn_of_another(ours: Contact) -> None:
    """Warn if YARP's configuration names another name server, where all other programs look for ports."""
    from grabbergui.net.yarp.os import sockets
    from grabbergui.net.yarp.os.configuration import name_server

    with suppress(GrabberError, OSError):
        configured = name_server()
        if configured is None:
            return
        local = ("127.0.0.1", *sockets.local_addresses())
        if configured.port != ours.port or socket.gethostbyname(configured.host) not in local:
            log.warning(
                "YARP's configuration names %s:%d, so other programs do not see this name server's ports; "
                "`yarp conf %s %d` names it",
                *configured.address,
                *ours.address,
            )
