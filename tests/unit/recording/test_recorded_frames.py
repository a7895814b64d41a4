"""Frames that are written and read back: equal, under a name that was free."""

import contextlib
import os
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grabbergui.core import pfnc
from grabbergui.core.errors import ExistingFileError, GrabberError, UsageError
from grabbergui.core.frame import Frame, FrameStatus
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.kinds import RecordingKind, kind_of
from grabbergui.recording.notes import MAX_LINE, parse_note
from grabbergui.recording.opening import open_recording
from grabbergui.recording.recorder import create_writer
from grabbergui.recording.stored_frames import note_of
from recorded_frames import INFO, NAMES, START, STEP, made, written


@pytest.mark.parametrize("suffix", ["", ".mcap", ".mp4"])
def test_a_name_too_long_for_the_disk_is_a_recording_error(tmp_path, suffix):
    path = tmp_path / ("x" * 300 + suffix)
    with pytest.raises(RecordingError, match="could not be created: File name too long; choose another"):
        create_writer(kind_of(path), path, INFO)


def unpacked_name(name):
    return name.removesuffix("Packed").removesuffix("p")


EXACT = [
    (kind, name)
    for kind in (RecordingKind.PNG, RecordingKind.TIFF, RecordingKind.MCAP)
    for name in (
        "Mono8",
        "Mono12",
        "Mono12p",
        "Mono10Packed",
        "BayerRG8",
        "BayerGB16",
        "RGB8",
        "BGR8",
        "YUV422_8",
    )
] + [
    *(
        (kind, name)
        for kind in (RecordingKind.STACK, RecordingKind.NUMPY)
        for name in ("Mono8", "Mono12p", "RGB8")
    ),
    *(
        (kind, name)
        for kind in (RecordingKind.STACK, RecordingKind.NUMPY)
        for name in ("BayerRG8", "Data16s")
    ),
    (RecordingKind.STACK, "RGBa8"),
    (RecordingKind.NUMPY, "YUV422_8"),
    (RecordingKind.NUMPY, "Coord3D_ABC16"),
    (RecordingKind.LOSSLESS, "Mono8"),
    (RecordingKind.LOSSLESS, "RGB8"),
    (RecordingKind.FFV1, "Mono8"),
    (RecordingKind.FFV1, "Mono12p"),
    (RecordingKind.FFV1, "Mono16"),
    (RecordingKind.FFV1, "RGB8"),
    (RecordingKind.PNG, "RGBa8"),
    (RecordingKind.MCAP, "BGRa8"),
    (RecordingKind.MCAP, "RGB10p"),
    (RecordingKind.MCAP, "BGRa16"),
    (RecordingKind.MCAP, "Data16s"),
    (RecordingKind.MCAP, "Coord3D_AC8"),
    (RecordingKind.MCAP, "Coord3D_B16"),
]


@pytest.mark.parametrize(("kind", "name"), EXACT, ids=lambda value: getattr(value, "name", value))
def test_frames_are_played_as_they_were_recorded(tmp_path, kind, name):
    frames = [made(name, index) for index in range(3)]
    recording = open_recording(written(kind, tmp_path / NAMES[kind], frames))
    try:
        assert [t - recording.times_ns[0] for t in recording.times_ns] == [0, STEP, 2 * STEP]
        for index in (2, 0, 1):  # in any order
            back = recording.frame(index, 5)
            assert back.pixel_format.name == unpacked_name(name)
            assert np.array_equal(back.raw(), frames[index].raw())
            assert (back.frame_id, back.timestamp_ns) == (index + 7, 1000 + index)
            assert back.received_ns == 5
    finally:
        recording.close()


def test_a_lossless_movie_of_colours_keeps_them(tmp_path):
    frames = [made("BayerRG8", index) for index in range(3)]
    recording = open_recording(written(RecordingKind.LOSSLESS, tmp_path / "movie.mp4", frames))
    try:
        assert np.array_equal(recording.frame(1, 0).rgb(), frames[1].rgb())
    finally:
        recording.close()


def test_a_movie_looks_alike(tmp_path):
    grey = np.tile(np.linspace(20, 200, 64, dtype=np.uint8), (48, 1))
    frame = Frame(grey.ravel(), 64, 48, pfnc.by_name("Mono8"), received_ns=START)
    recording = open_recording(written(RecordingKind.H264, tmp_path / "movie.mp4", [frame]))
    try:
        assert np.abs(recording.frame(0, 0).mono().astype(int) - grey).mean() < 4
    finally:
        recording.close()


def test_a_format_of_unknown_layout_is_stored_as_bytes(tmp_path):
    pixel_format = pfnc.by_code(0x81090001)
    payload = np.arange(72, dtype=np.uint8)
    frame = Frame(payload, 8, 8, pixel_format, received_ns=START)
    recording = open_recording(written(RecordingKind.PNG, tmp_path / "x", [frame]))
    back = recording.frame(0, 0)
    assert back.pixel_format == pixel_format and np.array_equal(back.payload, payload)
    writer = create_writer(RecordingKind.MCAP, tmp_path / "x.mcap", INFO)
    with pytest.raises(GrabberError):
        writer.write(frame)
    writer.close()


CHUNKS = {
    "ChunkExposureTime": 1234.5,
    "ChunkLineStatusAll": 3,
    "ChunkCounterSelector": "Counter0",
    "On": True,
}


