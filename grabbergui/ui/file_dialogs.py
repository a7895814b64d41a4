"""Dialogs that choose files."""

from __future__ import annotations

from pathlib import Path

from PyQt5.QtCore import QFileInfo
from PyQt5.QtWidgets import (
    QApplication,
    QFileDialog,
    QWidget,
)


class FileDialogs:
    """Qt's modal dialogs for files. Implements `bases.FileQuestions`.

    They are over the active window, which gets the focus back, or else over the given one.
    """

    def __init__(self, window: QWidget) -> None:
        self._window = window

    @property
    def _parent(self) -> QWidget:
        return QApplication.activeWindow() or self._window

    def to_open(self, title: str, kinds: str, folder: Path | None = None) -> Path | None:
        """Ask for a file that exists; `kinds` is a filter such as `Settings (*.yaml)`."""
        place = str(folder) if folder is not None else ""
        chosen, _ = QFileDialog.getOpenFileName(self._parent, title, place, kinds)
        return Path(chosen) if chosen else None

    def to_save(self, title: str, name: str, kinds: str) -> Path | None:
        """Ask for a file to write; `name` is the suggestion."""
        chosen, _ = QFileDialog.getSaveFileName(self._parent, title, name, kinds)
        return Path(chosen) if chosen else None

    def folder(self, title: str, before: Path) -> Path | None:
        """Ask for a folder; `before` is the one used so far, which need not exist yet."""
        # In place of a folder that does not exist, Qt offers one of its name below the working directory.
        place = next(
            (folder for folder in (before, *before.parents) if QFileInfo(str(folder)).isDir()), Path.home()
        )
        chosen = QFileDialog.getExistingDirectory(self._parent, title, str(place))
        return Path(chosen) if chosen else None
