"""Editors for switches, commands, and values that can only be read."""

from __future__ import annotations

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QCheckBox, QLabel, QPushButton, QWidget

from grabbergui.core.features import Feature, FeatureKind
from grabbergui.models.features.text import value_text
from grabbergui.ui.editors.feature_editor import FeatureEditor


class SwitchEditor(FeatureEditor):
    """A check box, for booleans and for integers that are one."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._integer = False
        self.box = QCheckBox()
        self.hold(self.box)
        self._layout.addStretch()
        self.box.clicked[bool].connect(self._on_box_clicked)

    def setFeature(self, feature: Feature) -> None:
        """Show whether it is on."""
        self._integer = feature.kind is FeatureKind.INTEGER
        self.box.setAccessibleName(feature.title)
        self.box.setChecked(bool(feature.value))

    def _on_box_clicked(self, checked: bool) -> None:
        self.valueEdited.emit(int(checked) if self._integer else checked)


class CommandEditor(FeatureEditor):
    """A button that runs a command."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.button = QPushButton(self.tr("Run"))
        self.hold(self.button)
        self.button.clicked.connect(lambda: self.valueEdited.emit(None))

    def setFeature(self, feature: Feature) -> None:
        """Name the button."""
        self.button.setAccessibleName(feature.title)


class ReadingLabel(FeatureEditor):
    """Text that can be selected and copied, for what cannot be written."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.label = QLabel()
        self.label.setTextFormat(Qt.TextFormat.PlainText)
        self.label.setWordWrap(True)
        self.label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.label.setMargin(3)
        self.hold(self.label)

    def setFeature(self, feature: Feature) -> None:
        """Show the value and its unit."""
        self.label.setAccessibleName(feature.title)
        text = feature.kind in (FeatureKind.STRING, FeatureKind.ENUMERATION) or feature.value is None
        side = Qt.AlignmentFlag.AlignLeft if text else Qt.AlignmentFlag.AlignRight
        self.label.setAlignment(Qt.Alignment(side) | Qt.AlignmentFlag.AlignVCenter)
        self.label.setText(value_text(feature))
