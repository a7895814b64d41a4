"""Numbers typed and stepped: the nearest one allowed is written, and none that nobody typed."""

import gc
from dataclasses import replace

import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtGui import QKeySequence
from PyQt5.QtWidgets import QLineEdit, QShortcut

from grabbergui.ui.editors.number_editors import FOLLOWING_MS, DelayedDisplay
from sample_features import EXPOSURE, FREE, WIDE, WIDTH, K, feature


def test_a_number_is_shown_with_its_unit_and_typed_without(take, qtbot):
    hand = take(EXPOSURE)
    field = hand.editor.field
    assert field.text() == "10 ms"
    field.setFocus()
    field.selectAll()
    qtbot.keyClicks(field, "2.5e1")
    assert hand.values == []
    assert hand.holds == ["start"]
    qtbot.keyClick(field, Qt.Key_Return)
    assert hand.values == [25000.0]
    assert hand.holds == ["start", "finish"]
    qtbot.waitUntil(lambda: field.text() == "25 ms")


@pytest.mark.parametrize(
    ("typed", "during", "taken"),
    [
        ("1.5s", "1.5s", 1e6),
        ("800us", "800us", 800.0),
        ("12,5 ms", "12,5 ms", 12500.0),
        ("40", "40 ms", 40000.0),
    ],
)
def test_a_unit_that_is_typed_takes_the_place_of_the_one_shown(take, qtbot, typed, during, taken):
    hand = take(EXPOSURE)
    hand.editor.field.selectAll()
    qtbot.keyClicks(hand.editor.field, typed)
    assert hand.editor.field.text() == during
    qtbot.keyClick(hand.editor.field, Qt.Key_Return)
    assert hand.values == [taken]


def test_numbers_typed_one_after_another_have_one_unit(take, qtbot):
    hand = take(EXPOSURE)
    field = hand.editor.field
    for typed, shown in (
        ("5", "5 ms"),
        ("6", "6 ms"),
        ("0.2s", "0.2 s"),
        ("0.3", "0.3 s"),
        ("80us", "80 µs"),
    ):
        field.selectAll()
        qtbot.keyClicks(field, typed)
        qtbot.keyClick(field, Qt.Key_Return)
        qtbot.waitUntil(lambda shown=shown: field.text() == shown)
    assert hand.values == [5000.0, 6000.0, 200_000.0, 300_000.0, 80.0]


def test_another_feature_is_shown_in_its_own_unit(take, qtbot):
    field = take(EXPOSURE).editor.field
    assert field.text() == "10 ms"
    field.setFeature(replace(EXPOSURE, name="ExposureTimeAbs", value=500.0))
    assert field.text() == "500 µs"


def test_only_what_a_number_can_be_may_be_typed(take, qtbot):
    gain = take(feature(K.FLOAT, 7.5, minimum=0.0, maximum=48.0, unit="dB")).editor.field
    assert gain.text() == "7.5 dB"
    qtbot.keyClick(gain, Qt.Key_End)
    qtbot.keyClicks(gain, "eExpw")
    assert gain.text() == "7.5 dB"


@pytest.mark.parametrize("typed", ["1/60", "2 Hz", "20O", "1 2"])
def test_what_is_no_number_is_refused_as_a_whole(take, qtbot, typed):
    """Without the keys that no number has, 1/60 would be 160."""
    hand = take(EXPOSURE)
    field = hand.editor.field
    qtbot.keyClick(field, "a", Qt.ControlModifier)
    qtbot.keyClicks(field, typed)
    qtbot.keyClick(field, Qt.Key_Return)
    assert (hand.values, field.text()) == ([], "10 ms")
    [hint] = hand.hints
    assert hint.startswith(f"“{typed}") and hint.endswith("is not a number in s, ms, µs, ns")


@pytest.mark.parametrize(
    ("typed", "hint"), [("5 s", "At most 1 s"), ("0", "At least 10 µs"), ("20 ms", ""), ("7", "")]
)
def test_a_number_beyond_the_range_is_moved_into_it_with_a_hint(take, qtbot, typed, hint):
    hand = take(EXPOSURE)
    qtbot.keyClick(hand.editor.field, "a", Qt.ControlModifier)
    qtbot.keyClicks(hand.editor.field, typed)
    qtbot.keyClick(hand.editor.field, Qt.Key_Return)
    assert hand.hints == ([hint] if hint else [])


