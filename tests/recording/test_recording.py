"""Frames recorded on the simulated camera and played back: equal, in pace, whatever runs out."""

import contextlib
import errno
import os
import re
import shutil
import struct
import time
import tracemalloc
from dataclasses import replace
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import zstandard
from full_disk import FullDisk

from grabbergui import sources
from grabbergui.core import pfnc
from grabbergui.core.errors import FrameTimeoutError, GrabberError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.uri import SourceUri
from grabbergui.recording import (
    MOVIE_KINDS,
    RecordingError,
    RecordingKind,
    in_order_of_receipt,
    kind_of,
    mcap_file,
    open_recording,
    playback,
)
from grabbergui.recording.recorder import Recorder, RecordingLimits, create_writer
from patience import PATIENCE, until

INFO = DeviceInfo("sim:", vendor="V", model="M", serial="1")
START = 1_700_000_000_000_000_000
STEP = 20_000_000
NAMES = {
    RecordingKind.PNG: "images",
    RecordingKind.TIFF: "images",
    **dict.fromkeys(MOVIE_KINDS, "movie.mp4"),
    RecordingKind.MCAP: "messages.mcap",
}


@pytest.mark.parametrize("suffix", ["", ".mcap", ".mp4"])
def test_a_name_too_long_for_the_disk_is_a_recording_error(tmp_path, suffix):
    path = tmp_path / ("x" * 300 + suffix)
    with pytest.raises(RecordingError, match="could not be made: File name too long"):
        create_writer(kind_of(path), path, INFO)


def made(name, index, width=48, height=32):
    pixel_format = pfnc.by_name(name)
    rng = np.random.default_rng(index)
    payload = rng.integers(0, 256, pixel_format.image_bytes(width, height), np.uint8)
    if pixel_format.bits_per_pixel == 16 and pixel_format.depth < 16:
        payload = (payload.view("<u2") & (1 << pixel_format.depth) - 1).view(np.uint8)
    return Frame(
        payload,
        width,
        height,
        pixel_format,
        frame_id=index + 7,
        timestamp_ns=1000 + index,
        received_ns=START + index * STEP,
        offset_x=4,
    )


def written(kind, path, frames):
    writer = create_writer(kind, path, INFO)
    for frame in frames:
        writer.write(frame)
    writer.close()
    writer.close()
    return path


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


@pytest.fixture
def camera():
    grabber = sources.create("sim:?width=64&height=48&fps=100")
    grabber.open()
    yield grabber
    grabber.close()


def ended(recorder):
    assert recorder.wait(PATIENCE)
    return recorder.progress


@pytest.mark.parametrize("kind", RecordingKind)
def test_a_camera_is_recorded_and_played(camera, tmp_path, kind):
    path = tmp_path / NAMES[kind]
    writer = create_writer(kind, path, camera.info, 100)
    recorder = Recorder(camera, writer, RecordingLimits(frames=10), reserve=0)
    reported = []
    recorder.changed.connect(reported.append)
    recorder.start()
    camera.start()
    progress = ended(recorder)
    assert (progress.frames, progress.reason) == (10, "")
    assert progress.size > 0 and reported[-1].ended

    player = playback.create(SourceUri.parse(f"file:{path}?loop=0&speed=4"))
    player.open()
    try:
        queue = player.open_queue(16)
        player.start()
        frames = [queue.get(PATIENCE) for _ in range(10)]
        assert len({frame.frame_id for frame in frames}) == 10
        assert all((frame.width, frame.height) == (64, 48) for frame in frames)
        with pytest.raises(FrameTimeoutError):
            queue.get(0.2)
        assert player.feature("PlaybackActive").value is False
    finally:
        player.close()


def test_it_ends_after_so_many_seconds(camera, tmp_path):
    writer = create_writer(RecordingKind.MCAP, tmp_path / "x.mcap", INFO)
    recorder = Recorder(camera, writer, RecordingLimits(seconds=0.1), reserve=0)
    recorder.start()
    camera.start()
    progress = ended(recorder)
    assert progress.frames and progress.seconds <= 0.1


