"""The command line: `grabbergui [SOURCE]` opens the window, `grabbergui COMMAND …` does the rest.

One file per family of commands; each adds its parsers in `add_commands` and sets `run` to the function that
does the work and returns the exit code.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence

from grabbergui import __version__
from grabbergui.cli import (
    doctor,
    events,
    features,
    gige,
    grab,
    gui,
    logs,
    record,
    serve,
    servo,
    settings,
    simulate,
    sources,
    terminal,
    yarp_server,
)
from grabbergui.core.errors import GrabberError, UsageError

EXIT_FAILURE = 1
EXIT_USAGE = 2
EXIT_INTERRUPTED = 130

_FAMILIES = (
    gui, sources, features, events, settings, grab, record, terminal,
    serve, simulate, gige, servo, yarp_server, doctor,
)  # fmt: skip


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code: 0, 1 for what failed, 2 for wrong usage."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    parser, commands = _parser()
    # A bare source, or only options of the window, mean the window.
    place = _command_place(arguments)
    first = arguments[place] if place < len(arguments) else ""
    if first not in commands and first not in ("-h", "--help", "--version"):
        arguments.insert(place, "gui")
    options = parser.parse_args(arguments)
    logs.set_up(options.log_level, options.log_format)
    try:
        return int(options.run(options))
    except UsageError as error:
        print(f"grabbergui: {error}", file=sys.stderr)
        return EXIT_USAGE
    except GrabberError as error:
        print(f"grabbergui: {error}", file=sys.stderr)
        return EXIT_FAILURE
    except OSError as error:
        if isinstance(error, BrokenPipeError):
            # Whoever read our output has had enough; nothing may be written at exit either.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 0
        print(f"grabbergui: {error}", file=sys.stderr)
        return EXIT_FAILURE
    except KeyboardInterrupt:
        return EXIT_INTERRUPTED


def _parser() -> tuple[argparse.ArgumentParser, frozenset[str]]:
    parser = argparse.ArgumentParser(
        prog="grabbergui",
        description="Tune GenICam cameras live. Without a command: the window on SOURCE (sim:).",
        epilog="A SOURCE is sim: (the built-in simulated camera), gige: (the first found), "
        "gige:192.168.0.10, gige:SERIAL or gige:MAC. `grabbergui list` shows those that can be seen.",
    )
    parser.add_argument("--version", action="version", version=f"grabbergui {__version__}")
    _add_log_options(parser)
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for family in _FAMILIES:
        family.add_commands(commands)
    for command in commands.choices.values():
        # Also after the command, where people look for it; there it must not undo what stood before.
        _add_log_options(command, argument_default=argparse.SUPPRESS)
    return parser, frozenset(commands.choices)


def _add_log_options(parser: argparse.ArgumentParser, argument_default: str = "") -> None:
    parser.add_argument(
        "--log-level",
        choices=("debug", "info", "warning", "error"),
        default=argument_default or "warning",
        help="how much to tell on stderr (warning)",
    )
    parser.add_argument(
        "--log-format",
        choices=logs.FORMATS,
        default=argument_default or "text",
        help="lines for people, or a JSON object a line (text)",
    )


def _command_place(arguments: list[str]) -> int:
    """Behind the options that belong to every command."""
    place = 0
    while place < len(arguments):
        if arguments[place] in ("--log-level", "--log-format"):
            place += 2
        elif arguments[place].startswith(("--log-level=", "--log-format=")):
            place += 1
        else:
            break
    return place
