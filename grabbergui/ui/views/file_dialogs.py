"""Qt's dialogs that ask for a file or a folder."""

from __future__ import annotations

from pathlib import Path

from PyQt5.QtWidgets import QFileDialog, QWidget


class FileDialogs:
    """Asks over a window, and waits for the answer. Fits `bases.FileQuestions`."""

    def __init__(self, window: QWidget) -> None:
        self._window = window

    def to_open(self, title: str, kinds: str, folder: Path | None = None) -> Path | None:
        """Ask for a file that exists; `kinds` is a filter such as `Settings (*.yaml)`."""
        place = str(folder) if folder is not None else ""
        chosen, _ = QFileDialog.getOpenFileName(self._window, title, place, kinds)
        return Path(chosen) if chosen else None

    def to_save(self, title: str, name: str, kinds: str) -> Path | None:
        """Ask for a file to write, `name` being offered."""
        chosen, _ = QFileDialog.getSaveFileName(self._window, title, name, kinds)
        return Path(chosen) if chosen else None

    def folder(self, title: str, before: Path) -> Path | None:
        """Ask for a folder; `before` is the one used so far."""
        chosen = QFileDialog.getExistingDirectory(self._window, title, str(before))
        return Path(chosen) if chosen else None
