"""The calibration dialog on a camera that renders a board, and as the main window opens it."""

import subprocess
import sys
import threading

import cv2
import numpy as np
import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QFileDialog

import fakes
from grabbergui.calibration import camera_info
from grabbergui.calibration.collector import Collector
from grabbergui.core.errors import CalibrationError
from grabbergui.core.frame import Frame, FrameStatus
from grabbergui.core.pfnc import PixelFormat, by_name
from grabbergui.driver.sim.rendered_scene import MOVE_S, REST_S, BoardScene, holds, pinhole
from grabbergui.driver.sim.settings import FrameSettings, Optics
from grabbergui.models import calibrating
from grabbergui.ui.controllers import calibration
from grabbergui.ui.controllers.calibration_dialogs import CalibratingController
from grabbergui.ui.views.calibration_dialogs import CalibrationDialog, CalibrationPage
from patience import PATIENCE, PROGRAM

MONO = by_name("Mono8")
SETTINGS = FrameSettings(
    608,
    512,
    208,
    14,
    MONO,
    Optics(binning_horizontal=4, binning_vertical=4, ratios=(1.0, 1.0, 1.0)),
    1e4,
    0.0,
    2.0,
)


@pytest.fixture(scope="module")
def views():
    """The camera's image for each pose of the board."""
    scene = BoardScene()
    times = [number * (MOVE_S + REST_S) + 0.1 for number in range(len(holds()))]
    images = (scene.rendered(int(seconds * 1e9), SETTINGS)[..., 1] for seconds in times)
    return [np.clip(image // 32, 0, 255).astype(np.uint8) for image in images]


def frame(grey, **changes):
    return Frame(np.ascontiguousarray(grey).reshape(-1), grey.shape[1], grey.shape[0], MONO, **changes)


class Stand:
    """A dialog on a camera whose images a test puts."""

    def __init__(self, qtbot):
        self.qtbot = qtbot
        self.grabber = fakes.ScriptedGrabber()
        self.grabber.start()
        self.dialog = CalibrationDialog()
        self.dialog.setAttribute(Qt.WA_DeleteOnClose, False)
        qtbot.addWidget(self.dialog)
        self.saved = []
        self.controller = CalibratingController(self.dialog, self.grabber, self.saved.append)
        self.model = self.controller.model
        self.looks = 0
        self.model.ready.connect(self._count)
        self.dialog.show()

    def _count(self):
        self.looks += 1

    def put(self, grey, times=1):
        """Show the camera an image and wait until it was looked at."""
        for _ in range(times):
            before = self.looks
            self.grabber._fanout.put(frame(grey))
            self.until(lambda before=before: self.looks > before)
            self.until(lambda: self.model._offer is None)

    def until(self, condition):
        self.qtbot.waitUntil(lambda: bool(condition()))

    def click(self, button):
        self.qtbot.mouseClick(button, Qt.LeftButton)


@pytest.fixture
def stand(qtbot):
    before = set(threading.enumerate())
    made = Stand(qtbot)
    yield made
    made.dialog.reject()
    made.until(lambda: set(threading.enumerate()) <= before)


def test_a_camera_is_calibrated_through_the_dialog(stand, views, tmp_path, monkeypatch):
    dialog = stand.dialog
    stand.put(views[0])
    stand.until(lambda: dialog.verdictLabel.text() == "● the board is seen")
    assert dialog.progress.value() == 0  # looking takes nothing yet
    stand.click(dialog.nextButton)
    assert dialog.step is CalibrationPage.VIEWS
    for number, view in enumerate(views):
        stand.put(view, times=2 if number else 3)
        if dialog.step is CalibrationPage.RESULT:
            break
    stand.until(lambda: dialog.step is CalibrationPage.RESULT)
    assert dialog.views.topLevelItemCount() == calibrating.WANTED
    assert len(stand.model.images) == calibrating.WANTED
    path = tmp_path / "camera.yaml"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(path), ""))
    stand.click(dialog.nextButton)
    stand.until(lambda: stand.saved == [path])
    found, true = camera_info.load(path), pinhole(SETTINGS)
    assert found.matrix[0, 0] == pytest.approx(true[0, 0], rel=0.01)
    assert found.matrix[:2, 2] == pytest.approx(true[:2, 2], abs=3)
    assert (found.width, found.height, found.camera_name) == (608, 512, "script")
    assert str(path) in dialog.messages.messages[0]
    _views_are_left_out_and_looked_at(stand)


