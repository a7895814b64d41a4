"""Runs the window: with a display, or without one for a while and with a screenshot of itself."""

from __future__ import annotations

import logging
import os
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType

from PyQt5.QtCore import QCoreApplication, QTimer

from grabbergui import sources
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.uri import SourceUri
from grabbergui.core.visible_text import print_line
from grabbergui.models.messages import MessageModel
from grabbergui.models.sharing import Served
from grabbergui.ui.application import application, closed_by
from grabbergui.ui.interface_language import speak
from grabbergui.ui.preferences import Preferences
from grabbergui.ui.run.program import Program
from grabbergui.ui.run.scripting import load_script, run_script
from grabbergui.ui.run.source_controls import FIRST_URI
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.views.main_window import MainWindow

log = logging.getLogger(__name__)

SCREENSHOT_FRAMES = 20
"Images to be painted before the screenshot is taken; by then the controls are filled."
SCREENSHOT_PATIENCE = 30.0
"Seconds to wait for the first frame where no duration is given."
FINISH_TIME = 30.0
"Seconds that the program waits, its window closed, for files to be finished and cameras to be released."


def run(
    uri: str | None,
    *,
    settings: Path | None = None,
    offscreen: bool = False,
    duration: float | None = None,
    screenshot: Path | None = None,
    script: Path | None = None,
    theme: str = "auto",
    language: str | None = None,
    create: Callable[[SourceUri], FrameGrabber] = sources.create,
    served: Sequence[Served] = (),
    stop: threading.Event | None = None,
) -> int:
    """Open the window on a source and return the exit code once it is closed.

    With `duration` it closes by itself after so many seconds. With `screenshot` it saves a screenshot
    when frames have flown, prints where and the frame rate, and fails with 1 and a line on stderr
    when no frame came. With `script` it runs that file, whose exit code is the window's, and opens
    nothing by itself but `uri`; see `ui.run.scripting`. With `settings` the first camera that opens is
    compared with that file, and the report offers to load it. `theme` is `light`, `dark`, or `auto` (what
    was chosen before, or the desktop's), `language` a code like `es`; without one it is the desktop's.
    Settings are neither read nor kept offscreen. `create` makes the grabber of a URI, for a program that
    holds one open already, and `served` are the servers that share it. Setting `stop` closes the window.
    Raises SourceUnavailableError where there is no display.
    """
    if offscreen:
        os.environ["QT_QPA_PLATFORM"] = "offscreen"
    code_of_script = load_script(script) if script is not None else None
    app = application()
    preferences = Preferences(None) if offscreen else Preferences.of_user()
    if theme != Theme.AUTO.value:
        preferences.look_for_now(Theme(theme))
    dress(app, preferences.theme)
    speak(app, language)
    window = MainWindow()
    controller = Program(window, preferences, create)
    for server in served:
        controller.source_controls.sharing.adopt(server)
    with _guarded(controller.messages), closed_by(stop, app.quit):
        window.show()
        wanted = screenshot is not None or (offscreen and script is None)
        report = _Report(controller, screenshot, wanted=wanted)
        if settings is not None:
            controller.compare_once_open(settings)
        if code_of_script is None:
            controller.begin(*first_sources(uri, preferences))
        else:
            controller.begin(uri)
            QTimer.singleShot(0, lambda: report.follow(run_script(code_of_script, controller)))
        if duration is not None:
            QTimer.singleShot(round(duration * 1000), app.quit)
        elif screenshot is not None:
            report.on_taken = app.quit
            QTimer.singleShot(round(SCREENSHOT_PATIENCE * 1000), app.quit)
        app.exec_()
        code = report.finish(interrupted=stop is not None and stop.is_set())
        window.close()
    # The window is gone, so the wait does no harm; a movie that is cut off here could not be opened.
    if late := controller.shut_down(FINISH_TIME):
        log.warning("given up after %g s: %s", FINISH_TIME, ", ".join(late))
    window.deleteLater()
    app.processEvents()
    return code


def first_sources(uri: str | None, preferences: Preferences) -> list[str]:
    """Return the sources to open: the requested one, those left open, the last, or the simulated camera."""
    if uri:
        return [uri]
    return preferences.left_open or preferences.recent[:1] or [FIRST_URI]


class _Report:
    """Takes a screenshot once frames flow, and prints the outcome at the end."""

    def __init__(self, controller: Program, path: Path | None, *, wanted: bool) -> None:
        """`wanted`: the window has no viewer, so a run without a single image has failed."""
        self._controller = controller
        self._path = path
        self._wanted = wanted
        self._painted = 0
        self._rate = 0.0
        self._taken = False
        self._code = 0
        self.on_taken: Callable[[], object] = lambda: None
        controller.window.image.painted.connect(self._on_painted)

    def _on_painted(self) -> None:
        self._painted += 1
        if self._painted >= SCREENSHOT_FRAMES:
            self._controller.window.image.painted.disconnect(self._on_painted)
            # Not from within painting.
            QTimer.singleShot(1000, self._take)

    def _take(self) -> None:
        if not self._taken and self._path is not None:
            self._taken = self._save(self._path)
            self.on_taken()

    def _save(self, path: Path) -> bool:
        source = self._controller.open_sources.current
        if source is not None and source.grabber is not None:
            self._rate = source.grabber.statistics().frame_rate
        return bool(self._controller.window.grab().save(str(path)))

    def follow(self, code: int) -> None:
        """A script has ended: end with its code."""
        self._code = code
        QCoreApplication.quit()

    def finish(self, *, interrupted: bool) -> int:
        """Print the outcome and return the exit code. A run ended by a signal may have shown no image."""
        if self._code or (interrupted and self._path is None):
            return self._code
        if self._painted == 0 and self._wanted:
            messages = self._controller.messages.shown(self._controller.open_sources.current)
            reason = messages[0].text if messages else "no frame came from the source in time"
            print_line(f"grabbergui: {reason}", error=True)
            return 1
        if self._path is None:
            return 0
        if not self._taken and not self._save(self._path):
            print_line(f"grabbergui: the screenshot could not be written to {self._path}", error=True)
            return 1
        print_line(f"{self._path.resolve()}  {self._rate:.1f} frames/s")
        return 0


@contextmanager
def _guarded(messages: MessageModel) -> Iterator[None]:
    """Log uncaught exceptions of any thread and show them in the window, instead of ending."""

    def show(error: BaseException | None, trace: TracebackType | None) -> None:
        log.error("uncaught exception", exc_info=(type(error), error, trace) if error else None)
        text = f"internal error: {type(error).__name__}: {error}; the log has the details"
        messages.error(text)

    before, before_threads = sys.excepthook, threading.excepthook
    sys.excepthook = lambda kind, error, trace: show(error, trace)
    threading.excepthook = lambda thrown: show(thrown.exc_value, thrown.exc_traceback)
    try:
        yield
    finally:
        sys.excepthook, threading.excepthook = before, before_threads
