"""The button of a feature's automatic mode."""

from __future__ import annotations

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QCursor
from PyQt5.QtWidgets import (
    QAction,
    QActionGroup,
    QMenu,
    QToolButton,
    QWidget,
)

from grabbergui.core.features import (
    Feature,
    FeatureKind,
)
from grabbergui.core.sfnc import AUTO_CONTINUOUS, AUTO_OFF, AUTO_ONCE
from grabbergui.models.features.feature_text import access_text
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.actions import set_available
from grabbergui.ui.shown_text import set_tooltip


class AutoButton(QToolButton):
    """Lit while the automatic mode is on. A click toggles it; its menu has every mode, Once included.

    Disabled until `setFeature`.
    """

    modeChosen = pyqtSignal(object)
    """The value for the automatic mode's feature."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._feature: Feature | None = None
        self._menu = QMenu(self)
        self._menu.setToolTipsVisible(True)
        self._group = QActionGroup(self)
        self._group.triggered.connect(lambda action: self.modeChosen.emit(action.data()))
        self.setCheckable(True)
        self.setEnabled(False)
        self.setPopupMode(QToolButton.ToolButtonPopupMode.MenuButtonPopup)  # as wide as it will be
        self.setText(self.tr("Auto"))
        self.clicked[bool].connect(self._on_clicked)
        self._menu.aboutToHide.connect(self._forget_mouse)

    def setFeature(self, feature: Feature) -> None:
        """Show the state of an automatic mode: an enumeration with Off, or a boolean."""
        entries_changed = self._feature is None or self._feature.entries != feature.entries
        self._feature = feature
        if entries_changed:
            self._fill_menu(feature)
        self.setChecked(feature.value not in (AUTO_OFF, False, None))
        self.setText(self.tr("Once") if feature.value == AUTO_ONCE else self.tr("Auto"))
        for action in self._group.actions():
            action.setChecked(action.data() == feature.value)
        self.setEnabled(feature.access.writable)
        self.setAccessibleName(feature.title)
        state = f"{feature.title}: {feature.value}"
        problem = self.tr("{0}\nIt {1}.").format(state, access_text(feature))
        set_tooltip(self, state if feature.access.writable else problem)

    def _fill_menu(self, feature: Feature) -> None:
        self._menu.clear()
        for action in self._group.actions():
            action.deleteLater()
            self._group.removeAction(action)
        for entry in feature.entries:
            action = QAction(entry.title, self._group)
            action.setData(entry.name)
            action.setCheckable(True)
            set_available(action, None if entry.available else Unavailable.OFFER)
        self._menu.addActions(self._group.actions())
        self.setMenu(self._menu if feature.entries else None)
        self.setPopupMode(
            QToolButton.ToolButtonPopupMode.MenuButtonPopup
            if feature.entries
            else QToolButton.ToolButtonPopupMode.DelayedPopup
        )

    def _forget_mouse(self) -> None:
        """End the hover state: Qt sends no leave event while the menu is open."""
        if not self.rect().contains(self.mapFromGlobal(QCursor.pos())):
            self.setAttribute(Qt.WidgetAttribute.WA_UnderMouse, False)
            self.update()

    def _on_clicked(self, checked: bool) -> None:
        feature = self._feature
        if feature is None:
            return
        # The camera's answer sets the state, not the click.
        self.setChecked(not checked)
        if feature.kind is FeatureKind.BOOLEAN:
            self.modeChosen.emit(checked)
        elif checked:
            names = [entry.name for entry in feature.entries if entry.available]
            modes = [
                name for name in (AUTO_CONTINUOUS, AUTO_ONCE, *names) if name in names and name != AUTO_OFF
            ]
            if modes:
                self.modeChosen.emit(modes[0])
        else:
            self.modeChosen.emit(AUTO_OFF)
