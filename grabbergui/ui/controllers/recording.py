"""Recording the current source, pausing its image, and playing a recording."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PyQt5.QtCore import QObject, Qt, pyqtSignal
from PyQt5.QtWidgets import QAction, QMessageBox

from grabbergui.core.errors import GrabberError
from grabbergui.core.frame import Frame
from grabbergui.core.uri import SourceUri
from grabbergui.models.error_text import error_text
from grabbergui.models.frame_history import FrameHistory
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.playback import PlaybackModel, PlaybackState, is_recording
from grabbergui.models.recording import Recordings
from grabbergui.models.unavailable import why_unavailable
from grabbergui.recording.kinds import RecordingKind
from grabbergui.recording.recorder import RecordingLimits
from grabbergui.ui.actions import set_available
from grabbergui.ui.controllers.frames_to_record import FramesToRecordController
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.shown_text import question_box
from grabbergui.ui.views.bases import PauseActions
from grabbergui.ui.views.recording_bars import PauseBar, PlaybackBar, RecordingBar

Confirm = Callable[[Sequence[OpenSource | None], Callable[[], None]], None]
"""Calls a function that closes these sources; asks first if one of them is being recorded."""


class RecordingController(QObject):
    """Shows and controls the recording of the current source. Those of other sources continue."""

    playRequested = pyqtSignal(str)
    """The URI of a recording to open in place of the camera."""

    def __init__(
        self,
        action: QAction,
        bar: RecordingBar,
        context: SourceContext,
        recordings: Recordings,
        frames: FramesToRecordController,
    ) -> None:
        super().__init__(bar)
        self._files = context.files
        self._action, self._bar = action, bar
        self._open_sources = context.open_sources
        self._recordings = recordings
        self._frames = frames
        self._preferences = context.preferences
        self.question: QMessageBox | None = None
        """The question whether to close a source that is being recorded, while it is open."""
        bridge = Bridge(self)
        bridge.bind(recordings.changed, lambda _: self._show())
        bridge.bind(context.open_sources.state_changed, lambda *_: self._show())
        action.triggered.connect(bar.recordButton.click)
        bar.recordRequested.connect(self.record)
        bar.stopRequested.connect(self.stop)
        bar.folderRequested.connect(self._choose_folder)
        bar.playRequested.connect(self._play)
        self._show()

    def record(self, kind: RecordingKind, limits: RecordingLimits) -> None:
        """Begin to record the current source."""
        if (source := self._open_sources.current) is not None:
            folder = self._preferences.snapshot_folder
            self._recordings.begin(source, folder, kind, limits, self._frames.thinning)

    def stop(self) -> None:
        """End the recording of the current source; its file is finished in the background."""
        if (source := self._open_sources.current) is not None:
            self._recordings.stop(source)

    def confirm(self, closing: Sequence[OpenSource | None], proceed: Callable[[], None]) -> None:
        """Call `proceed`, which closes these sources; ask first if one of them is being recorded."""
        recorded = [source for source in closing if source is not None and self._recordings.runs(source)]
        if not recorded:
            proceed()
            return
        if self.question is not None:
            self.question.raise_()
            return
        names = ", ".join(source.title for source in recorded)
        box = question_box(
            self._bar.window() or self._bar,
            self.tr("Being recorded: {0}").format(names),
            self.tr("Closing ends the recording; what was recorded so far is kept."),
        )
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.setWindowTitle(self.tr("Recording"))
        close = box.addButton(self.tr("Stop recording and close"), QMessageBox.ButtonRole.AcceptRole)
        go_on = box.addButton(self.tr("Continue recording"), QMessageBox.ButtonRole.RejectRole)
        box.setDefaultButton(go_on)
        box.setEscapeButton(go_on)

        def answered() -> None:
            self.question = None
            if box.clickedButton() is close:
                proceed()

        box.finished.connect(lambda _: answered())
        self.question = box
        box.open()

    def _show(self) -> None:
        source = self._open_sources.current
        recording = self._recordings.of(source)
        running = source is not None and self._recordings.runs(source)
        self._bar.setRecording(running)
        if recording is not None:
            self._bar.setProgress(recording.progress)
            if not recording.running and recording.progress.frames:
                self._bar.setPlayable(recording.path.name)
        reason = None if running else why_unavailable(source, stream=True)
        for control in (self._action, self._bar.recordButton):
            set_available(control, reason)

    def _choose_folder(self) -> None:
        before = self._preferences.snapshot_folder
        if chosen := self._files.folder(self.tr("Folder for recordings"), before):
            self._preferences.snapshot_folder = chosen

    def _play(self) -> None:
        recording = self._recordings.of(self._open_sources.current)
        if recording is not None:
            self.playRequested.emit(str(SourceUri("file", str(recording.path))))


class PauseController(QObject):
    """Pauses the image and steps through the last frames; the camera continues."""

    def __init__(
        self,
        actions: PauseActions,
        bar: PauseBar,
        context: SourceContext,
        history: FrameHistory,
    ) -> None:
        super().__init__(context.window)
        self._actions = actions
        self._bar = bar
        self._messages = context.messages
        self._open_sources = context.open_sources
        self._image = context.image
        self._history = history
        self._frames: tuple[Frame, ...] = ()
        self._index = 0
        self._steps_itself = False
        "Whether the source is a recording, which steps by its own features."
        bridge = Bridge(self)
        bridge.bind(context.open_sources.opened, self._on_source_opened)
        bridge.bind(context.open_sources.state_changed, self._on_source_state_changed)
        # Not over the bridge: the queue must be closed before the grabber.
        context.open_sources.closing.connect(self._on_source_closing, check_nargs=False)
        bar.frameChosen.connect(self._show)
        bar.liveRequested.connect(lambda: actions.actionPause.setChecked(False))
        actions.actionPause.toggled.connect(self._on_pause_toggled)
        actions.actionStepBack.triggered.connect(lambda: self._step(-1))
        actions.actionStepForward.triggered.connect(lambda: self._step(1))
        self._on_source_state_changed(context.open_sources.state, "")

    def _on_pause_toggled(self, paused: bool) -> None:
        if self._steps_itself:
            return
        self._history.pause(paused)
        self._frames = self._history.frames if paused else ()
        self._bar.setVisible(bool(self._frames))
        if self._frames:
            self._show(len(self._frames) - 1)
            return
        self._image.freeze(None)
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
        self._image.freeze(frame)
        self._bar.setPlace(index, len(self._frames), _seconds(frame, newest))

    def _on_source_opened(self, source: OpenSource) -> None:
        if source is self._open_sources.current and source.grabber is not None:
            self._actions.actionPause.setChecked(False)
            self._steps_itself = is_recording(source.grabber)
            if not self._steps_itself:
                self._history.attach(source.grabber)

    def _on_source_closing(self, _: OpenSource) -> None:
        self._history.detach()

    def _on_source_state_changed(self, state: LinkState, _: str) -> None:
        if state in (LinkState.CLOSED, LinkState.OPENING):
            self._actions.actionPause.setChecked(False)
        actions = self._actions
        for action in (actions.actionPause, actions.actionStepBack, actions.actionStepForward):
            pauses = action is actions.actionPause and not action.isChecked()
            reason = why_unavailable(self._open_sources.current, stream=pauses)
            set_available(action, None if state is LinkState.LOST else reason)


def _seconds(frame: Frame, newest: Frame) -> float:
    """Return how many seconds older a frame is, by the camera's clock if it has one."""
    if frame.timestamp_ns and newest.timestamp_ns:
        return (newest.timestamp_ns - frame.timestamp_ns) / 1e9
    return newest.captured - frame.captured


