"""A feature's row: the editor that suits it, why it cannot be used, and whatever a camera may claim of it."""

from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PyQt5.QtCore import QEvent, Qt
from PyQt5.QtWidgets import QAbstractSlider, QAbstractSpinBox, QLineEdit

from grabbergui.core.features import AccessCondition, Feature
from grabbergui.ui.editors.feature_row import FeatureRow
from grabbergui.ui.editors.number_editors import NumberEditor, RangeEditor
from grabbergui.ui.widgets.labels import WrappedLabel
from sample_features import AUTO, COMMAND, EXPOSURE, MODE, WIDTH, A, K, R, feature


@pytest.fixture
def row(qtbot):
    def make(shown):
        row = FeatureRow(shown)
        qtbot.addWidget(row)
        row.reported = []
        row.edited.connect(lambda name, value: row.reported.append((name, value)))
        row.executed.connect(lambda name: row.reported.append(name))
        row.held.connect(lambda name: row.reported.append(f"held {name}"))
        row.released.connect(lambda name: row.reported.append(f"released {name}"))
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
    qtbot.keyClick(made.editor.slider(), Qt.Key_Home)
    assert made.reported == [("ExposureTime", 10.0)]


def test_a_row_that_cannot_be_written_is_disabled_and_says_why(row):
    made = row(WIDTH)
    made.setFeature(WIDTH)
    made.setFeature(replace(WIDTH, access=A.READ_ONLY))
    assert isinstance(made.editor, RangeEditor)
    assert not made.editor.isEnabled()
    assert not made.editor.slider().isEnabled()
    assert "is read-only; streaming" in made.toolTip()
    made.setFeature(WIDTH)
    assert made.editor.isEnabled()
    assert "read-only" not in made.toolTip()
    assert made.reported == []


def test_the_mouse_over_a_locked_row_asks_what_locks_it(row, qapp):
    made, asked = row(WIDTH), []
    made.explanationRequested.connect(asked.append)
    hidden = replace(WIDTH, access=A.NOT_AVAILABLE, value=None)
    explained = replace(hidden, conditions=(AccessCondition("TriggerMode", "Off", ("On",)),))
    for shown, expected in ((WIDTH, []), (hidden, ["Width"]), (explained, ["Width"])):
        made.setFeature(shown)
        qapp.sendEvent(made, QEvent(QEvent.Enter))
        assert asked == expected
    assert "while TriggerMode is Off; set TriggerMode to On" in made.toolTip()


def test_a_row_changes_its_editor_when_the_range_does(row):
    made = row(WIDTH)
    made.setFeature(WIDTH)
    made.setFeature(replace(WIDTH, maximum=2**63 - 1))
    assert type(made.editor) is NumberEditor
    made.setFeature(WIDTH)
    assert type(made.editor) is RangeEditor


def test_a_problem_disables_the_row_and_says_which(row):
    made = row(WIDTH)
    made.setFeature(WIDTH)
    made.setFeature(replace(WIDTH, access=A.NOT_AVAILABLE, value=None, problem="no such node"))
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
    assert made.reported == ["F"]


def test_the_auto_button_of_a_row_writes_the_automatic_mode(row):
    gain = feature(K.FLOAT, 1.0, name="Gain", minimum=0.0, maximum=48.0, auto="GainAuto")
    made = row(gain)
    made.setFeature(gain)
    made.setAuto(AUTO)
    made.auto.click()
    assert made.reported == [("GainAuto", "Continuous")]


def test_a_slider_keeps_its_length_when_the_automatic_mode_is_known(row):
    gain = feature(K.FLOAT, 1.0, name="Gain", minimum=0.0, maximum=48.0, auto="GainAuto")
    made = row(gain)
    made.standBesideOthers()
    made.setFeature(gain)
    made.resize(made.leastWidth() + 60, made.sizeHint().height())
    made.layout().activate()
    before = made.editor.slider().geometry()
    assert not made.auto.isEnabled(), "its mode is not known yet"
    made.setAuto(AUTO)
    made.layout().activate()
    assert made.auto.isEnabled() and made.editor.slider().geometry() == before


def test_typing_holds_the_row(row, qtbot):
    made = row(WIDTH)
    made.setFeature(WIDTH)
    qtbot.keyClicks(made.editor.field, "1")
    assert made.reported == ["held Width"]
    made.setFeature(replace(WIDTH, problem="gone"))
    assert made.reported == ["held Width", "released Width"]


anything = st.one_of(
    st.none(), st.booleans(), st.integers(-(2**64), 2**64), st.floats(), st.text(max_size=5), st.just("On")
)
bound = st.one_of(st.none(), st.integers(-(2**64), 2**64), st.floats())
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
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_no_feature_however_odd_breaks_its_row_or_is_written(qtbot, oddities):
    made = FeatureRow(oddities[0])
    qtbot.addWidget(made)
    reported = []
    made.edited.connect(lambda name, value: reported.append(value))
    for odd in oddities:
        made.setFeature(odd)
        assert made.isEnabled(), "an exception disabled the row, see the log"
    assert reported == []


whole, fraction = st.one_of(st.none(), st.integers(-(2**63), 2**63 - 1)), st.one_of(st.none(), st.floats())
numbers = st.one_of(
    st.builds(
        Feature,
        name=st.just("Odd"),
        kind=st.just(kind),
        value=number,
        minimum=number,
        maximum=number,
        increment=number,
        representation=st.sampled_from(R),
    )
    for kind, number in ((K.INTEGER, whole), (K.FLOAT, fraction))
)
KEYS = (Qt.Key_Up, Qt.Key_PageDown, Qt.Key_Home, Qt.Key_End, Qt.Key_5, Qt.Key_Return)


@given(numbers, st.lists(st.sampled_from(KEYS), min_size=1, max_size=4))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_no_range_however_odd_breaks_a_number_that_is_edited(qtbot, odd, keys):
    made = FeatureRow(odd)
    made.setFeature(odd)
    qtbot.addWidget(made)
    made.show()
    kinds = (QAbstractSpinBox, QAbstractSlider, QLineEdit)
    with qtbot.capture_exceptions() as faults:
        for control in (each for kind in kinds for each in made.findChildren(kind) if each.isVisible()):
            for key in keys:
                qtbot.keyClick(control, key)
    made.close()
    assert not faults


def test_a_word_without_room_ends_in_an_ellipsis(qtbot):
    """A German compound was cut in the middle of a letter."""
    compound = "Belichtungszeitautomatikobergrenze"
    label = WrappedLabel(f"Die {compound}")
    qtbot.addWidget(label)
    label.resize(90, 60)
    label.show()
    first, second = label.text().split(" ")
    assert first == "Die" and second.endswith("…") and compound.startswith(second[:-1])
    label.resize(600, 60)
    assert label.text() == f"Die {compound}"
