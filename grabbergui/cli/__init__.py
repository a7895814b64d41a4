"""The command line: `grabbergui [SOURCE]` opens the window, `grabbergui COMMAND …` does the rest.

One file per family of commands; each adds its parsers in `add_commands` and sets `run` to the function that
does the work and returns the exit code. `guests` finds the commands of other packages. Help has an example,
keeps to the terminal's width, and ends by itself.
"""

from __future__ import annotations

import argparse
import contextlib
import difflib
import importlib
import os
import shutil
import sys
import textwrap
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NoReturn

from grabbergui import __version__
from grabbergui.cli.guests import add_guest_commands, guest_commands
from grabbergui.cli.process import (
    LOG_FORMATS,
    Terminated,
    dies_of_signals,
    raising_on_signals,
    set_up_log,
    spell_out,
)
from grabbergui.core.errors import GrabberError, SourceUnavailableError, UsageError
from grabbergui.core.missing_packages import explained
from grabbergui.core.uri import is_ip_address
from grabbergui.core.visible_text import print_json, print_line

EXIT_FAILURE = 1
EXIT_USAGE = 2
EXIT_INTERRUPTED = 130
EXIT_HUNG_UP = 129
EXIT_TERMINATED = 143
EXIT_CODES = {
    0: "success; also after Ctrl-C, SIGTERM or SIGHUP if the command runs until then",
    EXIT_FAILURE: "something failed, and one line on stderr says what: no such camera, no name server, no "
    "control. `diff`: the settings differ; `doctor`: a problem was found; `terminal`: a line "
    "of a script was refused; `gui --offscreen`: no image arrived",
    EXIT_USAGE: "wrong usage: an option, a value, a file that does not exist, or one that does and would be "
    "overwritten",
    EXIT_HUNG_UP: "the terminal was closed before the end (SIGHUP); the camera is released first",
    EXIT_INTERRUPTED: "Ctrl-C before the end; the camera is released first",
    EXIT_TERMINATED: "SIGTERM before the end; the camera is released first",
}
"""Exit codes."""
ON_FAILURE = (
    'With `--json`, a command that fails prints `{"error": {"type": "SourceNotFoundError", "message": "…"}}` '
    "on stdout, besides the line on stderr. `record` and `load` put `error` beside their results until then; "
    "`events` prints it as the last line. A command that a signal ends prints no such object."
)
"""How scripts learn of a failure."""
FAMILIES = {
    "gui": ("gui", "terminal"),
    "machine": ("list", "doctor", "setup", "paths"),
    "features": ("features", "get", "set", "run", "save", "load", "diff"),
    "files": ("files",),
    "report": ("report",),
    "grab": ("grab",),
    "record": ("record",),
    "events": ("events",),
    "serve": ("serve",),
    "simulate": ("simulate",),
    "name_servers": ("yarp-server",),
    "gige": ("force-ip", "persistent-ip", "trigger-group"),
    "rig": ("rig",),
    "calibrate": ("calibrate",),
}
"""Modules here, and the commands that each adds, in the order of `--help`.

A command imports its own family alone, within `main`: the imports take long enough for a Ctrl-C.
"""
COMMANDS = tuple(command for commands in FAMILIES.values() for command in commands)
"""All commands but those of guests."""
OTHER_WORDS = {"read": "get", "write": "set", "ls": "list", "find": "list", "view": "gui", "info": "features"}
"""Commands of other programs that none of ours resembles, and ours."""
_NARROWEST = 40
"""Columns below which help is not wrapped any further."""


