"""Settings files: written whole, read back, of other viewers, hostile; no camera."""

import operator
import os
import string
from concurrent.futures import ThreadPoolExecutor

import pytest
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from fakes import ScriptedGrabber
from grabbergui.core.errors import MissingFileError, UsageError
from grabbergui.core.features import AccessMode, Feature, FeatureKind, Representation
from grabbergui.core.settings import SettingKey, same_value
from grabbergui.models.settings import files
from grabbergui.models.settings.feature_set import FeatureSet, capture, compare
from grabbergui.models.settings.loading import load_onto
from patience import PATIENCE

# A file of pylon's, cut short: the names of older cameras, a selector put back at its end.
PYLON = (
    "# {05D8C294-F295-4dfb-9D01-096BD04049F4}\r\n"
    "# GenApi persistence file (version 3.1.0)\r\n"
    "# Device = Basler::GigECamera -- Basler generic GigEVision camera interface\r\n"
    "GainAuto\tOff\r\nGainSelector\tAll\r\nGainRaw\t136\r\nBlackLevelSelector\tAll\r\nBlackLevelRaw\t32\r\n"
    "BalanceRatioSelector\tRed\r\nBalanceRatioRaw\t64\r\nBalanceRatioSelector\tGreen\r\n"
    "BalanceRatioRaw\t70\r\nBalanceRatioSelector\tRed\r\nReverseX\t0\r\nDeviceUserID\ta\tb \r\n"
)


def test_a_file_of_other_viewers_is_read():
    read = files.parse(PYLON, "x")
    assert read.device.startswith("Basler::GigECamera")
    named = {str(key): value for key, value in read.settings.items()}
    assert named["GainRaw"] == "136"
    assert named["BalanceRatioRaw[BalanceRatioSelector=Green]"] == "70"
    assert named["BalanceRatioRaw[BalanceRatioSelector=Red]"] == "64" or "BalanceRatioRaw" in named
    assert named["DeviceUserID"] == "a\tb"


HOSTILE = {
    "nothing": "",
    "prose": "Dear camera,\nplease be brighter.\n",
    "several user sets": "# {4709CB3C-7322-4460-84C3-DA11DDA09939}\n[Default]\n",
    "no tabulator": "# {05D8C294-F295-4dfb-9D01-096BD04049F4}\nWidth 640\n",
    "a tag": "features:\n  Width: !!python/object:os.system 1\n",
    "a list": "features:\n  Width: [1, 2]\n",
    "no end": 'features:\n  Width: "640\n',
    "half a selector": "features:\n  Gain[All]: 1\n",
    "no name": "features:\n  [Gain]: 1\n",
    "a reference": "features: *other\n",
    "in one line": "features: {Width: 640}\n",
    "nested": "features:\n  Gain: {a: {b: {}}}\n",
}


@every_case("text", HOSTILE.values(), ids=HOSTILE)
def test_hostile_files_are_refused_with_their_name(text):
    with pytest.raises(UsageError, match=r"evil\.txt"):
        files.parse(text, "evil.txt")


def test_binary_and_huge_files_are_refused(tmp_path):
    (tmp_path / "binary").write_bytes(b"\x89PNG\xff\x00")
    (tmp_path / "huge").write_bytes(b"#" * (files.MAX_FILE_BYTES + 1))
    for name in ("binary", "huge"):
        with pytest.raises(UsageError, match=name):
            files.load(tmp_path / name)
    with pytest.raises(files.SettingsFileError):
        files.load(tmp_path)
    with pytest.raises(MissingFileError, match="no folder"):
        files.save(FeatureSet({}), tmp_path / "nowhere" / "x.yaml")


def test_only_settings_are_overwritten(tmp_path):
    path = tmp_path / "x.yaml"
    for value in (1, 2):
        files.save(FeatureSet({SettingKey("Width"): value}), path)
    assert files.load(path).settings == {SettingKey("Width"): 2}
    path.write_text("my diary\n")
    with pytest.raises(UsageError):
        files.save(FeatureSet({}), path)
    assert path.read_text() == "my diary\n"


def test_a_reader_during_saving_sees_the_old_file_whole(tmp_path):
    path = tmp_path / "settings.yaml"
    files.save(FeatureSet({SettingKey("Width"): 64}), path)
    before = path.read_text()
    with path.open() as reader:
        files.save(FeatureSet({SettingKey("Width"): 128}), path)
        assert reader.read() == before
    assert path.read_text() != before
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_stays_a_link(tmp_path):
    link, kept = tmp_path / "current.yaml", tmp_path / "kept.yaml"
    kept.touch()
    link.symlink_to(kept)
    files.save(FeatureSet({SettingKey("Width"): 1}), link)
    assert link.is_symlink()
    assert files.load(kept).settings == {SettingKey("Width"): 1}


