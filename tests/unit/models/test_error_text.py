"""Texts of errors and features: as they are written, and in the user's language."""

import re
from pathlib import Path

import pytest

import grabbergui
from grabbergui.core.errors import (
    AccessDeniedError,
    AckTimeoutError,
    DeviceStatusError,
    FeatureAccessError,
    FeatureNotFoundError,
    FeatureValueError,
    GrabberError,
    OtherCameraError,
    SourceNotFoundError,
    UsageError,
)
from grabbergui.core.features import AccessMode, EnumEntry, Feature, FeatureKind
from grabbergui.models import language
from grabbergui.models.error_text import error_text, held_text, lost_text
from grabbergui.models.features.feature_text import access_text, range_text
from grabbergui.models.language import set_translator

WIDTH = Feature(name="Width", kind=FeatureKind.INTEGER, access=AccessMode.READ_ONLY, value=64, minimum=16,
                maximum=2448, increment=16, unit="px")  # fmt: skip
KINDS = [
    WIDTH,
    Feature(name="Gain", kind=FeatureKind.FLOAT, access=AccessMode.READ_WRITE, minimum=0.0, maximum=24.5,
            unit="dB"),
    Feature(name="Any", kind=FeatureKind.FLOAT, access=AccessMode.NOT_IMPLEMENTED),
    Feature(name="On", kind=FeatureKind.BOOLEAN, access=AccessMode.NOT_AVAILABLE),
    Feature(name="Mode", kind=FeatureKind.ENUMERATION, access=AccessMode.WRITE_ONLY,
            entries=(EnumEntry("Off"), EnumEntry("Once"), EnumEntry("Gone", available=False))),
    Feature(name="Name", kind=FeatureKind.STRING, access=AccessMode.READ_WRITE, maximum_length=16),
    Feature(name="Note", kind=FeatureKind.STRING, access=AccessMode.NOT_AVAILABLE, problem="X has no Value"),
]  # fmt: skip


@pytest.fixture
def foreign():
    """A language in which every sentence is marked, and its placeholders are the same."""
    set_translator(lambda context, text: f"<{text}>")
    yield
    set_translator(None)


@pytest.mark.parametrize("feature", KINDS, ids=lambda feature: feature.name)
def test_as_written_a_feature_is_worded_as_everywhere_else(feature):
    assert range_text(feature) == feature.range_text()
    assert access_text(feature) == feature.access_problem()


def test_units_are_written_in_their_usual_form():
    exposure = Feature(name="ExposureTime", kind=FeatureKind.FLOAT, access=AccessMode.READ_WRITE,
                       minimum=10.0, maximum=1e6, unit="us")  # fmt: skip
    assert range_text(exposure) == "10 … 1000000 µs"


def test_in_the_language_they_are_written_in_errors_speak_for_themselves():
    error = SourceNotFoundError("no GigE Vision camera answers to 'X'; found: gige:GV01")
    assert error_text(error, "gige:X") == str(error)
    assert lost_text("GV01", "the cable was pulled") == "the cable was pulled"
    assert lost_text("GV01", "") == "the connection to GV01 was lost"
    assert held_text(AccessDeniedError("another one at 10.0.0.5")) == "another one at 10.0.0.5"


@pytest.mark.parametrize(
    ("error", "source", "feature", "reported"),
    [
        (FeatureValueError("Width=7: out of range", "Width"), "", WIDTH,
         "<Width does not take this value; allowed: <16 … 2448 px, step 16>>"),
        (FeatureAccessError("Width is locked", "Width"), "", WIDTH,
         "Width <is read-only; streaming or another feature may lock it>"),
        (FeatureNotFoundError("no Gamma", "Gamma"), "", None, "<the camera has no Gamma>"),
        (FeatureValueError("Gain=x: no number", "Gain"), "", None, "<Gain was refused: Gain=x: no number>"),
        (OtherCameraError("two"), "gige:7", None,
         "<gige:7 may be another camera than the one you named: two>"),
        (SourceNotFoundError("nobody"), "gige:7", None,
         "<gige:7 was not found; check address, power and cable>"),
        (AckTimeoutError("3 tries"), "gige:7", None,
         "<gige:7 does not answer; check address, power and cable>"),
        (AckTimeoutError("3 tries"), "", None, "<the camera does not answer: 3 tries>"),
        (AccessDeniedError("held by A"), "u3v:7", None, "<no access to u3v:7: held by A>"),
        (DeviceStatusError("busy", 0x8005), "", None, "<the camera refused it: busy>"),
        (UsageError("no scheme"), "", None, "<this cannot be understood: no scheme>"),
        (GrabberError("something else"), "", None, "something else"),
    ],
)  # fmt: skip
def test_in_another_language_the_commonest_are_worded_by_their_kind(
    foreign, error, source, feature, reported
):
    assert error_text(error, source, feature) == reported


def test_a_lost_or_held_source_in_another_language(foreign):
    assert lost_text("GV01", "no answer") == "<the connection to GV01 was lost>: no answer"
    assert held_text(AccessDeniedError("x")) == "<another application controls it>"


def test_every_known_sentence_is_still_used():
    root = Path(grabbergui.__file__).parent
    rooms = ("driver", "net", "core", "calibration", "recording", "rig")
    files = [path for room in rooms for path in (root / room).rglob("*.py")]
    files.append(root / "sources.py")
    sources = re.sub(r'"\s*\n\s*f?"', "", "\n".join(path.read_text("utf-8") for path in files))
    for template in language.SENTENCES:
        parts = sorted(re.split(r"\{\d\}(?: s)?|; ", template), key=len)[-2:]
        assert any(len(part) > 7 and part.strip(" ,(") in sources for part in parts), template


def test_drivers_sentences_are_translated_with_those_within_them(foreign):
    set_translator(lambda context, text: f"<{text}>", ",")
    sentence = "the camera is lost: the camera did not answer for 1.5 s"
    expected = "<the camera is lost: <the camera did not answer for 1,5 s>>"
    assert language.driver_text(sentence) == expected
    assert lost_text("GV01", sentence) == f"<the connection to GV01 was lost>: {expected}"
    held = "another application at 10.0.0.2 controls GV01 (10.0.0.1); close it there"
    assert language.driver_text(held) == f"<{held}>"
    assert language.driver_text("Gain is 6.5 instead of 0") == "<Gain is 6,5 instead of 0>"
    path = "/media/full/run.mcap could not be created: Read-only file system; choose another folder or name"
    assert language.driver_text(path) == f"<{path}>"
    assert error_text(UsageError("'/a.mp4' is no source; did you mean file:/a.mp4?")) == (
        "<this cannot be understood: <'/a.mp4' is no source; did you mean file:/a.mp4?>>"
    )
    assert language.driver_text("nobody has heard of this") == "nobody has heard of this"


def test_a_very_long_text_of_a_remote_peer_stays_as_it_is(foreign):
    endless = "the camera is lost: " * 10_000
    assert language.driver_text(endless) == endless, "it exceeded the recursion limit"