class PartialResultError(GrabberError):
    """A command failed after it had a result, which `--json` prints beside the error, its cause."""

    def __init__(self, message: str, result: dict[str, Any]) -> None:
        super().__init__(message)
        self.result = result
        "As JSON."


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; return the exit code: 0, 1 after a failure, 2 for wrong usage."""
    spell_out(sys.stdout)
    spell_out(sys.stderr)
    arguments = list(sys.argv[1:] if argv is None else argv)
    try:
        with raising_on_signals():
            return _run(arguments)
    except BrokenPipeError:
        # The reader of our output is gone; nothing may be written at exit either.
        _give_up_output()
        return 0
    except (GrabberError, OSError) as error:
        return _report(error, as_json="--json" in arguments)
    except ImportError as error:
        problem = SourceUnavailableError(f"this command cannot run: {explained(error)}")
        return _report(problem, as_json="--json" in arguments)
    except KeyboardInterrupt as interrupt:
        return 128 + interrupt.number if isinstance(interrupt, Terminated) else EXIT_INTERRUPTED


def _report(error: GrabberError | OSError, *, as_json: bool) -> int:
    """Report why a command failed; return its exit code."""
    message = str(error)
    if not isinstance(error, GrabberError):
        place = f"{error.filename}: " if error.filename is not None else ""
        message = f"{place}{error.strerror or error}"
    with contextlib.suppress(OSError):
        print_line(f"grabbergui: {message}", error=True)
    if as_json:
        result: dict[str, Any] = {}
        cause: BaseException = error
        if isinstance(error, PartialResultError):
            result, cause = error.result, error.__cause__ or GrabberError()
        with contextlib.suppress(OSError):
            print_json({**result, "error": {"type": type(cause).__name__, "message": message}})
    _give_up_output()
    # A named file is missing, as with MissingFileError elsewhere.
    return EXIT_USAGE if isinstance(error, UsageError | FileNotFoundError) else EXIT_FAILURE


def _run(arguments: list[str]) -> int:
    try:
        # A bare source, or only options of the window, mean the window.
        place = _command_place(arguments)
        first = arguments[place] if place < len(arguments) else ""
        if first not in ("-h", "--help", "--version") and not _is_command(first):
            _check_is_source(first)
            arguments.insert(place, "gui")
        with dies_of_signals():
            parser = command_line(*_wanted(arguments[place]))
        command = parsers_of(parser).get(arguments[place])
        if command is not None and (unknown := _unknown_option(arguments[place + 1 :], command)):
            raise _unknown([unknown], arguments[place], command)
        options, further = parser.parse_known_args(arguments)
        if further:
            raise _unknown(further, arguments[place], command or parser)
        set_up_log(options.log_level, options.log_format)
        return int(options.run(options))
    finally:
        # `main` reports output that cannot be written; at exit it would be a traceback.
        if sys.stdout is not None:
            sys.stdout.flush()


def _is_command(word: str) -> bool:
    """Return whether a word is a command; guests are asked last, as that takes longest."""
    if word in COMMANDS:
        return True
    return not (not word or word.startswith("-") or ":" in word) and word in guest_commands()


def _unknown_option(words: list[str], parser: argparse.ArgumentParser) -> str:
    """Return the first long option that the parser does not have; argparse may complain of others first."""
    known = {name: action for action in arguments_of(parser) for name in action.option_strings}
    for word in words:
        name = word.partition("=")[0]
        action = known.get(name)
        if word == "--" or (action is not None and action.nargs == argparse.REMAINDER):
            break
        if word.startswith("--") and action is None:
            return name
    return ""


def _unknown(words: list[str], command: str, parser: argparse.ArgumentParser) -> UsageError:
    """Return the error for arguments that a command does not have."""
    parser.print_usage(sys.stderr)
    option = next((word for word in words if word.startswith("-")), None)
    if option is None:
        return UsageError(f"{command} takes no further argument, such as '{words[0]}'")
    name = option.partition("=")[0]
    names = [each for action in arguments_of(parser) for each in action.option_strings]
    near = [each for each in names if each.startswith(name)] or _similar(name, names)
    hint = f"; did you mean {' or '.join(near)}?" if near else f"; `grabbergui {command} --help` lists them"
    return UsageError(f"{command} has no option {name}{hint}")


def _similar(name: str, names: Iterable[str]) -> list[str]:
    """Return the option that is most like a name, if one is; dashes are no likeness."""
    bare = {each.lstrip("-"): each for each in names}
    return [bare[each] for each in difflib.get_close_matches(name.lstrip("-"), bare, n=1)]


def _check_is_source(word: str) -> None:
    """Raise UsageError for a first word that is neither a command nor an option nor a source."""
    if not word or word.startswith("-") or ":" in word:
        return
    near = _nearest(word)
    hint = f"did you mean `grabbergui {near}`? " if near else ""
    raise UsageError(
        f"'{word}' is not a command; {hint}`grabbergui --help` lists them. "
        "A source begins with its kind, as in sim: or gige:192.168.0.10"
    )


def _nearest(word: str) -> str:
    from grabbergui import sources

    if is_ip_address(word):
        return f"gige:{word}"
    if Path(word).exists():
        return f"file:{word}"
    if word in OTHER_WORDS:
        return OTHER_WORDS[word]
    known = [*COMMANDS, *guest_commands(), *(f"{scheme}:" for scheme in sources.schemes())]
    return next(iter(difflib.get_close_matches(word, known, n=1)), "")


def _give_up_output() -> None:
    """Discard silently what still waits for a full disk, a closed pipe or a closed terminal."""
    for stream in (sys.stdout, sys.stderr):
        try:
            if stream is not None:
                stream.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def shared_options() -> list[argparse.Action]:
    """Return the options that every command has, as `grabbergui --help` explains them."""
    parser = argparse.ArgumentParser(prog="grabbergui", add_help=False)
    _add_shared_options(parser)
    return arguments_of(parser)


def arguments_of(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    """Return the options and positional arguments of a parser, of which argparse has no public list."""
    return parser._actions


def parsers_of(parser: argparse.ArgumentParser) -> dict[str, CommandParser]:
    """Return the parsers of a parser's commands by name."""
    (commands,) = (each for each in arguments_of(parser) if isinstance(each, argparse._SubParsersAction))
    return dict(commands.choices)


def command_parsers() -> dict[str, tuple[str, CommandParser]]:
    """Return the one-line help and the parser of every command, in the order of `--help`."""
    parser = argparse.ArgumentParser(prog="grabbergui")
    commands = parser.add_subparsers(parser_class=CommandParser)
    _add_families(commands, FAMILIES, guest_commands())
    summaries = {action.dest: action.help or "" for action in commands._choices_actions}
    return {name: (summaries.get(name, ""), command) for name, command in commands.choices.items()}


