"""Loads Qt Designer forms. Forms are edited in Designer only; no Python copy of them exists."""

from __future__ import annotations

from importlib import resources

from PyQt5 import uic
from PyQt5.QtWidgets import QWidget

# No form uses Qt's plugin widgets, and for each form all plugins would be searched for and run again.
uic.widgetPluginPath.clear()


def load_form(name: str, into: QWidget) -> None:
    """Build the form `ui/forms/<name>.ui` in a widget of the form's own class.

    The form's children become attributes of `into`, by their object names.
    """
    form = resources.files("grabbergui.ui") / "forms" / f"{name}.ui"
    with resources.as_file(form) as path:
        uic.loadUi(str(path), into)  # type: ignore[no-untyped-call]
