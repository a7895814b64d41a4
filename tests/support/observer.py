"""Runs in the window by `grabbergui gui --script`, and answers questions about it over stdin and stdout.

A question is a line with a Python expression, an answer a line of JSON. Nothing here acts on the window: the
test does that with the mouse and the keyboard. Questions are answered while a dialog is open, too.
"""

import json
import os
import sys

from PyQt5.QtCore import QPoint, QSocketNotifier
from PyQt5.QtWidgets import QAbstractButton, QAbstractSpinBox, QApplication, QLineEdit, QPushButton

window, program = app.window, app.program  # noqa: F821  what a script finds


def spot(widget, x, y):
    """A part of a widget in the desktop's coordinates."""
    return widget.mapToGlobal(QPoint(round(x * (widget.width() - 1)), round(y * (widget.height() - 1))))


def place(widget, x=0.5, y=0.5):
    """Where a part of a widget is on the screen, in its pixels; None where it cannot be clicked."""
    if widget is None or not widget.isVisible():
        return None
    point = spot(widget, x, y)
    under = QApplication.widgetAt(point)
    if under is not widget and not widget.isAncestorOf(under):
        return None
    ratio = widget.devicePixelRatioF()
    return round(point.x() * ratio), round(point.y() * ratio)


def hindrance(widget, x=0.5, y=0.5):
    """What may explain that a part of a widget cannot be clicked."""
    if widget is None or not widget.isVisible():
        return "it does not exist, or is hidden"
    under = QApplication.widgetAt(spot(widget, x, y))
    seen = widget.visibleRegion().boundingRect().getRect()
    return f"{under} is there; of {widget.rect().getRect()} only {seen} is seen"


def row(name):
    """The control of a feature above the image."""
    return window.favourites.rows.rows(name)[0]


def button(text):
    """A visible button of the window by its text, without its mnemonic."""
    visible = (each for each in window.findChildren(QPushButton) if each.isVisible())
    return next((each for each in visible if each.text().replace("&", "") == text), None)


def dialog():
    """The title of the dialog that has the focus, empty if nothing has it; None if the window itself has."""
    active = QApplication.activeModalWidget() or QApplication.activeWindow()
    if active is window:
        return None
    return "" if active is None else active.windowTitle()


def typed():
    """The text of the field that has the focus; empty if none has it."""
    field = QApplication.focusWidget()
    return field.text() if isinstance(field, QLineEdit | QAbstractSpinBox) else ""


def text_of(label):
    return label.text() if label.isVisible() else ""


def tile(each):
    return {
        "name": each.titleLabel.toolTip(),
        "state": text_of(each.stateLabel),
        "recording": each.recordingLabel.isVisible(),
        "current": bool(each.property("current")),
    }


def said():
    """Return the state, figures and messages that the window shows for each camera."""
    strip, bar = window.status, window.recordingBar
    return {
        "title": window.windowTitle(),
        "state": text_of(strip.stateLabel).removeprefix("● "),
        "tone": strip.stateLabel.property("tone"),
        "messages": strip.messages.messages,
        "heard": heard,
        "losses": text_of(strip.lossLabel),
        "loss tone": strip.lossLabel.property("tone"),
        "tiles": [tile(each) for each in window.gallery.tiles],
        "age": text_of(window.image.ageLabel),
        "note": text_of(window.image.note.summaryLabel),
        "record": bar.recordButton.isEnabled(),
        "recording": bar.recordButton.isChecked(),
        "progress": text_of(bar.progressLabel),
        "locked": any(not each.isEnabled() for each in window.favourites.rows.rows("ExposureTime")),
    }


def number(name):
    """Return the text of a control above the image, with its unit."""
    rows = window.favourites.rows.rows(name)
    return rows[0].editor.field.text() if rows and rows[0].editor is not None else None


def frames():
    """Frames that the current camera has delivered."""
    source = program.open_sources.current
    return source.grabber.statistics().frames if source is not None and source.grabber is not None else 0


def cut_off():
    """Buttons of the window that have less room than their text needs, or reach outside it on the left."""
    return [
        each.text()
        for each in window.findChildren(QAbstractButton)
        if each.text()
        and not each.visibleRegion().isEmpty()
        and (each.width() < each.minimumSizeHint().width() or each.mapTo(window, QPoint()).x() < 0)
    ]


def shot(path):
    """Save what is on the screen."""
    return QApplication.primaryScreen().grabWindow(0).save(path)


def answer():
    data = os.read(0, 65536)
    if not data:  # the test has ended
        window.close()
        return
    buffer.extend(data)
    while b"\n" in buffer:
        line, _, rest = bytes(buffer).partition(b"\n")
        buffer[:] = rest
        try:
            reply = {"answer": eval(line.decode(), globals())}
        except Exception as error:
            reply = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(reply), flush=True)


heard: list[str] = []
"Texts of messages about the current camera, in the order in which they appeared; some go by themselves."


def hear():
    shown = [each.text for each in program.messages.shown(program.open_sources.current)]
    heard.extend(text for text in reversed(shown) if text not in present)
    present[:] = shown


present: list[str] = []
program.messages.changed.connect(hear)
buffer = bytearray()
listener = QSocketNotifier(sys.stdin.fileno(), QSocketNotifier.Read)
listener.activated.connect(answer)
print(json.dumps({"answer": "ready"}), flush=True)
while True:
    app.wait(0.5)  # noqa: F821  ends with the window
