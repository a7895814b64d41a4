"""The hand–eye wizard: each direction apart, then robots calibrated by clicks and stopped by keys."""

import threading
from pathlib import Path

import numpy as np
import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QApplication

from grabbergui.core.pixels import DisplayImage, Region
from grabbergui.models.unavailable import Unavailable
from grabbergui.servo import closed_loop
from grabbergui.servo.config import Config, MarkerConfig
from grabbergui.servo.gate import CommandGate
from grabbergui.servo.hand_eye.hand_eye_file import placement
from grabbergui.servo.hand_eye.run import Step
from grabbergui.servo.hand_eye.simulated_cameras import SimulatedCameras
from grabbergui.servo.hand_eye.stand import HandEyeStand
from grabbergui.servo.models.hand_eye import Happened, Setup, TargetPreview
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.ui.hand_eye_controller import HandEyeController
from grabbergui.servo.ui.hand_eye_dialog import PRINTED, HandEyeDialog
from grabbergui.servo.ui.hand_eye_view import HandEyePage
from grabbergui.ui.theme import Theme, dress
from hand_eye_bench import Bench, BenchStand, Turnstile

NOTHING = {"head": "", "hand": "", "fixed": ""}


@pytest.fixture
def dialog(qtbot):
    made = HandEyeDialog()
    made.setAttribute(Qt.WA_DeleteOnClose, False)
    qtbot.addWidget(made)
    made.setRobot("TEO", NOTHING)
    made.setSetup(Setup("head", MarkerConfig()))
    made.show()
    return made


def test_a_setup_goes_in_without_coming_out_and_comes_out_when_set_by_hand(dialog, qtbot):
    marker = MarkerConfig(
        kind="grid", dictionary="tag36h11", size=0.04, columns=3, rows=2, pitch=0.06, first=7
    )
    setup = Setup("fixed", marker, 12, 0.3)
    with qtbot.assertNotEmitted(dialog.setupChanged):
        dialog.setSetup(setup)
    assert dialog.setup == setup
    with qtbot.waitSignal(dialog.setupChanged) as caught:
        dialog.handButton.click()
    assert caught.args[0].eye == "hand"
    with qtbot.waitSignal(dialog.setupChanged) as caught:
        dialog.printedButton.click()
    assert caught.args[0] == Setup("hand", PRINTED, 12, 0.3)


def test_only_what_the_robot_can_do_is_offered(dialog):
    dialog.setRobot("TEO", {"head": "", "hand": "the arm of TEO is not driven", "fixed": "no"})
    assert not dialog.handButton.isEnabled()
    assert dialog.handButton.toolTip().endswith("\nthe arm of TEO is not driven")
    assert dialog.nextButton.isEnabled()
    assert dialog.backButton.toolTip() == Unavailable.PAGE.text
    dialog.setRobot("TEO", {"head": "TEO does not report its joints", "hand": "", "fixed": ""})
    assert dialog.eyeLabel.text() == "TEO does not report its joints"
    assert not dialog.nextButton.isEnabled()
    assert dialog.nextButton.toolTip() == "TEO does not report its joints"
    dialog.setPage(HandEyePage.PLAN)
    assert dialog.nextButton.toolTip() == "Tick the box above first."
    dialog.agreeBox.setChecked(True)
    assert dialog.nextButton.isEnabled() and not dialog.nextButton.toolTip()


def test_the_target_is_marked_and_what_hinders_it_is_reported(dialog):
    image = DisplayImage(np.zeros((60, 80), np.uint8), Region(0, 0, 80, 60))
    corners = np.float64([(10, 10), (30, 20)])
    dialog.setPreview(TargetPreview(image, (80, 60), corners, ""))
    assert dialog.verdictLabel.text() == "● the target is seen"
    assert len(dialog.drawing.drawing.strokes) == 4
    dialog.setPreview(TargetPreview(image, (80, 60), None, "the target is not seen"))
    assert dialog.verdictLabel.property("tone") == "bad"
    assert not dialog.drawing.drawing.strokes
    dialog.setPreview(TargetPreview(None, (0, 0), None, "no images arrive from the camera"))
    assert dialog.verdictLabel.text() == "● no images arrive from the camera"


