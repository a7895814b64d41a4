"""Runs the servoing window's process, operated through a terminal: `python _servo_window.py TERMINAL`.

Each line of the terminal is one action of a user: `click startButton`, `click stopButton`, `press Space`,
`press Escape`; `kill` ends the process by SIGKILL.
"""

import os
import signal
import sys
from typing import Any

from PyQt5.QtCore import QSocketNotifier, Qt
from PyQt5.QtTest import QTest

from grabbergui.servo.ui.servo_process import main
from grabbergui.servo.ui.servo_window import ServoWindow
from grabbergui.ui.application import application


def obey(terminal: str) -> Any:
    """Obey the lines of the terminal; return the object to keep alive meanwhile."""
    app, lines = application(), os.open(terminal, os.O_RDONLY | os.O_NOCTTY)
    hands: Any = QTest  # the type stubs declare its functions as methods

    def act(*_: object) -> None:
        window = next((each for each in app.topLevelWidgets() if isinstance(each, ServoWindow)), None)
        for line in os.read(lines, 1024).decode().splitlines():
            verb, _space, name = line.partition(" ")
            if verb == "kill":
                os.kill(os.getpid(), signal.SIGKILL)
            elif window is not None and verb == "click":
                hands.mouseClick(getattr(window, name), Qt.MouseButton.LeftButton)
            elif window is not None and verb == "press":
                hands.keyClick(app.focusWidget() or window, getattr(Qt.Key, f"Key_{name}"))

    notifier = QSocketNotifier(lines, QSocketNotifier.Type.Read)  # type: ignore[arg-type]
    notifier.activated.connect(act)
    return notifier


if __name__ == "__main__":
    notifier = obey(sys.argv[1])  # it must live as long as the window
    main()
