"""The dialog of the files in the camera."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PyQt5.QtCore import Qt, pyqtBoundSignal, pyqtSignal
from PyQt5.QtWidgets import QDialog, QLabel, QMessageBox, QProgressBar, QPushButton, QTreeWidget, QWidget

from grabbergui.core.file_access import CameraFile, is_firmware
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.actions import set_available
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.screen import fit_screen
from grabbergui.ui.shown_text import question_box
from grabbergui.ui.widgets.columns import size_columns
from grabbergui.ui.widgets.labels import restyle
from grabbergui.ui.widgets.table_rows import fill_rows

READ, WRITE = "Read", "Write"
"Entries of FileOpenMode (SFNC)."
STEPS = 1000
"Steps of the progress bar."


class CameraFilesDialog(QDialog):
    """Setters for the files and the transfer; signals, with a file's name, for the requested actions."""

    downloadRequested = pyqtSignal(str)
    uploadRequested = pyqtSignal(str)
    deleteRequested = pyqtSignal(str)
    """The user has agreed."""
    cancelRequested = pyqtSignal()

    table: QTreeWidget
    progressBar: QProgressBar
    cancelButton: QPushButton
    outcomeLabel: QLabel
    downloadButton: QPushButton
    uploadButton: QPushButton
    deleteButton: QPushButton
    closeButton: QPushButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("camera_files", self)
        self._files: tuple[CameraFile, ...] = ()
        self._reachable = True
        "Whether files can be transferred."
        self._busy = False
        self.question: QMessageBox | None = None
        """The question whether to replace or delete a file, while it is open."""
        size_columns(self.table, ("ShadingCorrectionTable", "10,000,000 B"))
        self.progressBar.setRange(0, STEPS)
        self.table.currentItemChanged.connect(lambda: self._enable())
        self.downloadButton.clicked.connect(lambda: self._emit_for_chosen(self.downloadRequested))
        self.uploadButton.clicked.connect(lambda: self._emit_for_chosen(self.uploadRequested))
        self.deleteButton.clicked.connect(self._ask_delete)
        self.cancelButton.clicked.connect(self.cancelRequested)
        self.closeButton.clicked.connect(self.reject)
        self._enable()
        fit_screen(self)

    @property
    def chosen(self) -> CameraFile | None:
        """The file that is selected."""
        row = self.table.indexOfTopLevelItem(self.table.currentItem())
        return self._files[row] if 0 <= row < len(self._files) else None

    def setFiles(self, files: Sequence[CameraFile], *, reachable: bool) -> None:
        """Show these files; without `reachable`, they can only be listed."""
        before = self.chosen
        self._files, self._reachable = tuple(files), reachable
        fill_rows(self.table, [self._row(file) for file in files])
        names = [file.name for file in files]
        kept = names.index(before.name) if before is not None and before.name in names else 0
        self.table.setCurrentItem(self.table.topLevelItem(kept))
        self._enable()

    def setBusy(self, busy: bool) -> None:
        """Show whether a transfer is in progress, which forbids others."""
        self._busy = busy
        self.progressBar.setVisible(busy)
        self.cancelButton.setVisible(busy)
        self.progressBar.setValue(0)
        self._enable()

    def setShare(self, share: float) -> None:
        """Show which part of the transfer is done, 0 to 1."""
        self.progressBar.setValue(round(STEPS * share))

    def setOutcome(self, text: str, *, good: bool = True) -> None:
        """Show how the last transfer ended; with an empty text, nothing."""
        self.outcomeLabel.setText(text[:1].upper() + text[1:])
        self.outcomeLabel.setVisible(bool(text))
        restyle(self.outcomeLabel, "problem", not good)

    def confirmUpload(self, name: str, path: str, proceed: Callable[[], None]) -> None:
        """Call `proceed` if the user agrees that a file in the camera is replaced by the one at `path`."""
        title = self.tr("Replace {0} in the camera by {1}?").format(name, path)
        if is_firmware(name):
            detail = self.tr(
                "This is firmware: a wrong file, or a power cut meanwhile, may leave the camera useless."
            )
            self._ask(title, detail, self.tr("Replace the firmware"), proceed)
        else:
            detail = self.tr("The camera keeps no copy of its present content.")
            self._ask(title, detail, self.tr("Replace"), proceed)

    def _ask_delete(self) -> None:
        if (chosen := self.chosen) is not None:
            self._ask(
                self.tr("Delete {0} in the camera?").format(chosen.name),
                self.tr("This cannot be undone."),
                self.tr("Delete"),
                lambda: self.deleteRequested.emit(chosen.name),
            )

    def _ask(self, title: str, detail: str, agreement: str, proceed: Callable[[], None]) -> None:
        self.question = box = question_box(self, title, detail)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        agree = box.addButton(agreement, QMessageBox.ButtonRole.DestructiveRole)
        box.setDefaultButton(box.addButton(QMessageBox.StandardButton.Cancel))

        def answered() -> None:
            self.question = None
            if box.clickedButton() is agree:
                proceed()

        box.finished.connect(lambda _: answered())
        box.open()

    def _row(self, file: CameraFile) -> tuple[str, str, str]:
        size = "–" if file.size is None else self.tr("{0} B").format(self.locale().toString(file.size))
        return file.name, size, ", ".join(f"{name}: {value}" for name, value in file.details.items())

    def _emit_for_chosen(self, signal: pyqtBoundSignal) -> None:
        if (chosen := self.chosen) is not None:
            signal.emit(chosen.name)

    def _enable(self) -> None:
        file, reason = self.chosen, None
        if self._busy:
            reason = Unavailable.PATIENCE
        elif not self._reachable:
            reason = Unavailable.FILE_TRANSFER
        elif file is None:
            reason = Unavailable.CAMERA_FILE
        modes = file.modes if file is not None else ()
        both = not modes or "ReadWrite" in modes
        read = both or READ in modes
        write = both or WRITE in modes
        set_available(self.downloadButton, reason or (None if read else Unavailable.FILE_READING))
        set_available(self.uploadButton, reason or (None if write else Unavailable.FILE_WRITING))
        firmware = file is not None and is_firmware(file.name)
        kept = Unavailable.FIRMWARE if firmware else None if write else Unavailable.FILE_WRITING
        set_available(self.deleteButton, reason or kept)