def test_a_change_of_the_time_of_day_does_not_end_it(camera, tmp_path, monkeypatch):
    """As when the time of day is set by an hour while it records."""
    really, jumped = time.time_ns, []
    monkeypatch.setattr(time, "time_ns", lambda: really() + 3600 * 10**9 * bool(jumped))
    writer = create_writer(RecordingKind.MCAP, tmp_path / "x.mcap", INFO)
    recorder = Recorder(camera, writer, RecordingLimits(frames=20, seconds=PATIENCE), reserve=0)
    recorder.start()
    camera.start()
    until(lambda: recorder.progress.frames >= 5)
    jumped.append(True)
    progress = ended(recorder)
    assert progress.frames == 20 and progress.seconds < PATIENCE


def test_it_ends_after_so_many_seconds_even_if_no_frame_arrives(camera, tmp_path):
    writer = create_writer(RecordingKind.MCAP, tmp_path / "x.mcap", INFO)
    recorder = Recorder(camera, writer, RecordingLimits(seconds=0.3), reserve=0)
    recorder.start()
    camera.start()
    until(lambda: recorder.progress.frames)
    camera.stop()
    assert ended(recorder).reason == ""


def test_it_ends_once_so_many_bytes_are_written(camera, tmp_path):
    writer = create_writer(RecordingKind.TIFF, tmp_path / "x", INFO)
    recorder = Recorder(camera, writer, RecordingLimits(size=10_000), reserve=0)
    recorder.start()
    camera.start()
    progress = ended(recorder)
    frame = progress.size / progress.frames
    assert 10_000 <= progress.size < 10_000 + frame and progress.reason == ""


def test_it_ends_on_request_and_with_the_source(camera, tmp_path):
    reported = Recorder(camera, create_writer(RecordingKind.MCAP, tmp_path / "a.mcap", INFO))
    left = Recorder(camera, create_writer(RecordingKind.PNG, tmp_path / "b", INFO))
    reported.start()
    left.start()
    reported.stop()
    assert ended(reported).reason == ""
    camera.close()
    assert "closed" in ended(left).reason


@pytest.mark.parametrize("kind", list(RecordingKind))
def test_without_a_frame_the_name_is_free_again(camera, tmp_path, kind):
    path = tmp_path / NAMES[kind]
    recorder = Recorder(camera, create_writer(kind, path, INFO))
    recorder.start()
    recorder.stop()
    assert ended(recorder).reason == ""
    assert list(tmp_path.iterdir()) == []
    written(kind, path, [made("Mono8", 0)])


@pytest.mark.parametrize("kind", MOVIE_KINDS)
def test_without_a_frame_another_programs_file_stays(camera, tmp_path, kind):
    """A movie is made with its first frame; until then another program may have taken the name."""
    path = tmp_path / NAMES[kind]
    recorder = Recorder(camera, create_writer(kind, path, INFO))
    path.write_text("theirs")
    recorder.start()
    camera.start()
    assert "File exists" in ended(recorder).reason
    assert [file.name for file in tmp_path.iterdir()] == [path.name] and path.read_text() == "theirs"


def test_it_ends_even_if_closing_fails_unexpectedly(camera, tmp_path, monkeypatch):
    writer = create_writer(RecordingKind.PNG, tmp_path / "images", INFO)

    def no_memory(frame):
        time.sleep(0.1)  # so that others are begun, which fail when the writer is closed
        raise MemoryError("no room for an image")

    monkeypatch.setattr(writer, "_encoded", no_memory)
    recorder = Recorder(camera, writer)
    reported = []
    recorder.changed.connect(reported.append)
    recorder.start()
    camera.start()
    assert ended(recorder).reason == "internal error, see the log: no room for an image"
    assert reported[-1].ended


