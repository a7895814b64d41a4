"""The views of a calibration: each direction apart; the choice for a camera that has none."""

import numpy as np
import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QFileDialog

import fakes
from grabbergui.calibration import camera_info
from grabbergui.calibration.boards import BoardSettings
from grabbergui.calibration.collector import Coverage, ViewVerdict
from grabbergui.core.calibration import Calibration
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.pixels import DisplayImage, Region
from grabbergui.models import calibrating
from grabbergui.models.calibrating import BoardPreview, camera_name
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.controllers.calibration_dialogs import CalibratingController, CalibrationChooser
from grabbergui.ui.views.calibration_dialogs import (
    CalibrationChoiceDialog,
    CalibrationDialog,
    CalibrationPage,
)


@pytest.fixture
def dialog(qtbot):
    made = CalibrationDialog()
    made.setAttribute(Qt.WA_DeleteOnClose, False)
    qtbot.addWidget(made)
    made.show()
    return made


def preview(verdict, views=0, hint="nearer", coverage=None):
    image = DisplayImage(np.zeros((60, 80), np.uint8), Region(0, 0, 80, 60))
    corners = None if verdict is ViewVerdict.NOT_SEEN else np.float32([(10, 10), (30, 20)])
    return BoardPreview(image, (80, 60), corners, verdict, coverage or Coverage(), views, hint)


def test_a_board_goes_in_without_coming_out_and_comes_out_when_set_by_hand(dialog, qtbot):
    board = BoardSettings("charuco", 7, 9, 0.025, 0.019, "6X6_250")
    with qtbot.assertNotEmitted(dialog.boardChosen):
        dialog.setBoard(board)
    assert dialog.board == board
    with qtbot.waitSignal(dialog.boardChosen) as caught:
        dialog.kindBox.setCurrentIndex(1)
    assert caught.args[0].kind == "chessboard"
    assert not dialog.markerBox.isEnabled()


@pytest.mark.parametrize(
    ("step", "verdict", "text"),
    [
        (CalibrationPage.BOARD, ViewVerdict.KEPT, "the board is seen"),
        (CalibrationPage.BOARD, ViewVerdict.NOT_SEEN, "no board is seen"),
        (CalibrationPage.VIEWS, ViewVerdict.MOVING, "hold it still"),
        (CalibrationPage.VIEWS, ViewVerdict.KNOWN, "this view is there already"),
    ],
)
def test_what_hinders_is_reported(dialog, step, verdict, text):
    dialog.setStep(step)
    dialog.setPreview(preview(verdict), 20)
    assert dialog.verdictLabel.text() == f"● {text}"
    assert len(dialog.drawing.drawing.strokes) == (0 if verdict is ViewVerdict.NOT_SEEN else 4)


def test_progress_coverage_and_hint_are_shown(dialog):
    coverage = Coverage()
    coverage.cells[:3] = 5
    coverage.tilts[1, 2] = coverage.sizes[2] = 1
    assert dialog.backButton.toolTip() == Unavailable.PAGE.text
    dialog.setStep(CalibrationPage.VIEWS)
    assert dialog.backButton.isEnabled() and not dialog.backButton.toolTip()
    dialog.setPreview(preview(ViewVerdict.KEPT, 4, "Next: hold it at the top left", coverage), 20)
    assert (dialog.progress.value(), dialog.progress.maximum()) == (4, 20)
    assert dialog.hintLabel.text() == "Next: hold it at the top left"
    assert dialog.coverageLabel.text().startswith("50%")
    assert not dialog.nextButton.isEnabled()
    assert dialog.nextButton.toolTip() == Unavailable.VIEWS.text
    dialog.setPreview(preview(ViewVerdict.KEPT, 5, "", coverage), 20)
    assert dialog.nextButton.isEnabled()
    # The right one of the three boards in the middle, and the lowest of the distances.
    drawn = dialog.coverage.grab().toImage()
    green = [(x, y) for x in range(0, drawn.width(), 4) for y in range(0, drawn.height(), 4)
             if drawn.pixelColor(x, y).green() > drawn.pixelColor(x, y).red() + 30]  # fmt: skip
    assert green
    assert all(x > 100 and y > 70 for x, y in green)


def test_there_is_a_text_for_every_hint():
    coverage = Coverage()
    hints = set()
    for cell in range(coverage.cells.size + 1):
        hints.add(coverage.missing())
        coverage.cells.flat[cell % coverage.cells.size] = 1
    coverage.sizes[1] = 4
    for row, column in ((1, 0), (1, 2), (0, 1), (2, 1), (1, 1)):
        hints.add(coverage.missing())
        coverage.tilts[row, column] = 1
    for place in (2, 1):
        hints.add(coverage.missing())
        coverage.sizes[:] = 0
        coverage.sizes[place] = 4
    coverage.sizes[2] = 1
    hints.add(coverage.missing())
    texts = {calibrating.hint_text(hint) for hint in hints}
    assert len(texts) == len(hints) == 16
    assert len({calibrating.verdict_text(verdict) for verdict in ViewVerdict}) == len(ViewVerdict)


@pytest.mark.parametrize(
    ("info", "name"),
    [
        (DeviceInfo("a:", model="acA2440-75um", serial="23 17"), "aca2440_75um_23_17"),
        (DeviceInfo("a:", model="x", user_name="Left eye"), "left_eye"),
        (DeviceInfo("a:", model="相机"), "camera"),
        (DeviceInfo("ros2:/left"), "ros2_left"),
    ],
)
def test_a_camera_is_named_as_ros_allows(info, name):
    assert camera_name(info) == name


@pytest.fixture
def chooser(qtbot):
    dialog = CalibrationChoiceDialog("Left eye")
    qtbot.addWidget(dialog)
    dialog.open()
    grabber = fakes.ScriptedGrabber()
    grabber.start()
    made = CalibrationChooser(dialog, grabber)
    yield made
    if made.calibrating is not None:
        made.calibrating.reject()


def test_a_missing_calibration_is_reported(chooser):
    assert chooser.parent().titleLabel.text() == "Left eye is not calibrated"
    chooser.parent().cancelButton.click()
    assert chooser.choice is None


def test_a_field_of_view_may_be_assumed(chooser):
    dialog = chooser.parent()
    dialog.degreesBox.setValue(90)
    dialog.nominalButton.click()
    assert dialog.result() == dialog.Accepted
    assumed = chooser.choice(640, 480)
    assert assumed.nominal
    assert assumed.matrix[0, 0] == pytest.approx(320)


def test_a_file_may_be_opened_and_one_that_is_none_is_refused(chooser, tmp_path, monkeypatch):
    dialog, path = chooser.parent(), tmp_path / "camera.yaml"
    path.write_text("camera_matrix: broken")
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(path), ""))
    dialog.fileButton.click()
    assert "camera.yaml" in dialog.problemLabel.text()
    assert chooser.choice is None
    camera_info.save(Calibration.from_field_of_view(640, 480, 70), path)
    dialog.fileButton.click()
    assert chooser.choice(320, 240).matrix[0, 0] == pytest.approx(160 / np.tan(np.radians(35)))


def test_it_may_be_calibrated_at_once(chooser, tmp_path, qtbot):
    dialog, path = chooser.parent(), tmp_path / "camera.yaml"
    dialog.calibrateButton.click()
    assert chooser.calibrating.isVisible()
    camera_info.save(Calibration.from_field_of_view(640, 480, 70), path)
    chooser.calibrating.findChild(CalibratingController).model.saved.emit(path)
    qtbot.waitUntil(lambda: chooser.choice is not None)
    assert not dialog.isVisible()
