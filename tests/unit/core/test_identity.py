"""Telling cameras apart by all that they say of themselves."""

from dataclasses import replace

import pytest

from grabbergui.core.errors import OtherCameraError
from grabbergui.core.identity import (
    DeviceInfo,
    choose,
    describe,
    distinct_names,
    is_same,
    require_one,
    require_same,
    unit,
)

CAMERA = DeviceInfo(
    "gige:7", "Acme", "One", "7", "GigE Vision", "10.0.0.7", "left", hardware_id="00:30:53:0a:0b:0c"
)


@pytest.mark.parametrize("field", ["vendor", "model", "serial", "hardware_id"])
def test_a_camera_that_differs_in_anything_that_identifies_it_is_refused_and_named(field):
    other = replace(CAMERA, address="10.0.0.9", **{field: "other"})
    with pytest.raises(OtherCameraError, match=r"10\.0\.0\.9.*other.*00:30:53:0a:0b:0c.* is wanted"):
        require_same(CAMERA, other)


def test_a_camera_that_was_moved_and_renamed_is_the_same():
    moved = replace(CAMERA, uri="gige:right", address="10.0.0.9", user_name="right", version="2")
    assert unit(moved) == unit(CAMERA)
    require_same(CAMERA, moved)  # raises nothing


@pytest.mark.parametrize(
    ("other", "same"),
    [
        (DeviceInfo("aravis:x", "ACME Corp.", "One", "7", "GigE Vision by Aravis"), True),
        (replace(CAMERA, uri="aravis:x", bus="Aravis", serial=""), True),
        (replace(CAMERA, hardware_id="00:30:53:0a:0b:0d"), False),
        (DeviceInfo("gige:10.0.0.7", bus="GigE Vision", address="10.0.0.7"), True),
        (DeviceInfo("gige:10.0.0.8", bus="GigE Vision", address="10.0.0.8"), False),
        (DeviceInfo("gige:8", "Acme", "One", "8", "GigE Vision", "10.0.0.7"), False),
        (DeviceInfo("yarp:/grabber", "Acme", "Two", "7", "YARP"), False),
    ],
)
def test_sources_of_other_kinds_lead_to_the_same_camera_or_not(other, same):
    assert is_same(CAMERA, other) is same and is_same(other, CAMERA) is same


def test_a_name_of_several_cameras_is_refused_and_one_listed_twice_is_one():
    twin = replace(CAMERA, uri="gige:10.0.0.8", hardware_id="00:30:53:0a:0b:0d")
    require_one("7", [CAMERA, CAMERA])
    require_one("7", [])
    with pytest.raises(OtherCameraError, match=r"'7' names 2 cameras: gige:7, .* and gige:10\.0\.0\.8, "):
        require_one("7", [CAMERA, twin])


def test_a_camera_is_chosen_among_those_that_answer_and_later_only_the_same_one():
    other = replace(CAMERA, uri="gige:8", serial="8", hardware_id="00:30:53:0a:0b:0d")

    def chosen(name, answering, known=None):
        return choose(name, answering, known, lambda info: info)

    assert chosen("", []) is None and chosen("7", []) is None
    assert chosen("", [other, CAMERA]) is other and chosen("7", [CAMERA]) is CAMERA
    assert chosen("", [other, CAMERA], CAMERA) is CAMERA and chosen("left", [other, CAMERA], CAMERA) is CAMERA
    assert chosen("", [other], CAMERA) is None
    with pytest.raises(OtherCameraError, match="another camera answers"):
        chosen("left", [other], CAMERA)
    with pytest.raises(OtherCameraError, match="'left' names 2 cameras"):
        chosen("left", [other, CAMERA])


def test_a_description_identifies_a_camera():
    assert describe(CAMERA) == "Acme One ('left', serial 7, 00:30:53:0a:0b:0c)"
    assert describe(DeviceInfo("gige:10.0.0.7")) == "gige:10.0.0.7"


@pytest.mark.parametrize(
    ("cameras", "names"),
    [
        ([("7", "a"), ("8", "b")], ["7", "8"]),
        ([("SN", "a"), ("sn", "b")], ["a", "b"]),
        ([("7", "8"), ("8", "b")], ["7", "b"]),
        ([("", "a", "1"), ("", "a", "2")], ["1", "2"]),
        ([("7", "7", ""), ("8", "")], ["7", "8"]),
        ([("7", "1"), ("7", "1")], ["1", "1"]),
        ([], []),
    ],
)
def test_a_camera_is_named_by_its_first_name_that_no_other_has(cameras, names):
    assert distinct_names(cameras) == names
