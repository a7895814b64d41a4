"""Takes the manual's picture of the servoing window: the real loop on the simulated TEO, in simulated time.

    QT_QPA_PLATFORM=offscreen python scripts/servo_screenshot.py light docs/images/servo.png

Simulated time makes it the same on a busy machine, where the loop in real time would stop for late pictures.
"""

import sys
from types import SimpleNamespace

import numpy as np
from psygnal import Signal
from PyQt5.QtTest import QTest

from grabbergui.core.frame import Frame
from grabbergui.driver.sim.rendered.scene import Things, board_pose
from grabbergui.servo import closed_loop
from grabbergui.ui.controllers.servoing import ServoController
from grabbergui.ui.run.application import application
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.views.servo_window import ServoWindow

SECONDS, SHOWN_AT = 9.4, 4.0
SHOWN_EVERY = 4
"""Turns from one picture in the window to the next."""


class Follower:
    """What the window knows of a runner, around a run in simulated time."""

    cycle_done = Signal(object, object)
    failed = Signal(str)

    def __init__(self, run: closed_loop.ClosedLoop) -> None:
        self.loop, self.robot, self.config, self.gate = run.loop, run.robot, run.config, run.gate
        self.running = True
        self.grabber = SimpleNamespace()


def picture(run: closed_loop.ClosedLoop, number: int) -> Frame:
    """What the camera sees at the moment, in colour."""
    settings = closed_loop.settings("RGB8")
    out = run._sensor.render(settings, number, int(run.now * 1e9), np.empty(settings.image_bytes, np.uint8))
    return Frame(out.reshape(-1).copy(), settings.width, settings.height, settings.pixel_format, number)


def main(theme: str, file: str) -> None:
    """Run it and take the picture."""
    app = application()
    dress(app, Theme(theme))
    run = closed_loop.ClosedLoop(
        things=Things(board=lambda seconds: board_pose() if seconds >= SHOWN_AT else None)
    )
    follower, window = Follower(run), ServoWindow()
    controller = ServoController(window, follower, closed_loop.calibration().scaled_to)
    window.show()
    number = 0
    while run.now < SECONDS:
        cycle, number = run.cycle(), number + 1
        follower.cycle_done.emit(cycle, None if number % SHOWN_EVERY else picture(run, number))
        if number % SHOWN_EVERY == 0:
            QTest.qWait(45)  # as long as the window takes for a picture
    QTest.qWait(500)
    window.grab().save(file)
    controller.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
