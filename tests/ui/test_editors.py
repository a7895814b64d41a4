"""Each editor in both directions: a feature shown never emits, what a person does always does."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PyQt5.QtCore import QPoint, QPointF, Qt
from PyQt5.QtGui import QMouseEvent, QWheelEvent
from PyQt5.QtWidgets import QApplication, QLabel

from grabbergui.core.features import AccessMode, EnumEntry, Feature, FeatureKind, Representation
from grabbergui.ui.editors.auto_button import AutoButton
from grabbergui.ui.editors.choice_editor import ChoiceEditor
from grabbergui.ui.editors.editor_choice import editor_class
from grabbergui.ui.editors.feature_row import FeatureRow
from grabbergui.ui.editors.number_editors import NumberEditor, RangeEditor
from grabbergui.ui.editors.simple_editors import CommandEditor, ReadingLabel, SwitchEditor
from grabbergui.ui.editors.text_editors import CodedNumberEditor, TextEditor

K, A, R = FeatureKind, AccessMode, Representation


def feature(kind, value=None, access=A.READ_WRITE, name="F", **more):
    return Feature(name=name, kind=kind, value=value, access=access, **more)


EXPOSURE = feature(K.FLOAT, 10000.0, name="ExposureTime", minimum=10.0, maximum=1e6, unit="us")
WIDTH = feature(K.INTEGER, 640, name="Width", minimum=16, maximum=2448, increment=16)
WIDE = feature(K.INTEGER, 2**62 + 1, name="Timestamp", minimum=0, maximum=2**63 - 1)
FREE = feature(K.FLOAT, 0.1234567890123)
MODE = feature(
    K.ENUMERATION, "On", entries=(EnumEntry("On"), EnumEntry("Off"), EnumEntry("Never", available=False))
)
TEXT = feature(K.STRING, "left", maximum_length=8)
ADDRESS = feature(K.INTEGER, 0xC0A8000A, representation=R.IPV4_ADDRESS, minimum=0, maximum=2**32 - 1)
SWITCH = feature(K.BOOLEAN, True)
BIT = feature(K.INTEGER, 1, representation=R.BOOLEAN, minimum=0, maximum=1)
COMMAND = feature(K.COMMAND, None, A.WRITE_ONLY)
AUTO = feature(
    K.ENUMERATION,
    "Off",
    name="GainAuto",
    entries=(EnumEntry("Off"), EnumEntry("Once"), EnumEntry("Continuous")),
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


class Hand:
    """An editor on screen, and what it emitted."""

    def __init__(self, qtbot, editor, shown):
        self.editor = editor
        qtbot.addWidget(editor)
        self.values, self.holds = [], []
        editor.valueEdited.connect(self.values.append)
        editor.editingStarted.connect(lambda: self.holds.append("start"))
        editor.editingFinished.connect(lambda: self.holds.append("finish"))
        editor.setFeature(shown)
        if editor.slider() is not None:
            editor.slider().resize(200, 24)
            editor.slider().show()
        editor.resize(200, 30)
        editor.show()
        qtbot.waitExposed(editor)


@pytest.fixture
def take(qtbot):
    return lambda shown: Hand(qtbot, editor_class(shown)(), shown)


@pytest.mark.parametrize(("shown", "expected"), CHOICES)
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
        hand.editor.setFeature(feature(**{**vars(shown), "value": other}))
    assert hand.values == []
    assert hand.holds == []


@pytest.mark.parametrize("shown", [shown for shown, _ in CHOICES])
def test_every_editor_has_an_accessible_name(take, shown):
    hand = take(shown)
    assert hand.editor.focusProxy().accessibleName() == shown.title


# -- numbers -----------------------------------------------------------------------------------------
def test_a_number_is_shown_with_its_unit_and_typed_without(take, qtbot):
    hand = take(EXPOSURE)
    field = hand.editor.field
    assert field.text() == "10000 µs"
    field.setFocus()
    field.selectAll()
    qtbot.keyClicks(field, "2.5e4")
    assert hand.values == []
    assert hand.holds == ["start"]
    qtbot.keyClick(field, Qt.Key_Return)
    assert hand.values == [25000.0]
    assert hand.holds == ["start", "finish"]
    assert field.text() == "25000 µs"


@pytest.mark.parametrize(("typed", "taken"), [("100", 96), ("99999", 2448), ("-3", 16), ("0x20", 32)])
def test_what_is_typed_becomes_the_nearest_number_allowed(take, qtbot, typed, taken):
    hand = take(WIDTH)
    qtbot.keyClick(hand.editor.field, "a", Qt.ControlModifier)
    qtbot.keyClicks(hand.editor.field, typed)
    qtbot.keyClick(hand.editor.field, Qt.Key_Return)
    assert hand.values == [taken]


@pytest.mark.parametrize("typed", ["", "abc", "1 2 3", "nan"])
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
    hand.editor.setFeature(feature(**{**vars(WIDTH), "value": 1024}))
    assert field.text() == "3"
    qtbot.keyClicks(field, "20")
    qtbot.keyClick(field, Qt.Key_Return)
    assert hand.values == [320]


def test_leaving_a_field_untouched_writes_nothing(take, qtbot):
    hand = take(FREE)
    hand.editor.field.setFocus()
    qtbot.keyClick(hand.editor.field, Qt.Key_Return)
    hand.editor.field.clearFocus()
    assert hand.editor.field.text() == "0.1234568"
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


def test_fractions_keep_every_digit_typed(take, qtbot):
    hand = take(FREE)
    qtbot.keyClick(hand.editor.field, "a", Qt.ControlModifier)
    qtbot.keyClicks(hand.editor.field, "33.333333333333336")
    qtbot.keyClick(hand.editor.field, Qt.Key_Return)
    assert hand.values == [33.333333333333336]


def test_a_fraction_is_shown_with_the_digits_there_is_room_for(take, qtbot):
    hand = take(feature(**{**vars(EXPOSURE), "value": 11276.6321}))
    field = hand.editor.field
    assert field.text() == "11276.63 µs"

    def is_short_once_narrower():
        field.setFixedWidth(field.width() - 4)
        return field.text() == "11277 µs"

    qtbot.waitUntil(is_short_once_narrower)
    qtbot.keyClick(field, Qt.Key_Return)
    assert hand.values == []
    field.setFixedWidth(400)
    qtbot.waitUntil(lambda: field.text() == "11276.63 µs")


def test_arrow_keys_step_until_the_end_of_the_range(take, qtbot):
    hand = take(feature(K.INTEGER, 2432, minimum=16, maximum=2448, increment=16))
    field = hand.editor.field
    field.setFocus()
    qtbot.keyClick(field, Qt.Key_Up)
    assert hand.values == [2448]
    assert hand.editor.slider().value() == hand.editor.slider().maximum()
    hand.editor.setFeature(feature(**{**vars(WIDTH), "value": 2448}))
    assert not field.stepEnabled() & field.StepUpEnabled
    assert field.stepEnabled() & field.StepDownEnabled


def drag(slider, x):
    """Move the mouse with its left button down; qtbot's has none down."""
    event = QMouseEvent(QMouseEvent.MouseMove, QPointF(x, 12), Qt.NoButton, Qt.LeftButton, Qt.NoModifier)
    QApplication.sendEvent(slider, event)


