"""The servoing window, alone."""

import pytest

from grabbergui.servo.ui.servo_window import ServoWindow


@pytest.fixture
def window(qtbot):
    made = ServoWindow()
    qtbot.addWidget(made)
    made.show()
    qtbot.waitExposed(made)
    return made
