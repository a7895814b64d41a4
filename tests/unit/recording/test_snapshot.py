"""Snapshots: files that read back equal, and never one over another."""

import json
import re
import resource

import cv2
import numpy as np
import pytest

from grabbergui.core import pfnc
from grabbergui.core.errors import GrabberError
from grabbergui.core.frame import Frame
from grabbergui.core.identity import DeviceInfo
from grabbergui.recording.snapshot import SnapshotKind, SnapshotWriter, save
from patience import PATIENCE

INFO = DeviceInfo("gige:GV01", vendor="Acme", model="One/2 µ", serial="GV01")
MOMENT = 1_790_000_000.125


def random_frame(name, width=34, height=22):
    pixel_format = pfnc.by_name(name)
    size = pixel_format.image_bytes(width, height)
    payload = np.random.default_rng(1).integers(0, 256, size, np.uint8)
    if pixel_format.depth in (10, 12, 14) and pixel_format.bits_per_pixel == 16:
        payload[1::2] &= (1 << pixel_format.depth - 8) - 1
    return Frame(payload, width, height, pixel_format, 5)


@pytest.mark.parametrize("name", ["Mono8"])
def test_eight_bits_become_a_png_with_the_sensors_values(tmp_path, name):
    frame = random_frame(name)
    path = save(frame, tmp_path / "new folder", INFO, MOMENT)
    assert path.suffix == ".png"
    assert np.array_equal(cv2.imread(str(path), cv2.IMREAD_UNCHANGED), frame.raw())


@pytest.mark.parametrize("name", ["BayerRG8", "RGB8", "BGR8", "YUV422_8"])
def test_colour_becomes_a_png_as_it_is_seen(tmp_path, name):
    frame = random_frame(name)
    path = save(frame, tmp_path, INFO, MOMENT)
    assert path.suffix == ".png"
    assert np.array_equal(cv2.imread(str(path))[:, :, ::-1], frame.rgb())


@pytest.mark.parametrize(
    "name",
    ["Mono10", "Mono12", "Mono16", "Mono12p", "Mono12Packed", "BayerGB12", "Data16s", "Data32s", "Data64f"],
)
def test_deeper_formats_become_a_tiff_with_the_sensors_values(tmp_path, name):
    frame = random_frame(name)
    path = save(frame, tmp_path, INFO, MOMENT)
    assert path.suffix == ".tiff"
    back = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert back.dtype == frame.raw().dtype
    assert np.array_equal(back, frame.raw(), equal_nan=True)


@pytest.mark.parametrize("name", ["Data32", "Data64", "Data64s"])
def test_integers_too_deep_for_a_tiff_are_saved_as_bytes(tmp_path, name):
    frame = random_frame(name)
    path = save(frame, tmp_path, INFO, MOMENT)
    assert path.suffix == ".raw"
    assert path.read_bytes() == frame.payload.tobytes()


def test_a_format_of_unknown_layout_is_saved_as_bytes_with_a_description(tmp_path):
    frame = Frame(np.arange(200, dtype=np.uint8), 20, 10, pfnc.by_code(0x81090001), 5)
    path = save(frame, tmp_path, INFO, MOMENT)
    assert path.suffix == ".raw"
    assert path.read_bytes() == bytes(range(200))
    reported = json.loads(path.with_suffix(".json").read_text())
    assert (reported["width"], reported["height"], reported["bytes"]) == (20, 10, 200)
    assert reported["pixel_format_code"] == "0x81090001"
    assert reported["source"]["serial"] == "GV01"


def test_names_contain_camera_and_time_and_are_safe(tmp_path):
    path = save(random_frame("Mono8"), tmp_path, INFO, MOMENT)
    assert re.fullmatch(r"One-2-µ_GV01_\d{8}-\d{6}\.125\.png", path.name)


def test_no_file_is_overwritten(tmp_path):
    frame = random_frame("Mono8")
    paths = [save(frame, tmp_path, INFO, MOMENT) for _ in range(3)]
    assert len({path.name for path in paths}) == 3
    assert len(list(tmp_path.iterdir())) == 3


def test_a_raw_file_that_exists_keeps_its_json(tmp_path):
    frame = Frame(np.zeros(200, np.uint8), 20, 10, pfnc.by_code(0x81090001))
    for _ in range(2):
        save(frame, tmp_path, INFO, MOMENT)
    assert len(list(tmp_path.glob("*.json"))) == 2


def test_a_folder_that_cannot_be_written_is_reported(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    with pytest.raises(GrabberError, match="choose another folder"):
        save(random_frame("Mono8"), blocked, INFO)


def test_a_file_that_does_not_fit_leaves_none(tmp_path):
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, hard))  # bytes of a file, as on a disk that is full
    try:
        with pytest.raises(GrabberError, match="File too large"):
            save(random_frame("Mono8"), tmp_path, INFO, MOMENT)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert list(tmp_path.iterdir()) == []


def test_the_writer_saves_in_the_background_and_reports(tmp_path):
    writer, saved, failed = SnapshotWriter(), [], []
    writer.saved.connect(saved.append)
    writer.failed.connect(failed.append)
    frame = random_frame("Mono8")
    writer.save(frame, tmp_path, INFO)
    (tmp_path / "file").write_text("")
    writer.save(frame, tmp_path / "file", INFO)
    assert writer.wait(PATIENCE)
    assert [path.parent for path in saved] == [tmp_path]
    assert len(failed) == 1


@pytest.mark.parametrize("name", ["Mono8", "BayerRG8", "Mono12", "BayerRG12p"])
def test_as_tiff_every_format_has_the_sensors_values(tmp_path, name):
    frame = random_frame(name)
    path = save(frame, tmp_path, INFO, MOMENT, SnapshotKind.TIFF)
    assert path.suffix == ".tiff"
    assert np.array_equal(cv2.imread(str(path), cv2.IMREAD_UNCHANGED), frame.raw())


@pytest.mark.parametrize("name", ["RGB8", "BGR8", "YUV422_8"])
def test_as_tiff_colour_is_as_it_is_seen(tmp_path, name):
    frame = random_frame(name)
    path = save(frame, tmp_path, INFO, MOMENT, SnapshotKind.TIFF)
    assert path.suffix == ".tiff"
    assert np.array_equal(cv2.cvtColor(cv2.imread(str(path)), cv2.COLOR_BGR2RGB), frame.rgb())


def test_as_raw_a_frame_is_its_payload_with_a_description(tmp_path):
    frame = random_frame("BayerRG12p")
    path = save(frame, tmp_path, INFO, MOMENT, SnapshotKind.RAW)
    assert path.suffix == ".raw" and path.read_bytes() == frame.payload.tobytes()
    described = json.loads(path.with_suffix(".json").read_text())
    assert (described["pixel_format"], described["width"]) == ("BayerRG12p", 34)
