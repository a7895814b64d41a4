"""*Image → Save the last frames*."""

from __future__ import annotations

from PyQt5.QtCore import QObject
from PyQt5.QtWidgets import QAction

from grabbergui.models.frame_history import FrameHistory
from grabbergui.models.language import counted
from grabbergui.recording.snapshot import SnapshotWriter
from grabbergui.ui.controllers.source_context import SourceContext


class LastFramesController(QObject):
    """Saves the frames that the history holds, in a folder of their own below that of snapshots."""

    def __init__(
        self,
        action: QAction,
        context: SourceContext,
        history: FrameHistory,
        snapshots: SnapshotWriter,
    ) -> None:
        super().__init__(context.window)
        self._open_sources, self._history, self._snapshots = context.open_sources, history, snapshots
        self._preferences, self._messages = context.preferences, context.messages
        action.triggered.connect(self.save)

    def save(self) -> None:
        """Save them; the camera continues."""
        source, frames = self._open_sources.current, self._history.frames
        if not frames or source is None or source.grabber is None:
            self._messages.error(self.tr("there is no frame to save yet; start the camera first"))
            return
        preferences = self._preferences
        folder, kind = preferences.snapshot_folder, preferences.snapshot_kind
        self._messages.notice(
            counted(len(frames), self.tr("Saving the last frame"), self.tr("Saving the last {0} frames"))
        )
        self._snapshots.save_all(frames, folder, source.grabber.info, kind)
