"""The calibration of the current camera: made in a dialog, loaded, shown in the image.

The dialog, and all that it needs, is imported when it is about to be opened: the window starts without.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

from PyQt5.QtCore import QObject, pyqtSignal
from PyQt5.QtWidgets import QAction, QMenu

from grabbergui.calibration import camera_info
from grabbergui.calibration.fitting import FittedCalibration
from grabbergui.core.errors import UsageError
from grabbergui.models.error_text import error_text
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.unavailable import Unavailable, why_unavailable
from grabbergui.ui.actions import set_available
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.gui_thread import Bridge, busy
from grabbergui.ui.views.bases import CalibrationActions

if TYPE_CHECKING:
    from grabbergui.ui.controllers.calibration_dialogs import CalibratingController
    from grabbergui.ui.views.calibration_dialogs import CalibrationDialog


_DIALOG = "grabbergui.ui.controllers.calibration_dialogs"


class CalibrationOpener(QObject):
    """Opens the calibration dialog for the current source, and closes it with that source.

    A menu with its action imports the dialog in the background, while its user looks for the entry.
    """

    saved = pyqtSignal(Path)
    """A calibration of the current source was written."""

    def __init__(self, action: QAction, context: SourceContext) -> None:
        super().__init__(context.window)
        self._action, self._window, self._open_sources = action, context.window, context.open_sources
        self._controller: CalibratingController | None = None
        self._source: OpenSource | None = None
        bridge = Bridge(self)
        bridge.bind(context.open_sources.state_changed, self._on_source_state_changed)
        bridge.bind(context.open_sources.closing, self._on_source_closing)
        action.triggered.connect(self.open)
        for menu in action.associatedWidgets():
            if isinstance(menu, QMenu):
                menu.aboutToShow.connect(self._import)
        self._on_source_state_changed(context.open_sources.state, "")

    @property
    def dialog(self) -> CalibrationDialog | None:
        """The open dialog, if any."""
        return self._controller.dialog if self._controller is not None else None

    def open(self) -> None:
        """Open it, or bring it to the front."""
        source = self._open_sources.current
        if self.dialog is not None:
            self.dialog.raise_()
            self.dialog.activateWindow()
        elif source is not None and source.grabber is not None:
            with busy():
                from grabbergui.ui.controllers.calibration_dialogs import CalibratingController
                from grabbergui.ui.views.calibration_dialogs import CalibrationDialog

            dialog = CalibrationDialog(self._window)
            dialog.closing.connect(self._on_dialog_closing)
            self._controller = CalibratingController(dialog, source.grabber, self.saved.emit)
            self._source = source
            dialog.show()

    @property
    def unsaved(self) -> int:
        """Views that are lost if the dialog is closed now."""
        return self.dialog.unsaved if self.dialog is not None else 0

    def confirm(self, proceed: Callable[[], None]) -> None:
        """Call `proceed`, by which the dialog is closed; ask first if it has views that are not saved."""
        if self.dialog is not None and self.dialog.unsaved:
            self.dialog.ask_to_discard(proceed)
        else:
            proceed()

    def close(self) -> None:
        """Close the dialog if it is open."""
        if self.dialog is not None:
            self.dialog.reject()

    def _import(self) -> None:
        threading.Thread(target=import_module, args=(_DIALOG,), name="calibration", daemon=True).start()

    def _on_dialog_closing(self) -> None:
        self._controller = self._source = None

    def _on_source_closing(self, source: OpenSource) -> None:
        if source is self._source:
            self.close()

    def _on_source_state_changed(self, state: LinkState, reason: str) -> None:
        set_available(self._action, why_unavailable(self._open_sources.current, stream=True))


class CalibrationViewController(QObject):
    """Each source may have a calibration; while it is shown, the image is without the lens's distortion.

    The display thread fits it to the binning, region and mirroring of each frame.
    """

    def __init__(self, actions: CalibrationActions, context: SourceContext) -> None:
        super().__init__(context.window)
        self._actions = actions
        self._files = context.files
        self._messages = context.messages
        self._open_sources = context.open_sources
        self._image = context.image
        self._known: WeakKeyDictionary[OpenSource, FittedCalibration] = WeakKeyDictionary()
        actions.actionLoadCalibration.triggered.connect(self._ask)
        actions.actionShowCalibration.toggled.connect(self._apply)
        bridge = Bridge(self)
        bridge.bind(context.open_sources.opened, lambda _: self._on_source_changed())
        bridge.bind(context.open_sources.closing, lambda _: self._on_source_changed())
        bridge.bind(context.open_sources.ending, self._forget)
        bridge.bind(context.image.not_undistorted, self._on_not_undistorted)
        self._on_source_changed()

    def load(self, path: Path) -> None:
        """Read a camera_info file for the current source, and show it."""
        source = self._open_sources.current
        if source is None or source.grabber is None:
            return
        try:
            calibration = camera_info.load(path)
        except (UsageError, OSError) as error:
            self._messages.error(error_text(error))
            return
        self._forget(source)
        self._known[source] = FittedCalibration(source.grabber)
        self._known[source].calibration = calibration
        set_available(self._actions.actionShowCalibration, None)
        self._actions.actionShowCalibration.setChecked(True)
        self._apply()
        across, down = calibration.field_of_view
        text = self.tr("{0}: the image is shown undistorted, {1:.0f}° × {2:.0f}°")
        self._messages.notice(text.format(path.name, across, down))
        if calibration.is_of_another(source.grabber.info):
            text = self.tr("{0} was made with another camera, {1} {2}; calibrate this one as well")
            other = calibration.camera_model, calibration.camera_serial
            self._messages.error(text.format(path.name, *other))

    def _ask(self) -> None:
        kinds = "camera_info (*.yaml *.yml *.ini)"
        if path := self._files.to_open(self.tr("Load a calibration"), kinds, Path.home()):
            self.load(path)

    def _on_source_changed(self) -> None:
        source = self._open_sources.current
        reason = None if source is not None else Unavailable.SOURCE
        set_available(self._actions.actionLoadCalibration, reason)
        unknown = Unavailable.CALIBRATION if source is not None and source not in self._known else reason
        set_available(self._actions.actionShowCalibration, unknown)
        self._actions.actionShowCalibration.setChecked(False)
        self._apply()

    def _forget(self, source: OpenSource) -> None:
        if (known := self._known.pop(source, None)) is not None:
            known.close()

    def _on_not_undistorted(self, reason: str) -> None:
        if self._actions.actionShowCalibration.isChecked():  # more frames of the kind may be on their way
            self._actions.actionShowCalibration.setChecked(False)
            self._messages.error(reason)

    def _apply(self, _: bool = False) -> None:
        """Show the image with or without the distortion."""
        source = self._open_sources.current
        wanted = self._actions.actionShowCalibration.isChecked() and source is not None
        known = self._known.get(source) if wanted and source is not None else None
        fit = None if known is None else known.fit
        self._image.settings = replace(self._image.settings, calibration=fit)
