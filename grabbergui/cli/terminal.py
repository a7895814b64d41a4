"""`grabbergui terminal`: a camera by typed commands."""

from __future__ import annotations

import argparse
from typing import Any

from grabbergui.cli.opening import add_source, opened
from grabbergui.cli.stopping import stop_on_signals

EXIT_REFUSED = 1
"A line of a script was refused."


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser("terminal", help="type commands to a camera; `help` there lists them")
    add_source(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from grabbergui.terminal import console

    with stop_on_signals() as stop, opened(options.source, reading=True) as grabber:
        outcome = console.run(grabber, finished=stop.is_set)
    return EXIT_REFUSED if outcome.refused else 0
