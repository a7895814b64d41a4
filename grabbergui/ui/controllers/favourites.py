"""Joins what is at hand to what was chosen for this model of camera."""

from __future__ import annotations

from collections.abc import Callable

from PyQt5.QtCore import QObject, pyqtSignal

from grabbergui.core.grabber import DeviceInfo
from grabbergui.models.connection import Connection
from grabbergui.models.features import shown
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.controllers.features import FeatureController
from grabbergui.ui.preferences import LAYOUT_VERSION, Preferences, camera_model
from grabbergui.ui.views.main_window import MainWindow


class FavouritesController(QObject):
    """Favourites and the layout of the window are remembered for each model of camera."""

    failed = pyqtSignal(str)
    """What did not work, for the window's error bar."""

    def __init__(
        self,
        window: MainWindow,
        connection: Connection,
        features: FeatureController,
        preferences: Preferences,
    ) -> None:
        super().__init__(window)
        self._window = window
        self._features = features
        self._preferences = preferences
        self._model = ""
        "Of the camera at hand; empty where there is none."
        Bridge(self).bind(connection.closing, lambda _: self.keep_layout())
        window.favourites.dropped.connect(self.place)

    def restore(self, info: DeviceInfo) -> None:
        """Arrange the window as it was for this model of camera, whose features are shown."""
        self._model = camera_model(info)
        known = self._preferences.favourites_of(self._model)
        if known is not None:
            self._features.show_favourites(known)
        layout = self._preferences.layout_of(self._model)
        if layout is not None:
            self._window.restoreState(layout, LAYOUT_VERSION)

    @property
    def names(self) -> tuple[str, ...]:
        """What is at hand."""
        return self._features.favourites

    def place(self, name: str, index: int) -> None:
        """Have a feature at hand, before the one at `index`."""
        if name not in self.names and len(self.names) >= shown.MOST:
            text = self.tr("no more than {0} controls can be at hand; remove one first")
            self.failed.emit(text.format(shown.MOST))
            return
        self._change(lambda names: shown.placed(names, name, index))

    def add(self, name: str) -> None:
        """Have a feature at hand, behind the others."""
        self.place(name, len(self.names))

    def remove(self, name: str) -> None:
        """Have it at hand no longer."""
        self._change(lambda names: shown.without(names, name))

    def move(self, name: str, steps: int) -> None:
        """Have it some places further on, or back."""
        self._change(lambda names: shown.moved(names, name, steps))

    def reset(self) -> None:
        """Have at hand what suits any camera."""
        self._features.show_favourites(None)
        self._preferences.keep_favourites(self._model, None)

    def keep_layout(self) -> None:
        """Remember how the window is arranged now for the camera at hand."""
        if self._model:
            self._preferences.keep_layout_of(self._model, self._window.saveState(LAYOUT_VERSION))
            self._model = ""

    def _change(self, change: Callable[[tuple[str, ...]], tuple[str, ...]]) -> None:
        names = change(self.names)
        if self._model and names != self.names:
            self._features.show_favourites(names)
            self._preferences.keep_favourites(self._model, names)