def _views_are_left_out_and_looked_at(stand):
    dialog = stand.dialog
    before = dialog.resultLabel.text()
    dialog.views.topLevelItem(3).setCheckState(0, Qt.Unchecked)
    stand.until(lambda: dialog.resultLabel.text() != before)
    assert f"over {calibrating.WANTED - 1} views" in dialog.resultLabel.text()
    assert dialog.views.topLevelItem(3).text(2).endswith("left out")
    dialog.views.setCurrentItem(dialog.views.topLevelItem(3))
    stand.until(lambda: dialog.verdictLabel.text().startswith("● view 4"))
    assert len(dialog.drawing.drawing.strokes) == 3 * int(dialog.views.topLevelItem(3).text(1))
    stand.click(dialog.moreButton)
    assert dialog.step is CalibrationPage.VIEWS
    stand.put(np.full((512, 608), 90, np.uint8), times=2)
    stand.until(lambda: dialog.progress.maximum() == calibrating.WANTED * 3 // 2)
    assert dialog.verdictLabel.text() == "● no board is seen"


def test_a_few_views_suffice_where_one_finishes_early(stand, views):
    stand.click(stand.dialog.nextButton)
    for view in views[:7]:
        stand.put(view, times=3)
    stand.until(stand.dialog.nextButton.isEnabled)
    stand.click(stand.dialog.nextButton)
    stand.until(lambda: stand.dialog.step is CalibrationPage.RESULT)
    assert 5 <= stand.dialog.views.topLevelItemCount() <= 7


def test_views_that_were_left_out_stay_so_when_more_are_taken(stand, views):
    dialog = stand.dialog
    _take(stand, views[:7])
    count = dialog.views.topLevelItemCount()
    dialog.views.topLevelItem(1).setCheckState(0, Qt.Unchecked)
    stand.until(lambda: f"over {count - 1} views" in dialog.resultLabel.text())
    stand.click(dialog.moreButton)
    stand.put(views[7], times=3)
    stand.until(lambda: dialog.progress.value() > count)
    stand.click(dialog.nextButton)
    stand.until(lambda: dialog.step is CalibrationPage.RESULT)
    ticks = [dialog.views.topLevelItem(row).checkState(0) for row in range(count + 1)]
    assert ticks[1] == Qt.Unchecked
    assert ticks[count] == Qt.Checked


def test_views_unticked_while_a_calibration_is_computed_stay_unticked(stand, views, monkeypatch):
    dialog, solve, proceed, solutions = stand.dialog, Collector.solve, threading.Event(), []
    stand.model.solved.connect(solutions.append)
    _take(stand, views[:8])
    stand.until(lambda: solutions)  # the window may have heard of it first

    def slowly(*arguments):
        assert proceed.wait(PATIENCE)
        return solve(*arguments)

    monkeypatch.setattr(Collector, "solve", slowly)
    rows = range(2)
    for row in rows:
        dialog.views.topLevelItem(row).setCheckState(0, Qt.Unchecked)
        stand.model.solved.emit(solutions[0])  # comes late, with the ticks of before
        stand.qtbot.wait(1)
    assert [dialog.views.topLevelItem(row).checkState(0) for row in rows] == [Qt.Unchecked] * 2
    proceed.set()
    count = dialog.views.topLevelItemCount()
    stand.until(lambda: f"over {count - 2} views" in dialog.resultLabel.text())


def test_ticks_that_leave_too_few_views_are_those_of_the_result_again(stand, views):
    dialog = stand.dialog
    _take(stand, views[:7])
    count = dialog.views.topLevelItemCount()
    for row in range(count - 4):
        dialog.views.topLevelItem(row).setCheckState(0, Qt.Unchecked)
    stand.until(lambda: dialog.messages.messages)
    assert "at least 5" in dialog.messages.messages[0]
    rows = [dialog.views.topLevelItem(row) for row in range(count)]
    ticked = sum(row.checkState(0) == Qt.Checked for row in rows)
    assert ticked >= 5
    assert f"over {ticked} views" in dialog.resultLabel.text()


def test_views_are_still_taken_after_those_that_did_not_suffice(stand, views, monkeypatch):
    dialog = stand.dialog

    def fails(*_):
        raise CalibrationError("the views do not determine the camera")

    with monkeypatch.context() as patch:
        patch.setattr(Collector, "solve", fails)
        _take(stand, views[:6], finished=lambda: dialog.messages.messages)
    before = dialog.progress.value()
    stand.put(views[6], times=3)
    stand.until(lambda: dialog.progress.value() > before)


def test_escape_does_not_throw_views_away(stand, views):
    stand.click(stand.dialog.nextButton)
    stand.put(views[0], times=3)
    stand.until(lambda: stand.dialog.progress.value() == 1)
    stand.qtbot.keyClick(stand.dialog, Qt.Key_Escape)
    assert stand.dialog.isVisible()
    stand.click(stand.dialog.againButton)
    stand.put(np.full((512, 608), 90, np.uint8))
    stand.until(lambda: stand.dialog.progress.value() == 0)
    stand.qtbot.keyClick(stand.dialog, Qt.Key_Escape)
    assert not stand.dialog.isVisible()


def _answer(stand, text):
    stand.until(lambda: stand.dialog.question is not None)
    question = stand.dialog.question
    next(button for button in question.buttons() if button.text() == text).click()
    stand.until(lambda: stand.dialog.question is None)


@pytest.mark.parametrize("how", ["button", "title bar"])
def test_views_are_not_lost_without_a_question(stand, views, how, tmp_path, monkeypatch):
    """*Close* at the result discarded twenty views without a word."""
    close = stand.dialog.closeButton.click if how == "button" else stand.dialog.close
    _take(stand, views[:7])
    close()
    assert stand.dialog.isVisible() and "7 views" in stand.dialog.question.text()
    _answer(stand, "Keep them")
    assert stand.dialog.isVisible() and stand.dialog.views.topLevelItemCount() >= 5
    if how == "button":
        path = tmp_path / "camera.yaml"
        monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(path), ""))
        stand.click(stand.dialog.nextButton)
        stand.until(lambda: stand.saved == [path])
        close()  # nothing is lost any more
    else:
        close()
        _answer(stand, "Discard them")
    assert not stand.dialog.isVisible()


