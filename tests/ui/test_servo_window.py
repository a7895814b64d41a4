"""The servoing window: each direction apart, then a live run."""

import dataclasses
import threading

import numpy as np
import pytest
from PyQt5.QtCore import QEvent, QPoint, QPointF, Qt
from PyQt5.QtGui import QMouseEvent, QWheelEvent
from PyQt5.QtWidgets import QApplication, QPushButton
from test_accessibility import controls, spoken_name

from grabbergui.calibration import camera_info, geometry
from grabbergui.calibration.camera_info import CalibrationChoice
from grabbergui.core.errors import FrameTimeoutError, SourceUnavailableError
from grabbergui.core.pixels import DisplayImage, Region
from grabbergui.models.servo_proxy import RequestKind, RunnerProxy
from grabbergui.models.servoing import Entry, Posture, Tuning
from grabbergui.servo import closed_loop
from grabbergui.servo.config import Config
from grabbergui.servo.hand_eye_stand import HandEyeStand, SimulatedCameras
from grabbergui.servo.overlay import Drawing, Stroke
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.runner import Runner
from grabbergui.servo.state_machine import State
from grabbergui.ui.controllers.calibration_dialogs import CalibratingController
from grabbergui.ui.controllers.servoing import ServoController
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.views.calibration_dialogs import CalibrationChoiceDialog, CalibrationDialog
from grabbergui.ui.views.hand_eye_dialog import HandEyeDialog
from grabbergui.ui.views.servo_window import MOST_ENTRIES, ServoWindow
from grabbergui.ui.widgets.robot_view import NEAR, Orbit
from patience import PATIENCE, attempts
from servo_limits import patient_config

TUNING = Tuning.of(Config())


@pytest.fixture
def window(qtbot):
    made = ServoWindow()
    qtbot.addWidget(made)
    made.show()
    qtbot.waitExposed(made)
    return made


def posture(**changes):
    robot = SimRobot(teo.MODEL)
    state = robot.state()
    board = geometry.pose(np.diag([1.0, -1.0, -1.0]), (0.6, -0.2, 0.3))
    made = Posture(
        robot.skeleton(state),
        state.hand,
        robot.camera_pose(state.head),
        np.array([(-0.5, -0.4, 1), (0.5, -0.4, 1), (0.5, 0.4, 1), (-0.5, 0.4, 1)]),
        board,
        state.hand,
        np.array([1.3, 0.0, 0.8]),
        (0.1, 0.1),
        (np.array([0.1, -0.9, -0.3]), np.array([0.8, 0.3, 0.9])),
    )
    return dataclasses.replace(made, **changes)


# -- the stop --------------------------------------------------------------------------------------
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


