"""Joins what changes the view of the picture to the picture: turning, marks, colours, levels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from PyQt5.QtCore import QObject, pyqtSignal

from grabbergui.models.connection import Connection
from grabbergui.models.open_source import OpenSource
from grabbergui.models.picture.geometry import Orientation
from grabbergui.models.picture.picture import PictureModel
from grabbergui.models.picture.rendering import Levels, with_levels
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.views.main_window import MainWindow


class LookingController(QObject):
    """Nothing here changes the camera, or what is saved."""

    orientationChanged = pyqtSignal()

    def __init__(self, window: MainWindow, connection: Connection, picture: PictureModel) -> None:
        super().__init__(window)
        self._window = window
        self._picture = picture
        marks = window.picture.canvas.marks
        Bridge(self).bind(connection.opened, self._on_connection_opened)
        window.actionCrosshair.toggled.connect(marks.setCrosshair)
        window.actionGrid.toggled.connect(marks.setGrid)
        window.actionClipping.toggled.connect(self._on_clipping_toggled)
        window.colourMapChosen.connect(self._on_colour_map_chosen)
        window.histogram.levelsDragged.connect(self._on_levels_dragged)
        window.histogram.levelsReset.connect(self._reset_levels)
        for action, change in (
            (window.actionTurnRight, lambda seen: seen.turned(1)),
            (window.actionTurnLeft, lambda seen: seen.turned(-1)),
            (window.actionMirrorX, lambda seen: seen.mirrored(x=True)),
            (window.actionMirrorY, lambda seen: seen.mirrored(y=True)),
            (window.actionUpright, lambda _: Orientation()),
        ):
            action.triggered.connect(lambda _, change=change: self._turn(change))

    def _turn(self, change: Callable[[Orientation], Orientation]) -> None:
        settings = self._picture.settings
        self._picture.settings = replace(settings, orientation=change(settings.orientation))
        self.orientationChanged.emit()

    def _on_clipping_toggled(self, shown: bool) -> None:
        self._picture.settings = replace(self._picture.settings, show_clipping=shown)

    def _on_colour_map_chosen(self, name: str) -> None:
        self._picture.settings = replace(self._picture.settings, colour_map=name)

    def _on_levels_dragged(self, black: float, white: float) -> None:
        self._picture.settings = with_levels(self._picture.settings, black, white)

    def _reset_levels(self) -> None:
        self._picture.settings = replace(self._picture.settings, levels=Levels())
        self._window.histogram.setLevels(0.0, 1.0)

    def _on_connection_opened(self, _: OpenSource) -> None:
        self._reset_levels()  # those of another camera would make a riddle of this one's picture