def test_a_hint_outlasts_the_focus_and_the_next_one_replaces_it(take, qtbot):
    """Enter gives the focus to the image, and a click to what was clicked; Qt's tooltips end with either."""
    hand = take(EXPOSURE)
    field, elsewhere = hand.editor.field, QLineEdit(hand.editor)
    elsewhere.show()
    for typed, hint in (("5 s", "At most 1 s"), ("5 V", "“5 V” is not a number in s, ms, µs, ns")):
        field.setFocus()
        qtbot.keyClick(field, "a", Qt.ControlModifier)
        qtbot.keyClicks(field, typed)
        qtbot.keyClick(field, Qt.Key_Return)
        elsewhere.setFocus()
        qtbot.mouseClick(elsewhere, Qt.LeftButton)
        assert hand.hints == [hint]


def test_all_of_a_field_is_its_number_so_that_the_unit_stays(take, qtbot):
    field = take(EXPOSURE).editor.field
    qtbot.keyClick(field, "a", Qt.ControlModifier)
    qtbot.keyClicks(field, "20")
    assert field.text() == "20 ms"


def test_an_editor_of_which_a_test_holds_only_the_field_is_not_collected(take):
    field = take(EXPOSURE).editor.field
    gc.collect()
    assert field.text() == "10 ms"


@pytest.mark.parametrize("key", [Qt.Key_U, Qt.Key_E, Qt.Key_Z])
def test_the_windows_keys_are_the_windows_with_a_field_in_focus(take, qtbot, key):
    hand, pressed = take(EXPOSURE), []
    field = hand.editor.field
    shortcut = QShortcut(QKeySequence(int(Qt.ControlModifier) | key), hand.editor)
    shortcut.activated.connect(lambda: pressed.append(key))
    hand.editor.activateWindow()
    field.setFocus()
    qtbot.waitUntil(field.hasFocus)
    qtbot.keyClick(field, key, Qt.ControlModifier)
    assert (pressed, field.text()) == ([key], "10 ms")


@pytest.mark.parametrize(
    ("modifier", "taken"), [(Qt.NoModifier, 10100), (Qt.ShiftModifier, 10010), (Qt.ControlModifier, 11000)]
)
def test_a_step_is_one_percent_finer_with_shift_coarser_with_ctrl(take, qtbot, modifier, taken):
    hand = take(EXPOSURE)
    qtbot.keyClick(hand.editor.field, Qt.Key_Up, modifier)
    displays = hand.editor.findChildren(DelayedDisplay)
    qtbot.waitUntil(lambda: not any(each.isActive() for each in displays))
    assert hand.editor.field.text() != "10 ms"
    qtbot.keyClick(hand.editor.slider(), Qt.Key_Down, modifier)
    assert hand.values[0] == taken
    assert hand.values[1] == pytest.approx(10000, rel=0.02)
    if modifier == Qt.NoModifier:
        qtbot.keyClick(hand.editor.slider(), Qt.Key_Home)
        assert hand.values[-1] == 10


@pytest.mark.parametrize("shown", [WIDTH, WIDE], ids=["with a slider", "without one"])
def test_steps_faster_than_the_camera_answers_all_count(take, shown):
    hand = take(shown)
    for _ in range(5):
        hand.editor.field.stepBy(1)
    assert len(set(hand.values)) == 5
    assert hand.values == sorted(hand.values)


def test_a_number_leaves_before_it_is_shown_and_is_shown_while_more_follow(take, qtbot):
    """The write waits for the GIL, which laying out a text would keep for a while."""
    hand = take(WIDTH)
    field = hand.editor.field
    shown = []
    hand.editor.valueEdited.connect(lambda number: shown.append(field.text()))
    field.stepBy(1)
    assert shown == ["640"] == [field.text()]

    def stepped():
        field.stepBy(1)
        return field.text() != "640"

    qtbot.waitUntil(stepped)


def test_what_is_typed_right_after_a_step_stays(take, qtbot):
    field = take(WIDTH).editor.field
    field.setFocus()
    qtbot.keyClick(field, Qt.Key_Up)
    qtbot.keyClicks(field, "12")
    qtbot.wait(2 * FOLLOWING_MS)
    assert field.text() == "12"


def test_a_number_that_is_selected_to_be_replaced_stays_selected_when_the_camera_changes_it(take, qtbot):
    hand = take(EXPOSURE)
    hand.editor.field.selectAll()
    hand.editor.setFeature(replace(EXPOSURE, value=20000.0))
    qtbot.keyClicks(hand.editor.field, "5")
    assert hand.editor.field.text() == "5 ms"


@pytest.mark.parametrize(("typed", "taken"), [("100", 96), ("99999", 2448), ("-3", 16), ("0x20", 32)])
def test_what_is_typed_becomes_the_nearest_number_allowed(take, qtbot, typed, taken):
    hand = take(WIDTH)
    qtbot.keyClick(hand.editor.field, "a", Qt.ControlModifier)
    qtbot.keyClicks(hand.editor.field, typed)
    qtbot.keyClick(hand.editor.field, Qt.Key_Return)
    assert hand.values == [taken]


