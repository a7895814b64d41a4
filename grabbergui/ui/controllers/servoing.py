"""Joins the servoing window to a run."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

from PyQt5.QtCore import QObject, QTimer

from grabbergui.core.errors import UsageError
from grabbergui.models.servo_tuning import Tuning
from grabbergui.models.servoing import CalibrationFor, Entry, ServoModel
from grabbergui.servo.pilot import Pilot
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.views.servo_window import ServoWindow

log = logging.getLogger(__name__)

CURVES_MS = 150
"Between two paintings of the curves."


class ServoController(QObject):
    """Make it on the GUI thread; `close` it before the pilot is gone."""

    def __init__(self, window: ServoWindow, pilot: Pilot, calibration: CalibrationFor) -> None:
        super().__init__(window)
        self._window, self._pilot = window, pilot
        self.model = ServoModel(pilot, calibration)
        self._bridge = Bridge(self)
        self._bridge.bind(self.model.ready, self._on_model_ready)
        self._bridge.bind(self.model.entered, self._on_model_entered)
        self._bridge.bind(pilot.failed, self._on_pilot_failed)
        window.stopPressed.connect(self._on_window_stop_pressed)
        window.startPressed.connect(self._on_window_start_pressed)
        window.tuningChanged.connect(self._on_window_tuning_changed)
        window.viewChanged.connect(self.model.look_at)
        window.setTuning(Tuning.of(pilot.config))
        self._timer = QTimer(self)
        self._timer.timeout.connect(self._show_curves)
        self._timer.start(CURVES_MS)
        self.model.open()

    def close(self) -> None:
        """Let go of the pilot. May be called twice."""
        self._timer.stop()
        self._bridge.close()
        self.model.close()

    # -- from the window ---------------------------------------------------------------------------
    def _on_window_stop_pressed(self) -> None:
        # A thread for each: a robot whose network hangs must hold up neither the window nor a second stop.
        _apart(lambda: self._pilot.emergency_stop("stopped in the window"), "emergency stop")

    def _on_window_start_pressed(self) -> None:
        pilot = self._pilot

        def start() -> None:
            if not pilot.running:
                pilot.stop()  # its threads have ended; this takes them off its hands
                pilot.start()
            pilot.resume()

        _apart(start, "start")

    def _on_window_tuning_changed(self, tuning: Tuning) -> None:
        try:
            config = tuning.applied_to(self._pilot.config)
        except UsageError as error:
            self._window.messages.showError(str(error))
            self._window.setTuning(Tuning.of(self._pilot.config))
            return
        log.info("tuned: %s", tuning)
        self._pilot.tune(config)

    # -- from the run ------------------------------------------------------------------------------
    def _on_model_ready(self) -> None:
        shown = self.model.take()
        if shown is None:
            return
        window = self._window
        window.setState(shown.turn.state, shown.turn.reason)
        if shown.image is not None:
            window.setPicture(shown.image, *shown.size, shown.drawing)
        window.setPosture(shown.posture)

    def _on_model_entered(self, entry: Entry) -> None:
        self._window.addEntry(entry)

    def _on_pilot_failed(self, reason: str) -> None:
        self._window.messages.showError(reason)
        self._window.startButton.setEnabled(True)

    def _show_curves(self) -> None:
        curves = self.model.curves()
        if len(curves) > 1:
            self._window.setCurves(curves)


def _apart(function: Callable[[], None], name: str) -> None:
    threading.Thread(target=function, name=name, daemon=True).start()
