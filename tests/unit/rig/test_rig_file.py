"""A rig's file is read strictly: what is wrong is named, and what is written is read again."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui.core.errors import GrabberError, MissingFileError, UsageError
from grabbergui.rig import rig_file
from grabbergui.rig.rig_file import CameraEntry, FollowEntry, LinkEntry, RigEntry, TriggerEntry

FULL = """
rig: 1
cameras:
  left: gige:GV01
  right:
    source: gige:GV02
    settings: {ExposureTime: 5000, "Gain[GainSelector=Red]": 2.5}
clock: ptp
match: action
tolerance: 2ms
deadline: 0.05
wait: 1.5s
missing: drop
trigger: {by: action, rate: 12.5, align: middle, group_key: 0x10, ahead: 20ms}
link: {rate: 125MB, share: 0.8, buffer: 256kB}
follow:
  leader: left
  features: [ExposureTime]
  factors: {right: 1.2}
  limits: {right: [10, 20000]}
"""
READ = RigEntry(
    {
        "left": CameraEntry("gige:GV01"),
        "right": CameraEntry("gige:GV02", {"ExposureTime": 5000, "Gain[GainSelector=Red]": 2.5}),
    },
    clock="ptp",
    match="action",
    tolerance=0.002,
    deadline=0.05,
    wait=1.5,
    missing="drop",
    trigger=TriggerEntry("action", 12.5, "middle", group_key=16, ahead=0.02),
    link=LinkEntry(125e6, 0.8, 256e3),
    follow=FollowEntry("left", ("ExposureTime",), {"right": 1.2}, {"right": (10, 20000)}),
)


def test_all_keys_are_read_and_written():
    assert rig_file.parse(FULL) == READ
    assert rig_file.parse(rig_file.to_text(READ)) == READ


def test_what_has_its_default_is_not_written(tmp_path):
    path = tmp_path / "stereo.yaml"
    rig = rig_file.of_sources({"left": "sim:", "right": "sim:colour"})
    rig_file.write(path, rig)
    assert path.read_text() == "rig: 1\ncameras:\n  left: 'sim:'\n  right: sim:colour\n"
    assert rig_file.read(path) == rig


@every_case(
    ("old", "new", "problem"),
    [
        ("clock: ptp", "clocks: ptp", "there is no key clocks; did you mean clock?"),
        ("    source: gige:GV02", "    sorce: gige:GV02", "no key cameras.right.sorce; did you mean source?"),
        ("by: action", "bye: action", "there is no key trigger.bye"),
        ("buffer:", "bufer:", "there is no key link.bufer; did you mean buffer?"),
        ("clock: ptp", "clock: gps", "clock: 'gps' is not allowed; write auto or ptp or fitted or host"),
        ("tolerance: 2ms", "tolerance: 2 weeks", "write a duration from 0 to 3600s, such as 5ms"),
        ("share: 0.8", "share: 80", "link.share: 80 is not allowed; write a number from 0.01 to 1"),
        ("rate: 125MB", "rate: fast", "link.rate: 'fast' is not allowed; write bytes"),
        ("leader: left", "leader: middle", "follow.leader: there is no camera middle; there are left, right"),
        ("  left: gige:GV01", "  le ft: gige:GV01", "'le ft' cannot be a camera's name"),
        ("rig: 1", "rig: 2", "rig: 2 is not allowed"),
        ("[10, 20000]", "[20000, 10]", "follow.limits.right"),
        ("factors: {right: 1.2}", "factors: {right: x}", "follow.factors.right: 'x' is not allowed"),
        ("missing: drop", "missing: drop\nmissing: stop", "line 14 is not YAML: missing is there twice"),
        ("missing: drop", "missing: [", "is not YAML"),
        ("missing: drop", "missing: &a drop\nclok: *a", "aliases are not allowed"),
    ],
)
def test_a_wrong_key_or_value_is_named(old, new, problem):
    assert old in FULL
    with pytest.raises(UsageError) as refusal:
        rig_file.parse(FULL.replace(old, new, 1), "stereo.yaml")
    assert problem in str(refusal.value) and str(refusal.value).startswith("stereo.yaml")


@pytest.mark.parametrize(
    "text", ["", "cameras: {}", "cameras: 3", "[]", "cameras: {a: {}}", "cameras: {a: 3}"]
)
def test_a_rig_has_cameras(text):
    with pytest.raises(UsageError):
        rig_file.parse(text)


def test_a_missing_file_says_how_to_make_one(tmp_path):
    with pytest.raises(MissingFileError, match="rig new"):
        rig_file.read(tmp_path / "none.yaml")


@given(st.text(max_size=60) | st.binary(max_size=60).map(lambda data: data.decode("latin-1")))
def test_no_text_gives_anything_but_a_rig_or_a_usage_error(text):
    try:
        assert isinstance(rig_file.parse(text), RigEntry)
    except GrabberError as error:
        assert isinstance(error, UsageError)