# -- setters ---------------------------------------------------------------------------------------
def test_the_state_is_lit_and_reported(window):
    window.setState(State.WAITING, "centred; no marker yet")
    assert window.states.state is State.WAITING
    assert window.reasonLabel.text() == "centred; no marker yet"
    image = window.states.grab().toImage()
    colours = {image.pixelColor(x, image.height() // 2).name() for x in range(image.width())}
    assert "#50a0fa" in colours


def test_a_long_reason_does_not_move_the_stop_button(window, qapp):
    window.setState(State.SEARCHING, "")
    qapp.processEvents()
    place = window.stopButton.geometry()
    window.setState(State.STOPPED, "no image came within 0.5 s: check camera and cable, then start; " * 3)
    qapp.processEvents()
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


# -- the robot in space ----------------------------------------------------------------------------
def hues(view):
    image = view.grab().toImage()
    return {
        image.pixelColor(x, y).name() for x in range(0, image.width(), 2) for y in range(0, image.height(), 2)
    }


def test_a_robot_is_drawn_with_its_marker(window):
    empty = hues(window.robotView)
    window.setPosture(posture())
    drawn = hues(window.robotView)
    assert len(drawn) > len(empty) + 50
    window.setPosture(None)
    assert len(hues(window.robotView)) < len(drawn)


@pytest.mark.parametrize(
    "changes",
    [
        {"marker": None, "goal": None, "person": None},
        {"sight": np.zeros((0, 3))},
        {"skeleton": []},
        {"hand": geometry.pose(None, (50.0, 50.0, 50.0))},
        {"marker": geometry.pose(None, (-50.0, 3.0, 50.0))},
    ],
    ids=["alone", "no sight", "no body", "far away", "behind the eye"],
)
def test_whatever_is_not_known_or_seen_is_left_out(window, changes):
    window.setPosture(posture(**changes))
    assert hues(window.robotView)


def move(view, x, y):
    """A mouse's move; the one of QTest forgets which button is held."""
    event = QMouseEvent(QEvent.MouseMove, QPointF(x, y), Qt.NoButton, Qt.LeftButton, Qt.NoModifier)
    QApplication.sendEvent(view, event)


def test_a_drag_turns_and_a_double_click_goes_back(window, qtbot):
    view = window.robotView
    view.setGeometry(0, 0, 400, 300)
    before = view.orbit
    qtbot.mousePress(view, Qt.LeftButton, pos=QPoint(100, 100))
    move(view, 150, 80)
    qtbot.mouseRelease(view, Qt.LeftButton, pos=QPoint(150, 80))
    assert view.orbit.azimuth < before.azimuth
    assert view.orbit.elevation < before.elevation
    turned = view.orbit
    move(view, 10, 10)
    assert view.orbit == turned
    qtbot.mouseDClick(view, Qt.LeftButton)
    assert view.orbit == before


def test_the_wheel_goes_nearer(window, qapp):
    view, middle = window.robotView, QPointF(50, 50)
    far = view.orbit.distance
    event = QWheelEvent(
        middle, middle, QPoint(), QPoint(0, 120), Qt.NoButton, Qt.NoModifier, Qt.NoScrollPhase, False
    )
    qapp.sendEvent(view, event)
    assert view.orbit.distance < far


def test_an_orbit_sees_its_centre_in_the_middle_and_up_as_up():
    orbit = Orbit(azimuth=1.0, elevation=0.3, distance=2.0)
    seen = orbit.seen([orbit.centre, np.add(orbit.centre, (0, 0, 0.1))])
    flat = orbit.flat(seen, 400, 300)
    assert flat[0] == pytest.approx((200, 150))
    assert seen[0] == pytest.approx((0, 0, 2.0))
    assert flat[1][0] == pytest.approx(200)
    assert flat[1][1] < 150


def test_a_line_is_cut_off_before_the_eye():
    orbit = Orbit()
    behind = np.array(orbit.centre) - 3 * orbit.distance * orbit.axes[2]
    for ends in ((orbit.centre, behind), (behind, orbit.centre)):
        flat, depths = orbit.line(ends, 400, 300)
        assert flat.shape == (1, 2, 2)
        assert np.isfinite(flat).all()
        assert depths[0] == pytest.approx((orbit.distance + NEAR) / 2)
    assert len(orbit.line([behind, behind], 400, 300)[0]) == 0


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


# -- a live run ------------------------------------------------------------------------------------
@pytest.fixture
def calibration():
    """The calibration of the live run; a test may exchange it."""
    return CalibrationChoice(closed_loop.calibration().scaled_to)


@pytest.fixture
def limits():
    return patient_config()


@pytest.fixture
def live(qtbot, window, calibration, limits):
    """A runner on the simulated robot, shown."""
    threads = set(threading.enumerate())
    robot = SimRobot(teo.MODEL)
    camera = closed_loop.mounted_camera(robot, closed_loop.things_for(Config().marker))
    camera.open()
    runner = Runner(
        camera,
        robot,
        lambda frame: closed_loop.detector(limits, calibration(frame.width, frame.height)),
        limits,
    )
    cameras = SimulatedCameras(robot)
    stand = HandEyeStand(robot, runner.gate, Config(), cameras, calibration, None, leave=cameras.close)
    controller = ServoController(window, runner, calibration, stand)
    try:
        yield runner, robot
    finally:
        controller.close()
        runner.stop()
        camera.close()
        # Those of the stop button end by themselves.
        qtbot.waitUntil(lambda: set(threading.enumerate()) <= threads)


def test_a_live_run_is_shown_and_stopped_from_the_window(window, live, qtbot):
    runner, robot = live
    runner.start()
    qtbot.waitUntil(lambda: bool(window.drawing.drawing.strokes))
    qtbot.waitUntil(lambda: robot.speed > 0.02)
    qtbot.waitUntil(lambda: window.distancePlot.values() is not None)
    for watch in attempts(1.0):
        qtbot.waitUntil(lambda: robot.speed > 0.01)
        with watch:
            window.stopButton.click()
            qtbot.waitUntil(lambda: robot.speed == 0)
        qtbot.waitUntil(lambda: window.states.state is State.STOPPED)
        assert window.reasonLabel.text() == "stopped in the window"
        assert window.history.topLevelItem(window.history.topLevelItemCount() - 1).text(1) == "stopped"
        qtbot.waitUntil(window.startButton.isEnabled)
        window.startButton.click()
    qtbot.waitUntil(lambda: robot.speed > 0.01)


def test_a_robot_that_is_held_waits_for_start(window, live, qtbot):
    runner, robot = live
    runner.start(held="press Start")
    qtbot.waitUntil(lambda: window.reasonLabel.text() == "press Start")
    qtbot.waitUntil(lambda: window.distancePlot.values() is not None)
    assert window.states.state is State.STOPPED
    assert robot.speed == 0
    window.startButton.click()
    qtbot.waitUntil(lambda: robot.speed > 0.01)
    qtbot.waitUntil(lambda: not window.startButton.isEnabled())


@pytest.mark.parametrize("limits", [Config()], ids=["of a real robot"])
def test_a_gain_set_in_the_window_reaches_the_loop_and_nonsense_does_not(window, live, qtbot):
    runner, _ = live
    runner.start()
    window.headGainBox.setValue(0.7)
    qtbot.waitUntil(lambda: runner.config.head.gain == 0.7)
    window.tuningChanged.emit(dataclasses.replace(TUNING, rate=5))
    assert "too long" in window.messages.messages[0]
    assert window.rateBox.value() == 50


def test_a_stop_that_hangs_in_the_network_does_not_hold_up_the_window(window, live, qtbot):
    runner, robot = live
    entered, leave = threading.Event(), threading.Event()
    stop = robot.stop

    def hang():
        entered.set()
        leave.wait(PATIENCE)
        stop()

    robot.stop = hang
    window.stopButton.click()  # returns at once, or the test would end in its time limit
    assert entered.wait(PATIENCE)
    leave.set()
    qtbot.waitUntil(lambda: bool(runner.gate.halted))


@pytest.fixture
def slow_start(live, monkeypatch):
    """Returns the starts of the loop so far, and the event that lets them proceed."""
    runner, _ = live
    starts, proceed, start = [], threading.Event(), runner._start

    def start_slowly():
        starts.append(True)
        assert proceed.wait(PATIENCE)
        start()

    monkeypatch.setattr(runner, "_start", start_slowly)
    return starts, proceed


def starting():
    return any(thread.name == "start" for thread in threading.enumerate())


def test_start_pressed_twice_starts_one_loop(window, live, slow_start, qtbot):
    starts, proceed = slow_start
    window.startPressed.emit()
    window.startPressed.emit()
    qtbot.waitUntil(lambda: bool(starts))
    proceed.set()
    qtbot.waitUntil(lambda: not starting())
    assert len(starts) == 1


def test_a_stop_pressed_while_the_loop_starts_keeps_the_robot_still(window, live, slow_start, qtbot):
    runner, robot = live
    starts, proceed = slow_start
    window.startPressed.emit()
    qtbot.waitUntil(lambda: bool(starts))
    window.stopButton.click()
    qtbot.waitUntil(lambda: runner.gate.halted == "stopped in the window")
    proceed.set()
    qtbot.waitUntil(lambda: not starting())
    assert runner.gate.halted == "stopped in the window"
    assert robot.speed == 0


def test_a_run_that_failed_says_why_and_can_be_started_again(window, live, qtbot):
    runner, _ = live
    make = runner._make_detector

    def fail(frame):
        raise FrameTimeoutError("the lens fell off")

    runner._make_detector = fail
    runner.start()
    qtbot.waitUntil(lambda: window.messages.messages == ["the lens fell off"])
    runner._make_detector = make
    qtbot.waitUntil(lambda: not runner.running and window.startButton.isEnabled())
    window.startButton.click()
    qtbot.waitUntil(lambda: bool(window.drawing.drawing.strokes))


def test_a_camera_that_does_not_start_leaves_the_start_to_be_repeated(window, live, qtbot, monkeypatch):
    runner, _ = live

    def fail():
        raise SourceUnavailableError("the camera is used by another program")

    with monkeypatch.context() as refused:
        refused.setattr(runner.grabber, "start", fail)
        runner.start()
        qtbot.waitUntil(lambda: window.startButton.isEnabled())
    assert window.messages.messages == ["the camera is used by another program"]
    window.startButton.click()
    qtbot.waitUntil(lambda: bool(window.drawing.drawing.strokes))


def test_the_robot_that_is_drawn_is_the_one_that_moves(live, window, qtbot):
    runner, robot = live
    runner.start()
    qtbot.waitUntil(lambda: bool(window.drawing.drawing.strokes))
    shown = window.robotView.posture
    reach = teo.RIGHT_ARM.forward(robot.state().arm)[:3, 3]
    assert np.linalg.norm(shown.hand[:3, 3] - reach) < 0.05
    assert shown.sight.shape == (4, 3)


def test_a_camera_that_is_not_calibrated_can_be_from_here(window, live, calibration, qtbot, tmp_path):
    runner, robot = live
    calibration.exchange(CalibrationChoice.nominal(60))
    runner.start()
    qtbot.waitUntil(lambda: bool(window.messages.messages))
    assert "not calibrated" in window.messages.messages[0]
    window.findChild(QPushButton, "offerButton").click()
    dialog = window.findChild(CalibrationDialog)
    assert dialog.isVisible()
    qtbot.waitUntil(lambda: bool(runner.gate.halted) and robot.speed == 0)
    path = tmp_path / "camera.yaml"
    camera_info.save(closed_loop.calibration(), path)
    dialog.findChild(CalibratingController).model.saved.emit(path)
    qtbot.waitUntil(lambda: "in use" in window.messages.messages[0])
    assert not calibration(608, 512).nominal
    qtbot.waitUntil(lambda: not any("not calibrated" in text for text in window.messages.messages))
    dialog.reject()


def test_hand_and_eye_are_calibrated_while_the_loop_rests(window, live, qtbot):
    runner, robot = live
    runner.start()
    qtbot.waitUntil(lambda: robot.speed > 0.01)
    window.handEyeButton.click()
    qtbot.waitUntil(lambda: window.findChild(HandEyeDialog) is not None)
    dialog = window.findChild(HandEyeDialog)
    qtbot.waitUntil(lambda: "is seen" in dialog.verdictLabel.text())
    assert not runner.running
    assert robot.speed == 0
    assert not window.handEyeButton.isEnabled()
    window.startPressed.emit()
    assert "still being calibrated" in window.messages.messages[0]
    dialog.reject()
    qtbot.waitUntil(lambda: runner.running and window.reasonLabel.text() == "Start lets the robot move")
    assert robot.speed == 0
    window.startButton.click()
    qtbot.waitUntil(lambda: robot.speed > 0.01)


def test_nothing_starts_while_the_calibration_of_hand_and_eye_opens(window, live, qtbot):
    runner, robot = live
    runner.start()
    qtbot.waitUntil(lambda: robot.speed > 0.01)
    window.handEyeButton.click()
    window.startPressed.emit()
    assert "still being calibrated" in window.messages.messages[0]
    qtbot.waitUntil(lambda: window.findChild(HandEyeDialog) is not None)
    assert not runner.running
    window.findChild(HandEyeDialog).reject()
    qtbot.waitUntil(lambda: runner.running)


class Elsewhere(RunnerProxy):
    """A run of another process that reports nothing."""

    def __init__(self):
        self.running, self.calibrates_hand_eye, self.config, self.requests = True, True, Config(), []

    def _request(self, request):
        self.requests.append(request.kind)


def test_a_window_of_another_process_gives_way_to_the_calibration_there(window, qtbot):
    proxy = Elsewhere()
    controller = ServoController(window, proxy, lambda width, height: None)
    assert window.handEyeButton.isEnabled()
    window.handEyeButton.click()
    assert proxy.requests == [RequestKind.HAND_EYE]
    assert not window.isVisible()
    controller.close()
