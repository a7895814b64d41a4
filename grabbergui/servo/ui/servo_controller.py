"""Joins the windows that move a robot to its models: hand–eye calibration and servoing, which opens it."""

from __future__ import annotations

import logging
import threading
from functools import partial
from pathlib import Path

from PyQt5.QtCore import QObject, QTimer

from grabbergui.calibration.calibration_choice import CalibrationChoice, CalibrationFor
from grabbergui.core.errors import UsageError
from grabbergui.models.error_text import error_text
from grabbergui.models.messages import UserMessage
from grabbergui.servo.models.servo_proxy import HAND_EYE, Run
from grabbergui.servo.models.servoing import Entry, ServoModel, Tuning
from grabbergui.servo.runner import STOPPED, Runner
from grabbergui.servo.state_machine import State
from grabbergui.servo.ui.servo_window import ServoWindow
from grabbergui.ui.controllers.calibration_dialogs import CalibratingController
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.views.calibration_dialogs import CalibrationDialog

log = logging.getLogger(__name__)


CURVES_MS = 150
"Milliseconds between two updates of the curves."


class ServoController(QObject):
    """Joins the servoing window to a run. Make it on the GUI thread; `close` it before the runner ends."""

    def __init__(
        self,
        window: ServoWindow,
        runner: Run,
        calibration: CalibrationFor,
        *,
        hand_eye: bool = False,
    ) -> None:
        """With `hand_eye`, the button for that calibration is offered; it closes the window."""
        super().__init__(window)
        self.calibrating: CalibrationDialog | None = None
        """The calibration dialog that is open on top of the window, if any."""
        self.hand_eye_wanted = False
        "Whether hand and eye are to be calibrated, now that the window is closed."
        window.setHandEyeAvailable(hand_eye)
        window.handEyePressed.connect(self._on_window_hand_eye_pressed)
        self._window, self._runner, self._calibration = window, runner, calibration
        self._offer: UserMessage | None = None
        self.model = ServoModel(runner, calibration)
        self._bridge = Bridge(self)
        self._bridge.bind(self.model.ready, self._on_model_ready)
        self._bridge.bind(self.model.entered, self._on_model_entered)
        self._bridge.bind(runner.failed, self._on_runner_failed)
        window.stopPressed.connect(self._on_window_stop_pressed)
        window.startPressed.connect(self._on_window_start_pressed)
        window.tuningChanged.connect(self._on_window_tuning_changed)
        window.viewChanged.connect(self.model.set_viewport)
        window.setTuning(Tuning.of(runner.config))
        self._timer = QTimer(self)
        self._timer.timeout.connect(self._show_curves)
        self._timer.start(CURVES_MS)
        self.model.open()

    def close(self) -> None:
        """Release the runner. May be called twice."""
        self._timer.stop()
        if self.calibrating is not None:
            self.calibrating.reject()
        self._bridge.close()
        self.model.close()

    def _on_window_stop_pressed(self) -> None:
        self._stop(STOPPED)

    def _stop(self, reason: str) -> None:
        # A thread for each: a robot whose network hangs must hold up neither the window nor a second stop.
        stop = partial(self._runner.emergency_stop, reason)
        threading.Thread(target=stop, name="emergency stop", daemon=True).start()

    def _on_window_start_pressed(self) -> None:
        if not self.hand_eye_wanted:
            self._runner.request_start()

    def _on_window_hand_eye_pressed(self) -> None:
        self.hand_eye_wanted = True
        self._stop(HAND_EYE)
        self._window.close()  # no loop runs beside the wizard, which `ui.run.standalone` shows next

    def _on_window_tuning_changed(self, tuning: Tuning) -> None:
        try:
            config = tuning.applied_to(self._runner.config)
        except UsageError as error:
            self._window.messages.showError(error_text(error))
            self._window.setTuning(Tuning.of(self._runner.config))
            return
        log.info("tuned: %s", tuning)
        self._runner.tune(config)

    def _on_model_ready(self) -> None:
        shown = self.model.take()
        if shown is None:
            return
        window = self._window
        if self._runner.running:
            window.setState(shown.cycle.state, shown.cycle.reason)
        else:
            window.setState(State.STOPPED, self._runner.gate.halted)
        if shown.image is not None:
            window.setImage(shown.image, *shown.size, shown.drawing)
            self._offer_calibrating(shown.nominal)
        window.setPosture(shown.posture)
        window.setLimits(shown.limits)

    def _on_model_entered(self, entry: Entry) -> None:
        self._window.addEntry(entry)

    def _on_runner_failed(self, reason: str) -> None:
        self._window.messages.showError(reason)
        if not self._runner.running:  # no cycle may have shown the state
            self._window.setState(State.STOPPED, self._runner.gate.halted)

    def _offer_calibrating(self, nominal: bool) -> None:
        if nominal and self._offer is None and isinstance(self._calibration, CalibrationChoice):
            self._offer = self._window.messages.showOffer(
                self.tr("The camera is not calibrated, a field of view is assumed: distances are rough"),
                self.tr("Calibrate…"),
                self._calibrate,
            )
        elif not nominal and self._offer is not None:
            self._window.messages.dismiss(self._offer)
            self._offer = None

    def _calibrate(self) -> None:
        runner = self._runner
        if not isinstance(runner, Runner):
            return  # its camera is another process's
        if self.calibrating is not None:
            self.calibrating.raise_()
            return
        self._stop("stopped to calibrate")
        self.calibrating = CalibrationDialog(self._window)
        self.calibrating.closing.connect(self._on_calibrating_closing)
        CalibratingController(self.calibrating, runner.grabber, self._on_calibration_saved)
        self.calibrating.show()

    def _on_calibrating_closing(self) -> None:
        self.calibrating = None

    def _on_calibration_saved(self, path: Path) -> None:
        if not isinstance(self._calibration, CalibrationChoice) or not isinstance(self._runner, Runner):
            return
        try:
            self._calibration.exchange(CalibrationChoice.file(path, self._runner.grabber))
        except (UsageError, OSError) as error:
            self._window.messages.showError(error_text(error))
            return
        self._runner.renew_detector()
        text = self.tr("{0} is in use; Start lets the robot move")
        self._window.messages.showNotice(text.format(path))

    def _show_curves(self) -> None:
        curves = self.model.curves()
        if len(curves) > 1:
            self._window.setCurves(curves)
