"""The dialog that shows what a camera's report contains before it is written."""

from __future__ import annotations

from collections.abc import Sequence

from PyQt5.QtCore import QSize, pyqtSignal
from PyQt5.QtWidgets import QCheckBox, QDialog, QDialogButtonBox, QPlainTextEdit, QVBoxLayout, QWidget

from grabbergui.ui.dialog_style import dress_dialog
from grabbergui.ui.screen import fit_screen
from grabbergui.ui.shown_text import PlainLabel, set_tooltip

SIZE = QSize(640, 420)


class ReportDialog(QDialog):
    """Lists the contents as plain text: they repeat what the camera says."""

    optionsChanged = pyqtSignal()
    """Whether names or pixels are kept."""
    saveRequested = pyqtSignal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle(self.tr("Report this camera"))
        self.stateLabel = PlainLabel(self.tr("Asking the camera and this computer…"), self)
        self.stateLabel.setWordWrap(True)
        self.text = QPlainTextEdit(self)
        self.text.setReadOnly(True)
        self.text.setAccessibleName(self.tr("Contents of the report"))
        self.namesBox = QCheckBox(self.tr("Keep &names, serial numbers and addresses"), self)
        set_tooltip(self.namesBox, self.tr("Otherwise stand-ins replace them, also in registers and log"))
        self.pixelsBox = QCheckBox(self.tr("With the &pixels of some frames"), self)
        for box in (self.namesBox, self.pixelsBox):
            box.toggled.connect(self.optionsChanged)
        self.buttons = QDialogButtonBox(self)
        self.saveButton = self.buttons.addButton(QDialogButtonBox.StandardButton.Save)
        self.buttons.addButton(QDialogButtonBox.StandardButton.Close)
        self.buttons.accepted.connect(self.saveRequested)
        self.buttons.rejected.connect(self.reject)
        layout = QVBoxLayout(self)
        for widget in (self.stateLabel, self.text, self.namesBox, self.pixelsBox, self.buttons):
            layout.addWidget(widget)
        dress_dialog(self, self.saveButton)
        self._set_ready(ready=False)
        self.resize(SIZE)
        fit_screen(self)

    def setContents(self, lines: Sequence[str]) -> None:
        """Show what the file will contain."""
        self.stateLabel.setText(self.tr("The file will contain:"))
        self.text.setPlainText("\n".join(lines))
        self._set_ready(ready=True)

    def _set_ready(self, *, ready: bool) -> None:
        for widget in (self.namesBox, self.pixelsBox, self.saveButton):
            assert widget is not None
            widget.setEnabled(ready)
