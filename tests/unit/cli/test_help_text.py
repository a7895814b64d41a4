"""The help of every command: an example that is accepted, a meaning for everything, no line too wide."""

import argparse
import os
import shlex
from importlib.metadata import EntryPoint

import pytest

from every_case import every_case
from grabbergui.cli import (
    FAMILIES,
    arguments_of,
    command_line,
    command_parsers,
    guests,
    main,
    parsers_of,
    shared_options,
)
from grabbergui.cli.guests import GROUP, add_guest_commands, guest_commands

COMMANDS = command_parsers()


@every_case("name", COMMANDS)
def test_the_example_is_a_command_line_that_is_accepted(name):
    program, command, *arguments = shlex.split(COMMANDS[name][1].example)
    assert (program, command) == ("grabbergui", name)
    parser = command_line()
    parser.parse_args([command, *arguments])


@every_case("name", COMMANDS)
def test_every_argument_has_a_meaning(name):
    actions = [each for each in arguments_of(COMMANDS[name][1]) if each.help != argparse.SUPPRESS]
    assert not [each.dest for each in actions if len(each.help or "") < 8]


@pytest.mark.parametrize("columns", [60, 100])
@pytest.mark.parametrize("arguments", [["--help"], *([name, "--help"] for name in COMMANDS)], ids=" ".join)
def test_help_keeps_to_the_width_of_the_terminal(arguments, columns, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", str(columns))
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    text = capsys.readouterr().out
    assert ended.value.code == 0
    example = {COMMANDS[arguments[0]][1].example} if arguments[0] in COMMANDS else set()
    wide = [line for line in text.splitlines() if len(line) > columns and line.strip() not in example]
    # A usage's option is not divided from its value.
    assert not [line for line in wide if " " in line.strip() and not line.strip().startswith("[--")]


def test_logging_is_explained_once(capsys):
    for arguments in (["--help"], ["list", "--help"]):
        with pytest.raises(SystemExit):
            main(arguments)
        expected = 2 if arguments == ["--help"] else 0  # usage and explanation
        assert capsys.readouterr().out.count("--log-level") == expected


def test_logging_may_follow_the_command():
    parser = command_line()
    assert parser.parse_args(["list", "--log-level", "debug"]).log_level == "debug"
    assert parser.parse_args(["--log-level", "debug", "list"]).log_level == "debug"


def test_every_family_adds_the_commands_that_are_said_to_be_its():
    for family, commands in FAMILIES.items():
        assert tuple(parsers_of(command_line([family], []))) == commands
    own = tuple(command for commands in FAMILIES.values() for command in commands)
    assert tuple(COMMANDS) == (*own, *guest_commands())
    for command in guest_commands():
        assert command in parsers_of(command_line([], [command]))


def test_no_command_redefines_a_shared_option():
    shared = {name for action in shared_options() for name in action.option_strings}
    own = {
        name
        for _, parser in COMMANDS.values()
        for each in arguments_of(parser)
        for name in each.option_strings
    }
    assert not shared & own


def test_output_has_no_colour_where_nobody_wants_it(monkeypatch, capsys):
    monkeypatch.setitem(os.environ, "NO_COLOR", "1")
    with pytest.raises(SystemExit):
        main(["--help"])
    assert "\x1b" not in capsys.readouterr().out


def test_a_guest_that_was_deleted_adds_no_command(monkeypatch):
    gone = EntryPoint("gone", "grabbergui.gone.cli:add_commands", GROUP)
    monkeypatch.setattr(guests, "guest_commands", lambda: {"gone": gone})
    commands = argparse.ArgumentParser().add_subparsers()
    add_guest_commands(commands, ["gone"])
    assert not commands.choices


def test_a_guest_that_lacks_a_package_says_so(monkeypatch, tmp_path):
    (tmp_path / "guest_without_its_package.py").write_text("import no_such_package")
    monkeypatch.syspath_prepend(tmp_path)
    faulty = EntryPoint("faulty", "guest_without_its_package:add_commands", GROUP)
    monkeypatch.setattr(guests, "guest_commands", lambda: {"faulty": faulty})
    with pytest.raises(ModuleNotFoundError, match="no_such_package"):
        add_guest_commands(None, ["faulty"])
