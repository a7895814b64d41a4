"""The servoing window: the picture with what was found in it, the state, curves, and the emergency stop."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QImage, QKeyEvent, QPixmap
from PyQt5.QtWidgets import QLabel, QPushButton, QWidget

from grabbergui.ui.loader import load_form


class ServoWindow(QWidget):
    """Setters and signals; what is shown is decided elsewhere."""

    stopPressed = pyqtSignal()
    resumePressed = pyqtSignal()

    pictureLabel: QLabel
    plotsLabel: QLabel
    stateLabel: QLabel
    stopButton: QPushButton
    resumeButton: QPushButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("servo", self)
        self.stopButton.clicked.connect(lambda: self.stopPressed.emit())
        self.resumeButton.clicked.connect(lambda: self.resumePressed.emit())
        # Keys go to the window itself: a focused button would take Space for a click of its own.
        for button in (self.stopButton, self.resumeButton):
            button.setFocusPolicy(Qt.FocusPolicy.NoFocus)

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Space and Escape stop."""
        if event is not None and event.key() in (Qt.Key.Key_Space, Qt.Key.Key_Escape):
            self.stopPressed.emit()
        else:
            super().keyPressEvent(event)

    def setPicture(self, pixels: NDArray[np.uint8]) -> None:
        """Show a picture (rows, columns, 3) R G B."""
        _show(self.pictureLabel, pixels)

    def setPlots(self, pixels: NDArray[np.uint8]) -> None:
        """Show curves (rows, columns, 3) R G B."""
        _show(self.plotsLabel, pixels)

    def setState(self, state: str, reason: str) -> None:
        """Tell the state and why."""
        self.stateLabel.setText(f"{state}: {reason}")

    def setStopped(self, stopped: bool) -> None:
        """Offer to resume only what is stopped."""
        self.resumeButton.setEnabled(stopped)


def _show(label: QLabel, pixels: NDArray[np.uint8]) -> None:
    scale = min(label.width() / pixels.shape[1], label.height() / pixels.shape[0])
    width, height = (max(1, int(side * scale)) for side in (pixels.shape[1], pixels.shape[0]))
    # Not by Qt, which would keep the loop's thread waiting for the interpreter meanwhile.
    scaled = cv2.resize(pixels, (width, height), interpolation=cv2.INTER_AREA)
    # QImage only borrows the bytes; they live until the pixmap has its own copy.
    data = scaled.tobytes()
    label.setPixmap(QPixmap.fromImage(QImage(data, width, height, 3 * width, QImage.Format.Format_RGB888)))
