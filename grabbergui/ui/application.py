"""The Qt application: making and stopping it."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path, PurePath

from PyQt5.QtCore import (
    QCoreApplication,
    QLibraryInfo,
    Qt,
    QTimer,
)
from PyQt5.QtWidgets import QApplication, QDialog

from grabbergui.core.errors import SourceUnavailableError
from grabbergui.ui.garbage import GuiThreadCollector
from grabbergui.ui.preferences import Preferences
from grabbergui.ui.qt_log import log_qt_messages
from grabbergui.ui.theme import Theme, window_icon

_made: QApplication | None = None
"Keeps the application, which ends with its last reference in Python: the next window would abort us."
STOP_POLL_MS = 200
"Also the period at which Python runs its signal handlers: it does so only between its own instructions."


def application() -> QApplication:
    """Return the one application of this process; make it if there is none.

    Raises SourceUnavailableError where there is no display, for which Qt would abort.
    """
    running = QApplication.instance()
    if isinstance(running, QApplication):
        return running
    forget_qt_of_opencv()
    require_display()
    require_platform()
    log_qt_messages()
    QCoreApplication.setAttribute(Qt.ApplicationAttribute.AA_EnableHighDpiScaling)
    QCoreApplication.setAttribute(Qt.ApplicationAttribute.AA_UseHighDpiPixmaps)
    global _made
    _made = app = QApplication(["grabbergui"])
    app.setApplicationName("grabbergui")
    app.setApplicationDisplayName("grabbergui")
    app.setDesktopFileName("grabbergui")
    app.setWindowIcon(window_icon())
    GuiThreadCollector(app)
    return app


def forget_qt_of_opencv() -> None:
    """Undo what OpenCV's packages with windows do when they are loaded: PyQt5 cannot use their plugins."""
    for variable in ("QT_QPA_PLATFORM_PLUGIN_PATH", "QT_QPA_FONTDIR"):
        if PurePath(os.environ.get(variable, "")).parts[-3:-1] == ("cv2", "qt"):
            del os.environ[variable]


def require_display() -> None:
    """Raise SourceUnavailableError where there is no display."""
    places = ("QT_QPA_PLATFORM", "DISPLAY", "WAYLAND_DISPLAY")
    if sys.platform.startswith("linux") and not any(os.environ.get(name) for name in places):
        raise SourceUnavailableError(
            "there is no display for a window; leave out --window, or add --headless, or --offscreen to `gui`"
        )


_NEEDED = {"xcb": "DISPLAY", "wayland": "WAYLAND_DISPLAY", "wayland-egl": "WAYLAND_DISPLAY"}
"The variable that a platform needs."


def require_platform() -> None:
    """Raise SourceUnavailableError if Qt would abort, as QT_QPA_PLATFORM names none that it can use."""
    wanted = os.environ.get("QT_QPA_PLATFORM", "")
    if not wanted or os.environ.get("QT_QPA_PLATFORM_PLUGIN_PATH"):
        return
    folder = Path(QLibraryInfo.location(QLibraryInfo.LibraryLocation.PluginsPath)) / "platforms"
    known = sorted(file.stem.removeprefix("libq") for file in folder.glob("libq*.so"))
    names = [name.partition(":")[0] for name in wanted.split(";")]
    present = [name for name in names if name in known]
    if known and not present:
        raise SourceUnavailableError(
            f"QT_QPA_PLATFORM={wanted}: Qt has no such platform; unset the variable, or set it to one of "
            f"{', '.join(known)}"
        )
    needed = [_NEEDED.get(name, "") for name in present]
    if needed and all(variable and not os.environ.get(variable) for variable in needed):
        raise SourceUnavailableError(
            f"QT_QPA_PLATFORM={wanted} needs a display, and {needed[0]} is not set; unset the first one, "
            "or set it to offscreen"
        )


def look(theme: Theme, screenshot: bool = False) -> Theme:
    """Return the theme of a window: AUTO is that of the user's preferences, or light in a screenshot."""
    if theme is not Theme.AUTO:
        return theme
    return Theme.LIGHT if screenshot else Preferences.of_user().theme


@contextmanager
def closed_by(stop: threading.Event | None, close: Callable[[], object]) -> Iterator[None]:
    """Close the dialogs over all windows, then call `close`, once an event is set by a signal or a thread.

    A dialog that asks for a file, for instance, would keep the window below it open. A signal handler must
    not call it: an exception in it would surface in the middle of painting.
    """

    def poll() -> None:
        if stop is not None and stop.is_set():
            timer.stop()
            for window in QApplication.topLevelWidgets():
                if isinstance(window, QDialog) and window.isVisible() and window.parentWidget() is not None:
                    window.reject()
            close()

    timer = QTimer()
    timer.timeout.connect(poll)
    timer.start(STOP_POLL_MS)
    try:
        yield
    finally:
        timer.stop()
