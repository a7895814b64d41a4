"""What every editor of a feature has in common."""

from __future__ import annotations

from abc import abstractmethod

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QHBoxLayout, QWidget

from grabbergui.core.features import Feature


class FeatureEditor(QWidget):
    """Shows a feature and lets it be edited. One subclass a kind of control.

    `setFeature` shows and never emits. What a person does is told by the signals, and only that.
    """

    valueEdited = pyqtSignal(object)
    """The value a person wants (int, float, bool or str); None to run a command."""
    editingStarted = pyqtSignal()
    """A person has the control in hand: it is dragged or typed into."""
    editingFinished = pyqtSignal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._layout = QHBoxLayout(self)
        self._layout.setContentsMargins(0, 0, 0, 0)
        self._layout.setSpacing(4)

    @abstractmethod
    def setFeature(self, feature: Feature) -> None:
        """Show a feature of the kind this editor is for."""

    def slider(self) -> QWidget | None:
        """A part that wants a line of its own, as wide as it gets; the row places it."""
        return None

    def hold(self, control: QWidget) -> None:
        """Make a control the editor's, with the focus going to it."""
        self._layout.addWidget(control)
        self.setFocusProxy(control)
