"""Settings as other programs leave them: their characters, their blanks, their formats; large ones."""

import time

import pytest

from fakes import ScriptedGrabber
from grabbergui.core.errors import UsageError
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.core.settings import SettingKey
from grabbergui.models.settings import files
from grabbergui.models.settings.feature_set import FeatureSet
from grabbergui.models.settings.loading import SettingOutcome, load_onto

PERSISTENT = (
    "# {05D8C294-F295-4dfb-9D01-096BD04049F4}\n# Device = Kamera für 20 °C\nGain\t2\nDeviceUserID\tTür\n"
)


@pytest.mark.parametrize(
    "encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "latin-1", "cp1252"]
)
@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_a_file_in_any_encoding_loses_no_setting(tmp_path, encoding, ends):
    (path := tmp_path / "x.pfs").write_bytes(PERSISTENT.replace("\n", ends).encode(encoding))
    read = files.load(path)
    assert read.settings == {SettingKey("Gain"): "2", SettingKey("DeviceUserID"): "Tür"}
    assert read.device == "Kamera für 20 °C" and not read.lost_lines


def test_one_byte_of_latin_1_costs_no_yaml(tmp_path):
    (path := tmp_path / "x.yaml").write_bytes(b"# 20 \xb0C\nfeatures:\n  Gain: 2\n")
    assert files.load(path).settings == {SettingKey("Gain"): 2}


@pytest.mark.parametrize("content", [b"\x89PNG\xff\x00", b"\xff\xfe\x00", b"PK\3\4\0\0", bytes(range(256))])
def test_what_is_no_text_is_refused(tmp_path, content):
    (path := tmp_path / "x.pfs").write_bytes(content)
    with pytest.raises(UsageError, match=r"it is not text|neither GenICam's"):
        files.load(path)


def test_blanks_behind_a_value_are_not_part_of_it():
    read = files.parse(
        "# {05D8C294-F295-4dfb-9D01-096BD04049F4}\nGainSelector\tAll  \nGain\t2 \r\n"
        "GainSelector\tRed \nGain \t3\nGainAuto\tOff   \n",
        "x.pfs",
    )
    assert {str(key): value for key, value in read.settings.items()} == {
        "Gain[GainSelector=All]": "2",
        "Gain[GainSelector=Red]": "3",
        "GainAuto": "Off",
    }


def test_a_selection_that_no_camera_has_costs_its_settings_alone():
    text = PERSISTENT + "GainSelector\tAl,\nGain\t3\nGainSelector\tRed\nGain\t4\n"
    read = files.parse(text, "x.pfs", lambda name: ("GainSelector",) if name == "Gain" else ())
    assert read.settings[SettingKey("Gain", (("GainSelector", "Red"),))] == "4" and len(read) == 3
    assert read.lost_lines == ("x.pfs: Gain with GainSelector=Al,, which is no entry of a selector",)


@pytest.mark.parametrize(
    ("text", "name"),
    [
        (
            '<?xml version="1.0" encoding="UTF-8"?>\n<CameraSettings CameraID="DEV_1">\n</CameraSettings>\n',
            "Vimba",
        ),
        ("[Versions]\nueye_api.dll=4.96.0\n[Sensor]\nSensor=UI324xCP-M\n[Timing]\nPixelclock=43\n", "uEye"),
        ("[General]\nCamera Name=x\n[Board]\nVersion=1\n[Stream Conditioning]\nCrop=0\n", "Sapera"),
        ('{\n "device": {}, "properties": [] }', "The Imaging Source"),
        ('<?xml version="1.0"?>\n<propertyList name="Device"/>\n', "mvIMPACT"),
        ('<?xml version="1.0"?>\n<something/>\n', "is XML, which"),
        ('{"Gain": 1}\n', "is JSON, which"),
    ],
)
def test_another_format_is_refused_by_its_name(text, name):
    with pytest.raises(UsageError, match=rf"his.file .*{name}.*save the settings in GenICam's format"):
        files.parse(text, "his.file")


def test_a_file_of_too_many_lines_is_refused_at_once():
    begun = time.process_time()
    with pytest.raises(UsageError, match="300001 lines, but a file of settings at most 100000"):
        files.parse("features:\n" + "".join(f"  U{i}: 1\n" for i in range(300_000)), "x.yaml")
    assert time.process_time() - begun < 2


def test_thousands_of_selectors_take_no_time():
    lines = [f"S{i}Selector\tA\nX{i}\t1\nX{i}\t2\n" for i in range(5_000)]
    begun = time.process_time()
    read = files.parse("# {05D8C294-F295-4dfb-9D01-096BD04049F4}\n" + "".join(lines), "x.pfs")
    assert len(read.settings) == 10_000
    assert time.process_time() - begun < 2


def test_thousands_of_unknown_settings_take_no_time():
    grabber = ScriptedGrabber(
        Feature(name=f"Feature{i}", kind=FeatureKind.INTEGER, access=AccessMode.READ_WRITE, value=1)
        for i in range(100)
    )
    wanted = {SettingKey(f"Featura{i}"): 1 for i in range(10_000)}
    begun = time.process_time()
    report = load_onto(grabber, FeatureSet(wanted), dry_run=True)
    assert report.count(SettingOutcome.UNKNOWN) == 10_000
    assert "did you mean" in report.settings[0].reason and not report.settings[-1].reason
    assert time.process_time() - begun < 2
