"""Every command of README and manual is one that the program takes: its options and values are parsed.

`tests/system/cli/test_documented_commands.py` runs those that end by themselves.
"""

import shlex
from pathlib import Path

from documented_commands import PAGES, ROOT, commands
from every_case import every_case
from grabbergui.cli import command_line
from grabbergui.core.errors import UsageError


def test_commands_are_found() -> None:
    assert "record gige: --out scene.mcap -t 10" in commands(ROOT / "docs/command-line.md")
    assert sum(len(commands(page)) for page in PAGES) > 100


@every_case("page", [page for page in PAGES if commands(page)], ids=lambda page: page.name)
def test_a_command_of_a_page_is_one(page: Path) -> None:
    parser, wrong = command_line(), {}
    for line in commands(page):
        words = shlex.split(line)
        if "…" in line or not words or ":" in words[0] or words[0].startswith("-"):
            continue  # left out by the page, or the window on a source
        try:
            parser.parse_args(words)
        except UsageError as error:
            wrong[line] = str(error)
    assert not wrong
