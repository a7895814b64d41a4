"""Where libraries may be imported, and how long a file may be; `lint-imports` checks the packages."""

import ast
import gc
from collections import defaultdict
from functools import cache
from pathlib import Path

import pytest

from every_case import every_case

PACKAGE = Path(__file__).parents[2] / "grabbergui"
MODULES = sorted(PACKAGE.rglob("*.py"))
QT = {"PyQt5", "PyQt6", "PySide2", "PySide6", "pyqtgraph", "superqt", "qtpy"}

HOMES = {
    "genicam": ("driver/genapi", "driver/gentl"),
    "usb": ("driver/u3v", "driver/sim/u3v/backend.py"),
    "libusb_package": ("driver/u3v",),
    "rclpy": ("net/ros2", "servo"),
    "av": (
        "recording/movie_file.py",
        "recording/movie_writer.py",
        "driver/h264.py",
        "driver/sim/contents.py",
        "driver/sim/h264_encoder.py",
    ),
    "numba": ("core/compiled_loops.py",),
    "psutil": ("driver/gige", "net/yarp/os"),
    "pinocchio": ("servo/robots",),
    "example_robot_data": ("servo/robots",),
    **dict.fromkeys(QT, ("ui", "rig/ui", "servo/ui")),
}
"""Library: the only folders that import it."""

TWINS = {
    "Block",  # these, of GVSP; of USB3 Vision
    "BlockAssembler",
    "ControlChannel",  # GVCP; GenCP
    "Event",
    "FoundCamera",  # by Aravis; by a GenTL producer
    "ImageStream",  # over YARP; over ROS 2
    "Leader",
    "Status",
    "StreamReceiver",
    "Trailer",
}
"""Names of classes that stand for the same idea of two transports. Every other name means one thing."""

CODE = (ast.ClassDef, ast.FunctionDef)


@pytest.fixture
def trees():
    """Keep the trees of all files for one test. Garbage collections would search their million objects."""
    collects = gc.isenabled()
    gc.disable()
    yield
    parsed.cache_clear()
    if collects:
        gc.enable()


@cache
def parsed(path):
    return ast.parse(path.read_text("utf-8"), str(path))


@cache
def imports(path):
    """Return the full names of all modules that a file imports, at its top or inside a function."""
    return frozenset(_imports(path))


def _imports(path):
    package = ("grabbergui", *path.relative_to(PACKAGE).parent.parts)
    for node in _statements([parsed(path)]):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            module = ".".join((*base, *([node.module] if node.module else [])))
            yield from (f"{module}.{alias.name}" for alias in node.names)


def _statements(nodes):
    """Yield all statements; `ast.walk` visits twenty times as many expressions, which import nothing."""
    for node in nodes:
        yield node
        for part in ("body", "orelse", "finalbody", "handlers", "cases"):
            yield from _statements(getattr(node, part, ()))


def below(path, folders):
    return any(path.relative_to(PACKAGE).is_relative_to(folder) for folder in folders)


def name(path):
    return path.relative_to(PACKAGE).as_posix()


def libraries_are_imported_only_where_they_are_at_home():
    strays = {
        (name(path), library)
        for path in MODULES
        for library in {module.split(".")[0] for module in imports(path)} & HOMES.keys()
        if not below(path, HOMES[library])
    }
    assert not strays


def test_one_concern_a_file():
    assert not [name(path) for path in MODULES if len(path.read_text("utf-8").splitlines()) > 500]


def test_no_rule_separates_families_within_a_file():
    """A file is one story; families of classes or functions have a file each."""
    assert not [name(path) for path in MODULES if "# -- " in path.read_text("utf-8")]


def constants_stand_above_the_code_that_uses_them():
    """Numbers and texts. Constants made of classes stand below these; TEO's, beside its chains."""
    below_code = []
    for path in MODULES:
        body = parsed(path).body
        first = next((n for n, node in enumerate(body) if isinstance(node, CODE)), len(body))
        plain = [node for node in body[first:] if isinstance(getattr(node, "value", None), ast.Constant)]
        named = [each for each in plain if isinstance(each, ast.Assign) and each.targets[0].id.isupper()]
        below_code += [
            (name(path), each.targets[0].id) for each in named if name(path) != "servo/robots/teo.py"
        ]
    assert not below_code


def no_constructor_takes_eight_arguments_by_their_order():
    """What several classes get together is one object (`SourceContext`), and options have names."""
    wide = [
        name(path)
        for path in MODULES
        for function in _statements([parsed(path)])
        if isinstance(function, ast.FunctionDef)
        and function.name == "__init__"
        and len(function.args.args) - 1 - len(function.args.defaults) >= 8
    ]
    assert not wide


def a_class_name_means_one_thing():
    """Whoever searches for a class finds one idea. Private classes are read only inside of their file."""
    places = defaultdict(list)
    for path in MODULES:
        for node in _statements([parsed(path)]):
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                places[node.name].append(name(path))
    found = {each: files for each, files in places.items() if len(files) > 1}
    assert not {each: files for each, files in found.items() if each not in TWINS or len(files) > 2}
    assert found.keys() == TWINS, "a twin that is alone needs no exception"


@every_case(
    "rule",
    [
        libraries_are_imported_only_where_they_are_at_home,
        constants_stand_above_the_code_that_uses_them,
        no_constructor_takes_eight_arguments_by_their_order,
        a_class_name_means_one_thing,
    ],
    ids=lambda rule: rule.__name__,
)
def test_the_syntax_of_all_files_keeps_each_rule(trees, rule):
    rule()


def test_the_rules_see_what_they_should(tmp_path, monkeypatch):
    """`imports` finds every form of import; otherwise the rules above would check nothing."""
    room = tmp_path / "grabbergui" / "driver"
    room.mkdir(parents=True)
    module = room / "bad.py"
    module.write_text(
        "import os, usb.core\nfrom ..net import yarp\nfrom . import device\n"
        "def late():\n    from grabbergui import ui\n    from PyQt5.QtCore import Qt\n"
        "try:\n    pass\nexcept OSError:\n    import a\nelse:\n    import b\nfinally:\n    import c\n"
        "match a:\n    case 1:\n        import d\n"
    )
    monkeypatch.setitem(globals(), "PACKAGE", tmp_path / "grabbergui")
    assert imports(module) == {
        "os",
        "usb.core",
        "grabbergui.net.yarp",
        "grabbergui.driver.device",
        "grabbergui.ui",
        "PyQt5.QtCore.Qt",
        *"abcd",
    }
    assert MODULES
