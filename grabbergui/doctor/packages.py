"""Checks of the packages that this program needs: whether each can be loaded, and which OpenCV there is."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Iterator, Sequence
from importlib import metadata

from grabbergui.core.missing_packages import explained, install_command
from grabbergui.core.shell_words import shell_line
from grabbergui.doctor.findings import Finding, good, note, problem

NEEDED = (
    "numpy",
    "cv2",
    "genicam.genapi",
    "av",
    "lz4.frame",
    "zstandard",
    "yaml",
    "psutil",
    "libusb_package",
)
"Modules with compiled parts, without which something does not work."
WINDOW = "PyQt5.QtWidgets"
OPENCV = (
    "opencv-python-headless", "opencv-python", "opencv-contrib-python", "opencv-contrib-python-headless",
)  # fmt: skip
"OpenCV's packages on the package index, all of which have the module `cv2`."


def check_packages() -> Iterator[Finding]:
    """The compiled packages, and that there is only one OpenCV."""
    yield from loadable(importlib.import_module)
    yield from opencv([each for each in OPENCV if _is_installed(each)])


def loadable(load: Callable[[str], object]) -> Iterator[Finding]:
    """Check that each package can be loaded, by a function that raises ImportError."""
    failed = False
    for module in NEEDED:
        try:
            load(module)
        except ImportError as error:
            failed = True
            what, _, remedy = explained(error).partition(": ")
            yield problem(what, remedy)
    try:
        load(WINDOW)
    except ImportError as error:
        what, _, remedy = explained(error).partition(": ")
        yield note(f"the window cannot be opened, all else can: {what}", remedy)
    if not failed:
        yield good("the packages that this program needs can be loaded")


def opencv(installed: Sequence[str]) -> Iterator[Finding]:
    """Check for several packages with the same files: the last one has replaced parts of the others."""
    if len(installed) > 1:
        others = [each for each in installed if each != OPENCV[0]]
        again = shell_line([sys.executable, "-m", "pip", "install", "--force-reinstall", "--no-deps"])
        yield problem(
            f"{' and '.join(installed)} are installed, and overwrite each other: cv2 or its imshow may fail",
            f"pip uninstall {' '.join(installed)}, then {again} with the one that you need: {OPENCV[0]}, or "
            f"{others[0]} for cv2.imshow; this program runs with either",
        )
    elif not installed:
        yield note("OpenCV is not from the package index", f"if cv2 fails: {install_command('cv2')}")


def _is_installed(name: str) -> bool:
    try:
        metadata.distribution(name)
    except metadata.PackageNotFoundError:
        return False
    return True