@pytest.mark.parametrize("kind", RecordingKind)
def test_what_came_with_a_frame_is_kept(kind, tmp_path):
    frames = [
        replace(made("Mono8", 0), chunks=CHUNKS | {"Raw": b"x", "Never": float("nan")}),
        replace(made("Mono8", 1), status=FrameStatus.INCOMPLETE, missing_bytes=100),
        replace(made("Mono8", 2), frame_id=2**40 + 1),
    ]
    path = written(kind, tmp_path / NAMES[kind], frames)
    with contextlib.closing(open_recording(path)) as recording:
        first, second, third = (recording.frame(index, 0) for index in range(3))
    assert first.chunks == CHUNKS and first.complete and not third.chunks
    assert (second.status, second.missing_bytes) == (FrameStatus.INCOMPLETE, 100)
    assert third.frame_id == 2**40 + 1
    assert [frame.offset_x for frame in (first, second, third)] == [4, 4, 4]


def test_chunk_data_beyond_a_line_are_left_out():
    frame = replace(made("Mono8", 0), chunks={"Long": "x" * MAX_LINE, "Short": 1})
    line = note_of(frame, frame.pixel_format).line()
    assert parse_note(line, "a").frame_id == frame.frame_id and "chunks" not in line


@pytest.mark.parametrize("wrong", ['"chunks":[]', '"chunks":{"a":[]}', '"chunks":{"a":NaN}', '"complete":1'])
def test_a_note_with_what_no_camera_sends_is_refused(wrong):
    with pytest.raises(UsageError, match="wrong type"):
        parse_note(f'{{"width":4,"height":4,"pixel_format":"Mono8",{wrong}}}', "line 1")


def test_nothing_is_overwritten(tmp_path):
    for kind, name in NAMES.items():
        path = tmp_path / kind.value / name
        written(kind, path, [made("Mono8", 0)])
        with pytest.raises(ExistingFileError, match="overwrites nothing"):
            create_writer(kind, path, INFO)


@pytest.mark.parametrize("kind", RecordingKind)
def test_a_source_whose_name_is_no_utf8_is_recorded(tmp_path, kind):
    info = replace(INFO, user_name=os.fsdecode(b"caf\xe9"))
    writer = create_writer(kind, tmp_path / NAMES[kind], info)
    writer.write(made("Mono8", 0))
    writer.close()
    with contextlib.closing(open_recording(tmp_path / NAMES[kind])) as recording:
        assert len(recording) == 1


def test_notes_that_are_left_of_a_removed_movie_are_named(tmp_path):
    notes = tmp_path / "movie.frames.jsonl"
    notes.write_text("")
    with pytest.raises(ExistingFileError, match=re.escape(f"{notes} could not be created: File exists")):
        create_writer(RecordingKind.H264, tmp_path / "movie.mp4", INFO)


def test_the_suffix_chooses_the_kind():
    assert kind_of(Path("a.MP4")) is RecordingKind.H264
    assert kind_of(Path("a.mp4"), lossless=True) is RecordingKind.LOSSLESS
    assert kind_of(Path("a.mcap")) is RecordingKind.MCAP
    assert kind_of(Path("a")) is RecordingKind.PNG
    assert kind_of(Path("run.2026.11.28")) is RecordingKind.PNG
    for name in ("a.bag", "a.xyz", "a.mp3", "a.png"):
        with pytest.raises(UsageError, match=r"recordings are \.mp4, \.mcap"):
            kind_of(Path(name))


@pytest.mark.parametrize(
    ("name", "options", "kind"),
    [
        ("a.mp4", {"codec": "h264"}, RecordingKind.H264),
        ("a.mp4", {"codec": "h264", "lossless": True}, RecordingKind.LOSSLESS),
        ("a.mp4", {"codec": "ffv1", "lossless": True}, RecordingKind.FFV1),
        ("a", {"tiff": True}, RecordingKind.TIFF),
        ("a.tiff", {"tiff": True}, RecordingKind.STACK),
        ("a.TIF", {}, RecordingKind.STACK),
        ("a.npy", {}, RecordingKind.NUMPY),
    ],
)
def test_options_choose_among_movies_and_folders(name, options, kind):
    assert kind_of(Path(name), **options) is kind


@pytest.mark.parametrize(
    ("name", "options", "problem"),
    [
        ("a.mp4", {"codec": "vp9"}, "'vp9' is no codec of a movie; there are h264, ffv1"),
        ("a.mp4", {"tiff": True}, "tiff is for a folder of images, not for a.mp4"),
        ("a.mcap", {"tiff": True}, "tiff is for a folder of images, not for a.mcap"),
        ("a.mcap", {"lossless": True}, "lossless is for a movie (.mp4), not for a.mcap"),
        ("a", {"codec": "ffv1"}, "codec ffv1 is for a movie (.mp4), not for a"),
    ],
)
def test_options_of_another_kind_are_refused(name, options, problem):
    with pytest.raises(UsageError, match=f"^{re.escape(problem)}$"):
        kind_of(Path(name), **options)


def test_free_space_is_that_of_its_disk(tmp_path):
    writer = create_writer(RecordingKind.PNG, tmp_path / "x", INFO)
    assert abs(writer.free() - shutil.disk_usage(tmp_path).free) < 1 << 30
    writer.close()
