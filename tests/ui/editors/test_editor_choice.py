"""Which editor suits a feature; and what holds for each: a feature shown never edits, and has a name."""

from dataclasses import replace

import pytest
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
        hand.editor.setFeature(replace(shown, value=other))
    assert hand.values == []
    assert hand.holds == []


@pytest.mark.parametrize("shown", [shown for shown, _ in CHOICES])
def test_every_editor_has_an_accessible_name(take, shown):
    hand = take(shown)
    assert hand.editor.focusProxy().accessibleName() == shown.title
