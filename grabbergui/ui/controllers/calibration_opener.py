"""Opens the calibration dialog on the current source.

The dialog and all of `servo` that it needs are imported when it is opened, so that the window starts without.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PyQt5.QtCore import QObject, pyqtSignal

from grabbergui.models.connection import Connection
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.views.main_window import MainWindow

if TYPE_CHECKING:
    from grabbergui.ui.controllers.calibrating import CalibratingController
    from grabbergui.ui.views.calibration_dialog import CalibrationDialog


class CalibrationOpener(QObject):
    """Opens the dialog on what the window shows, and closes it with that."""

    saved = pyqtSignal(Path)
    """A calibration of what the window shows was written."""

    def __init__(self, window: MainWindow, connection: Connection) -> None:
        super().__init__(window)
        self._window, self._connection = window, connection
        self._controller: CalibratingController | None = None
        self._source: OpenSource | None = None
        bridge = Bridge(self)
        bridge.bind(connection.state_changed, self._on_connection_state_changed)
        bridge.bind(connection.closing, self._on_connection_closing)
        window.actionCalibrate.triggered.connect(self.open)
        window.closing.connect(self.close)

    @property
    def dialog(self) -> CalibrationDialog | None:
        """The one that is open."""
        return self._controller.dialog if self._controller is not None else None

    def open(self) -> None:
        """Open it, or bring it to the front."""
        source = self._connection.source
        if self.dialog is not None:
            self.dialog.raise_()
            self.dialog.activateWindow()
        elif source is not None and source.grabber is not None:
            from grabbergui.ui.controllers.calibrating import CalibratingController
            from grabbergui.ui.views.calibration_dialog import CalibrationDialog

            dialog = CalibrationDialog(self._window)
            dialog.closing.connect(self._on_dialog_closing)
            self._controller = CalibratingController(dialog, source.grabber, self.saved.emit)
            self._source = source
            dialog.show()

    def close(self) -> None:
        """Close it where it is open."""
        if self.dialog is not None:
            self.dialog.reject()

    def _on_dialog_closing(self) -> None:
        self._controller = self._source = None

    def _on_connection_closing(self, source: OpenSource) -> None:
        if source is self._source:
            self.close()

    def _on_connection_state_changed(self, state: LinkState, reason: str) -> None:
        self._window.actionCalibrate.setEnabled(state is LinkState.STREAMING)
