"""Windows of the *Help* menu: the manual, and what the doctor found."""

from __future__ import annotations

import html
import re
from pathlib import Path
from typing import Any

from PyQt5.QtCore import QSize, Qt, QUrl
from PyQt5.QtGui import QDesktopServices, QImage
from PyQt5.QtWidgets import QDialog, QLabel, QPushButton, QTextBrowser, QVBoxLayout, QWidget

from grabbergui.doctor.finding import Finding, Level

FIRST_PAGE = "window.md"
SIZE = QSize(820, 640)
PICTURE_WIDTH = 740

_PICTURE = re.compile(r'<picture>.*?<img src="([^"]*)" alt="([^"]*)">\s*</picture>', re.DOTALL)
"""Qt's Markdown ends at HTML that it does not know."""


class ManualBrowser(QTextBrowser):
    """Shows Markdown pages; pictures are made to fit, and those in HTML are shown too."""

    def loadResource(self, kind: int, name: QUrl) -> Any:
        """Read a page or a picture from its file."""
        path = Path(self.source().resolved(name).toLocalFile())
        if path.suffix == ".md":
            return _PICTURE.sub(r"![\2](\1)", path.read_text("utf-8"))
        picture = QImage(str(path))
        if picture.width() <= PICTURE_WIDTH:
            return picture
        return picture.scaledToWidth(PICTURE_WIDTH, Qt.TransformationMode.SmoothTransformation)


class ManualDialog(QDialog):
    """The pages of the manual, with links between them; others open in the desktop's browser."""

    def __init__(self, folder: Path, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle(self.tr("Manual"))
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.text = ManualBrowser(self)
        self.text.setAccessibleName(self.tr("Manual"))
        self.text.setOpenLinks(False)
        self.text.anchorClicked.connect(self._follow)
        self.text.setSource(QUrl.fromLocalFile(str(folder / FIRST_PAGE)))
        back = QPushButton(self.tr("&Back"), self)
        back.setAutoDefault(False)
        back.setEnabled(False)
        back.clicked.connect(self.text.backward)
        self.text.backwardAvailable.connect(back.setEnabled)
        layout = QVBoxLayout(self)
        layout.addWidget(self.text)
        layout.addWidget(back, 0, Qt.AlignmentFlag.AlignLeft)
        self.resize(SIZE)

    def _follow(self, link: QUrl) -> None:
        target = self.text.source().resolved(link)
        if target.isLocalFile() and Path(target.toLocalFile()).suffix == ".md":
            self.text.setSource(target)
        else:
            QDesktopServices.openUrl(target)


class DoctorDialog(QDialog):
    """Findings as they come, each with what to do about it."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle(self.tr("Doctor"))
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.text = QTextBrowser(self)
        self.text.setAccessibleName(self.tr("What was found"))
        self.stateLabel = QLabel(self.tr("Checking this computer…"), self)
        self._names = {
            Level.GOOD: self.tr("good"),
            Level.NOTE: self.tr("note"),
            Level.PROBLEM: self.tr("problem"),
        }
        self._problems = 0
        layout = QVBoxLayout(self)
        layout.addWidget(self.stateLabel)
        layout.addWidget(self.text)
        self.resize(SIZE)

    def addFinding(self, finding: Finding) -> None:
        """Show one more."""
        self._problems += finding.level is Level.PROBLEM
        line = f"<b>{self._names[finding.level]}</b>: {html.escape(finding.text)}"
        if finding.remedy:
            line += f"<br>→ {html.escape(finding.remedy)}"
        self.text.append(f"<p>{line}</p>")

    def finish(self) -> None:
        """Say that nothing more comes."""
        found = self.tr("{0} problems found").format(self._problems)
        self.stateLabel.setText(found if self._problems else self.tr("Nothing is wrong"))
