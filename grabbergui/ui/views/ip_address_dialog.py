"""The dialog that gives a GigE Vision camera an IP address."""

from __future__ import annotations

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QCheckBox, QDialog, QLabel, QLineEdit, QPushButton, QWidget

from grabbergui.core.visible_text import shortened
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.actions import set_available
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.screen import fit_screen
from grabbergui.ui.shown_text import set_tooltip
from grabbergui.ui.widgets.labels import ElidedLabel, restyle

MOST_REASON = 300
"Characters of a reason or a result that are shown; the tooltip has all of them."


class IpAddressDialog(QDialog):
    """Setters and a signal."""

    setRequested = pyqtSignal(str, str, str, bool)
    """Address, mask, gateway (may be empty), and whether to keep them."""

    cameraLabel: ElidedLabel
    reasonLabel: QLabel
    ipEdit: QLineEdit
    maskEdit: QLineEdit
    gatewayEdit: QLineEdit
    keepBox: QCheckBox
    resultLabel: QLabel
    setButton: QPushButton
    closeButton: QPushButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("ip_address", self)
        self.setButton.clicked.connect(self._on_set_clicked)
        self.closeButton.clicked.connect(self.reject)
        self.setOutcome("", good=True)
        fit_screen(self)

    def setCamera(self, title: str, mac: str, reason: str) -> None:
        """Show which camera it is, and why it needs an address."""
        self.cameraLabel.setText(f"{title} · {mac}")
        self.reasonLabel.setText(shortened(reason[:1].upper() + reason[1:], MOST_REASON))
        set_tooltip(self.reasonLabel, reason)

    def setProposal(self, ip: str, mask: str) -> None:
        """Fill the fields."""
        self.ipEdit.setText(ip)
        self.maskEdit.setText(mask)
        self.ipEdit.selectAll()

    def setWorking(self) -> None:
        """Show that the camera is being asked."""
        set_available(self.setButton, Unavailable.PATIENCE)
        self._show(self.tr("Waiting for the camera…"), "idle")

    def setOutcome(self, text: str, *, good: bool) -> None:
        """Show how it ended."""
        set_available(self.setButton, None)
        self._show(text, "idle" if good else "bad")

    def _show(self, text: str, tone: str) -> None:
        self.resultLabel.setText(shortened(text[:1].upper() + text[1:], MOST_REASON))
        set_tooltip(self.resultLabel, text)
        restyle(self.resultLabel, "tone", tone)

    def _on_set_clicked(self) -> None:
        edits = (self.ipEdit, self.maskEdit, self.gatewayEdit)
        self.setRequested.emit(*(edit.text().strip() for edit in edits), self.keepBox.isChecked())
