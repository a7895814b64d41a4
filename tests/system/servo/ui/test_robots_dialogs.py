"""The windows of a robot: text from outside as it is, on a small screen, in Spanish."""

import pytest
from PyQt5.QtWidgets import QWidget

from grabbergui.servo.hand_eye.plan import RunPlan
from grabbergui.servo.hand_eye.run import Step
from grabbergui.servo.models.hand_eye import Happened
from grabbergui.servo.models.hand_eye_text import plan_text
from grabbergui.servo.models.servoing import Entry
from grabbergui.servo.state_machine import State
from grabbergui.servo.ui.hand_eye_dialog import HandEyeDialog
from grabbergui.servo.ui.servo_window import ServoWindow, TimePlot
from grabbergui.ui.interface_language import speak
from grabbergui.ui.theme import Theme, dress
from marked_camera import MARKUP
from shown_walk import walk
from small_screen import check_fits

PLAN = RunPlan("head", 9, 0, 5.0, (-9.0, -9.0), (9.0, 9.0), 0.0, 60.0)


def hand_eye(window):
    dialog = HandEyeDialog(window)
    dialog.setRobot(MARKUP, dict.fromkeys(("head", "hand", "fixed"), MARKUP))
    dialog.setPlan(plan_text(PLAN, MARKUP))
    dialog.addEvent(Happened(1.0, Step.VIEW, MARKUP, 1, 9, 5.0))
    dialog.setEnded(MARKUP, enough=False)
    dialog.showError(MARKUP)
    return dialog


def servo(window):
    made = ServoWindow(window)
    made.setState(State.STOPPED, MARKUP)
    made.addEntry(Entry(1.0, State.STOPPED, MARKUP))
    return made


@pytest.mark.parametrize("make", [hand_eye, servo])
def test_no_text_from_outside_is_rendered(qtbot, make):
    window = QWidget()
    qtbot.addWidget(window)
    made = make(window)
    found = walk(made)
    assert found.places
    assert not found.found, "\n".join(found.found)
    made.close()


def test_the_wizard_fits_800_by_600_and_its_buttons_are_whole(qtbot, qapp, monkeypatch):
    dress(qapp, Theme.LIGHT)
    window = QWidget()
    qtbot.addWidget(window)
    check_fits(HandEyeDialog, lambda: HandEyeDialog(window), monkeypatch)


def test_the_axes_of_a_plot_have_the_languages_decimal_point(qtbot, qapp):
    speak(qapp, "es")
    try:
        made = TimePlot()
        qtbot.addWidget(made)
        for side in ("left", "bottom"):
            assert made.getAxis(side).tickStrings([1.5, 1.6], 1.0, 0.1) == ["1,5", "1,6"]
    finally:
        speak(qapp, "en")
