"""Windows: built from Qt Designer's forms, fitted to the screen, and asking for a file or a folder.

Forms are edited in Designer only; no Python copy of them exists.
"""

from __future__ import annotations

import io
from functools import cache
from importlib import resources
from pathlib import Path

from PyQt5 import uic
from PyQt5.QtCore import QSize
from PyQt5.QtGui import QGuiApplication
from PyQt5.QtWidgets import QFileDialog, QWidget

from grabbergui.ui.theme import apply_icons

# No form uses Qt's plugin widgets, and for each form all plugins would be searched for and run again.
uic.widgetPluginPath.clear()

TITLE_BAR = 40
"Pixels that a window manager may take of the screen's height for a window's title."


def load_form(name: str, into: QWidget) -> None:
    """Build the form `ui/forms/<name>.ui` in a widget of the form's own class, with the icons that it names.

    The form's children become attributes of `into`, by their object names.
    """
    uic.loadUi(io.StringIO(_form(name)), into)  # type: ignore[no-untyped-call]
    apply_icons(into)


@cache
def _form(name: str) -> str:
    """Return a form's text without its list of connections, which is empty.

    Qt would look in every child for signals that match the names of our methods: a fifth of the time.
    """
    form = resources.files("grabbergui.ui") / "forms" / f"{name}.ui"
    return form.read_text(encoding="utf-8").replace("<connections/>", "")


def fit_screen(window: QWidget) -> None:
    """Make a window no larger than the screen, where its last buttons would be out of reach."""
    if has_screen() and (screen := window.screen()) is not None:
        window.resize(window.size().boundedTo(screen.availableGeometry().size() - QSize(0, TITLE_BAR)))


def has_screen() -> bool:
    """Return whether windows are seen; Qt's offscreen platform only claims a screen of 800 × 800 pixels."""
    return QGuiApplication.platformName() != "offscreen"


class FileDialogs:
    """Qt's modal dialogs for files, over a window. Implements `bases.FileQuestions`."""

    def __init__(self, window: QWidget) -> None:
        self._window = window

    def to_open(self, title: str, kinds: str, folder: Path | None = None) -> Path | None:
        """Ask for a file that exists; `kinds` is a filter such as `Settings (*.yaml)`."""
        place = str(folder) if folder is not None else ""
        chosen, _ = QFileDialog.getOpenFileName(self._window, title, place, kinds)
        return Path(chosen) if chosen else None

    def to_save(self, title: str, name: str, kinds: str) -> Path | None:
        """Ask for a file to write; `name` is the suggestion."""
        chosen, _ = QFileDialog.getSaveFileName(self._window, title, name, kinds)
        return Path(chosen) if chosen else None

    def folder(self, title: str, before: Path) -> Path | None:
        """Ask for a folder; `before` is the one used so far."""
        chosen = QFileDialog.getExistingDirectory(self._window, title, str(before))
        return Path(chosen) if chosen else None
