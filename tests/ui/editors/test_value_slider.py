"""The slider beside a number: dragged, clicked beside, and in step with the field."""

from dataclasses import replace

import pytest
from PyQt5.QtCore import QPoint, QPointF, Qt
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import QApplication
from sample_features import EXPOSURE, K, feature


def drag(slider, x):
    """Move the mouse with its left button down; qtbot's has none down."""
    event = QMouseEvent(QMouseEvent.MouseMove, QPointF(x, 12), Qt.NoButton, Qt.LeftButton, Qt.NoModifier)
    QApplication.sendEvent(slider, event)


def test_a_slider_is_dragged(take, qtbot):
    hand = take(EXPOSURE)
    slider = hand.editor.slider()
    qtbot.mousePress(slider, Qt.LeftButton, pos=QPoint(100, 12))
    assert hand.holds == ["start"]
    for x in (120, 140, 160):
        drag(slider, x)
    assert len(hand.values) >= 3
    assert hand.values[-1] == max(hand.values)
    # While it is in the hand nothing from outside moves it, nor the field beside it.
    position, text = slider.value(), hand.editor.field.text()
    hand.editor.setFeature(replace(EXPOSURE, value=20.0))
    assert (slider.value(), hand.editor.field.text()) == (position, text)
    qtbot.mouseRelease(slider, Qt.LeftButton, pos=QPoint(160, 12))
    assert hand.holds == ["start", "finish"]
    hand.editor.setFeature(replace(EXPOSURE, value=20.0))
    assert slider.value() < position
    assert hand.editor.field.text() == "20 µs"


def test_a_click_beside_the_handle_takes_it_there(take, qtbot):
    hand = take(feature(K.FLOAT, 0.0, minimum=0.0, maximum=100.0))
    qtbot.mouseClick(hand.editor.slider(), Qt.LeftButton, pos=QPoint(100, 12))
    assert hand.values[0] == pytest.approx(50, abs=3)
    assert hand.holds == ["start", "finish"]


def test_the_ends_of_the_slider_are_the_ends_of_the_range(take):
    hand = take(EXPOSURE)
    hand.editor.slider().setValue(0)
    hand.editor.slider().setValue(hand.editor.slider().maximum())
    assert hand.values == [10.0, 1e6]


def test_slider_and_field_follow_each_other(take):
    hand = take(EXPOSURE)
    middle = hand.editor.slider().maximum() // 2
    hand.editor.slider().setValue(middle)
    assert hand.editor.field.text() == "3160 µs"
    before = hand.editor.slider().value()
    for _ in range(20):
        hand.editor.field.stepBy(10)
    assert hand.editor.slider().value() > before
    assert hand.values[-1] == 5160.0
