"""Which editor suits a feature."""

from __future__ import annotations

from grabbergui.core.features import AccessMode, Feature, FeatureKind, Representation
from grabbergui.models.features.scale import SliderScale
from grabbergui.models.features.text import CODED
from grabbergui.ui.editors.choice_editor import ChoiceEditor
from grabbergui.ui.editors.feature_editor import FeatureEditor
from grabbergui.ui.editors.number_editors import NumberEditor, RangeEditor
from grabbergui.ui.editors.simple_editors import CommandEditor, ReadingLabel, SwitchEditor
from grabbergui.ui.editors.text_editors import CodedNumberEditor, TextEditor

_BY_KIND: dict[FeatureKind, type[FeatureEditor]] = {
    FeatureKind.BOOLEAN: SwitchEditor,
    FeatureKind.COMMAND: CommandEditor,
    FeatureKind.ENUMERATION: ChoiceEditor,
    FeatureKind.STRING: TextEditor,
}

_EDITABLE_LATER = (FeatureKind.BOOLEAN, FeatureKind.COMMAND)
"""Shown by their control even where they cannot be used: it says the same and does not move."""


def editor_class(feature: Feature, current: type[FeatureEditor] | None = None) -> type[FeatureEditor]:
    """The class of editor for a feature that is shown by one of class `current`, if any.

    What can only be read is a label, unless it had an editor: a control that is locked for a while turns
    grey instead of going away.
    """
    if feature.problem:
        return ReadingLabel
    locked = not feature.access.writable and feature.kind not in _EDITABLE_LATER
    if locked and current in (None, ReadingLabel):
        return ReadingLabel
    if locked and feature.access is not AccessMode.READ_ONLY and current is not None:
        return current
    return _editor_of_kind(feature)


def _editor_of_kind(feature: Feature) -> type[FeatureEditor]:
    if feature.kind in _BY_KIND:
        return _BY_KIND[feature.kind]
    if feature.representation is Representation.BOOLEAN:
        return SwitchEditor
    if feature.kind is FeatureKind.INTEGER and feature.representation in CODED:
        return CodedNumberEditor
    return NumberEditor if SliderScale.of(feature) is None else RangeEditor