def _take(stand, views, finished=None):
    """Take these views and finish."""
    stand.click(stand.dialog.nextButton)
    for view in views:
        stand.put(view, times=3)
    stand.until(stand.dialog.nextButton.isEnabled)
    stand.click(stand.dialog.nextButton)
    stand.until(finished or (lambda: stand.dialog.step is CalibrationPage.RESULT))


def test_too_few_views_are_no_calibration(stand, views):
    stand.model.solve()
    stand.until(lambda: stand.dialog.messages.messages)
    assert "at least 5" in stand.dialog.messages.messages[0]
    stand.controller.save_to(None)
    stand.until(lambda: "no calibration to save" in stand.dialog.messages.messages[0])


def test_images_of_another_size_begin_again(stand, views):
    stand.click(stand.dialog.nextButton)
    stand.put(views[0], times=3)
    stand.until(lambda: stand.dialog.progress.value() == 1)
    stand.grabber._fanout.put(frame(cv2.resize(views[0], (304, 256))))
    stand.until(lambda: stand.dialog.messages.messages)
    assert "608×512 to 304×256" in stand.dialog.messages.messages[0]
    stand.put(cv2.resize(views[0], (304, 256)), times=2)
    assert stand.dialog.progress.value() <= 1


def test_a_damaged_image_is_no_reason_to_end(stand, views):
    stand.click(stand.dialog.nextButton)
    stand.grabber._fanout.put(frame(views[0], status=FrameStatus.INCOMPLETE))
    short = frame(views[0])
    short.payload = short.payload[:1000]
    stand.grabber._fanout.put(short)
    stand.put(views[0], times=3)
    stand.until(lambda: stand.dialog.progress.value() == 1)


