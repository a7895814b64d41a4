"""The values along a line through the picture."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QWIDGETSIZE_MAX, QCheckBox, QPushButton, QWidget

from grabbergui.models.measuring.channels import Line
from grabbergui.ui.loader import load_form
from grabbergui.ui.widgets.channel_plot import ChannelPlot
from grabbergui.ui.widgets.elided_label import ElidedLabel


class ProfilePanel(QWidget):
    """Setters for the values; a signal where another line is to be drawn."""

    lineRequested = pyqtSignal()
    rawToggled = pyqtSignal()
    """The sensor's own values are wanted, or the colours shown: see `rawBox`."""

    lineLabel: ElidedLabel
    rawBox: QCheckBox
    lineButton: QPushButton
    plot: ChannelPlot

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("profile_panel", self)
        self.plot.setToolTip(self.tr("The sensor's values over the pixels along the line"))
        self.rawBox.toggled.connect(self.rawToggled)
        self.lineButton.clicked.connect(self.lineRequested)
        self.setLine(None)
        self.clear()

    def setLine(self, line: Line | None) -> None:
        """Say where the line is, in the frame's pixels."""
        if line is None:
            self.lineLabel.setText(self.tr("Draw a line through the picture to see its values."))
        else:
            self.lineLabel.setText(f"({line.x0}, {line.y0}) … ({line.x1}, {line.y1})")

    def setProfile(self, profile: dict[str, NDArray[Any]]) -> None:
        """Show the values of each channel along the line."""
        samples = len(next(iter(profile.values())))
        self.plot.setChannels(np.arange(samples), profile)
        self.plot.showAxes((True, False, False, True))
        self._give_room(True)

    def clear(self) -> None:
        """Nothing was measured."""
        self.plot.clearChannels()
        self.plot.showAxes(False)  # they would be of nothing
        self._give_room(False)

    def _give_room(self, needed: bool) -> None:
        """Be no higher than the line that says what to do, until there is something to show."""
        self.plot.setVisible(needed)
        self.setMaximumHeight(QWIDGETSIZE_MAX if needed else self.minimumSizeHint().height())
