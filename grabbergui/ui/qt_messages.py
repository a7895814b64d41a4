"""Qt's own messages go to the log, not to stderr."""

from __future__ import annotations

import logging
import os

from PyQt5.QtCore import QMessageLogContext, QtMsgType, qInstallMessageHandler

log = logging.getLogger("Qt")

_LEVELS = {
    QtMsgType.QtDebugMsg: logging.DEBUG,
    QtMsgType.QtInfoMsg: logging.INFO,
    QtMsgType.QtWarningMsg: logging.WARNING,
    QtMsgType.QtCriticalMsg: logging.ERROR,
    QtMsgType.QtFatalMsg: logging.CRITICAL,
}

EXIT_FATAL = 1

_HARMLESS = ("This plugin does not support ", "QStandardPaths: XDG_RUNTIME_DIR not set")
"""Beginnings of what is no warning: platforms without a display or a desktop lack these things."""


def to_log() -> None:
    """Send what Qt says from here on to the logger `Qt`. May be called again."""
    qInstallMessageHandler(_log)


def _log(kind: QtMsgType, context: QMessageLogContext, message: str | None) -> None:
    text = message or ""
    level = logging.DEBUG if text.startswith(_HARMLESS) else _LEVELS.get(kind, logging.WARNING)
    log.log(level, "%s", text.strip())
    if kind == QtMsgType.QtFatalMsg:
        # Qt is about to abort, with a core dump; all there is to know has been said.
        os._exit(EXIT_FATAL)
