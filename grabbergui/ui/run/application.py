"""The Qt application of this process: how it is made, stopped, and where Qt's own messages go."""

from __future__ import annotations

import logging
import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from PyQt5.QtCore import QCoreApplication, QMessageLogContext, Qt, QTimer, QtMsgType, qInstallMessageHandler
from PyQt5.QtWidgets import QApplication

from grabbergui.core.errors import SourceUnavailableError
from grabbergui.ui import icons
from grabbergui.ui.preferences import Preferences
from grabbergui.ui.theme import Theme

qt_log = logging.getLogger("Qt")

STOP_POLL_MS = 200
"Also how often Python gets to run its signal handlers, which it does between its own instructions only."

_LEVELS = {
    QtMsgType.QtDebugMsg: logging.DEBUG,
    QtMsgType.QtInfoMsg: logging.INFO,
    QtMsgType.QtWarningMsg: logging.WARNING,
    QtMsgType.QtCriticalMsg: logging.ERROR,
    QtMsgType.QtFatalMsg: logging.CRITICAL,
}

EXIT_FATAL = 1

_HARMLESS = ("This plugin does not support ", "QStandardPaths: XDG_RUNTIME_DIR not set")
"""Beginnings of messages that are no warnings: platforms without a display or a desktop lack these."""


def application() -> QApplication:
    """The one application of this process, made as ours where there is none.

    Raises SourceUnavailableError where there is no display, for which Qt would abort.
    """
    running = QApplication.instance()
    if isinstance(running, QApplication):
        return running
    require_display()
    log_qt_messages()
    QCoreApplication.setAttribute(Qt.ApplicationAttribute.AA_EnableHighDpiScaling)
    QCoreApplication.setAttribute(Qt.ApplicationAttribute.AA_UseHighDpiPixmaps)
    app = QApplication(["grabbergui"])
    app.setApplicationName("grabbergui")
    app.setApplicationDisplayName("grabbergui")
    app.setDesktopFileName("grabbergui")
    app.setWindowIcon(icons.window_icon())
    return app


def require_display() -> None:
    """Raise SourceUnavailableError where there is no display."""
    places = ("QT_QPA_PLATFORM", "DISPLAY", "WAYLAND_DISPLAY")
    if sys.platform.startswith("linux") and not any(os.environ.get(name) for name in places):
        raise SourceUnavailableError(
            "there is no display for a window; `grabbergui gui --offscreen` does without one, "
            "and so do the other commands (`grabbergui --help`)"
        )


def look(theme: Theme, screenshot: bool = False) -> Theme:
    """The look of a window: AUTO is that of the user's preferences, or light in a screenshot."""
    if theme is not Theme.AUTO:
        return theme
    return Theme.LIGHT if screenshot else Preferences.of_user().theme


@contextmanager
def closed_by(stop: threading.Event | None, close: Callable[[], object]) -> Iterator[None]:
    """Call `close` once an event is set, by a signal or another thread.

    A signal's own handler must not do it: an exception out of it would come up in the midst of painting.
    """

    def look_at_it() -> None:
        if stop is not None and stop.is_set():
            timer.stop()
            close()

    timer = QTimer()
    timer.timeout.connect(look_at_it)
    timer.start(STOP_POLL_MS)
    try:
        yield
    finally:
        timer.stop()


def log_qt_messages() -> None:
    """Send what Qt says from here on to the logger `Qt`. May be called again."""
    qInstallMessageHandler(_log)


def _log(kind: QtMsgType, context: QMessageLogContext, message: str | None) -> None:
    text = message or ""
    level = logging.DEBUG if text.startswith(_HARMLESS) else _LEVELS.get(kind, logging.WARNING)
    qt_log.log(level, "%s", text.strip())
    if kind == QtMsgType.QtFatalMsg:
        # Qt is about to abort, with a core dump; all there is to know has been said.
        os._exit(EXIT_FATAL)
