"""Shows windows as the command line does, each in a process of its own, and reports how they end.

The processes are forked from this one, which has loaded what they all need. Cases come as JSON on stdin.
"""

import json
import os
import signal
import sys
from pathlib import Path

from PyQt5.QtCore import QTimer
from PyQt5.QtWidgets import QApplication, QLabel

from grabbergui.cli import main
from grabbergui.ui import application
from grabbergui.ui.garbage import GuiThreadCollector
from grabbergui.ui.widgets.image_canvas import ImageCanvas
from patience import PATIENCE

SHOWN = b"SHOWN\n"
LOOK_MS = 50


class Watching(GuiThreadCollector):
    """Says on stderr when an image is on the screen, or the text that the environment names."""

    def __init__(self, app):
        super().__init__(app)
        self._timer = QTimer(app)
        self._timer.timeout.connect(self._look)
        self._timer.start(LOOK_MS)

    def _look(self):
        seen = [widget for widget in QApplication.allWidgets() if widget.isVisible()]
        wanted = os.environ["WANTED"]
        if wanted:
            found = any(wanted in widget.text() for widget in seen if isinstance(widget, QLabel))
        else:
            found = any(not widget.empty for widget in seen if isinstance(widget, ImageCanvas))
        if found:
            self._timer.stop()
            os.write(2, SHOWN)
            if os.environ["CLOSED"]:
                seen[0].window().close()


application.GuiThreadCollector = Watching  # as the application makes it


def show(arguments, wanted, closed):
    """Become the program of a window, which reports on stderr."""
    from grabbergui.models.sources import SourceListModel

    SourceListModel.start = lambda self: None  # to import each kind of source takes longer than all else
    os.environ.update(WANTED=wanted, CLOSED="yes" if closed else "")
    signal.alarm(round(PATIENCE))
    sys.exit(main(arguments))


def outcome(arguments, wanted, closed):
    """Show a window and end it by SIGTERM, or let it close itself; return exit status and stderr."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.dup2(writing, 2)
        sys.stderr = os.fdopen(2, "w", closefd=False)  # it was a file perhaps, whose position it asks
        os.close(reading)
        os.close(writing)
        show(arguments, wanted, closed)
    os.close(writing)
    said, ended = b"", closed
    while more := os.read(reading, 4096):
        said += more
        if not ended and SHOWN in said:
            ended = True
            os.kill(child, signal.SIGTERM)
    os.close(reading)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), said.decode()


def serve():
    """Show the windows that stdin asks for, and print their outcomes."""
    os.environ["QT_QPA_PLATFORM"] = "offscreen"
    cases = json.load(sys.stdin)
    with Path(os.devnull).open() as nothing:
        os.dup2(nothing.fileno(), 0)
    for case in cases:
        print(json.dumps(outcome(*case)), flush=True)


if __name__ == "__main__":
    import grabbergui.driver.device_grabber
    import grabbergui.driver.sim.device
    import grabbergui.ui.run.standalone
    import grabbergui.ui.run.window  # noqa: F401

    serve()
