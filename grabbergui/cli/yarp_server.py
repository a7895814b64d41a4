"""YARP's name server as a command, and within `serve` and `simulate-teo`."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from grabbergui.cli.parsing import port
from grabbergui.cli.process import stop_on_signals
from grabbergui.config import EVERYBODY, AllowedAddresses
from grabbergui.core.errors import UsageError

if TYPE_CHECKING:
    from grabbergui.net.yarp.os.name_client import NameClient

DEFAULT = "127.0.0.1:10000"
"""The default address of our name server."""


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser(
        "yarp-server", help="run a small YARP name server", example="grabbergui yarp-server --host 0.0.0.0"
    )
    parser.add_argument(
        "--host", default="127.0.0.1", help="where to listen; 0.0.0.0 for everybody (127.0.0.1)"
    )
    parser.add_argument("--port", type=port, default=10000, help="its TCP port; 0 takes a free one (10000)")
    parser.add_argument("--namespace", default="/root", help="the server's own name (/root)")
    parser.add_argument(
        "--allow",
        action="append",
        default=[],
        metavar="ADDRESS",
        help="answer only this address or network, as 10.0.0.0/24; repeatable",
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from grabbergui.net.yarp.os.name_server import NameServer

    server = NameServer(
        options.host,
        options.port,
        namespace=options.namespace,
        allowed=AllowedAddresses.parse(options.allow),
    )
    with stop_on_signals() as stop:
        server.open()
        try:
            contact = server.contact
            print(f"YARP name server {contact.name} is at {contact.host}:{contact.port}", flush=True)
            stop.wait()
        finally:
            server.close()
    return 0


def add_name_server_options(parser: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:
    """Add `--with-name-server` and `--nameserver`."""
    parser.add_argument("--with-name-server", action="store_true", help=f"run one too, at {DEFAULT}")
    parser.add_argument(
        "--nameserver",
        metavar="HOST:PORT",
        help="the name server (YARP's configuration), or where ours is to listen",
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
    host, _, port = (address or DEFAULT).rpartition(":")
    if not host or not (port.isascii() and port.isdigit()) or int(port) > 0xFFFF:
        raise UsageError(f"--nameserver {address}: write HOST:PORT")
    server = NameServer(host, int(port), allowed=allowed)
    server.open()
    try:
        contact = server.contact
        print(f"YARP name server {contact.name} is at {contact.host}:{contact.port}", flush=True)
        yield NameClient.find(f"{contact.host}:{contact.port}")
    finally:
        server.close()
