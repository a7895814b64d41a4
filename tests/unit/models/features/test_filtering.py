import pytest

from grabbergui.core.features import Category, FeatureDescription, FeatureKind, Visibility
from grabbergui.models.features.filtering import visible_names


def describe(name, visibility=Visibility.BEGINNER, **more):
    return FeatureDescription(name=name, kind=FeatureKind.INTEGER, visibility=visibility, **more)


TREE = Category(
    "Root",
    members=(
        Category(
            "AcquisitionControl",
            members=(
                describe(
                    "ExposureTime", display_name="Exposure Time", tooltip="How long the shutter is open."
                ),
                describe("ExposureMode", Visibility.EXPERT),
                describe("SensorTaps", Visibility.GURU),
                describe("Hidden", Visibility.INVISIBLE),
            ),
        ),
        Category("Secrets", visibility=Visibility.GURU, members=(describe("Key"), describe("ExposureTime"))),
        describe("AtTheRoot"),
    ),
)


def test_each_visibility_sees_those_below():
    assert visible_names(TREE, Visibility.BEGINNER) == ["ExposureTime", "AtTheRoot"]
    assert visible_names(TREE, Visibility.EXPERT) == ["ExposureTime", "ExposureMode", "AtTheRoot"]
    guru = ["ExposureTime", "ExposureMode", "SensorTaps", "Key", "AtTheRoot"]
    assert visible_names(TREE, Visibility.GURU) == guru
    assert "Hidden" in visible_names(TREE, Visibility.INVISIBLE)


def test_text_is_found_in_name_display_name_and_tooltip_whatever_its_case():
    assert visible_names(TREE, Visibility.GURU, "exposuretime") == ["ExposureTime"]
    assert visible_names(TREE, Visibility.GURU, "exposure time") == ["ExposureTime"]
    assert visible_names(TREE, Visibility.GURU, "SHUTTER") == ["ExposureTime"]
    assert visible_names(TREE, Visibility.GURU, "exposure") == ["ExposureTime", "ExposureMode"]


def test_every_word_must_match():
    assert visible_names(TREE, Visibility.GURU, "mode exposure") == ["ExposureMode"]
    assert visible_names(TREE, Visibility.GURU, "exposure banana") == []
    assert visible_names(TREE, Visibility.BEGINNER, "mode") == []


def test_blanks_are_no_filter():
    assert visible_names(TREE, Visibility.BEGINNER, "  ") == ["ExposureTime", "AtTheRoot"]


def test_beginners_see_pinned_features_only_when_they_search_for_them():
    pinned = {"ExposureTime"}
    assert visible_names(TREE, Visibility.BEGINNER, elsewhere=pinned) == ["AtTheRoot"]
    assert visible_names(TREE, Visibility.BEGINNER, "exposuretime", pinned) == ["ExposureTime"]
    assert "ExposureTime" in visible_names(TREE, Visibility.EXPERT, elsewhere=pinned)


@pytest.mark.parametrize("name", ["AcquisitionStart", "AcquisitionStop"])
def test_commands_that_have_buttons_are_for_experts(name):
    start = FeatureDescription(name=name, kind=FeatureKind.COMMAND)
    gain = FeatureDescription(name="Gain", kind=FeatureKind.FLOAT)
    root = Category("Root", members=(start, gain))
    assert visible_names(root, Visibility.BEGINNER) == ["Gain"]
    assert visible_names(root, Visibility.EXPERT) == [name, "Gain"]
    assert visible_names(root, Visibility.BEGINNER, "acquisition") == [name]