@pytest.mark.parametrize("kind", [RecordingKind.MCAP, RecordingKind.H264])
def test_it_ends_even_if_its_file_was_removed(camera, tmp_path, kind):
    recorder = Recorder(camera, create_writer(kind, tmp_path / NAMES[kind], camera.info))
    recorder.start()
    camera.start()
    until(lambda: recorder.progress.frames >= 3, "frames")
    (tmp_path / NAMES[kind]).unlink()
    recorder.stop()
    progress = ended(recorder)
    assert progress.ended
    assert "could not be finished" in progress.reason


def test_a_slow_disk_drops_frames_and_counts_them(camera, tmp_path, monkeypatch):
    writer = create_writer(RecordingKind.MCAP, tmp_path / "x.mcap", INFO)
    really = writer.write
    monkeypatch.setattr(writer, "write", lambda frame: (time.sleep(0.3), really(frame)))
    recorder = Recorder(camera, writer, RecordingLimits(frames=3), reserve=0)
    recorder.start()
    camera.start()
    progress = ended(recorder)
    assert progress.frames == 3 and progress.dropped > 10
    recording = open_recording(tmp_path / "x.mcap")
    assert len(recording) == 3
    recording.close()


@pytest.mark.parametrize("kind", RecordingKind)
def test_a_disk_that_fills_up_ends_it_with_readable_files(camera, tmp_path, monkeypatch, kind):
    path = tmp_path / NAMES[kind]
    writer = create_writer(kind, path, INFO, 100)
    left = iter([10**9] * 5 + [10**6] * 99)
    monkeypatch.setattr(writer, "free", lambda: next(left))
    recorder = Recorder(camera, writer)
    recorder.start()
    camera.start()
    progress = ended(recorder)
    assert progress.frames == 5
    assert progress.reason == (f"the disk of {path} is full (0 MiB left); 5 frames recorded by then are kept")
    recording = open_recording(path)
    assert len(recording) == 5
    assert recording.frame(4, 0).width == 64
    recording.close()


@pytest.mark.parametrize("fitting", [0, 5])
def test_images_that_did_not_fit_are_not_counted(camera, tmp_path, monkeypatch, fitting):
    """As with a quota, or where another program filled the disk."""
    save = Path.write_bytes

    def limited(file, content):
        if file.suffix == ".png" and int(file.stem) >= fitting:
            raise OSError(errno.EDQUOT, "Disk quota exceeded")
        return save(file, content)

    monkeypatch.setattr(Path, "write_bytes", limited)
    path = tmp_path / "images"
    recorder = Recorder(camera, create_writer(RecordingKind.PNG, path, INFO), reserve=0)
    recorder.start()
    camera.start()
    progress = ended(recorder)
    assert progress.frames == fitting
    assert "Disk quota exceeded" in progress.reason
    if fitting:
        with contextlib.closing(open_recording(path)) as recording:
            assert len(recording) == fitting
    else:
        assert progress.reason.endswith("nothing was recorded")
        assert not path.exists()


def test_a_disk_without_any_room_leaves_no_file(camera, tmp_path, monkeypatch):
    path = tmp_path / "x.mcap"
    writer = create_writer(RecordingKind.MCAP, path, INFO)
    monkeypatch.setattr(writer, "free", lambda: 0)
    finish = writer.close

    def full():
        finish()
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(writer, "close", full)
    recorder = Recorder(camera, writer)
    recorder.start()
    camera.start()
    assert ended(recorder).reason == f"the disk of {path} is full (0 MiB left); nothing was recorded"
    assert not path.exists()


def test_an_mcap_is_played_in_the_order_of_receipt_though_the_clock_was_set_back(tmp_path):
    hour = 3_600_000_000_000
    frames = [
        replace(made("Mono8", index), received_ns=START + index * STEP - (hour if index > 2 else 0))
        for index in range(6)
    ]
    path = written(RecordingKind.MCAP, tmp_path / "x.mcap", frames)
    with contextlib.closing(open_recording(path)) as recording:
        played = [recording.frame(index, 0).frame_id for index in range(6)]
        assert played == [frame.frame_id for frame in frames]
        assert np.diff(recording.times_ns).tolist() == [STEP, STEP, 0, STEP, STEP]


