"""The wheel over an editor: it scrolls past, and steps only what has the focus."""

import pytest
from PyQt5.QtCore import QPoint, QPointF, Qt
from PyQt5.QtGui import QWheelEvent
from PyQt5.QtWidgets import QApplication, QLabel
from sample_features import EXPOSURE, MODE, WIDE, WIDTH


def wheel(widget):
    event = QWheelEvent(
        QPointF(10, 10),
        QPointF(10, 10),
        QPoint(),
        QPoint(0, 120),
        Qt.NoButton,
        Qt.NoModifier,
        Qt.NoScrollPhase,
        False,
    )
    QApplication.sendEvent(widget, event)
    return event.isAccepted()


@pytest.mark.parametrize("shown", [EXPOSURE, WIDE, MODE])
def test_the_wheel_changes_nothing_without_focus(take, qtbot, shown):
    hand = take(shown)
    elsewhere = QLabel(hand.editor)
    elsewhere.setFocusPolicy(Qt.StrongFocus)
    elsewhere.setFocus()
    controls = [hand.editor.focusProxy()]
    if hand.editor.slider() is not None:
        controls.append(hand.editor.slider())
    for control in controls:
        assert not control.hasFocus()
        assert not wheel(control)
    assert hand.values == []


def test_the_wheel_steps_a_field_with_focus(take, qtbot):
    hand = take(WIDTH)
    hand.editor.activateWindow()
    hand.editor.field.setFocus()
    qtbot.waitUntil(hand.editor.field.hasFocus)
    assert wheel(hand.editor.field)
    assert hand.values == [656]
