"""Every file and folder that a page names exists."""

import re
import subprocess
from pathlib import Path, PurePosixPath

import pytest

from every_case import every_case

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")])
PAGES.remove(ROOT / "CHANGELOG.md")  # it may name what is gone
TOP = {path.name for folder in (ROOT, ROOT / "grabbergui") for path in folder.iterdir() if path.is_dir()}
NOT_OURS = {"check.py", "grabbergui/scan3d"}
"A reader's program; a topic."
NAMED = re.compile(r"(?<![\w/.:~-])([\w-]+(?:/[\w-]+)*\.(?:py|ui)|[a-z]\w*/[\w/]+)(?![\w/*.{-])")
"A file with its ending, or anything below a folder; not the middle of an address or of a longer path."


def tracked() -> set[PurePosixPath]:
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
    return {PurePosixPath(line) for line in listed.stdout.splitlines()}


def named(page: Path) -> set[str]:
    """Return the project's paths in backticks: Python files, forms, and paths below its folders."""
    prose = re.findall(r"`([^`\n]+)`", page.read_text(encoding="utf-8"))
    found = {path for text in prose for path in NAMED.findall(text)}
    ours = {path for path in found if path.endswith((".py", ".ui")) or path.partition("/")[0] in TOP}
    return {path for path in ours if "NAME" not in path} - NOT_OURS


@pytest.fixture(scope="module")
def places() -> set[PurePosixPath]:
    files = tracked()
    if not files:
        pytest.skip("this is no git checkout")
    return files.union(*(file.parents for file in files))


def test_paths_are_found() -> None:
    assert {"driver/device.py", "tests/support/patience.py"} <= named(ROOT / "CONTRIBUTING.md")


@every_case("page", PAGES, ids=lambda page: page.name)
def test_a_path_on_a_page_exists(page: Path, places: set[PurePosixPath]) -> None:
    missing = {
        path
        for path in named(page)
        if not any(place.match(path.rstrip("/")) or place.match(path + ".py") for place in places)
    }
    assert not missing