def test_a_pipe_is_written_to_not_replaced(tmp_path):
    pipe = tmp_path / "pipe.yaml"
    os.mkfifo(pipe)
    with ThreadPoolExecutor(1) as pool:
        written = pool.submit(pipe.read_text)
        files.save(FeatureSet({SettingKey("Width"): 1}), pipe)
        assert "Width: 1" in written.result(PATIENCE)
    assert pipe.is_fifo()


LETTERS = string.ascii_letters + "_"
NAMES = st.builds(operator.add, st.sampled_from(LETTERS), st.text(LETTERS + string.digits, max_size=12))
ENTRIES = st.text(LETTERS + string.digits, min_size=1, max_size=12)
VALUES = st.one_of(
    st.booleans(),
    st.integers(-(2**63), 2**63 - 1),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(max_size=40),
)
KEYS = st.builds(SettingKey, NAMES, st.lists(st.tuples(NAMES, ENTRIES), max_size=2).map(tuple))


@given(st.dictionaries(KEYS, VALUES, max_size=8), st.text(max_size=30))
def test_yaml_keeps_every_value(settings, device):
    read = files.parse(files.to_yaml(FeatureSet(settings, device)), "x")
    assert read.device == device
    assert list(read.settings) == list(settings)
    assert all(
        type(read.settings[key]) is type(value) and read.settings[key] == value
        for key, value in settings.items()
    )


@given(st.text(max_size=300))
def test_any_text_is_a_set_or_refused(text):
    for start in ("", "# {05D8C294-F295-4dfb-9D01-096BD04049F4}\n", "features:\n  "):
        try:
            files.parse(start + text, "x")
        except UsageError as error:
            assert "x" in str(error)


def test_values_mean_the_same_however_they_are_written():
    assert same_value(True, "1")
    assert same_value("0x10", 16)
    assert same_value(10000.0, "10000")
    assert same_value(0.1, "0.1000000")
    assert not same_value(2**63 - 1, 2**63 - 2)
    assert not same_value("On", "Off")


@pytest.mark.parametrize("text", ["no", "No", "off", "Off", "OFF", "false", "False", "0", " no "])
def test_a_switch_in_a_file_is_compared_by_its_meaning(text):
    assert same_value(False, text)
    assert same_value(text, False)
    assert not same_value(True, text)


@pytest.mark.parametrize("text", ["maybe", "", "2", "Continuous"])
def test_other_words_are_no_switch(text):
    assert not same_value(False, text)
    assert not same_value(True, text)


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (0xC0A8000A, "192.168.0.10"),
        (0x00111C012345, "00:11:1c:01:23:45"),
        (0x00111C012345, "00-11-1C-1-23-45"),
        (31, "0x1f"),
    ],
)
def test_addresses_are_compared_by_their_numbers(number, text):
    assert same_value(number, text)
    assert not same_value(number + 1, text)


def test_a_switch_that_a_file_calls_no_is_loaded_without_a_difference():
    switch = Feature(name="ReverseX", kind=FeatureKind.BOOLEAN, access=AccessMode.READ_WRITE, value=True)
    camera = ScriptedGrabber([switch])
    report = load_onto(camera, files.parse("features:\n  ReverseX: no\n", "x.yaml"))
    assert report.settled
    assert camera.known["ReverseX"].value is False


@pytest.mark.parametrize(
    ("representation", "number", "text"),
    [
        (Representation.IPV4_ADDRESS, 0xC0A8000A, "192.168.0.10"),
        (Representation.MAC_ADDRESS, 0x00111C012345, "00:11:1C:01:23:45"),
        (Representation.HEX_NUMBER, 0x1F, "0x1F"),
    ],
)
@pytest.mark.parametrize("suffix", [".yaml", ".txt"])
def test_coded_numbers_are_saved_and_loaded_in_their_own_spelling(
    representation, number, text, suffix, tmp_path
):
    feature = Feature(
        name="Odd",
        kind=FeatureKind.INTEGER,
        access=AccessMode.READ_WRITE,
        value=number,
        minimum=0,
        maximum=2**48 - 1,
        representation=representation,
        streamable=True,
    )
    camera, file = ScriptedGrabber([feature]), tmp_path / f"camera{suffix}"
    files.save(capture(camera), file)
    assert text in file.read_text()

    camera.set("Odd", 0)
    report = load_onto(camera, files.load(file, camera.selectors.of))
    assert report.settled
    assert camera.known["Odd"].value == number
    assert not compare(capture(camera), files.load(file, camera.selectors.of))
