"""`grabbergui yarp-server`: a YARP name server for desks without YARP."""

from __future__ import annotations

import argparse
from typing import Any

from grabbergui.cli.numbers import port
from grabbergui.cli.stopping import stop_on_signals
from grabbergui.config.allowed_addresses import AllowedAddresses


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser("yarp-server", help="run a small YARP name server")
    parser.add_argument(
        "--host", default="127.0.0.1", help="where to listen; 0.0.0.0 for everybody (127.0.0.1)"
    )
    parser.add_argument("--port", type=port, default=10000, help="0 takes a free one (10000)")
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
