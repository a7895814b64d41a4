"""The command line of `grabbergui servo`, read."""

import argparse

from grabbergui.cli import CommandParser
from grabbergui.servo.cli import servo as command


def options(*arguments):
    parser = argparse.ArgumentParser()
    command.add_commands(parser.add_subparsers(required=True, parser_class=CommandParser))
    return parser.parse_args(arguments)