@pytest.mark.parametrize("typed", ["", "-", "0x", "1e"])
def test_nonsense_typed_changes_nothing(take, qtbot, typed):
    hand = take(WIDTH)
    field = hand.editor.field
    qtbot.keyClick(field, "a", Qt.ControlModifier)
    qtbot.keyClicks(field, typed or "5")
    if not typed:
        qtbot.keyClick(field, Qt.Key_Backspace)
    qtbot.keyClick(field, Qt.Key_Return)
    assert hand.values == []
    assert field.text() == "640"
    assert hand.holds == ["start", "finish"]


def test_escape_gives_up_what_was_typed(take, qtbot):
    hand = take(WIDTH)
    qtbot.keyClicks(hand.editor.field, "1")
    qtbot.keyClick(hand.editor.field, Qt.Key_Escape)
    assert hand.editor.field.text() == "640"
    assert hand.values == []
    assert hand.holds == ["start", "finish"]


def test_what_is_typed_stays_while_the_camera_moves(take, qtbot):
    hand = take(WIDTH)
    field = hand.editor.field
    qtbot.keyClick(field, "a", Qt.ControlModifier)
    qtbot.keyClicks(field, "3")
    hand.editor.setFeature(replace(WIDTH, value=1024))
    assert field.text() == "3"
    qtbot.keyClicks(field, "20")
    qtbot.keyClick(field, Qt.Key_Return)
    assert hand.values == [320]


def test_leaving_a_field_untouched_writes_nothing(take, qtbot):
    hand = take(FREE)
    hand.editor.field.setFocus()
    qtbot.keyClick(hand.editor.field, Qt.Key_Return)
    hand.editor.field.clearFocus()
    assert hand.editor.field.text() == "0.12346"
    assert hand.values == []


def test_64_bit_integers_keep_every_digit(take, qtbot):
    hand = take(WIDE)
    field = hand.editor.field
    assert field.text() == "4611686018427387905"
    field.stepBy(1)
    assert hand.values == [2**62 + 2]
    qtbot.keyClick(field, "a", Qt.ControlModifier)
    qtbot.keyClicks(field, "9223372036854775807")
    qtbot.keyClick(field, Qt.Key_Return)
    assert hand.values[-1] == 2**63 - 1


def test_a_number_beyond_64_bits_is_not_limited_in_silence(take, qtbot):
    hand = take(WIDE)
    field = hand.editor.field
    qtbot.keyClick(field, "a", Qt.ControlModifier)
    qtbot.keyClicks(field, str(2**63))
    qtbot.keyClick(field, Qt.Key_Return)
    assert hand.values[-1] == 2**63 - 1
    assert hand.hints == ["At most 9223372036854775807"]


def test_fractions_keep_every_digit_typed(take, qtbot):
    hand = take(FREE)
    qtbot.keyClick(hand.editor.field, "a", Qt.ControlModifier)
    qtbot.keyClicks(hand.editor.field, "33.333333333333336")
    qtbot.keyClick(hand.editor.field, Qt.Key_Return)
    assert hand.values == [33.333333333333336]


def test_a_fraction_is_shown_with_the_digits_there_is_room_for(take, qtbot):
    hand = take(replace(EXPOSURE, value=11276.6321))
    field = hand.editor.field
    field.clearFocus()
    assert field.text() == "11.277 ms"

    def is_short_once_narrower():
        field.setFixedWidth(field.width() - 4)
        return field.text() == "11.28 ms"

    qtbot.waitUntil(is_short_once_narrower)
    qtbot.keyClick(field, Qt.Key_Return)
    assert hand.values == []
    field.setFixedWidth(400)
    field.clearFocus()
    qtbot.waitUntil(lambda: field.text() == "11.277 ms", timeout=5000)
    hand.editor.activateWindow()
    field.setFocus()
    qtbot.waitUntil(lambda: field.text() == "11.27663 ms")  # all of it, to be edited
    field.clearFocus()
    assert field.text() == "11.277 ms" and hand.values == []


def test_arrow_keys_step_until_the_end_of_the_range(take, qtbot):
    hand = take(feature(K.INTEGER, 2432, minimum=16, maximum=2448, increment=16))
    field = hand.editor.field
    field.setFocus()
    qtbot.keyClick(field, Qt.Key_Up)
    assert hand.values == [2448]
    qtbot.waitUntil(lambda: hand.editor.slider().value() == hand.editor.slider().maximum())
    hand.editor.setFeature(replace(WIDTH, value=2448))
    assert not field.stepEnabled() & field.StepUpEnabled
    assert field.stepEnabled() & field.StepDownEnabled
