"""Qt's own messages in the program's log."""

from __future__ import annotations

import logging
import os

from PyQt5.QtCore import (
    QMessageLogContext,
    QtMsgType,
    qInstallMessageHandler,
)

log = logging.getLogger("Qt")

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
    log.log(level, "%s", text.strip())
    if kind == QtMsgType.QtFatalMsg:
        # Qt is about to abort with a core dump, which would add nothing to its message.
        os._exit(EXIT_FATAL)
