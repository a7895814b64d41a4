"""One file for all frames: TIFF with pages and NumPy arrays, read by others, and theirs read here."""

import contextlib
import json

import cv2
import numpy as np
import PIL.Image
import pytest

from grabbergui.cli import main
from grabbergui.core.errors import UsageError
from grabbergui.recording import stack_writer
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.kinds import RecordingKind
from grabbergui.recording.opening import open_recording, playable_frames
from grabbergui.recording.recorder import create_writer
from recorded_frames import INFO, START, STEP, made, written

SMALL = "sim:?width=64&height=48&fps=100"


def played(path):
    with contextlib.closing(open_recording(path)) as recording:
        return [recording.frame(index, 0) for index in range(len(recording))]


@pytest.mark.parametrize("name", ["Mono8", "Mono12", "RGB8", "RGBa8", "BGR8", "BayerRG8", "Data16s"])
def test_a_tiff_is_what_opencv_and_pillow_read(tmp_path, name):
    frames = [made(name, index) for index in range(3)]
    path = written(RecordingKind.STACK, tmp_path / "x.tiff", frames)
    with PIL.Image.open(path) as image:
        assert image.n_frames == 3
    done, pages = cv2.imreadmulti(str(path), flags=cv2.IMREAD_UNCHANGED)
    assert done and len(pages) == 3
    for page, frame in zip(pages, frames, strict=True):
        if page.ndim == 2:
            assert np.array_equal(page, frame.raw())
        elif page.shape[2] == 3:
            assert np.array_equal(page[..., ::-1], frame.rgb())


@pytest.mark.parametrize("name", ["Mono8", "Mono12", "BGR8", "YUV422_8", "Coord3D_C32f"])
def test_an_array_is_what_numpy_loads(tmp_path, name):
    frames = [made(name, index) for index in range(4)]
    path = written(RecordingKind.NUMPY, tmp_path / "x.npy", frames)
    array = np.load(path)
    raw = np.array([frame.raw() for frame in frames])
    assert np.array_equal(array, raw[..., ::-1] if name == "BGR8" else raw, equal_nan=raw.dtype.kind == "f")
    with contextlib.closing(open_recording(path)) as recording:
        assert np.diff(recording.times_ns).tolist() == [STEP] * 3 and recording.times_ns[0] == START
        assert recording.frame(2, 0).frame_id == 9
    (tmp_path / "x.frames.jsonl").unlink()
    if name not in ("YUV422_8",):
        assert len(played(path)) == 4


@pytest.mark.parametrize(
    ("array", "count", "name"),
    [
        (np.zeros((5, 6, 8), np.uint8), 5, "Mono8"),
        (np.zeros((6, 8), np.uint16), 1, "Mono16"),
        (np.zeros((6, 8, 3), np.uint8), 1, "RGB8"),
        (np.zeros((2, 6, 8, 3), np.uint16), 2, "RGB16"),
        (np.zeros((2, 6, 8, 4), np.uint8), 2, "RGBa8"),
        (np.ones((2, 6, 8), ">f4"), 2, "Coord3D_C32f"),
        (np.ones((2, 6, 8), np.float64), 2, "Data64f"),
    ],
)
def test_arrays_of_others_are_played(tmp_path, array, count, name):
    np.save(tmp_path / "x.npy", array)
    frames = played(tmp_path / "x.npy")
    assert len(frames) == count and frames[0].pixel_format.name == name
    assert np.array_equal(frames[0].raw(), array.reshape(count, *frames[0].raw().shape)[0])


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (np.zeros((2, 6, 8), bool), "an array of [|]b1, not of numbers"),
        (np.zeros((2, 6, 8), complex), "of <c16, not of numbers"),
        (np.zeros(5), "of the shape"),
        (np.zeros((2, 3, 4, 5, 6)), "of the shape"),
        (np.zeros((0, 6, 8)), "holds no frames"),
        (np.zeros((2, 0, 8)), "of the shape"),
        (np.zeros((2, 6, 8, 2), np.uint8), "cannot be shown"),
        (np.asfortranarray(np.zeros((2, 6, 8))), "Fortran"),
        (np.array([{}, []], object), "an array of [|]O, not of numbers"),
    ],
)
def test_other_arrays_are_refused(tmp_path, array, message):
    np.save(tmp_path / "x.npy", array, allow_pickle=True)
    with pytest.raises(UsageError, match=message):
        open_recording(tmp_path / "x.npy")


