import numpy as np
from PyQt5.QtCore import Qt

from grabbergui.servo import desk
from grabbergui.servo.pilot import Pilot
from grabbergui.servo.robots.sim_teo import SimTeo
from grabbergui.ui.views.servo_run import ServoPresenter
from grabbergui.ui.views.servo_window import ServoWindow


def test_the_stop_is_a_button_and_two_keys(qtbot):
    window = ServoWindow()
    qtbot.addWidget(window)
    window.show()
    qtbot.waitExposed(window)
    for press in (
        lambda: qtbot.mouseClick(window.stopButton, Qt.LeftButton),
        lambda: qtbot.keyClick(window, Qt.Key_Space),
        lambda: qtbot.keyClick(window, Qt.Key_Escape),
    ):
        with qtbot.waitSignal(window.stopPressed, timeout=5000):
            press()


def test_resuming_is_offered_only_when_stopped(qtbot):
    window = ServoWindow()
    qtbot.addWidget(window)
    assert not window.resumeButton.isEnabled()
    window.setStopped(True)
    with qtbot.waitSignal(window.resumePressed, timeout=5000):
        qtbot.mouseClick(window.resumeButton, Qt.LeftButton)


def test_pictures_keep_their_colours(qtbot):
    window = ServoWindow()
    qtbot.addWidget(window)
    window.setPicture(np.full((50, 70, 3), (250, 20, 40), np.uint8))
    colour = window.pictureLabel.pixmap().toImage().pixelColor(5, 5)
    assert (colour.red(), colour.green(), colour.blue()) == (250, 20, 40)


def test_a_live_session_is_shown_and_stopped_from_the_window(qtbot):
    robot = SimTeo()
    camera = desk.mounted_camera(robot, desk.things_for(desk.Config().marker))
    camera.open()
    pilot = Pilot(camera, robot, lambda frame: desk.detector(desk.Config(), desk.calibration()))
    window = ServoWindow()
    qtbot.addWidget(window)
    presenter = ServoPresenter(window, pilot, desk.calibration().scaled_to)
    try:
        pilot.start()
        qtbot.waitUntil(lambda: window.pictureLabel.pixmap() is not None, timeout=10000)
        qtbot.waitUntil(lambda: window.plotsLabel.pixmap() is not None, timeout=10000)
        qtbot.waitUntil(lambda: robot.speed > 0.02, timeout=10000)
        window.stopButton.click()
        assert robot.speed == 0
        qtbot.waitUntil(lambda: "stopped in the window" in window.stateLabel.text(), timeout=5000)
        qtbot.waitUntil(window.resumeButton.isEnabled, timeout=5000)
        window.resumeButton.click()
        qtbot.waitUntil(lambda: robot.speed > 0.01, timeout=10000)
    finally:
        presenter.close()
        pilot.stop()
        camera.close()
