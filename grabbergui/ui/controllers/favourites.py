"""The pinned controls of each model of camera, and the menu that pins them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PyQt5.QtCore import QObject, QPoint, Qt, pyqtSignal
from PyQt5.QtWidgets import QApplication, QMenu, QWidget

from grabbergui.core.features import FeatureDescription, format_value
from grabbergui.core.grabber import DeviceInfo
from grabbergui.models.connection import Connection
from grabbergui.models.features import shown
from grabbergui.models.features.value_watch import PLOTTABLE
from grabbergui.models.messages import CurrentMessages
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.controllers.features import FeatureController
from grabbergui.ui.editors.feature_row import FeatureRows
from grabbergui.ui.preferences import LAYOUT_VERSION, Preferences, camera_model
from grabbergui.ui.views.bases import Layout
from grabbergui.ui.views.favourites import FavouritesStrip


class FavouritesController(QObject):
    """Favourites and the layout of the window are remembered for each model of camera."""

    def __init__(
        self,
        layout: Layout,
        strip: FavouritesStrip,
        connection: Connection,
        features: FeatureController,
        preferences: Preferences,
        messages: CurrentMessages,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._layout = layout
        self._messages = messages
        self._features = features
        self._preferences = preferences
        self._model = ""
        "Of the current camera; empty if there is none."
        Bridge(self).bind(connection.closing, lambda _: self.keep_layout())
        strip.dropped.connect(self.place)

    def restore(self, info: DeviceInfo) -> None:
        """Arrange the window as it was for this model of camera, whose features are shown."""
        self._model = camera_model(info)
        known = self._preferences.favourites_of(self._model)
        if known is not None:
            self._features.show_favourites(known)
        layout = self._preferences.layout_of(self._model)
        if layout is not None:
            self._layout.restoreState(layout, LAYOUT_VERSION)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the pinned controls."""
        return self._features.favourites

    def place(self, name: str, index: int) -> None:
        """Pin a feature before the one at `index`."""
        if name not in self.names and len(self.names) >= shown.MOST:
            text = self.tr("no more than {0} controls can be pinned; unpin one first")
            self._messages.error(text.format(shown.MOST))
            return
        self._change(lambda names: shown.placed(names, name, index))

    def add(self, name: str) -> None:
        """Pin a feature behind the others."""
        self.place(name, len(self.names))

    def remove(self, name: str) -> None:
        """Unpin a feature."""
        self._change(lambda names: shown.without(names, name))

    def move(self, name: str, steps: int) -> None:
        """Move a pinned control by so many places."""
        self._change(lambda names: shown.moved(names, name, steps))

    def reset(self) -> None:
        """Pin the usual controls."""
        self._features.show_favourites(None)
        self._preferences.keep_favourites(self._model, None)

    def keep_layout(self) -> None:
        """Remember the arrangement of the window for the current camera."""
        if self._model:
            self._preferences.keep_layout_of(self._model, self._layout.saveState(LAYOUT_VERSION))
            self._model = ""

    def _change(self, change: Callable[[tuple[str, ...]], tuple[str, ...]]) -> None:
        names = change(self.names)
        if self._model and names != self.names:
            self._features.show_favourites(names)
            self._preferences.keep_favourites(self._model, names)


class FeatureMenuController(QObject):
    """The context menu of any feature."""

    plotRequested = pyqtSignal(FeatureDescription)

    def __init__(
        self,
        window: QWidget,
        shown: Sequence[FeatureRows],
        connection: Connection,
        favourites: FavouritesController,
    ) -> None:
        super().__init__(window)
        self._favourites = favourites
        self._window = window
        self._connection = connection
        self.menu: QMenu | None = None
        "The menu that is open, if any."
        for rows in shown:
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
        pinned = self._favourites
        if name not in pinned.names:
            menu.addAction(self.tr("P&in"), lambda: pinned.add(name))
            return
        place = pinned.names.index(name)
        menu.addSeparator()
        menu.addAction(self.tr("&Unpin"), lambda: pinned.remove(name))
        for text, steps, possible in (
            (self.tr("Move to the &left"), -1, place > 0),
            (self.tr("Move to the ri&ght"), 1, place + 1 < len(pinned.names)),
        ):
            action = menu.addAction(text, lambda steps=steps: pinned.move(name, steps))
            if action is not None:
                action.setEnabled(possible)
        menu.addAction(self.tr("Pin t&he usual controls"), pinned.reset)

    def _on_menu_hidden(self) -> None:
        self.menu = None


def _copy(text: str) -> None:
    if (clipboard := QApplication.clipboard()) is not None:
        clipboard.setText(text)
