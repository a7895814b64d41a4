"""The import rules of docs/architecture.md, held by reading every module of the package."""

import ast
from functools import cache
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "grabbergui"
MODULES = sorted(PACKAGE.rglob("*.py"))
QT = {"PyQt5", "PyQt6", "PySide2", "PySide6", "pyqtgraph", "superqt", "qtpy"}
ROOMS = {"core", "driver", "net", "models", "ui", "cli", "servo", "terminal", "doctor", "config"}

FORBIDDEN = {
    "core": ROOMS - {"core"} | {"sources"},
    "config": ROOMS - {"core", "config"} | {"sources"},
    "driver": ROOMS - {"core", "driver"} | {"sources"},
    "net": ROOMS - {"core", "config", "net"} | {"sources"},
    "sources.py": ROOMS - {"core", "driver", "net"},
    "servo": {"models", "ui", "cli", "terminal", "doctor"},
    "models": {"ui", "cli", "terminal", "doctor"},
    "terminal": {"ui", "cli", "doctor"},
    "doctor": {"models", "ui", "cli", "terminal"},
}
"""Room: the rooms that it must not know."""

HOMES = {
    "genicam": ("driver/genapi", "driver/gentl"),
    "usb": ("driver/u3v", "driver/sim/u3v/backend.py"),
    "libusb_package": ("driver/u3v",),
    "rclpy": ("net/ros2", "servo"),
    "pinocchio": ("servo/robots",),
    "example_robot_data": ("servo/robots",),
    **dict.fromkeys(QT, ("ui",)),
}
"""Library: the only folders that import it."""


@cache
def imports(path):
    """Every module that a file imports, at its top or inside a function, with its full name."""
    return frozenset(_imports(path))


def _imports(path):
    package = ("grabbergui", *path.relative_to(PACKAGE).parent.parts)
    for node in ast.walk(ast.parse(path.read_text("utf-8"), str(path))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            module = ".".join((*base, *([node.module] if node.module else [])))
            yield from (f"{module}.{alias.name}" for alias in node.names)


def room_of(path):
    return path.relative_to(PACKAGE).parts[0]


def below(path, folders):
    return any(path.relative_to(PACKAGE).is_relative_to(folder) for folder in folders)


def name(path):
    return path.relative_to(PACKAGE).as_posix()


@pytest.mark.parametrize("path", MODULES, ids=name)
def test_rooms_know_only_those_below(path):
    forbidden = FORBIDDEN.get(room_of(path), set())
    known = {module.split(".")[1] for module in imports(path) if module.startswith("grabbergui.")}
    assert not known & forbidden


@pytest.mark.parametrize("path", MODULES, ids=name)
def test_libraries_are_imported_only_where_they_are_at_home(path):
    libraries = {module.split(".")[0] for module in imports(path)}
    strays = {library for library in libraries & HOMES.keys() if not below(path, HOMES[library])}
    assert not strays


@pytest.mark.parametrize("path", MODULES, ids=name)
def test_one_concern_a_file(path):
    assert len(path.read_text("utf-8").splitlines()) <= 500


def test_the_rules_see_what_they_should(tmp_path, monkeypatch):
    """The rules above would be worth nothing if `imports` overlooked a way of writing an import."""
    room = tmp_path / "grabbergui" / "driver"
    room.mkdir(parents=True)
    module = room / "bad.py"
    module.write_text(
        "import os, usb.core\nfrom ..net import yarp\nfrom . import device\n"
        "def late():\n    from grabbergui import ui\n    from PyQt5.QtCore import Qt\n"
    )
    monkeypatch.setitem(globals(), "PACKAGE", tmp_path / "grabbergui")
    assert imports(module) == {
        "os",
        "usb.core",
        "grabbergui.net.yarp",
        "grabbergui.driver.device",
        "grabbergui.ui",
        "PyQt5.QtCore.Qt",
    }
    assert MODULES
