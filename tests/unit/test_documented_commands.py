"""Every command of README and manual is one that the program takes: its options and values are parsed.

What a command does is tested elsewhere: most of those on these pages need a camera, a robot, root or a
minute.
"""

import re
import shlex
from pathlib import Path

import pytest

from grabbergui.cli import command_line
from grabbergui.core.errors import UsageError

ROOT = Path(__file__).parents[2]
PAGES = sorted([ROOT / "README.md", *ROOT.glob("docs/*.md")])
BLOCK = re.compile(r"```(?:sh|bash|console)\n(.*?)```", re.DOTALL)
STARTERS = {"sudo", "exec", "time", "xvfb-run", "-a"}
ENDS = {"|", "&", ";", "&&", ">", "2>", ">>"}


def commands(page: Path) -> list[str]:
    """Return the commands in a page's shell blocks, without the program's name and what is the shell's."""
    found = []
    for block in BLOCK.findall(page.read_text("utf-8")):
        for line in block.replace("\\\n", " ").splitlines():
            words = shlex.split(line.removeprefix("$ "), comments=True)
            while words and (words[0] in STARTERS or re.match(r"\w+=", words[0])):
                words.pop(0)
            if words and Path(words[0]).name == "grabbergui":
                end = next((index for index, word in enumerate(words) if word in ENDS), len(words))
                found.append(shlex.join(words[1:end]))
    return found


def test_commands_are_found() -> None:
    assert "record gige: --out scene.mcap -t 10" in commands(ROOT / "docs/command-line.md")
    assert sum(len(commands(page)) for page in PAGES) > 100


@pytest.mark.parametrize("page", [page for page in PAGES if commands(page)], ids=lambda page: page.name)
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