class PlaybackController(QObject):
    """Shows the bar for sources with a recording's features; pause and step act on the recording then."""

    def __init__(self, actions: PauseActions, bar: PlaybackBar, context: SourceContext) -> None:
        super().__init__(context.window)
        self._actions = actions
        self._bar = bar
        self._messages = context.messages
        self._open_sources = context.open_sources
        self._model: PlaybackModel | None = None
        self._bridge: Bridge | None = None
        join = Bridge(self)
        join.bind(context.open_sources.opened, self._on_source_opened)
        join.bind(context.open_sources.closing, lambda _: self._leave())
        bar.playRequested.connect(lambda playing: self._model.play(playing) if self._model else None)
        bar.stepRequested.connect(self._step)
        bar.positionChosen.connect(lambda place: self._model.go_to(place) if self._model else None)
        bar.speedChosen.connect(lambda speed: self._model.set_speed(speed) if self._model else None)
        bar.loopRequested.connect(lambda loop: self._model.set_loop(loop) if self._model else None)
        actions.actionPause.triggered[bool].connect(self._on_pause_triggered)
        actions.actionStepBack.triggered.connect(lambda: self._step(-1))
        actions.actionStepForward.triggered.connect(lambda: self._step(1))

    def _on_source_opened(self, source: OpenSource) -> None:
        self._leave()
        if source is not self._open_sources.current or source.grabber is None:
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
