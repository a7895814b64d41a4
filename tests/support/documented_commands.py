"""The shell commands of README and manual."""

import re
import shlex
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = sorted([ROOT / "README.md", *ROOT.glob("docs/*.md")])
BLOCK = re.compile(r"```(?:sh|bash|console)\n(.*?)```", re.DOTALL)
STARTERS = {"sudo", "exec", "time", "xvfb-run", "-a"}
ENDS = {"|", "&", ";", "&&", ">", "2>", ">>"}


def lines(page: Path) -> list[list[str]]:
    """Return the words of each line in a page's shell blocks, without what is the shell's."""
    found = []
    for block in BLOCK.findall(page.read_text("utf-8")):
        for line in block.replace("\\\n", " ").splitlines():
            words = shlex.split(line.removeprefix("$ "), comments=True)
            while words and (words[0] in STARTERS or re.match(r"\w+=", words[0])):
                words.pop(0)
            if words:
                found.append(words)
    return found


def commands(page: Path) -> list[str]:
    """Return this program's commands on a page, without the program's name and what follows in the line."""
    found = []
    for words in lines(page):
        if Path(words[0]).name == "grabbergui":
            end = next((index for index, word in enumerate(words) if word in ENDS), len(words))
            found.append(shlex.join(words[1:end]))
    return found
