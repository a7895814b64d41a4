"""`docs/architecture.md` draws the layers, lists the packages and names the methods of the code as it is."""

from __future__ import annotations

import json
import re
from functools import lru_cache

from architecture_walks import PAGE, ROOT, walks
from every_case import every_case

COMMANDS = {"serve"}
"Words in the table that are no modules."
STEPS = [step for steps in walks().values() for step in steps]


@lru_cache
def classes(package: str) -> dict[str, str]:
    """Return the text of each class in a package, by name."""
    found = {}
    for path in (ROOT / "grabbergui" / package).rglob("*.py"):
        for text in re.split(r"^(?=class )", path.read_text(), flags=re.MULTILINE)[1:]:
            found[re.match(r"class (\w+)", text)[1]] = text  # type: ignore[index]
    return found


def test_the_walks_are_found() -> None:
    assert len({package.partition("/")[0] for package, _, _ in STEPS}) >= 5 and len(STEPS) > 25


@every_case("package, name, method", STEPS)
def test_a_step_is_in_the_code(package: str, name: str, method: str) -> None:
    assert name in classes(package), f"grabbergui/{package} has no class {name}"
    assert re.search(rf"def {method}\b", classes(package)[name]), f"{name} has no method {method}"


def test_the_layers_are_those_of_the_import_contract() -> None:
    layers = re.search(
        r"^layers = (.*)$", (ROOT / "pyproject.toml").read_text(encoding="utf-8"), re.MULTILINE
    )
    assert layers is not None
    drawing = PAGE.split("```")[1]
    drawn = [re.findall(r"(?<!\S)([a-z]+)(?:/|\.py)(?!\S)", line) for line in drawing.strip().splitlines()]
    assert drawn == [layer.strip("()").split(" | ") for layer in json.loads(layers[1])]


def test_every_package_and_file_of_the_table_exists() -> None:
    rows = re.findall(r"^\| (`[^|]+`) \|", PAGE.partition("## Threads")[0], re.MULTILINE)
    names = [name for row in rows for name in re.findall(r"`([^`]+)`", row)]
    assert len(names) > 30
    package = ROOT / "grabbergui"
    missing = [name for name in names if not any((package / (name + end)).exists() for end in ("", ".py"))]
    assert not missing


def test_every_module_that_a_row_names_is_in_its_packages() -> None:
    missing = []
    for row in re.findall(r"^\| (`[^\n]+)$", PAGE.partition("## Threads")[0], re.MULTILINE):
        packages, contents = row.split(" | ")[:2]
        places = [ROOT / "grabbergui" / name for name in re.findall(r"`([^`]+)`", packages)]
        folders = [place if place.is_dir() else place.parent for place in places]
        missing += [
            (packages, name)
            for name in set(re.findall(r"`([a-z_0-9/]+?)/?`", contents)) - COMMANDS
            if not any([*folder.rglob(name), *folder.rglob(f"{name}.py")] for folder in folders)
        ]
    assert not missing
