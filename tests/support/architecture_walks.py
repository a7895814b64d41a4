"""The drawings of `docs/architecture.md` that follow something on its way through the code."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
STEP = re.compile(r"\b([A-Z]\w+)\.(\w+)\b")


def walks() -> dict[str, list[tuple[str, str, str]]]:
    """Return package, class and method of every step, by the first words of the drawing's title."""
    found = {}
    for title, drawing in re.findall(
        r"^## ([^\n]*) on its way to .*?```\n(.*?)```", PAGE, re.DOTALL | re.MULTILINE
    ):
        package, steps = "", []
        for line in drawing.splitlines():
            if not line.startswith(" "):
                package = line.split()[0]
            steps += [(package, *match.groups()) for match in STEP.finditer(line)]
        found[title] = steps
    return found
