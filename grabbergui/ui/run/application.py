"""The Qt application of this process: making and stopping it, Qt's own messages, the language of texts."""

from __future__ import annotations

import logging
import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import resources

from PyQt5.QtCore import (
    QCoreApplication,
    QLibraryInfo,
    QLocale,
    QMessageLogContext,
    QObject,
    Qt,
    QTimer,
    QtMsgType,
    QTranslator,
    qInstallMessageHandler,
)
from PyQt5.QtWidgets import QApplication

from grabbergui.core.errors import SourceUnavailableError, UsageError
from grabbergui.models.language import set_translator
from grabbergui.ui.preferences import Preferences
from grabbergui.ui.theme import Theme, window_icon

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
    """Return the one application of this process; make it if there is none.

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
    app.setWindowIcon(window_icon())
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
    """Return the theme of a window: AUTO is that of the user's preferences, or light in a screenshot."""
    if theme is not Theme.AUTO:
        return theme
    return Theme.LIGHT if screenshot else Preferences.of_user().theme


@contextmanager
def closed_by(stop: threading.Event | None, close: Callable[[], object]) -> Iterator[None]:
    """Call `close` once an event is set, by a signal or another thread.

    A signal's own handler must not do it: an exception out of it would come up in the midst of painting.
    """

    def poll() -> None:
        if stop is not None and stop.is_set():
            timer.stop()
            close()

    timer = QTimer()
    timer.timeout.connect(poll)
    timer.start(STOP_POLL_MS)
    try:
        yield
    finally:
        timer.stop()


def log_qt_messages() -> None:
    """Send Qt's messages to the logger `Qt` from now on. May be called again."""
    qInstallMessageHandler(_log)


def _log(kind: QtMsgType, context: QMessageLogContext, message: str | None) -> None:
    text = message or ""
    level = logging.DEBUG if text.startswith(_HARMLESS) else _LEVELS.get(kind, logging.WARNING)
    qt_log.log(level, "%s", text.strip())
    if kind == QtMsgType.QtFatalMsg:
        # Qt is about to abort with a core dump, which would add nothing to its message.
        os._exit(EXIT_FATAL)


WRITTEN_IN = "en"
"The language of the texts in the sources."
_PREFIX, _SUFFIX = "grabbergui_", ".qm"


def languages() -> list[str]:
    """Return the codes of the languages available."""
    folder = resources.files("grabbergui.resources") / "translations"
    names = [entry.name for entry in folder.iterdir() if entry.name.endswith(_SUFFIX)]
    return sorted({WRITTEN_IN, *(name[len(_PREFIX) : -len(_SUFFIX)] for name in names)})


def speak(app: QCoreApplication, language: str | None = None) -> str:
    """Translate windows made from now on; None is the desktop's language. Return the code of the language.

    Existing windows keep their language. Raises UsageError for an unknown language.
    """
    known = languages()
    if language is not None and language not in known:
        raise UsageError(f"there is no language '{language}'; there are {', '.join(known)}")
    chosen = language or _of_desktop(known)
    for before in app.findChildren(QTranslator):
        app.removeTranslator(before)
        before.deleteLater()
    translators = [] if chosen == WRITTEN_IN else [_of_qt(chosen, app), _ours(chosen, app)]
    for translator in translators:
        app.installTranslator(translator)
    locale = QLocale(chosen)
    QLocale.setDefault(locale)  # for Qt's own fields
    set_translator(QCoreApplication.translate if translators else None, locale.decimalPoint())
    return chosen


def _of_desktop(known: list[str]) -> str:
    """Return the first of the desktop's languages that is available."""
    wanted = [name.replace("_", "-").split("-")[0].lower() for name in QLocale.system().uiLanguages()]
    return next((language for language in wanted if language in known), WRITTEN_IN)


def _of_qt(language: str, parent: QObject) -> QTranslator:
    """Return the translator of Qt's own dialogs."""
    translator = QTranslator(parent)
    translator.load(f"qtbase_{language}", QLibraryInfo.location(QLibraryInfo.TranslationsPath))
    return translator


def _ours(language: str, parent: QObject) -> QTranslator:
    translator = QTranslator(parent)
    file = resources.files("grabbergui.resources") / "translations" / f"{_PREFIX}{language}{_SUFFIX}"
    with resources.as_file(file) as path:
        translator.load(str(path))
    return translator