def test_an_image_in_an_unknown_format_is_reported_and_costs_no_view(stand, views):
    stand.click(stand.dialog.nextButton)
    stand.put(views[0], times=3)
    stand.until(lambda: stand.dialog.progress.value() == 1)
    strange = frame(views[1])
    strange.pixel_format = PixelFormat("Strange8", 0x81080001)
    stand.grabber._fanout.put(strange)
    stand.until(lambda: stand.dialog.messages.messages)
    assert "Strange8" in stand.dialog.messages.messages[0]
    stand.put(views[0], times=2)
    assert stand.dialog.progress.value() == 1


def test_begin_again_forgets(stand, views):
    stand.click(stand.dialog.nextButton)
    stand.put(views[0], times=3)
    stand.until(lambda: stand.dialog.progress.value() == 1)
    stand.click(stand.dialog.againButton)
    stand.put(np.full((512, 608), 90, np.uint8), times=2)
    stand.until(lambda: stand.dialog.progress.value() == 0)
    assert stand.model.images == []


def test_missing_images_are_reported(stand, monkeypatch):
    monkeypatch.setattr(calibrating, "SILENCE", 0.05)
    stand.until(lambda: "no images" in stand.dialog.verdictLabel.text())


def test_a_board_that_cannot_be_is_refused_and_can_be_mended(stand):
    dialog = stand.dialog
    dialog.markerBox.setValue(40)
    assert "does not fit" in dialog.messages.messages[0]
    assert not dialog.nextButton.isEnabled()
    assert "does not fit" in dialog.nextButton.toolTip()
    dialog.markerBox.setValue(20)
    assert dialog.nextButton.isEnabled()
    assert dialog.messages.messages == []


@pytest.mark.parametrize("suffix", ["pdf", "png"])
def test_the_board_is_printed(stand, tmp_path, monkeypatch, suffix):
    path = tmp_path / f"board.{suffix}"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(path), ""))
    stand.click(stand.dialog.printButton)
    assert path.stat().st_size > 1000
    assert "A4 at 100 %" in stand.dialog.messages.messages[0]


def test_a_file_that_cannot_be_written_is_reported(stand, tmp_path):
    stand.controller.print_to(tmp_path / "no" / "where.pdf")
    assert "could not be saved" in stand.dialog.messages.messages[0]


def test_the_window_opens_it_on_what_it_shows_and_closes_it_with_that(app):
    window, opener = app.window, app.program.image_controls.calibrating
    assert not window.actionCalibrate.isEnabled()
    app.connect("sim:board")
    app.until(window.actionCalibrate.isEnabled)
    window.actionCalibrate.trigger()
    first = opener.dialog
    app.until(lambda: first.verdictLabel.text() == "● the board is seen")
    window.actionCalibrate.trigger()
    assert opener.dialog is first
    first.closeButton.click()
    assert opener.dialog is None
    window.actionCalibrate.trigger()
    app.program.open_sources.close_current()
    app.until(lambda: opener.dialog is None and not window.actionCalibrate.isEnabled())
    app.until(lambda: "calibrating" not in {thread.name for thread in threading.enumerate()})


def test_a_menu_imports_the_dialog_while_its_user_looks_for_the_entry(app, monkeypatch):
    """The import kept the window for a third of a second, on a busy computer for one."""
    imported = []
    monkeypatch.setattr(calibration, "import_module", imported.append)
    app.window.menuTools.aboutToShow.emit()
    app.until(lambda: imported == [CalibratingController.__module__])


def test_the_dialog_imports_nothing_of_a_robots_loop():
    program = (
        "import sys, grabbergui.ui.controllers.calibration_dialogs;"
        "print(*(name for name in sys.modules if name.startswith('grabbergui.servo.')))"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=PROGRAM)
    assert (run.returncode, run.stdout.split()) == (0, []), run.stderr