# -- the slider --------------------------------------------------------------------------------------
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
    hand.editor.setFeature(feature(**{**vars(EXPOSURE), "value": 20.0}))
    assert (slider.value(), hand.editor.field.text()) == (position, text)
    qtbot.mouseRelease(slider, Qt.LeftButton, pos=QPoint(160, 12))
    assert hand.holds == ["start", "finish"]
    hand.editor.setFeature(feature(**{**vars(EXPOSURE), "value": 20.0}))
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


# -- the others --------------------------------------------------------------------------------------
def test_an_entry_is_chosen_and_those_not_available_are_grey(take, qtbot):
    hand = take(MODE)
    combo = hand.editor.combo
    assert combo.currentText() == "On"
    assert [combo.model().item(index).isEnabled() for index in range(3)] == [True, True, False]
    combo.setFocus()
    qtbot.keyClick(combo, Qt.Key_Down)
    assert hand.values == ["Off"]
    qtbot.keyClick(combo, Qt.Key_Down)
    assert hand.values == ["Off"]


def test_a_list_that_is_open_holds(take, qtbot):
    hand = take(MODE)
    hand.editor.combo.showPopup()
    assert hand.holds == ["start"]
    hand.editor.combo.hidePopup()
    assert hand.holds == ["start", "finish"]


