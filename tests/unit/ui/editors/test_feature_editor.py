"""Which editor suits a feature, what holds for each editor, and the simple ones: boxes, buttons, text."""

from dataclasses import replace

import pytest
from PyQt5.QtCore import QPoint, QPointF, Qt
from PyQt5.QtGui import QWheelEvent
from PyQt5.QtWidgets import QApplication, QLabel

from every_case import every_case
from grabbergui.ui.editors.choice_editor import ChoiceEditor
from grabbergui.ui.editors.feature_editor import (
    CodedNumberEditor,
    CommandEditor,
    ReadingLabel,
    SwitchEditor,
    TextEditor,
)
from grabbergui.ui.editors.feature_row import editor_class
from grabbergui.ui.editors.number_editors import NumberEditor, RangeEditor
from sample_features import (
    ADDRESS,
    BIT,
    COMMAND,
    EXPOSURE,
    FREE,
    MODE,
    SWITCH,
    TEXT,
    WIDE,
    WIDTH,
    A,
    K,
    R,
    feature,
)

CHOICES = [
    (EXPOSURE, RangeEditor),
    (WIDTH, RangeEditor),
    (WIDE, NumberEditor),
    (FREE, NumberEditor),
    (feature(K.INTEGER, 3, representation=R.PURE_NUMBER, minimum=0, maximum=9), NumberEditor),
    (MODE, ChoiceEditor),
    (TEXT, TextEditor),
    (ADDRESS, CodedNumberEditor),
    (SWITCH, SwitchEditor),
    (BIT, SwitchEditor),
    (COMMAND, CommandEditor),
]


@every_case(("shown", "expected"), CHOICES)
def test_which_editor_suits_a_feature(shown, expected):
    assert editor_class(shown) is expected


def test_what_can_only_be_read_is_a_label_and_what_is_locked_stays_an_editor():
    locked = feature(K.INTEGER, 640, A.READ_ONLY, minimum=16, maximum=2448)
    assert editor_class(locked) is ReadingLabel
    assert editor_class(locked, RangeEditor) is RangeEditor
    assert editor_class(WIDTH, ReadingLabel) is RangeEditor
    away = feature(K.INTEGER, None, A.NOT_AVAILABLE)
    assert editor_class(away, RangeEditor) is RangeEditor
    assert editor_class(feature(K.INTEGER, None, A.NOT_AVAILABLE, problem="odd"), RangeEditor) is ReadingLabel


@pytest.mark.parametrize("shown", [shown for shown, _ in CHOICES])
def test_showing_a_feature_never_edits(take, shown):
    hand = take(shown)
    hand.editor.setFeature(shown)
    for other in (0, 1, 17, 0.5, True, False, "On", "Off", "Never", "text", "nowhere", None):
        hand.editor.setFeature(replace(shown, value=other))
    assert hand.values == []
    assert hand.holds == []


@pytest.mark.parametrize("shown", [shown for shown, _ in CHOICES])
def test_every_editor_has_an_accessible_name(take, shown):
    hand = take(shown)
    assert hand.editor.focusProxy().accessibleName() == shown.title


@pytest.mark.parametrize(("shown", "value"), [(SWITCH, False), (BIT, 0)])
def test_a_box_is_ticked(take, qtbot, shown, value):
    hand = take(shown)
    assert hand.editor.box.isChecked()
    qtbot.mouseClick(hand.editor.box, Qt.LeftButton, pos=QPoint(6, hand.editor.box.height() // 2))
    assert hand.values == [value]
    assert type(hand.values[0]) is type(value)


def test_a_command_is_run(take, qtbot):
    hand = take(COMMAND)
    qtbot.mouseClick(hand.editor.button, Qt.LeftButton)
    assert hand.values == [None]


def test_a_number_that_can_only_be_read_stays_beside_its_unit(take, qtbot):
    label = take(replace(EXPOSURE, access=A.READ_ONLY)).editor.label
    label.setText("10 ms")
    assert label.heightForWidth(20) <= label.fontMetrics().height() + 2 * label.margin() + 1


def test_text_is_typed(take, qtbot):
    hand = take(TEXT)
    line = hand.editor.line
    assert line.text() == "left"
    qtbot.keyClicks(line, "XY")
    hand.editor.setFeature(replace(TEXT, value="other"))
    assert hand.holds == ["start"]
    qtbot.keyClick(line, Qt.Key_Return)
    assert len(hand.values) == 1
    assert "XY" in hand.values[0]
    assert hand.holds == ["start", "finish"]
    qtbot.keyClicks(line, "Z" * 50)
    qtbot.keyClick(line, Qt.Key_Escape)
    assert line.text() == "other"
    assert len(hand.values) == 1


def test_an_address_is_typed_as_an_address(take, qtbot):
    hand = take(ADDRESS)
    line = hand.editor.line
    assert line.text() == "192.168.0.10"
    line.selectAll()
    qtbot.keyClicks(line, "10.0.0.1")
    qtbot.keyClick(line, Qt.Key_Return)
    line.selectAll()
    qtbot.keyClicks(line, "10.0.0.999")
    qtbot.keyClick(line, Qt.Key_Return)
    assert hand.values == [0x0A000001]


@pytest.mark.parametrize(
    ("representation", "typed", "hint"),
    [
        (R.IPV4_ADDRESS, "10.0.0.999", "“10.0.0.999” is not an IPv4 address"),
        (R.MAC_ADDRESS, "00:11:22", "“00:11:22” is not a MAC address"),
        (R.HEX_NUMBER, "0xfg", "“0xfg” is not a number"),
    ],
)
def test_a_mistyped_address_or_hexadecimal_number_is_discarded_with_a_hint(
    take, qtbot, representation, typed, hint
):
    hand = take(replace(ADDRESS, representation=representation))
    line = hand.editor.line
    before = line.text()
    line.selectAll()
    qtbot.keyClicks(line, typed)
    qtbot.keyClick(line, Qt.Key_Return)
    assert (hand.hints, hand.values, line.text()) == ([hint], [], before)


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