def test_progress_and_what_was_skipped_are_listed(dialog):
    dialog.setPage(HandEyePage.MOTION)
    dialog.setRunning(True)
    dialog.addEvent(Happened(1.0, Step.MOVING, "moving to pose 3", 2, 9, 65.0))
    assert dialog.events.topLevelItemCount() == 0
    assert dialog.stateLabel.text() == "Moving to pose 3"
    dialog.addEvent(Happened(2.5, Step.SKIPPED, "skipped: it was not reached", 2, 9, 31.0))
    row = dialog.events.topLevelItem(0)
    assert (row.text(0), row.text(1)) == ("2.5 s", "skipped: it was not reached")
    assert (dialog.progress.value(), dialog.progress.maximum()) == (2, 9)
    assert dialog.remainingLabel.text() == "about 30 s left"
    assert not dialog.nextButton.isEnabled()
    dialog.setEnded("Stopped", enough=True)
    assert dialog.nextButton.isEnabled()
    assert dialog.backButton.isEnabled()


@pytest.mark.parametrize("theme", [Theme.LIGHT, Theme.DARK])
def test_every_page_fits_800_by_600_pixels_in_either_look(dialog, qapp, theme):
    dress(qapp, theme)
    dialog.setPlan("<p>" + "What the robot will do, in many words. " * 12 + "</p>")
    dialog.setPreview(
        TargetPreview(None, (0, 0), None, "no image arrived within 5 s: check camera and cable, then again")
    )
    for page in HandEyePage:
        dialog.setPage(page)
        dialog.resize(800, 600)
        qapp.processEvents()
        assert (dialog.width(), dialog.height()) == (800, 600)


class Files:
    """Answers the question for a file."""

    def __init__(self, path):
        self.path, self.asked = path, []

    def to_save(self, title, name, kinds):
        self.asked.append(name)
        return self.path


class Wizard:
    """A dialog on a bench, driven by clicks and keys."""

    def __init__(self, qtbot, stand, path):
        self.qtbot, self.stand, self.files = qtbot, stand, Files(path)
        self.dialog = HandEyeDialog()
        self.dialog.setAttribute(Qt.WA_DeleteOnClose, False)
        qtbot.addWidget(self.dialog)
        self.controller = HandEyeController(self.dialog, stand, self.files, self.dialog)
        self.model = self.controller.model
        self.dialog.viewsBox.setValue(5)
        self.dialog.show()

    def until(self, condition):
        self.qtbot.waitUntil(lambda: bool(condition()))

    def click(self, button):
        self.qtbot.mouseClick(button, Qt.LeftButton)

    def agree(self):
        """To the plan, and let the robot move."""
        self.click(self.dialog.nextButton)
        self.until(lambda: self.dialog.page is HandEyePage.PLAN)
        assert not self.dialog.nextButton.isEnabled()
        self.qtbot.keyClick(self.dialog.agreeBox, Qt.Key_Space)
        self.click(self.dialog.nextButton)

    def stopped(self):
        self.until(lambda: self.dialog.stateLabel.text().startswith("Stopped"))


@pytest.fixture
def wizard(qtbot, tmp_path):
    """Open wizards, and close them without leaving a thread."""
    before, made = set(threading.enumerate()), []

    def make(stand):
        made.append(Wizard(qtbot, stand, tmp_path / "robot.yaml"))
        return made[-1]

    yield make
    for one in made:
        one.dialog.reject()
        one.model.close(60)
        one.stand.close()
    qtbot.waitUntil(lambda: set(threading.enumerate()) <= before)


def test_a_robot_is_calibrated_by_clicks_and_its_file_is_saved(wizard, tmp_path):
    bench = Bench("head")
    one = wizard(BenchStand(bench))
    dialog = one.dialog
    one.until(lambda: "is seen" in dialog.verdictLabel.text())
    assert bench.gate.sent == 0
    one.agree()
    assert "to 5 poses" in dialog.planLabel.text()
    one.until(lambda: dialog.page is HandEyePage.RESULT)
    assert bench.robot.speed < 1e-3
    assert dialog.poses.topLevelItemCount() == 5
    assert "±" in dialog.resultLabel.text()
    assert "the robot's model" in dialog.comparedLabel.text()
    one.click(dialog.useButton)
    assert bench.robot.placed.camera is one.model.solution.result.camera
    assert dialog.useButton.text() == "In &use"
    one.click(dialog.useButton)
    assert bench.robot.placed is None
    dialog.mountEdit.setText("neck")
    one.click(dialog.nextButton)
    one.until(lambda: dialog.messages.messages)
    assert one.files.asked == [str(Path.home() / "simulated-teo.hand-eye.yaml")]
    assert "Saved as" in dialog.messages.messages[0]
    assert placement(tmp_path / "robot.yaml").mount == "neck"
    dialog.frameEdit.clear()
    one.click(dialog.publishButton)
    assert "name both frames" in dialog.messages.messages[0]
    assert not dialog.publishButton.isChecked()


