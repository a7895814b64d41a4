"""`grabbergui terminal`: a camera by typed commands."""

from __future__ import annotations

import argparse
from typing import Any

from grabbergui.cli.opening import add_source, opened


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser("terminal", help="type commands to a camera; `help` there lists them")
    add_source(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from grabbergui.terminal import console

    with opened(options.source, reading=True) as grabber:
        console.run(grabber)
    return 0
