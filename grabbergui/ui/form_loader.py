"""Qt Designer's forms, loaded and compiled. They are edited there only; no Python copy exists."""

from __future__ import annotations

import io
from functools import cache
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import CodeType
from typing import Any

from PyQt5.QtWidgets import (
    QDialog,
    QLabel,
    QWidget,
)

from grabbergui.ui.dialog_style import dress_dialog
from grabbergui.ui.shown_text import make_plain
from grabbergui.ui.theme import apply_icons

FORMS = Path(__file__).with_name("forms")
PACKAGE = Path(__file__).parents[1]


def load_form(form: str | Path, into: QWidget) -> None:
    """Build a form in a widget of the form's own class, with the icons that it names.

    `form` is the name of a file in `ui/forms`, without its ending, or the path of another.
    The form's children become attributes of `into`, by their object names. Its labels show plain text.
    """
    built = form_class(form if isinstance(form, Path) else FORMS / f"{form}.ui")()
    built.setupUi(into)
    for label in into.findChildren(QLabel):
        make_plain(label)
    for child, widget in vars(built).items():
        setattr(into, child, widget)
    apply_icons(into)
    if isinstance(into, QDialog):
        dress_dialog(into)


def compile_forms() -> None:
    """Compile all forms, after an installation into a folder that its users may not write to."""
    for form in PACKAGE.rglob("forms/*.ui"):
        form_class(form)


@cache
def form_class(path: Path) -> type[Any]:
    """Return the class that Qt's compiler makes of a form; its `setupUi` fills a widget."""
    code = _FormLoader(path.stem, str(path)).get_code(path.stem)
    assert code is not None, "get_code answers None only for modules without code"
    made: dict[str, Any] = {}
    exec(code, made)
    compiled: type[Any] = next(value for name, value in made.items() if name.startswith("Ui_"))
    return compiled


class _FormLoader(SourceFileLoader):
    """Compiles a form as Python compiles a module: once, and again after its file has changed.

    Python keeps the code in `forms/__pycache__`, if it may write there. Reading the XML would take half
    of the time to build a window.
    """

    def source_to_code(self, data: Any, path: Any, *, _optimize: int = -1) -> CodeType:  # type: ignore[override]
        """Compile the XML of a form without its list of connections, which is empty.

        Qt would look in every child for signals that match the names of our methods.
        """
        from PyQt5 import uic  # here, because its import takes as long as building a window

        # No form uses Qt's plugin widgets, and for each form all plugins would be searched for and run again.
        uic.widgetPluginPath.clear()
        source = io.StringIO()
        form = io.StringIO(bytes(data).decode().replace("<connections/>", ""))
        uic.compileUi(form, source)  # type: ignore[no-untyped-call]
        return super().source_to_code(source.getvalue().encode(), path)
