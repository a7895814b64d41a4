"""*Image → Frame data…*."""

from __future__ import annotations

from PyQt5.QtCore import QObject, QTimer
from PyQt5.QtGui import QGuiApplication
from PyQt5.QtWidgets import QAction

from grabbergui.models.image.frame_data import frame_rows
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.views.frame_data_dialog import FrameDataDialog

PERIOD_MS = 200
"Milliseconds between two frames whose data is shown."


class FrameDataController(QObject):
    """Shows the data of the newest frame, or of the one at which the image is paused."""

    def __init__(self, action: QAction, context: SourceContext) -> None:
        super().__init__(context.window)
        self._window, self._image = context.window, context.image
        self.dialog: FrameDataDialog | None = None
        "While it is shown."
        self._timer = QTimer(self)
        self._timer.setInterval(PERIOD_MS)
        self._timer.timeout.connect(self._show_frame)
        action.triggered.connect(self.show)

    def show(self) -> None:
        """Show the dialog."""
        if self.dialog is not None:
            self.dialog.raise_()
            return
        self.dialog = dialog = FrameDataDialog(self._window)
        dialog.copyRequested.connect(self._on_dialog_copy_requested)
        dialog.finished.connect(self._on_dialog_finished)
        self._show_frame()
        self._timer.start()
        dialog.show()

    def _show_frame(self) -> None:
        frame = self._image.frame
        if self.dialog is not None:
            rows = frame_rows(frame) if frame is not None else []
            self.dialog.setRows(rows, chunks=frame is not None and bool(frame.chunks))

    def _on_dialog_copy_requested(self) -> None:
        frame, clipboard = self._image.frame, QGuiApplication.clipboard()
        if frame is not None and clipboard is not None:
            clipboard.setText("\n".join(f"{name}\t{value}" for name, value in frame_rows(frame)))

    def _on_dialog_finished(self, _: int) -> None:
        self._timer.stop()
        dialog, self.dialog = self.dialog, None
        if dialog is not None:
            dialog.deleteLater()
