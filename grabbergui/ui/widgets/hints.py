"""Hints that appear for a moment."""

from __future__ import annotations

from PyQt5.QtCore import QPoint, Qt, QTimer
from PyQt5.QtWidgets import (
    QLabel,
    QWidget,
)

from grabbergui.ui.shown_text import PlainLabel

HINT_MS = 5000
"Milliseconds for which a hint is shown."
_HINT = "hint"


def show_hint(control: QWidget, text: str) -> None:
    """Show below a control, for a few seconds, what became of the text typed into it; replaces another hint.

    Not a tooltip: Qt hides those when the focus moves, which is what ends most typing.
    """
    window = control.window() or control
    for old in window.findChildren(QLabel, _HINT):
        old.hide()
        old.deleteLater()
    hint = PlainLabel(text, window)
    hint.setObjectName(_HINT)
    hint.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
    hint.ensurePolished()
    hint.adjustSize()
    place = control.mapTo(window, QPoint(0, control.height()))
    if place.y() + hint.height() > window.height():
        place.setY(place.y() - control.height() - hint.height())
    hint.move(max(0, min(place.x(), window.width() - hint.width())), max(0, place.y()))
    hint.show()
    hint.raise_()
    timer = QTimer(hint)
    timer.setSingleShot(True)
    timer.timeout.connect(hint.deleteLater)
    timer.start(HINT_MS)
