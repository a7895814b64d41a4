"""MCAP files: in the order of receipt, of others, cut short, compressed, broken."""

import contextlib
import os
import struct
import tracemalloc
from dataclasses import replace
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import zstandard
from mcap.writer import CompressionType, Writer

from full_disk import FullDisk
from grabbergui.core.errors import GrabberError, UsageError
from grabbergui.core.ros_image import IMAGE_DEFINITION, IMAGE_NAME, RosImage
from grabbergui.recording import mcap_file
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.kinds import RecordingKind
from grabbergui.recording.opening import open_recording
from grabbergui.recording.recorder import create_writer
from grabbergui.recording.times import in_order_of_receipt
from recorded_frames import INFO, START, STEP, made, written


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


def test_a_write_that_does_not_fit_leaves_complete_frames(tmp_path, monkeypatch):
    really, disks = Path.open, []

    def on_a_full_disk(path, mode="r", **options):
        disks.append(FullDisk(really(path, mode, **options), 10**6))
        return disks[-1]

    with monkeypatch.context() as patch:
        patch.setattr(Path, "open", on_a_full_disk)
        writer = create_writer(RecordingKind.MCAP, tmp_path / "x.mcap", INFO)
    frames = [made("Mono8", index) for index in range(6)]
    writer.write(frames[0])
    (disk,) = disks
    disk.room = 5000
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
        assert summary.statistics.message_count == 9
        topics = {channel.topic for channel in summary.channels.values()}
        image = "/grabbergui/image_raw"
        assert topics == {image, f"{image}/device_time", f"{image}/note"}
        times = [message.log_time for _, _, message in reader.iter_messages("/grabbergui/image_raw")]
        assert times == [START, START + STEP, START + 2 * STEP]


def write_compressed(path, images, compression=CompressionType.ZSTD, **options):
    """Write a file as ROS's tools do; with `chunk_size=1`, each image has a chunk of its own."""
    with path.open("wb") as file:
        writer = Writer(file, compression=compression, **options)
        writer.start()
        schema = writer.register_schema(IMAGE_NAME, "ros2msg", IMAGE_DEFINITION.encode())
        channel = writer.register_channel("/cam", "cdr", schema)
        for index, image in enumerate(images):
            writer.add_message(channel, START + index, image.encode(), START + index, index)
        writer.finish()


def test_compressed_files_of_others_are_played(tmp_path):
    lines = np.arange(60, dtype=np.uint8).reshape(3, 20)  # two bytes of padding a line
    images = [RosImage(START, "c", 3, 18, "mono8", 0, 20, lines.tobytes())] * 4
    for compression in (CompressionType.ZSTD, CompressionType.LZ4):
        path = tmp_path / f"{compression.name}.mcap"
        write_compressed(path, images, compression)
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


def test_a_damaged_chunk_is_left_out_with_a_warning(tmp_path, caplog):
    path = tmp_path / "x.mcap"
    write_compressed(path, [RosImage(START, "c", 3, 18, "mono8", 0, 18, bytes(54))] * 4, chunk_size=1)
    content = path.read_bytes()
    begin = content.index(b"zstd")
    path.write_bytes(content[: begin + 12] + bytes(8) + content[begin + 20 :])
    with contextlib.closing(open_recording(path)) as recording:
        assert [recording.frame(index, 0).frame_id for index in range(len(recording))] == [1, 2, 3]
    assert len(caplog.records) == 1 and "its frames are left out" in caplog.text


def test_a_compressed_file_that_is_cut_short_while_it_is_played_is_refused(tmp_path):
    path = tmp_path / "x.mcap"
    pixels = [made("Mono8", index, 64, 64).payload.tobytes() for index in range(8)]
    images = [RosImage(START, "c", 64, 64, "mono8", 0, 64, each) for each in pixels]
    write_compressed(path, images, chunk_size=1)  # only the last chunks are in memory
    recording = open_recording(path)
    os.truncate(path, 8)
    with pytest.raises(RecordingError, match="was cut short while it was played"):
        recording.frame(0, 0)
    recording.close()
