"""The Qt application: making and stopping it, Qt's messages, the language, and the user's preferences."""

from __future__ import annotations

import logging
import os
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import resources
from pathlib import Path
from urllib.parse import quote

from PyQt5.QtCore import (
    QByteArray,
    QCoreApplication,
    QLibraryInfo,
    QLocale,
    QMessageLogContext,
    QObject,
    QSettings,
    QStandardPaths,
    Qt,
    QTimer,
    QtMsgType,
    QTranslator,
    qInstallMessageHandler,
)
from PyQt5.QtWidgets import QApplication, QDialog

from grabbergui.core.errors import SourceUnavailableError, UsageError
from grabbergui.core.identity import DeviceInfo
from grabbergui.models.language import set_translator
from grabbergui.ui.gui_thread import GuiThreadCollector
from grabbergui.ui.theme import Theme, window_icon

qt_log = logging.getLogger("Qt")


# -- making and stopping it ----------------------------------------------------------------------
_made: QApplication | None = None
"Keeps the application, which ends with its last reference in Python: the next window would abort us."


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
    global _made
    _made = app = QApplication(["grabbergui"])
    app.setApplicationName("grabbergui")
    app.setApplicationDisplayName("grabbergui")
    app.setDesktopFileName("grabbergui")
    app.setWindowIcon(window_icon())
    GuiThreadCollector(app)
    return app


def require_display() -> None:
    """Raise SourceUnavailableError where there is no display."""
    places = ("QT_QPA_PLATFORM", "DISPLAY", "WAYLAND_DISPLAY")
    if sys.platform.startswith("linux") and not any(os.environ.get(name) for name in places):
        raise SourceUnavailableError(
            "there is no display for a window; leave out --window, add --headless to `servo`, or --offscreen "
            "to `gui`"
        )


def look(theme: Theme, screenshot: bool = False) -> Theme:
    """Return the theme of a window: AUTO is that of the user's preferences, or light in a screenshot."""
    if theme is not Theme.AUTO:
        return theme
    return Theme.LIGHT if screenshot else Preferences.of_user().theme


STOP_POLL_MS = 200
"Also the period at which Python runs its signal handlers: it does so only between its own instructions."


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


# -- Qt's messages -------------------------------------------------------------------------------
_LEVELS = {
    QtMsgType.QtDebugMsg: logging.DEBUG,
    QtMsgType.QtInfoMsg: logging.INFO,
    QtMsgType.QtWarningMsg: logging.WARNING,
    QtMsgType.QtCriticalMsg: logging.ERROR,
    QtMsgType.QtFatalMsg: logging.CRITICAL,
}

_HARMLESS = ("This plugin does not support ", "QStandardPaths: XDG_RUNTIME_DIR not set")
"""Beginnings of messages that are logged as debug: platforms without a display or a desktop emit them."""

EXIT_FATAL = 1
"Exit status after a message for which Qt would abort."


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


# -- the language --------------------------------------------------------------------------------
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


# -- the user's preferences ----------------------------------------------------------------------
MOST_RECENT = 10
"Most sources remembered that were opened."
LAYOUT_VERSION = 2
"Incremented when docks change so much that older layouts no longer fit."


def camera_model(info: DeviceInfo) -> str:
    """Return the model of a camera, under which its preferences are kept; its URI if it has no model."""
    return " ".join(part for part in (info.vendor, info.model) if part) or info.uri


class Preferences:
    """A few named settings in QSettings; with None nothing is kept, as in tests and offscreen."""

    def __init__(self, store: QSettings | None) -> None:
        self._store = store
        self._passing: dict[str, object] = {}
        self._look: Theme | None = None

    @classmethod
    def of_user(cls) -> Preferences:
        """Return the preferences of the user who runs the program."""
        return cls(QSettings("grabbergui", "grabbergui"))

    def look_for_now(self, theme: Theme) -> None:
        """Use this theme for this run only, until another is chosen."""
        self._look = theme

    @property
    def geometry(self) -> QByteArray | None:
        """Where the window was."""
        value = self._get("window/geometry")
        return value if isinstance(value, QByteArray) else None

    @property
    def layout(self) -> QByteArray | None:
        """Where its docks were."""
        value = self._get("window/layout")
        return value if isinstance(value, QByteArray) else None

    def keep_window(self, geometry: QByteArray, layout: QByteArray) -> None:
        """Remember both."""
        self._set("window/geometry", geometry)
        self._set("window/layout", layout)

    def favourites_of(self, model: str) -> list[str] | None:
        """Names of the features that were pinned for a model of camera; None if none were chosen."""
        value = self._get(_of_model(model, "favourites"))
        return [name for name in value.split(",") if name] if isinstance(value, str) else None

    def keep_favourites(self, model: str, names: Sequence[str] | None) -> None:
        """Remember the pinned features; None returns to the usual ones."""
        # As one text: QSettings returns an empty list as None.
        self._set(_of_model(model, "favourites"), ",".join(names) if names is not None else None)

    def layout_of(self, model: str) -> QByteArray | None:
        """Where the docks were when a camera of this model was closed."""
        value = self._get(_of_model(model, "layout"))
        return value if isinstance(value, QByteArray) else None

    def keep_layout_of(self, model: str, layout: QByteArray) -> None:
        """Remember it."""
        self._set(_of_model(model, "layout"), layout)

    @property
    def recent(self) -> list[str]:
        """URIs of sources that were opened, the last one first."""
        return self._list("sources/recent")

    def note_source(self, uri: str) -> None:
        """Remember that a source was opened."""
        others = [known for known in self.recent if known != uri]
        self._set("sources/recent", [uri, *others][:MOST_RECENT])

    @property
    def typed(self) -> list[str]:
        """URIs of sources that the user added."""
        return self._list("sources/typed")

    @typed.setter
    def typed(self, uris: list[str]) -> None:
        self._set("sources/typed", uris)

    @property
    def snapshot_folder(self) -> Path:
        """Where snapshots go."""
        value = self._get("snapshots/folder")
        if isinstance(value, str) and value:
            return Path(value)
        pictures = QStandardPaths.writableLocation(QStandardPaths.PicturesLocation)
        return Path(pictures or Path.home()) / "grabbergui"

    @snapshot_folder.setter
    def snapshot_folder(self, folder: Path) -> None:
        self._set("snapshots/folder", str(folder))

    @property
    def theme(self) -> Theme:
        """The theme chosen."""
        if self._look is not None:
            return self._look
        try:
            return Theme(self._get("window/theme"))
        except ValueError:
            return Theme.AUTO

    @theme.setter
    def theme(self, theme: Theme) -> None:
        self._look = None
        self._set("window/theme", theme.value)

    def _list(self, key: str) -> list[str]:
        """Return several texts; QSettings returns a list of one as a single text."""
        value = self._get(key)
        if isinstance(value, str):
            return [value]
        return [str(text) for text in value] if isinstance(value, list) else []

    def _get(self, key: str) -> object:
        return self._store.value(key) if self._store is not None else self._passing.get(key)

    def _set(self, key: str, value: object) -> None:
        if self._store is None:
            self._passing[key] = value
        elif value is None:
            self._store.remove(key)
        else:
            self._store.setValue(key, value)


def _of_model(model: str, what: str) -> str:
    """Return the key of a model, whose name may contain a slash, QSettings' separator."""
    return f"cameras/{quote(model, safe=' ')}/{what}"