def test_hostile_arrays_are_refused(tmp_path):
    path = tmp_path / "x.npy"
    np.save(path, np.zeros((3, 6, 8), np.uint8))
    good = path.read_bytes()
    for content in (
        b"",
        b"PK\3\4",
        good[:30],
        good.replace(b"(3, 6, 8)", b"(3,-6, 8)"),
        good.replace(b"(3, 6, 8)", b"[3, 6, 8]"),
        good.replace(b"'|u1'", b"'|O8'"),
        b"\x93NUMPY\x02\x00\xff\xff\xff\xff" + b"(" * 100_000,
    ):
        path.write_bytes(content)
        with pytest.raises(UsageError, match=r"x\.npy"):
            open_recording(path)
    path.write_bytes(good.replace(b"(3, 6, 8), }        ", b"(3, 6, 8000000000), }"[:20].ljust(20)))
    with pytest.raises(UsageError):
        open_recording(path)
    path.write_bytes(good[:-10])
    assert len(played(path)) == 2


@pytest.mark.parametrize(("kind", "name"), [(RecordingKind.STACK, "x.tiff"), (RecordingKind.NUMPY, "x.npy")])
def test_a_file_is_readable_after_each_frame(tmp_path, kind, name):
    """As after a crash: the writer is not closed."""
    writer = create_writer(kind, tmp_path / name, INFO)
    for index in range(5):
        writer.write(made("Mono8", index))
        assert playable_frames(tmp_path / name) == index + 1
    writer.close()


def test_a_tiff_that_is_full_ends_the_recording(tmp_path, monkeypatch):
    monkeypatch.setattr(stack_writer, "_LARGEST_TIFF", 5000)
    writer = create_writer(RecordingKind.STACK, tmp_path / "x.tiff", INFO)
    with pytest.raises(RecordingError, match=r"at most 4 GiB; record a folder or \.npy"):
        for index in range(9):
            writer.write(made("Mono8", index))
    writer.close()
    assert len(played(tmp_path / "x.tiff")) == 2


def test_an_array_cannot_change_its_size(tmp_path):
    writer = create_writer(RecordingKind.NUMPY, tmp_path / "x.npy", INFO)
    writer.write(made("Mono8", 0))
    with pytest.raises(RecordingError, match=r"size or format changed; an array cannot follow, \.mcap can"):
        writer.write(made("Mono8", 1, 64, 32))
    writer.close()
    assert np.load(tmp_path / "x.npy").shape == (1, 32, 48)


@pytest.mark.parametrize("command", ["record", "grab"])
@pytest.mark.parametrize("name", ["a.npy", "a.tiff"])
def test_out_does_what_its_ending_says(tmp_path, capsys, command, name):
    path = tmp_path / name
    assert main([command, SMALL, "--out", str(path), "-n", "3", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["frames"] == 3
    assert path.is_file() and len(played(path)) == 3
    if name == "a.npy":
        assert np.load(path).shape == (3, 48, 64)


@pytest.mark.parametrize("command", ["record", "grab"])
def test_out_makes_no_folder_of_the_name_of_an_image(tmp_path, capsys, command):
    assert main([command, SMALL, "--out", str(tmp_path / "a.png"), "-n", "1"]) == 2
    assert "recordings are .mp4, .mcap, .tiff, .npy, or a folder" in capsys.readouterr().err
    assert not (tmp_path / "a.png").exists()
