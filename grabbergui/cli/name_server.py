"""The YARP name server that `--nameserver` and `--with-name-server` ask for."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from grabbergui.config.allowed_addresses import EVERYBODY, AllowedAddresses
from grabbergui.core.errors import UsageError

if TYPE_CHECKING:
    from grabbergui.net.yarp.os.name_client import NameClient

DEFAULT = "127.0.0.1:10000"
"""Where one of ours listens unless told otherwise."""


def add_options(parser: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:
    """`--with-name-server` and `--nameserver`."""
    parser.add_argument("--with-name-server", action="store_true", help=f"run one too, at {DEFAULT}")
    parser.add_argument(
        "--nameserver",
        metavar="HOST:PORT",
        help="the name server (YARP's configuration), or where ours is to listen",
    )


@contextmanager
def named(address: str, *, ours: bool, allowed: AllowedAddresses = EVERYBODY) -> Iterator[NameClient]:
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
