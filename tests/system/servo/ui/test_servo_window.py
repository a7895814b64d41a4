"""The servoing window: each direction apart."""

import dataclasses

import numpy as np
import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QApplication

from grabbergui.core.drawing import Drawing, Stroke
from grabbergui.core.pixels import DisplayImage, Region
from grabbergui.servo.config import Config
from grabbergui.servo.models.servo_proxy import HAND_EYE, RunnerProxy
from grabbergui.servo.models.servoing import Entry, Tuning
from grabbergui.servo.state_machine import State
from grabbergui.servo.ui.hand_eye_dialog import HandEyeDialog
from grabbergui.servo.ui.servo_controller import ServoController
from grabbergui.servo.ui.servo_window import MOST_ENTRIES, ServoWindow
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.views.calibration_dialogs import CalibrationChoiceDialog, CalibrationDialog
from operated_controls import controls, spoken_name

TUNING = Tuning.of(Config())


@pytest.mark.parametrize("key", [Qt.Key_Space, Qt.Key_Escape])
@pytest.mark.parametrize("focus", ["canvas", "headGainBox", "history", "startButton", "robotView"])
def test_two_keys_stop_whatever_has_the_focus(window, qtbot, key, focus):
    window.setState(State.STOPPED, "so that Start can take the focus")
    child = getattr(window, focus)
    child.setFocus()
    target = QApplication.focusWidget() or child
    with qtbot.waitSignal(window.stopPressed), qtbot.assertNotEmitted(window.startPressed):
        qtbot.keyClick(target, key)


def test_the_button_stops(window, qtbot):
    with qtbot.waitSignal(window.stopPressed):
        qtbot.mouseClick(window.stopButton, Qt.LeftButton)


def test_starting_is_offered_only_when_stopped(window, qtbot):
    window.setState(State.CENTRING, "a target is seen")
    assert not window.startButton.isEnabled()
    window.setState(State.STOPPED, "stopped in the window")
    with qtbot.waitSignal(window.startPressed):
        qtbot.mouseClick(window.startButton, Qt.LeftButton)


