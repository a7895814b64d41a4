"""Pause and steps, through the last frames of a camera or through a recording."""

from __future__ import annotations

from PyQt5.QtCore import QObject

from grabbergui.core.errors import GrabberError
from grabbergui.core.frame import Frame
from grabbergui.models.connection import Connection
from grabbergui.models.error_text import error_text
from grabbergui.models.messages import CurrentMessages
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.picture.frame_history import FrameHistory
from grabbergui.models.picture.picture import PictureModel
from grabbergui.models.playback import PlaybackModel, PlaybackState, is_recording
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.views.bases import PauseActions
from grabbergui.ui.widgets.playback_bar import PauseBar, PlaybackBar


class PauseController(QObject):
    """The camera goes on while the picture is paused."""

    def __init__(
        self,
        actions: PauseActions,
        bar: PauseBar,
        connection: Connection,
        picture: PictureModel,
        history: FrameHistory,
        messages: CurrentMessages,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._actions = actions
        self._bar = bar
        self._messages = messages
        self._connection = connection
        self._picture = picture
        self._history = history
        self._frames: tuple[Frame, ...] = ()
        self._index = 0
        self._steps_itself = False
        "Whether the source is a recording, which is stepped through by itself."
        bridge = Bridge(self)
        bridge.bind(connection.opened, self._on_connection_opened)
        bridge.bind(connection.state_changed, self._on_connection_state_changed)
        # Not over the bridge: the queue must be closed before the grabber.
        connection.closing.connect(self._on_connection_closing, check_nargs=False)
        bar.frameChosen.connect(self._show)
        bar.liveRequested.connect(lambda: actions.actionPause.setChecked(False))
        actions.actionPause.toggled.connect(self._on_pause_toggled)
        actions.actionStepBack.triggered.connect(lambda: self._step(-1))
        actions.actionStepForward.triggered.connect(lambda: self._step(1))
        self._on_connection_state_changed(connection.state, "")

    def _on_pause_toggled(self, paused: bool) -> None:
        if self._steps_itself:
            return
        self._history.pause(paused)
        self._frames = self._history.frames if paused else ()
        self._bar.setVisible(bool(self._frames))
        if self._frames:
            self._show(len(self._frames) - 1)
            return
        self._picture.freeze(None)
        if paused:
            self._actions.actionPause.setChecked(False)
            self._messages.error(self.tr("there is no frame yet to pause at; start the camera first"))

    def _step(self, steps: int) -> None:
        if self._steps_itself:
            return
        if not self._actions.actionPause.isChecked():
            self._actions.actionPause.setChecked(True)
        if self._frames:
            self._show(min(max(self._index + steps, 0), len(self._frames) - 1))

    def _show(self, index: int) -> None:
        self._index = index
        frame, newest = self._frames[index], self._frames[-1]
        self._picture.freeze(frame)
        self._bar.setPlace(index, len(self._frames), _seconds(frame, newest))

    def _on_connection_opened(self, source: OpenSource) -> None:
        if source is self._connection.source and source.grabber is not None:
            self._actions.actionPause.setChecked(False)
            self._steps_itself = is_recording(source.grabber)
            if not self._steps_itself:
                self._history.attach(source.grabber)

    def _on_connection_closing(self, _: OpenSource) -> None:
        self._history.detach()

    def _on_connection_state_changed(self, state: LinkState, _: str) -> None:
        if state in (LinkState.CLOSED, LinkState.OPENING):
            self._actions.actionPause.setChecked(False)
        actions = self._actions
        for action in (actions.actionPause, actions.actionStepBack, actions.actionStepForward):
            action.setEnabled(state.connected or state is LinkState.LOST)


def _seconds(frame: Frame, newest: Frame) -> float:
    """How much older a frame is, by the camera's clock where it has one."""
    if frame.timestamp_ns and newest.timestamp_ns:
        return (newest.timestamp_ns - frame.timestamp_ns) / 1e9
    return newest.captured - frame.captured


class PlaybackController(QObject):
    """Shows the bar for sources with a recording's features; pause and step act on the recording then."""

    def __init__(
        self,
        actions: PauseActions,
        bar: PlaybackBar,
        connection: Connection,
        messages: CurrentMessages,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._actions = actions
        self._bar = bar
        self._messages = messages
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
        actions.actionPause.triggered[bool].connect(self._on_pause_triggered)
        actions.actionStepBack.triggered.connect(lambda: self._step(-1))
        actions.actionStepForward.triggered.connect(lambda: self._step(1))

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
        self._actions.actionPause.setChecked(not state.playing)

    def _on_model_failed(self, error: GrabberError) -> None:
        self._messages.error(error_text(error))

    def _on_pause_triggered(self, paused: bool) -> None:
        if self._model is not None:
            self._model.play(not paused)

    def _step(self, steps: int) -> None:
        if self._model is not None:
            self._model.step(steps)
