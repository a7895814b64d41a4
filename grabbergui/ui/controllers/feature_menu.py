"""The menu that a right click on a feature opens."""

from __future__ import annotations

from PyQt5.QtCore import QObject, QPoint, Qt, pyqtSignal
from PyQt5.QtWidgets import QApplication, QMenu

from grabbergui.core.features import FeatureDescription, format_value
from grabbergui.models.connection import Connection
from grabbergui.models.features.value_watch import PLOTTABLE
from grabbergui.ui.controllers.favourites import FavouritesController
from grabbergui.ui.views.main_window import MainWindow


class FeatureMenuController(QObject):
    """What can be done with any feature, whatever its kind."""

    plotRequested = pyqtSignal(FeatureDescription)

    def __init__(self, window: MainWindow, connection: Connection, at_hand: FavouritesController) -> None:
        super().__init__(window)
        self._favourites = at_hand
        self._window = window
        self._connection = connection
        self.menu: QMenu | None = None
        "Open just now, if any."
        for rows in (window.features.rows, window.favourites.rows):
            rows.menuRequested.connect(self._on_menu_requested)

    def _on_menu_requested(self, name: str, where: QPoint) -> None:
        source = self._connection.source
        description = source.features.description(name) if source and source.features else None
        if source is None or source.features is None or description is None:
            return
        menu = QMenu(self._window)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        if description.kind in PLOTTABLE:
            menu.addAction(self.tr("&Plot over time"), lambda: self.plotRequested.emit(description))
        self._add_favourites(menu, name)
        menu.addSeparator()
        menu.addAction(self.tr("&Copy the name"), lambda: _copy(name))
        feature = source.features.feature(name)
        if feature is not None and feature.value is not None:
            text = f"{name}={format_value(feature.value)}"
            menu.addAction(self.tr("Copy name and &value"), lambda: _copy(text))
        menu.aboutToHide.connect(self._on_menu_hidden)
        self.menu = menu
        menu.popup(where)

    def _add_favourites(self, menu: QMenu, name: str) -> None:
        at_hand = self._favourites
        if name not in at_hand.names:
            menu.addAction(self.tr("Keep at &hand"), lambda: at_hand.add(name))
            return
        place = at_hand.names.index(name)
        menu.addSeparator()
        menu.addAction(self.tr("&Remove from what is at hand"), lambda: at_hand.remove(name))
        for text, steps, possible in (
            (self.tr("Move to the &left"), -1, place > 0),
            (self.tr("Move to the ri&ght"), 1, place + 1 < len(at_hand.names)),
        ):
            action = menu.addAction(text, lambda steps=steps: at_hand.move(name, steps))
            if action is not None:
                action.setEnabled(possible)
        menu.addAction(self.tr("&Usual controls at hand"), at_hand.reset)

    def _on_menu_hidden(self) -> None:
        self.menu = None


def _copy(text: str) -> None:
    if (clipboard := QApplication.clipboard()) is not None:
        clipboard.setText(text)
