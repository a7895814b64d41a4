"""Windows: built from Qt Designer's forms, fitted to the screen, and asking for a file or a folder.

Forms are edited in Designer only; no Python copy of them exists.
"""

from __future__ import annotations

import io
from functools import cache
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import CodeType
from typing import Any

from PyQt5.QtCore import QSize
from PyQt5.QtGui import QGuiApplication
from PyQt5.QtWidgets import QFileDialog, QWidget

from grabbergui.ui.theme import apply_icons

_FORMS = Path(__file__).with_name("forms")

TITLE_BAR = 40
"Pixels that a window manager may take of the screen's height for a window's title."


def load_form(name: str, into: QWidget) -> None:
    """Build the form `ui/forms/<name>.ui` in a widget of the form's own class, with the icons that it names.

    The form's children become attributes of `into`, by their object names.
    """
    form = _form(name)()
    form.setupUi(into)
    for child, widget in vars(form).items():
        setattr(into, child, widget)
    apply_icons(into)


def compile_forms() -> None:
    """Compile all forms, after an installation into a folder that its users may not write to."""
    for form in _FORMS.glob("*.ui"):
        _form(form.stem)


@cache
def _form(name: str) -> type[Any]:
    """Return the class that Qt's compiler makes of a form; its `setupUi` fills a widget."""
    code = _FormLoader(name, str(_FORMS / f"{name}.ui")).get_code(name)
    assert code is not None, "get_code answers None only for modules without code"
    made: dict[str, Any] = {}
    exec(code, made)
    compiled: type[Any] = next(value for name, value in made.items() if name.startswith("Ui_"))
    return compiled


class _FormLoader(SourceFileLoader):
    """Compiles a form as Python compiles a module: once, and anew after a change of its file.

    Python keeps the code in `forms/__pycache__`, if it may write there. Half of the time in which a window is
    built would go into reading the XML.
    """

    def source_to_code(self, data: Any, path: Any, *, _optimize: int = -1) -> CodeType:  # type: ignore[override]
        """Compile the XML of a form without its list of connections, which is empty.

        Qt would look in every child for signals that match the names of our methods.
        """
        from PyQt5 import uic  # only to compile: its import takes as long as building a window

        # No form uses Qt's plugin widgets, and for each form all plugins would be searched for and run again.
        uic.widgetPluginPath.clear()
        source = io.StringIO()
        form = io.StringIO(bytes(data).decode().replace("<connections/>", ""))
        uic.compileUi(form, source)  # type: ignore[no-untyped-call]
        return super().source_to_code(source.getvalue().encode(), path)


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
