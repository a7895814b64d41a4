"""Takes the manual's screenshots of the servoing window and the hand–eye calibration, on the simulated TEO.

    QT_QPA_PLATFORM=offscreen python scripts/servo_screenshot.py light docs/images/servo.png

The others go to the same folder as hand-eye and hand-eye-result. The loop runs in simulated time, so the
screenshot is the same on a busy machine; in real time the loop would stop for late images.
"""

import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from psygnal import Signal
from PyQt5.QtTest import QTest

from grabbergui.core.frame import Frame
from grabbergui.driver.sim.rendered_scene import Things, board_pose
from grabbergui.servo import closed_loop
from grabbergui.servo.config import Config, MarkerConfig
from grabbergui.servo.gate import CommandGate
from grabbergui.servo.hand_eye.hand_eye_file import CameraMount
from grabbergui.servo.hand_eye.simulated_cameras import SimulatedCameras
from grabbergui.servo.hand_eye.stand import HandEyeStand
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.ui.hand_eye_controller import HandEyeController
from grabbergui.servo.ui.hand_eye_dialog import HandEyeDialog
from grabbergui.servo.ui.hand_eye_view import HandEyePage
from grabbergui.servo.ui.servo_controller import ServoController
from grabbergui.servo.ui.servo_window import ServoWindow
from grabbergui.ui.application import application
from grabbergui.ui.file_dialogs import FileDialogs
from grabbergui.ui.theme import Theme, dress

SECONDS, SHOWN_AT = 9.4, 4.0
SHOWN_EVERY = 4
"""Control cycles between two images in the window."""


class Follower:
    """The part of a runner that the window uses, in simulated time."""

    cycle_done = Signal(object, object)
    failed = Signal(str)

    def __init__(self, run: closed_loop.ClosedLoop) -> None:
        self.loop, self.robot, self.config, self.gate = run.loop, run.robot, run.config, run.gate
        self.running = True
        self.grabber = SimpleNamespace()


def image(run: closed_loop.ClosedLoop, number: int) -> Frame:
    """Return what the camera sees now, in colour."""
    settings = closed_loop.settings("RGB8")
    out = run._sensor.render(settings, number, int(run.now * 1e9), np.empty(settings.image_bytes, np.uint8))
    return Frame(out.reshape(-1).copy(), settings.width, settings.height, settings.pixel_format, number)


def main(theme: str, file: str) -> None:
    """Run the loop and take the screenshot."""
    app = application()
    dress(app, Theme(theme))
    run = closed_loop.ClosedLoop(
        things=Things(board=lambda seconds: board_pose() if seconds >= SHOWN_AT else None)
    )
    follower, window = Follower(run), ServoWindow()
    controller = ServoController(window, follower, closed_loop.calibration().scaled_to, hand_eye=True)
    window.show()
    number = 0
    while run.now < SECONDS:
        cycle, number = run.cycle(), number + 1
        follower.cycle_done.emit(cycle, None if number % SHOWN_EVERY else image(run, number))
        if number % SHOWN_EVERY == 0:
            QTest.qWait(45)  # as long as the window takes for an image
    QTest.qWait(500)
    window.grab().save(file)
    controller.close()
    window.close()
    hand_eye(Path(file))


def hand_eye(beside: Path) -> None:
    """Calibrate a camera on the hand, in real time, and take the pages of motion and result."""
    robot, poses = SimRobot(teo.MODEL), 12
    config = Config(marker=MarkerConfig(kind="charuco", size=0.03, columns=5, rows=4))
    cameras = SimulatedCameras(robot)
    gate, calibration = CommandGate(robot, config), closed_loop.calibration().scaled_to
    stand = HandEyeStand(
        robot, gate, config, cameras, calibration, lambda eye: CameraMount(eye, "hand", "camera"), "hand",
        leave=cameras.close,
    )  # fmt: skip
    dialog = HandEyeDialog()
    controller = HandEyeController(dialog, stand, FileDialogs(dialog), dialog)
    dialog.show()
    dialog.viewsBox.setValue(poses)
    await_that(lambda: "is seen" in dialog.verdictLabel.text())
    dialog.nextButton.click()
    dialog.agreeBox.click()
    dialog.nextButton.click()
    await_that(lambda: dialog.progress.value() >= poses - 3)
    await_that(lambda: "is seen" in dialog.verdictLabel.text())
    dialog.grab().save(str(beside.with_name(beside.name.replace("servo", "hand-eye"))))
    await_that(lambda: dialog.page is HandEyePage.RESULT)
    QTest.qWait(500)
    dialog.grab().save(str(beside.with_name(beside.name.replace("servo", "hand-eye-result"))))
    dialog.reject()
    controller.model.close(10)


def await_that(condition: Callable[[], bool], seconds: float = 300.0) -> None:
    """Run Qt's event loop until a condition holds."""
    until = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > until:
            raise TimeoutError("the calibration did not get there")
        QTest.qWait(50)


if __name__ == "__main__":
    main(*sys.argv[1:])