def test_messages_that_lie_a_little_out_of_order_are_sorted():
    second = 1_000_000_000
    times = [second, 3 * second, 2 * second + 1, 4 * second, second, second + 2, second + 1]
    ordered = in_order_of_receipt(times, lambda time: time)
    assert ordered == [*sorted(times[:4]), *sorted(times[4:])]


def test_a_camera_that_counts_from_one_again_keeps_the_device_times_of_its_first_frames(tmp_path):
    frames = [
        replace(made("Mono8", index), frame_id=index % 3 + 1, timestamp_ns=1000 + index) for index in range(6)
    ]
    path = written(RecordingKind.MCAP, tmp_path / "x.mcap", frames)
    with contextlib.closing(open_recording(path)) as recording:
        assert [recording.frame(index, 0).timestamp_ns for index in range(6)] == list(range(1000, 1006))


def test_a_write_that_does_not_fit_leaves_complete_frames(tmp_path):
    writer = create_writer(RecordingKind.MCAP, tmp_path / "x.mcap", INFO)
    frames = [made("Mono8", index) for index in range(6)]
    writer.write(frames[0])
    # The package's writer holds its stream; ours sees the same object fail.
    writer._writer._Writer__stream = FullDisk(writer._file, 4000)
    with pytest.raises(OSError, match="space"):
        for frame in frames[1:]:
            writer.write(frame)
    writer.close()
    recording = open_recording(tmp_path / "x.mcap")
    assert len(recording) == 3
    assert np.array_equal(recording.frame(2, 0).raw(), frames[2].raw())
    recording.close()


def test_an_mcap_file_cut_anywhere_plays_up_to_there_or_is_refused(tmp_path):
    whole = written(RecordingKind.MCAP, tmp_path / "x.mcap", [made("Mono8", i, 8, 8) for i in range(3)])
    content = whole.read_bytes()
    lengths = set()
    for size in range(0, len(content), 7):
        (tmp_path / "cut.mcap").write_bytes(content[:size])
        try:
            recording = open_recording(tmp_path / "cut.mcap")
        except GrabberError:
            continue
        lengths.add(len(recording))
        recording.frame(len(recording) - 1, 0)
        recording.close()
    assert lengths == {1, 2, 3}


def test_broken_bytes_never_give_a_traceback(tmp_path):
    whole = written(RecordingKind.MCAP, tmp_path / "x.mcap", [made("Mono8", i, 8, 8) for i in range(2)])
    content, rng = whole.read_bytes(), np.random.default_rng(3)
    read = 0
    for _ in range(300):
        broken = bytearray(content)
        for at in rng.integers(8, len(content), 3):
            broken[at] = rng.integers(0, 256)
        (tmp_path / "broken.mcap").write_bytes(broken)
        try:
            recording = open_recording(tmp_path / "broken.mcap")
        except GrabberError:
            continue
        for index in range(min(len(recording), 4)):
            with contextlib.suppress(GrabberError):
                frame = recording.frame(index, 0)
                assert frame.payload.nbytes <= len(content)
                read += frame.payload.nbytes == 64
        recording.close()
    assert read > 100, "most frames are not where it is broken"


def test_the_mcap_package_reads_what_we_write(tmp_path):
    from mcap.reader import make_reader

    path = written(RecordingKind.MCAP, tmp_path / "x.mcap", [made("Mono8", i) for i in range(3)])
    with path.open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        assert summary.statistics.message_count == 6
        topics = {channel.topic for channel in summary.channels.values()}
        assert topics == {"/grabbergui/image_raw", "/grabbergui/image_raw/device_time"}
        times = [message.log_time for _, _, message in reader.iter_messages("/grabbergui/image_raw")]
        assert times == [START, START + STEP, START + 2 * STEP]