@pytest.mark.parametrize(
    "stop",
    [
        lambda one: one.qtbot.keyClick(one.dialog.events, Qt.Key_Space),
        lambda one: one.qtbot.keyClick(one.dialog.closeButton, Qt.Key_Space),
        lambda one: one.qtbot.keyClick(QApplication.focusWidget() or one.dialog, Qt.Key_Escape),
        lambda one: one.click(one.dialog.stopButton),
    ],
    ids=["Space", "Space on a button", "Escape", "button"],
)
def test_keys_and_button_stop_the_robot_whatever_has_the_focus(wizard, stop):
    bench = Bench("head")
    turnstile, one = Turnstile(bench, 2), wizard(BenchStand(bench))
    one.agree()
    assert turnstile.reached.wait(60)
    stop(one)
    one.until(lambda: bench.gate.halted)
    sent = bench.gate.sent
    turnstile.left.set()
    one.stopped()
    assert bench.gate.sent == sent
    assert one.dialog.isVisible()
    one.click(one.dialog.backButton)
    assert one.dialog.page is HandEyePage.PLAN
    bench.on_observation = lambda number: None
    one.qtbot.keyClick(one.dialog.agreeBox, Qt.Key_Space)
    one.click(one.dialog.nextButton)
    one.until(lambda: one.dialog.page is HandEyePage.RESULT)


def test_escape_stops_and_never_closes(wizard):
    one = wizard(BenchStand(Bench("head")))
    with one.qtbot.waitSignal(one.dialog.stopPressed):
        one.qtbot.keyClick(one.dialog.viewsBox, Qt.Key_Escape)
    assert one.dialog.isVisible()
    one.until(lambda: one.stand.gate.halted == "stopped in the window")


def test_closing_while_the_robot_moves_stops_it(wizard):
    bench = Bench("head")
    turnstile, one = Turnstile(bench, 2), wizard(BenchStand(bench))
    one.agree()
    assert turnstile.reached.wait(60)
    one.dialog.close()
    one.until(lambda: bench.gate.halted)
    turnstile.left.set()
    assert one.model.close(60)
    again = wizard(BenchStand(bench))
    again.until(lambda: "is seen" in again.dialog.verdictLabel.text())


def test_what_cannot_be_is_said_before_anything_moves(wizard):
    bench = Bench("head")
    one = wizard(BenchStand(bench))
    one.dialog.kindBox.setCurrentIndex(2)
    one.dialog.pitchBox.setValue(20)
    one.dialog.sizeBox.setValue(50)
    assert "overlap" in one.dialog.messages.messages[0]
    one.click(one.dialog.nextButton)
    assert one.dialog.page is HandEyePage.SETUP
    one.dialog.sizeBox.setValue(15)
    assert not one.dialog.messages.messages
    bench.robot.state = lambda: None
    one.click(one.dialog.nextButton)
    assert "does not report its joints" in one.dialog.messages.messages[0]
    del bench.robot.state


def test_the_simulated_camera_goes_where_the_eye_is_said_to_be(wizard):
    robot = SimRobot(teo.MODEL)
    cameras = SimulatedCameras(robot)
    config = Config(marker=MarkerConfig(kind="charuco", size=0.03, columns=5, rows=4))
    stand = HandEyeStand(
        robot, CommandGate(robot, config), config, cameras, closed_loop.calibration().scaled_to, None,
        leave=cameras.close,
    )  # fmt: skip
    one = wizard(stand)
    for button in (one.dialog.headButton, one.dialog.handButton):
        one.dialog.verdictLabel.setText("")
        button.click()
        one.until(lambda: "is seen" in one.dialog.verdictLabel.text())
    assert len(one.dialog.drawing.drawing.strokes) == 24
    assert stand.gate.sent == 0