def test_an_entry_the_camera_did_not_announce_is_still_shown(take):
    hand = take(feature(**{**vars(MODE), "value": "Secret"}))
    assert hand.editor.combo.currentIndex() == -1
    assert hand.editor.combo.placeholderText() == "Secret"


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


def test_text_is_typed(take, qtbot):
    hand = take(TEXT)
    line = hand.editor.line
    assert line.text() == "left"
    qtbot.keyClicks(line, "XY")
    hand.editor.setFeature(feature(**{**vars(TEXT), "value": "other"}))
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


# -- the auto button ---------------------------------------------------------------------------------
@pytest.fixture
def auto(qtbot):
    button = AutoButton()
    qtbot.addWidget(button)
    button.modes = []
    button.modeChosen.connect(button.modes.append)
    button.setFeature(AUTO)
    return button


def test_auto_toggles_between_continuous_and_off(auto):
    assert not auto.isChecked()
    auto.click()
    assert auto.modes == ["Continuous"]
    # Only the camera's answer lights it.
    assert not auto.isChecked()
    auto.setFeature(feature(**{**vars(AUTO), "value": "Continuous"}))
    assert auto.isChecked()
    auto.click()
    assert auto.modes == ["Continuous", "Off"]


def test_once_is_in_the_menu(auto):
    actions = {action.text(): action for action in auto.menu().actions()}
    assert list(actions) == ["Off", "Once", "Continuous"]
    actions["Once"].trigger()
    assert auto.modes == ["Once"]
    auto.setFeature(feature(**{**vars(AUTO), "value": "Once"}))
    assert auto.text() == "Once"
    assert auto.isChecked()


def test_auto_without_continuous_does_it_once(auto):
    auto.setFeature(feature(**{**vars(AUTO), "entries": (EnumEntry("Off"), EnumEntry("Once"))}))
    auto.click()
    assert auto.modes == ["Once"]


def test_auto_may_be_a_boolean_or_locked(auto):
    auto.setFeature(feature(K.BOOLEAN, False))
    auto.click()
    assert auto.modes == [True]
    auto.setFeature(feature(K.BOOLEAN, True, A.READ_ONLY))
    assert auto.isChecked()
    auto.click()
    assert auto.modes == [True]
    assert "read-only" in auto.toolTip()


# -- the row -----------------------------------------------------------------------------------------
@pytest.fixture
def row(qtbot):
    def make(shown):
        row = FeatureRow(shown)
        qtbot.addWidget(row)
        row.told = []
        row.edited.connect(lambda name, value: row.told.append((name, value)))
        row.executed.connect(lambda name: row.told.append(name))
        row.held.connect(lambda name: row.told.append(f"held {name}"))
        row.released.connect(lambda name: row.told.append(f"released {name}"))
        row.resize(320, row.sizeHint().height())
        row.show()
        return row

    return make


def test_a_row_is_empty_until_its_feature_is_known(row, qtbot):
    made = row(EXPOSURE)
    assert made.editor is None
    made.setFeature(EXPOSURE)
    assert isinstance(made.editor, RangeEditor)
    qtbot.waitUntil(made.editor.slider().isVisible)
    made.editor.slider().setValue(0)
    assert made.told == [("ExposureTime", 10.0)]


