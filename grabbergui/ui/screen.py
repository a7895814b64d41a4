"""The room on the screen."""

from __future__ import annotations

from PyQt5.QtCore import QSize
from PyQt5.QtGui import QGuiApplication
from PyQt5.QtWidgets import (
    QWIDGETSIZE_MAX,
    QWidget,
)

TITLE_BAR = 40
"Pixels that a window manager may take of the screen's height for a window's title."


def fit_screen(window: QWidget) -> None:
    """Make a window no larger than the screen, where its last buttons would be out of reach."""
    if has_screen():
        window.resize(window.size().boundedTo(screen_room(window)))


def screen_room(window: QWidget) -> QSize:
    """Return the largest size of a window on its screen, without the title."""
    screen = window.screen()
    if screen is None:
        return QSize(QWIDGETSIZE_MAX, QWIDGETSIZE_MAX)
    return screen.availableGeometry().size() - QSize(0, TITLE_BAR)


def has_screen() -> bool:
    """Return whether windows are seen; Qt's offscreen platform only claims a screen of 800 × 800 pixels."""
    return QGuiApplication.platformName() != "offscreen"