def sentence(text: str) -> str:
    """Return the text with a capital letter and a full stop."""
    return f"{text[:1].upper()}{text[1:].rstrip('.')}."


def columns() -> int:
    """Return the width of a line of help: the terminal's, less the two columns that argparse leaves free."""
    return max(shutil.get_terminal_size().columns - 2, _NARROWEST)


def wrapped(text: str, indent: str = "", first: str | None = None) -> str:
    """Wrap one paragraph to the terminal's width, its first line with an indent of its own."""
    return textwrap.fill(
        text,
        columns(),
        initial_indent=indent if first is None else first,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )


class CommandParser(argparse.ArgumentParser):
    """Parses one command. `example` is a complete command line, printed below the options."""

    def __init__(self, *arguments: Any, example: str = "", **keywords: Any) -> None:
        # An abbreviation in a script would change its meaning, or lose it, with the next new option.
        super().__init__(*arguments, **{"allow_abbrev": False, **keywords})
        self.example = example

    def _match_arguments_partial(
        self, actions: Sequence[argparse.Action], arg_strings_pattern: str
    ) -> list[int]:
        """Let optional arguments follow options, as in `events SOURCE --start NAME`.

        Python before 3.12.7 considers NAME left out as soon as an option follows SOURCE. The pattern has an
        A for each argument and an O for each option.
        """
        counts = super()._match_arguments_partial(actions, arg_strings_pattern)
        if "O" in arg_strings_pattern:
            while counts and counts[-1] == 0:
                counts.pop()
        return counts

    def error(self, message: str) -> NoReturn:
        """Print the usage, and raise UsageError, which `main` reports."""
        self.print_usage(sys.stderr)
        raise UsageError(message)

    def format_help(self) -> str:
        """Return usage, description, arguments, and the example."""
        text = super().format_help()
        return f"{text}\nexample:\n  {self.example}\n" if self.example else text


class _ProgramParser(CommandParser):
    """Ends its help with the kinds of source, which take a while to import."""

    def format_help(self) -> str:
        from grabbergui.cli.sources_help import sources_help

        self.epilog = sources_help()
        return super().format_help()


def _wanted(first: str) -> tuple[Iterable[str], Iterable[str]]:
    """Return the families and the guests' commands that a command line needs with this first word."""
    if first in ("-h", "--help"):
        return FAMILIES, guest_commands()
    families = [family for family, commands in FAMILIES.items() if first in commands]
    return families, [] if families or first == "--version" else [first]


def command_line(
    families: Iterable[str] = tuple(FAMILIES), guests: Iterable[str] | None = None
) -> argparse.ArgumentParser:
    """Return the parser of a command line with these families and guests' commands, by default all."""
    parser = _ProgramParser(
        prog="grabbergui",
        description=wrapped("Tune GenICam cameras live. Without a command, the window opens on SOURCE.")
        + "\n"
        + wrapped("`grabbergui COMMAND --help` explains a command."),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    _add_shared_options(parser)
    commands = parser.add_subparsers(metavar="COMMAND", required=True, parser_class=CommandParser)
    _add_families(commands, families, guest_commands() if guests is None else guests)
    for command in commands.choices.values():
        # Also after the command, where their defaults must not override options before it.
        _add_log_options(command, argument_default=argparse.SUPPRESS, explained=False)
        _add_version(command, explained=False)
    return parser


def _add_families(commands: Any, families: Iterable[str], guests: Iterable[str]) -> None:
    for family in families:
        importlib.import_module(f"grabbergui.cli.{family}").add_commands(commands)
    add_guest_commands(commands, guests)
    for action in commands._choices_actions:
        command = commands.choices[action.dest]
        command.description = " ".join(filter(None, (sentence(action.help), command.description)))


def _add_shared_options(parser: argparse.ArgumentParser) -> None:
    _add_version(parser)
    _add_log_options(parser)


def _add_version(parser: argparse.ArgumentParser, *, explained: bool = True) -> None:
    meaning = "print the version and exit" if explained else argparse.SUPPRESS
    parser.add_argument("--version", action="version", version=f"grabbergui {__version__}", help=meaning)


def _add_log_options(
    parser: argparse.ArgumentParser, argument_default: str = "", *, explained: bool = True
) -> None:
    parser.add_argument(
        "--log-level",
        choices=("debug", "info", "warning", "error"),
        default=argument_default or "warning",
        help="log to stderr from this level on (warning)" if explained else argparse.SUPPRESS,
    )
    parser.add_argument(
        "--log-format",
        choices=LOG_FORMATS,
        default=argument_default or "text",
        help="log lines of text, or one JSON object per line (text)" if explained else argparse.SUPPRESS,
    )


def _command_place(arguments: list[str]) -> int:
    """Return the index of the first argument after the options that every command has."""
    place = 0
    while place < len(arguments):
        if arguments[place] in ("--log-level", "--log-format"):
            place += 2
        elif arguments[place].startswith(("--log-level=", "--log-format=")):
            place += 1
        else:
            break
    return place