def test_the_state_is_lit_and_reported(window):
    window.setState(State.WAITING, "centred; no marker yet")
    assert window.states.state is State.WAITING
    assert window.reasonLabel.text() == "centred; no marker yet"
    image = window.states.grab().toImage()
    colours = {image.pixelColor(x, image.height() // 2).name() for x in range(image.width())}
    assert "#50a0fa" in colours


def test_the_limits_are_beside_the_state(window):
    window.setLimits("Hand: 60 of 120 mm/s")
    assert window.limitsLabel.text() == "Hand: 60 of 120 mm/s"


def test_a_long_reason_does_not_move_the_stop_button(window, qapp):
    window.setState(State.SEARCHING, "")
    qapp.processEvents()
    place = window.stopButton.geometry()
    window.setState(State.STOPPED, "no image arrived within 0.5 s: check camera and cable, then start; " * 3)
    qapp.processEvents()
    assert window.stopButton.geometry() == place


def test_a_message_does_not_move_the_stop_button(window, qapp):
    window.show()
    qapp.processEvents()
    place = window.stopButton.geometry()
    window.messages.showError("the camera is lost")
    qapp.processEvents()
    assert window.messages.height() > 0
    assert window.stopButton.geometry() == place


def test_a_state_that_was_entered_goes_into_the_history(window):
    window.addEntry(Entry(0.0, State.LOST, "no image yet"))
    window.addEntry(Entry(1.25, State.CENTRING, "a target is seen"))
    rows = [window.history.topLevelItem(index) for index in range(window.history.topLevelItemCount())]
    texts = [[row.text(column) for column in range(3)] for row in rows]
    assert texts[1] == ["1.25 s", "centring", "a target is seen"]


def test_the_history_of_a_long_run_loses_its_oldest_lines(window):
    for second in range(MOST_ENTRIES + 2):
        window.addEntry(Entry(second, State.LOST, ""))
    assert window.history.topLevelItemCount() == MOST_ENTRIES
    assert window.history.topLevelItem(0).text(0) == "2.00 s"


def test_an_image_keeps_its_colours_and_what_lies_over_it(window, qtbot):
    pixels = np.full((300, 400, 3), (250, 20, 40), np.uint8)
    drawing = Drawing([Stroke(np.array([(100.0, 150.0), (300.0, 150.0)]), (10, 240, 30), weight=3)])
    with qtbot.waitSignal(window.canvas.painted):
        window.setImage(DisplayImage(pixels, Region(0, 0, 400, 300)), 400, 300, drawing)
    image = window.canvas.grab().toImage()
    at = window.canvas.frameToView
    assert image.pixelColor(at(200, 50).toPoint()).getRgb()[:3] == (250, 20, 40)
    line = image.pixelColor(at(200, 150.5).toPoint())
    assert line.green() > 180
    assert line.red() < 120


def test_curves_are_shown_in_usual_units(window):
    curves = np.zeros((3, 9))
    curves[:, 0] = (-2, -1, 0)
    curves[:, 1], curves[:, 2] = (0.2, 0.1, np.nan), np.radians((10, 5, np.nan))
    curves[:, 4], curves[:, 8] = 0.05, np.radians(3)
    window.setCurves(curves)
    assert window.distancePlot.values()[:2] == pytest.approx([200, 100])
    assert window.anglePlot.values()[:2] == pytest.approx([10, 5])
    assert window.velocityPlot.values(1) == pytest.approx([50] * 3)
    assert window.turnPlot.values(2) == pytest.approx([3] * 3)


def test_gains_go_in_without_coming_out_and_come_out_when_set_by_hand(window, qtbot):
    with qtbot.assertNotEmitted(window.tuningChanged):
        window.setTuning(dataclasses.replace(TUNING, head_gain=1.25, rate=80))
    assert (window.headGainBox.value(), window.rateBox.value()) == (1.25, 80)
    with qtbot.waitSignal(window.tuningChanged) as caught:
        window.armFastestBox.setValue(60)
    assert caught.args[0] == dataclasses.replace(TUNING, head_gain=1.25, rate=80, arm_fastest=60)


@pytest.mark.parametrize("theme", [Theme.LIGHT, Theme.DARK])
def test_it_is_dressed_in_either_look(window, qapp, theme):
    colours = dress(qapp, theme)
    qapp.processEvents()
    view = window.robotView
    assert view.grab().toImage().pixelColor(2, view.height() // 3).name() == colours.panel


@pytest.mark.parametrize(
    "make",
    [ServoWindow, CalibrationDialog, lambda: CalibrationChoiceDialog("Left eye"), HandEyeDialog],
    ids=["servo window", "calibration", "choice of a calibration", "hand and eye"],
)
def test_every_control_has_a_name_to_be_read_aloud(qtbot, make):
    made = make()
    made.setAttribute(Qt.WA_DeleteOnClose, False)
    qtbot.addWidget(made)
    nameless = [control.objectName() for control in controls(made) if not spoken_name(control, made)]
    assert not nameless


class Elsewhere(RunnerProxy):
    """A run of another process that reports nothing."""

    def __init__(self):
        self.running, self.config, self.requests = True, Config(), []

    def emergency_stop(self, reason):
        self.requests.append(reason)

    def request_start(self):
        self.requests.append("start")


def test_a_window_gives_way_to_the_calibration_of_hand_and_eye(window, qtbot):
    proxy = Elsewhere()
    controller = ServoController(window, proxy, lambda width, height: None, hand_eye=True)
    assert window.handEyeButton.isEnabled()
    window.handEyeButton.click()
    assert controller.hand_eye_wanted
    assert not window.isVisible()
    window.startPressed.emit()
    qtbot.waitUntil(lambda: proxy.requests == [HAND_EYE])
    controller.close()
