"""The walks that `docs/architecture.md` draws name methods of the packages they say."""

from __future__ import annotations

import re
from functools import lru_cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
STEP = re.compile(r"\b([A-Z]\w+)\.(\w+)\b")


def walks() -> list[tuple[str, str, str]]:
    """Package, class and method of every step."""
    page = (ROOT / "docs" / "architecture.md").read_text()
    found = []
    for drawing in re.findall(r"^## [^\n]* on its way to .*?```\n(.*?)```", page, re.DOTALL | re.MULTILINE):
        package = ""
        for line in drawing.splitlines():
            if not line.startswith(" "):
                package = line.split()[0]
            found += [(package, *match.groups()) for match in STEP.finditer(line)]
    return found


@lru_cache
def classes(package: str) -> dict[str, str]:
    """The text of each class in a package, by name."""
    found = {}
    for path in (ROOT / "grabbergui" / package).rglob("*.py"):
        for text in re.split(r"^(?=class )", path.read_text(), flags=re.MULTILINE)[1:]:
            found[re.match(r"class (\w+)", text)[1]] = text  # type: ignore[index]
    return found


def test_the_walks_are_found() -> None:
    assert len({package.partition("/")[0] for package, _, _ in walks()}) >= 5 and len(walks()) > 25


@pytest.mark.parametrize("package, name, method", walks())
def test_a_step_is_in_the_code(package: str, name: str, method: str) -> None:
    assert name in classes(package), f"grabbergui/{package} has no class {name}"
    assert re.search(rf"def {method}\b", classes(package)[name]), f"{name} has no method {method}"