def test_a_row_that_cannot_be_written_is_disabled_and_says_why(row):
    made = row(WIDTH)
    made.setFeature(WIDTH)
    made.setFeature(feature(**{**vars(WIDTH), "access": A.READ_ONLY}))
    assert isinstance(made.editor, RangeEditor)
    assert not made.editor.isEnabled()
    assert not made.editor.slider().isEnabled()
    assert "read-only just now" in made.toolTip()
    made.setFeature(WIDTH)
    assert made.editor.isEnabled()
    assert "read-only" not in made.toolTip()
    assert made.told == []


def test_a_row_changes_its_editor_when_the_range_does(row):
    made = row(WIDTH)
    made.setFeature(WIDTH)
    made.setFeature(feature(**{**vars(WIDTH), "maximum": 2**63 - 1}))
    assert type(made.editor) is NumberEditor
    made.setFeature(WIDTH)
    assert type(made.editor) is RangeEditor


def test_a_problem_disables_the_row_and_says_which(row):
    made = row(WIDTH)
    made.setFeature(WIDTH)
    made.setFeature(
        feature(**{**vars(WIDTH), "access": A.NOT_AVAILABLE, "value": None, "problem": "no such node"})
    )
    assert not made.editor.isEnabled()
    assert "no such node" in made.toolTip()


def test_an_editor_that_fails_disables_only_its_row(row, caplog, monkeypatch):
    monkeypatch.setattr(RangeEditor, "setFeature", lambda self, feature: 1 / 0)
    made = row(WIDTH)
    made.setFeature(WIDTH)
    assert not made.isEnabled()
    assert "Width cannot be shown" in caplog.text


def test_a_command_row_runs_its_command(row, qtbot):
    made = row(COMMAND)
    made.setFeature(COMMAND)
    qtbot.mouseClick(made.editor.button, Qt.LeftButton)
    assert made.told == ["F"]


def test_the_auto_button_of_a_row_writes_the_automatic_mode(row):
    gain = feature(K.FLOAT, 1.0, name="Gain", minimum=0.0, maximum=48.0, auto="GainAuto")
    made = row(gain)
    made.setFeature(gain)
    made.setAuto(AUTO)
    made.auto.click()
    assert made.told == [("GainAuto", "Continuous")]


def test_typing_holds_the_row(row, qtbot):
    made = row(WIDTH)
    made.setFeature(WIDTH)
    qtbot.keyClicks(made.editor.field, "1")
    assert made.told == ["held Width"]
    made.setFeature(feature(**{**vars(WIDTH), "problem": "gone"}))
    assert made.told == ["held Width", "released Width"]


anything = st.one_of(
    st.none(), st.booleans(), st.integers(-(2**64), 2**64), st.floats(), st.text(max_size=5), st.just("On")
)
bound = st.one_of(st.none(), st.integers(-(2**64), 2**64), st.floats(allow_nan=False))
features = st.builds(
    Feature,
    name=st.just("Odd"),
    kind=st.sampled_from(K),
    access=st.sampled_from(A),
    value=anything,
    minimum=bound,
    maximum=bound,
    increment=st.one_of(st.none(), st.integers(0, 2**40), st.floats(0, 1e9)),
    representation=st.sampled_from(R),
    entries=st.sampled_from([(), MODE.entries]),
    unit=st.sampled_from(["", "us", "<b>"]),
    maximum_length=st.one_of(st.none(), st.integers(1, 10)),
    problem=st.sampled_from(["", "", "odd"]),
)


@given(st.lists(features, min_size=1, max_size=4))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_no_feature_however_odd_breaks_its_row_or_is_written(qtbot, oddities):
    made = FeatureRow(oddities[0])
    qtbot.addWidget(made)
    told = []
    made.edited.connect(lambda name, value: told.append(value))
    for odd in oddities:
        made.setFeature(odd)
        assert made.isEnabled(), "an exception disabled the row, see the log"
    assert told == []
