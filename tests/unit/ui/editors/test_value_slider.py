"""The slider beside a number: dragged, clicked beside, and in step with the field."""

from dataclasses import replace
from itertools import pairwise
from unittest.mock import patch

import pytest
from PyQt5.QtCore import QPoint, QPointF, Qt
from PyQt5.QtGui import QMouseEvent, QWheelEvent
from PyQt5.QtWidgets import QApplication, QStyle, QStyleOptionSlider

from sample_features import EXPOSURE, WIDTH, K, feature


def drag(slider, x, modifier=Qt.NoModifier):
    """Move the mouse with its left button down; qtbot's has none down."""
    event = QMouseEvent(QMouseEvent.MouseMove, QPointF(x, 12), Qt.NoButton, Qt.LeftButton, modifier)
    QApplication.sendEvent(slider, event)


def turn(control, modifier):
    """Turn the wheel by one notch; what the field asks of the keyboard is what was pressed last."""
    at = QPointF(10, 10)
    wheel = QWheelEvent(at, at, QPoint(), QPoint(0, 120), Qt.NoButton, modifier, Qt.NoScrollPhase, False)
    with patch.object(QApplication, "keyboardModifiers", lambda: modifier):
        QApplication.sendEvent(control, wheel)


def handle_of(slider):
    """The middle of the handle."""
    option = QStyleOptionSlider()
    slider.initStyleOption(option)
    handle = slider.style().subControlRect(QStyle.CC_Slider, option, QStyle.SC_SliderHandle, slider)
    return handle.center()


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


def test_a_pixel_of_a_wide_range_changes_the_number_by_less_than_three_percent(take, qtbot):
    hand = take(EXPOSURE)
    slider = hand.editor.slider()
    slider.resize(117, 24)  # as above the image of a window of 1280 × 800
    middle = handle_of(slider)
    qtbot.mousePress(slider, Qt.LeftButton, pos=middle)
    numbers = [10000.0]
    for pixels in range(1, 20):
        drag(slider, middle.x() + pixels)
        numbers.append(hand.values[-1])
    assert all(1.005 < after / before < 1.03 for before, after in pairwise(numbers))
    # A tenth of that with Shift, from where it is.
    for pixels in range(20, 40):
        drag(slider, middle.x() + pixels, Qt.ShiftModifier)
    assert 1.03 < hand.values[-1] / numbers[-1] < 1.09


def test_a_handle_held_beyond_the_end_takes_the_range_along(take, qtbot):
    hand = take(EXPOSURE)
    slider = hand.editor.slider()
    qtbot.mousePress(slider, Qt.LeftButton, pos=handle_of(slider))
    drag(slider, slider.width() + 50)
    end = hand.values[-1]
    qtbot.waitUntil(lambda: hand.values[-1] > 1.5 * end)
    assert slider.value() == slider.maximum()
    qtbot.mouseRelease(slider, Qt.LeftButton, pos=QPoint(slider.width(), 12))
    taken = hand.values[-1]
    # Then there is room again on both sides.
    assert 0.3 < slider.value() / slider.maximum() < 0.7
    qtbot.wait(100)
    assert hand.values[-1] == taken


@pytest.mark.parametrize(
    ("modifier", "taken"), [(Qt.NoModifier, 10100), (Qt.ShiftModifier, 10010), (Qt.ControlModifier, 11000)]
)
def test_the_wheel_steps_fine_and_coarse(take, qtbot, modifier, taken):
    hand = take(EXPOSURE)
    hand.editor.slider().setFocus()
    hand.editor.activateWindow()
    for control in (hand.editor.slider(), hand.editor.field):
        hand.editor.setFeature(EXPOSURE)
        control.setFocus()
        qtbot.waitUntil(control.hasFocus)
        turn(control, modifier)
        assert hand.values[-1] == taken


def test_the_end_keys_lead_to_the_ends_of_the_range(take, qtbot):
    hand = take(EXPOSURE)
    qtbot.keyClick(hand.editor.slider(), Qt.Key_Home)
    qtbot.keyClick(hand.editor.slider(), Qt.Key_End)
    assert hand.values == [10.0, 1e6]
    assert hand.editor.slider().value() == hand.editor.slider().maximum()


def test_slider_and_field_follow_each_other(take, qtbot):
    hand = take(EXPOSURE)
    slider = hand.editor.slider()
    slider.setValue(slider.maximum() * 3 // 4)
    moved = f"{hand.values[-1] / 1000:g} ms"
    assert moved != "10 ms"
    qtbot.waitUntil(lambda: hand.editor.field.text() == moved)
    before = slider.value()
    hand.editor.field.stepBy(-10)
    qtbot.waitUntil(lambda: slider.value() < before)


def test_the_slider_hands_on_its_number_before_the_field_shows_it(take, qtbot):
    """The write waits for the GIL, which formatting a text would keep for a while."""
    hand = take(EXPOSURE)
    shown = []
    hand.editor.valueEdited.connect(lambda number: shown.append(hand.editor.field.text()))
    slider = hand.editor.slider()
    slider.setValue(slider.maximum())
    assert shown == ["10 ms"] == [hand.editor.field.text()]
    qtbot.waitUntil(lambda: hand.editor.field.text() != "10 ms")


def test_a_number_from_the_camera_is_not_overtaken_by_an_older_one_of_the_slider(take, qtbot):
    hand = take(EXPOSURE)
    hand.editor.slider().setValue(0)
    hand.editor.setFeature(replace(EXPOSURE, value=20.0))
    qtbot.wait(20)
    assert hand.editor.field.text() == "20 µs"


def test_what_pauses_the_stream_is_written_once_the_slider_is_released(take, qtbot):
    hand = take(replace(WIDTH, pauses_stream=True))
    slider = hand.editor.slider()
    start = handle_of(slider)
    qtbot.mousePress(slider, Qt.LeftButton, pos=start)
    for x in (20, 40, 60):
        drag(slider, start.x() + x)
    assert hand.values == []
    qtbot.waitUntil(lambda: int(hand.editor.field.text()) > 640)
    shown = int(hand.editor.field.text())
    qtbot.mouseRelease(slider, Qt.LeftButton, pos=start)
    assert hand.values == [shown]
    qtbot.keyClick(slider, Qt.Key_Up)
    assert hand.values == [shown, shown + 16]
