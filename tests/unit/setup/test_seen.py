"""What commands keep for completion."""

import json

import pytest

from grabbergui.core.features import AccessMode, EnumEntry, Feature, FeatureKind
from grabbergui.setup.seen import Seen, simulated_features

FOUND = ["gige:192.168.0.10", "u3v:SN1"]


def test_sources_are_kept_for_a_while(tmp_path):
    now = [1000.0]
    seen = Seen(tmp_path / "below" / "seen.json", lambda: now[0])
    assert seen.sources(60) is None
    seen.keep_sources(FOUND)
    assert seen.sources(60) == FOUND
    now[0] += 61
    assert seen.sources(60) is None


def test_features_are_those_of_the_source_or_of_the_simulated_camera(tmp_path):
    seen = Seen(tmp_path / "seen.json")
    seen.keep_features("gige:GV01", ["GainRaw"])
    seen.keep_sources(FOUND)
    assert seen.features("gige:GV01") == ["GainRaw"]
    assert seen.features("gige:GV02") == simulated_features()
    assert {"ExposureTime", "Gain", "TriggerSoftware"} <= set(simulated_features())


def test_no_more_than_twenty_cameras_are_kept(tmp_path):
    seen = Seen(tmp_path / "seen.json")
    for number in range(25):
        seen.keep_features(f"gige:{number}", [f"Feature{number}"])
    kept = json.loads(seen.file.read_text())["features"]
    assert list(kept) == [f"gige:{number}" for number in range(5, 25)]


@pytest.mark.parametrize(
    "content", ["", "[]", "{", '{"sources": 3, "features": []}', '{"features": {"a": 1}}']
)
def test_a_damaged_file_is_as_none(tmp_path, content):
    seen = Seen(tmp_path / "seen.json")
    seen.file.write_text(content)
    assert seen.sources(60) is None
    assert seen.features("a") == simulated_features()
    seen.keep_features("a", ["Gain"])
    assert seen.features("a") == ["Gain"]


def test_a_folder_that_cannot_be_written_is_no_failure(tmp_path):
    (tmp_path / "file").touch()
    seen = Seen(tmp_path / "file" / "seen.json")
    seen.keep_sources(FOUND)
    assert seen.sources(60) is None


def test_the_values_of_enumerations_and_switches_are_kept(tmp_path):
    seen = Seen(tmp_path / "seen.json")
    entries = (EnumEntry("Fast"), EnumEntry("Slow", available=False), EnumEntry("Auto"))
    mode = Feature(name="Mode", kind=FeatureKind.ENUMERATION, access=AccessMode.READ_WRITE, entries=entries)
    mirror = Feature(name="ReverseX", kind=FeatureKind.BOOLEAN, access=AccessMode.READ_WRITE, value=True)
    gain = Feature(name="Gain", kind=FeatureKind.FLOAT, access=AccessMode.READ_WRITE, value=1.0)
    seen.keep_values("gige:GV01", [mode, gain])
    seen.keep_values("gige:GV01", [mirror])
    assert seen.values("gige:GV01", "Mode") == ["Fast", "Auto"]
    assert seen.values("gige:GV01", "ReverseX") == ["true", "false"]
    assert seen.values("gige:GV01", "Gain") == []
    assert seen.values("gige:GV02", "ExposureAuto") == ["Off", "Once", "Continuous"]
