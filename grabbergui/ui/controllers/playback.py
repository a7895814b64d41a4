"""Joins the playback bar to a source that is a recording."""

from __future__ import annotations

from PyQt5.QtCore import QObject, pyqtSignal

from grabbergui.core.errors import GrabberError
from grabbergui.models.connection import Connection
from grabbergui.models.error_text import error_text
from grabbergui.models.open_source import OpenSource
from grabbergui.models.playback import PlaybackModel, PlaybackState, is_recording
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.views.main_window import MainWindow


class PlaybackController(QObject):
    """Shows the bar for sources with a recording's features; pause and step act on the recording then."""

    failed = pyqtSignal(str)
    """What did not work, for the window's error bar."""

    def __init__(self, window: MainWindow, connection: Connection) -> None:
        super().__init__(window)
        self._window = window
        self._bar = bar = window.picture.playbackBar
        self._connection = connection
        self._model: PlaybackModel | None = None
        self._bridge: Bridge | None = None
        join = Bridge(self)
        join.bind(connection.opened, self._on_connection_opened)
        join.bind(connection.closing, lambda _: self._leave())
        bar.playRequested.connect(lambda playing: self._model.play(playing) if self._model else None)
        bar.stepRequested.connect(self._step)
        bar.positionChosen.connect(lambda place: self._model.go_to(place) if self._model else None)
        bar.speedChosen.connect(lambda speed: self._model.set_speed(speed) if self._model else None)
        bar.loopRequested.connect(lambda loop: self._model.set_loop(loop) if self._model else None)
        window.actionPause.triggered[bool].connect(self._on_pause_triggered)
        window.actionStepBack.triggered.connect(lambda: self._step(-1))
        window.actionStepForward.triggered.connect(lambda: self._step(1))

    def _on_connection_opened(self, source: OpenSource) -> None:
        self._leave()
        if source is not self._connection.source or source.grabber is None:
            return
        if not is_recording(source.grabber):
            return
        self._model = model = PlaybackModel(source)
        self._bridge = Bridge(self)
        self._bridge.bind(model.changed, self._on_model_changed)
        self._bridge.bind(model.failed, self._on_model_failed)
        self._bar.setState(model.state)
        self._bar.show()

    def _leave(self) -> None:
        if self._model is not None and self._bridge is not None:
            self._model.close()
            self._bridge.close()
        self._model = self._bridge = None
        self._bar.hide()

    def _on_model_changed(self, state: PlaybackState) -> None:
        self._bar.setState(state)
        self._window.actionPause.setChecked(not state.playing)

    def _on_model_failed(self, error: GrabberError) -> None:
        self.failed.emit(error_text(error))

    def _on_pause_triggered(self, paused: bool) -> None:
        if self._model is not None:
            self._model.play(not paused)

    def _step(self, steps: int) -> None:
        if self._model is not None:
            self._model.step(steps)