def test_compressed_files_of_others_are_played(tmp_path):
    from mcap.writer import CompressionType, Writer

    from grabbergui.recording.ros_image import IMAGE_DEFINITION, IMAGE_NAME, RosImage

    for compression in (CompressionType.ZSTD, CompressionType.LZ4):
        path = tmp_path / f"{compression.name}.mcap"
        with path.open("wb") as file:
            writer = Writer(file, compression=compression)
            writer.start()
            schema = writer.register_schema(IMAGE_NAME, "ros2msg", IMAGE_DEFINITION.encode())
            channel = writer.register_channel("/cam", "cdr", schema)
            lines = np.arange(60, dtype=np.uint8).reshape(3, 20)  # two bytes of padding a line
            message = RosImage(START, "c", 3, 18, "mono8", 0, 20, lines.tobytes()).encode()
            for index in range(4):
                writer.add_message(channel, START + index, message, START + index, index)
            writer.finish()
        recording = open_recording(path)
        assert len(recording) == 4
        assert np.array_equal(recording.frame(3, 0).raw(), lines[:, :18])
        recording.close()


@pytest.mark.parametrize(("name", "compress"), [("zstd", zstandard.compress), ("lz4", lz4.frame.compress)])
def test_a_chunk_is_decompressed_no_further_than_it_announces(tmp_path, name, compress):
    data = compress(bytes(1 << 26))
    body = (
        struct.pack("<QQQII", 0, 0, 1000, 0, len(name)) + name.encode() + struct.pack("<Q", len(data)) + data
    )
    path = tmp_path / "x.mcap"
    path.write_bytes(mcap_file.MAGIC + struct.pack("<BQ", 6, len(body)) + body)
    tracemalloc.start()
    try:
        with pytest.raises(UsageError, match="holds no images"):
            open_recording(path)
        assert tracemalloc.get_traced_memory()[1] < 1 << 22
    finally:
        tracemalloc.stop()


def test_a_compressed_file_that_is_cut_short_while_it_is_played_is_refused(tmp_path):
    from mcap.writer import CompressionType, Writer

    from grabbergui.recording.ros_image import IMAGE_DEFINITION, IMAGE_NAME, RosImage

    path = tmp_path / "x.mcap"
    with path.open("wb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD, chunk_size=1)
        writer.start()
        schema = writer.register_schema(IMAGE_NAME, "ros2msg", IMAGE_DEFINITION.encode())
        channel = writer.register_channel("/cam", "cdr", schema)
        for index in range(8):  # each in a chunk, of which only the last are in memory
            pixels = made("Mono8", index, 64, 64).payload.tobytes()
            message = RosImage(START, "c", 64, 64, "mono8", 0, 64, pixels).encode()
            writer.add_message(channel, START + index, message, START + index, index)
        writer.finish()
    recording = open_recording(path)
    os.truncate(path, 8)
    with pytest.raises(RecordingError, match="was cut short while it was played"):
        recording.frame(0, 0)
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


def test_nothing_is_overwritten(tmp_path):
    for kind, name in NAMES.items():
        path = tmp_path / kind.value / name
        written(kind, path, [made("Mono8", 0)])
        with pytest.raises(RecordingError, match="overwrites nothing"):
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
    with pytest.raises(RecordingError, match=re.escape(f"{notes} could not be made: File exists")):
        create_writer(RecordingKind.H264, tmp_path / "movie.mp4", INFO)


def test_the_suffix_chooses_the_kind():
    assert kind_of(Path("a.MP4")) is RecordingKind.H264
    assert kind_of(Path("a.mp4"), movie=RecordingKind.LOSSLESS) is RecordingKind.LOSSLESS
    assert kind_of(Path("a.mcap")) is RecordingKind.MCAP
    assert kind_of(Path("a")) is RecordingKind.PNG
    with pytest.raises(GrabberError, match=r"\.mcap"):
        kind_of(Path("a.bag"))


def test_free_space_is_that_of_its_disk(tmp_path):
    writer = create_writer(RecordingKind.PNG, tmp_path / "x", INFO)
    assert abs(writer.free() - shutil.disk_usage(tmp_path).free) < 1 << 30
    writer.close()
