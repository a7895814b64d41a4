"""Movies: exact times and seeking, other readers, crashes, full disks, bad files."""

import contextlib
import math
import os
import resource
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from full_disk import FullDisk
from grabbergui.core import pfnc
from grabbergui.core.errors import GrabberError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.identity import DeviceInfo
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.kinds import MOVIE_KINDS, RecordingKind
from grabbergui.recording.opening import open_recording, playable_frames
from grabbergui.recording.recorder import create_writer
from patience import PROGRAM, until

av = pytest.importorskip("av", reason="needs the package av")

from grabbergui.recording.file_names import notes_beside  # noqa: E402
from grabbergui.recording.movie_writer import FRAGMENT, MovieFile  # noqa: E402

INFO = DeviceInfo("sim:", model="M")
START = 1_700_000_000_000_000_000
TIMES = [0, 20_000_123, 40_000_456, 41_000_000, 900_000_000, 5_000_000_000, 5_000_001_500]
"Nanoseconds of an irregular camera."


def level(index):
    """A brightness that no other frame of a minute's neighbours has."""
    return 30 + (index * 37) % 180


def flat(index, width=64, height=48, name="Mono8", at=None):
    pixel_format = pfnc.by_name(name)
    payload = np.full(pixel_format.image_bytes(width, height), level(index), np.uint8)
    received = START + (index * 40_000_000 if at is None else at)
    return Frame(payload, width, height, pixel_format, index, received_ns=received)


def written(path, kind, frames):
    writer = create_writer(kind, path, INFO, 25)
    for frame in frames:
        writer.write(frame)
    writer.close()
    return path


@pytest.mark.parametrize("rate", [0.0, 1e-4, 1e12, math.inf])
def test_a_movie_is_written_whatever_rate_the_camera_reports(tmp_path, rate):
    writer = create_writer(RecordingKind.H264, tmp_path / "x.mp4", INFO, rate)
    writer.write(flat(0))
    writer.close()
    assert len(open_recording(tmp_path / "x.mp4")) == 1


@pytest.mark.parametrize("kind", MOVIE_KINDS)
def test_each_frame_has_its_own_time(tmp_path, kind):
    frames = [flat(index, at=time) for index, time in enumerate(TIMES)]
    path = written(tmp_path / "x.mp4", kind, frames)

    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        times = [packet.pts * stream.time_base for packet in container.demux(stream) if packet.size]
    assert [int(time * 10**6) for time in times] == [time // 1000 for time in TIMES]

    for notes in (True, False):
        if not notes:
            notes_beside(path).unlink()
        recording = open_recording(path)
        exact = [time - recording.times_ns[0] for time in recording.times_ns]
        assert exact == (TIMES if notes else [time // 1000 * 1000 for time in TIMES])
        recording.close()


def test_constant_or_decreasing_times_increase_in_the_movie(tmp_path):
    frames = [flat(index, at=at) for index, at in enumerate((0, 10**9, 10**9, 5 * 10**8, 10**13))]
    recording = open_recording(written(tmp_path / "x.mp4", RecordingKind.H264, frames))
    assert len(recording) == 5
    assert [recording.frame(index, 0).frame_id for index in (4, 1, 3, 0, 2)] == [4, 1, 3, 0, 2]
    recording.close()


def test_a_clock_that_is_set_back_does_not_crowd_the_frames_after_it(tmp_path):
    hour = 3_600_000
    at = [0, 40, 80, 80 - hour, 120 - hour, 160 - hour]
    frames = [flat(index, at=ms * 1_000_000) for index, ms in enumerate(at)]
    path = written(tmp_path / "set.mp4", RecordingKind.H264, frames)
    with contextlib.closing(open_recording(path)) as recording:
        steps = np.diff(recording.times_ns) // 1_000_000
    assert steps.tolist() == [40, 40, 0, 40, 40]
    notes_beside(path).unlink()
    with contextlib.closing(open_recording(path)) as recording:
        assert recording.times_ns[-1] > 150_000_000


@pytest.mark.parametrize("kind", MOVIE_KINDS)
@pytest.mark.parametrize("name", ["Mono8", "RGB8"])
def test_any_frame_is_found_exactly(tmp_path, kind, name):
    path = written(tmp_path / "x.mp4", kind, [flat(index, name=name) for index in range(60)])
    for notes in (True, False):
        if not notes:
            notes_beside(path).unlink()
        recording = open_recording(path)
        for index in (59, 0, 31, 30, 32, 40, 7, 58, 24, 25, 26, 3):
            assert abs(float(recording.frame(index, 0).mono().mean()) - level(index)) < 4, index
        recording.close()


@pytest.mark.parametrize("kind", MOVIE_KINDS)
@pytest.mark.parametrize("name", ["Mono8", "RGB8"])
def test_opencv_sees_the_same(tmp_path, kind, name):
    path = written(tmp_path / "x.mp4", kind, [flat(index, name=name) for index in range(30)])
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    assert capture.get(cv2.CAP_PROP_FRAME_COUNT) == 30
    for index in range(30):
        read, pixels = capture.read()
        assert read and abs(float(pixels.mean()) - level(index)) < 6, index
    assert not capture.read()[0]
    capture.release()


@pytest.mark.parametrize("name", ["Mono8", "BayerRG8", "RGB8"])
@pytest.mark.parametrize("kind", MOVIE_KINDS)
def test_odd_sizes_are_recorded(tmp_path, kind, name):
    path = written(tmp_path / "x.mp4", kind, [flat(index, 65, 47, name) for index in range(3)])
    recording = open_recording(path)
    back = recording.frame(2, 0)
    assert (back.width, back.height) == (65, 47)
    assert abs(float(back.mono().mean()) - level(2)) < 4
    recording.close()


def test_another_size_does_not_end_the_movie_before_it(tmp_path):
    writer = create_writer(RecordingKind.H264, tmp_path / "x.mp4", INFO)
    writer.write(flat(0))
    with pytest.raises(RecordingError, match=r"\.mcap can"):
        writer.write(flat(1, 32, 32))
    writer.close()
    recording = open_recording(tmp_path / "x.mp4")
    assert len(recording) == 1
    recording.close()


IMPORTS = f"""
import sys, numpy as np
sys.path[:0] = {[str(Path(__file__).parent), str(Path(__file__).parents[2] / "support")]}
from test_movie_files import *
"""
WRITE = f"""{IMPORTS}
random = np.random.default_rng(0)
writer = create_writer(RecordingKind(sys.argv[2]), Path(sys.argv[1]), INFO, 25)
index = 0
while True:
    frame = flat(index)
    frame.payload = random.integers(0, 256, frame.payload.size, np.uint8)
    writer.write(frame)
    index += 1
    if index >= 200:
        print(index, flush=True)
"""


@pytest.mark.parametrize("kind", MOVIE_KINDS)
def test_a_movie_whose_program_was_killed_is_played(tmp_path, kind):
    path = tmp_path / "x.mp4"
    with subprocess.Popen(
        [sys.executable, "-c", WRITE, str(path), kind.value], stdout=subprocess.PIPE, text=True
    ) as program:
        try:
            wrote = int(program.stdout.readline())
        finally:
            program.send_signal(signal.SIGKILL)

    recording = open_recording(path)
    lost = FRAGMENT // 40_000 + 80  # the last fragment, and what encoders hold
    assert len(recording) >= wrote - lost
    last = len(recording) - 1
    assert recording.frame(last, 0).frame_id == last
    assert recording.frame(5, 0).frame_id == 5
    recording.close()
    capture, count = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG), 0
    while capture.read()[0]:
        count += 1
    assert abs(count - last - 1) <= 1
    capture.release()


def test_a_crash_costs_the_last_half_second_if_the_encoder_holds_nothing(tmp_path):
    movie = MovieFile(tmp_path / "x.mp4", RecordingKind.FFV1, (48, 64), np.uint8, 25)
    for index in range(60):
        movie.add(flat(index).mono(), index * 40_000)
        if index % 10 == 9:
            assert index + 1 - playable_frames(tmp_path / "x.mp4") <= FRAGMENT // 40_000 + 2
    movie.finish()


@pytest.mark.parametrize("kind", MOVIE_KINDS)
def test_a_narrow_region_damages_no_memory(tmp_path, kind):
    """An encoder that writes beyond its buffers ends the process, so it has one of its own."""
    code = f"""{IMPORTS}
for width, height in ((16, 16), (48, 32), (48, 48), (34, 34), (32, 320)):
    path = Path(sys.argv[1]) / f"{{width}}x{{height}}.mp4"
    written(path, RecordingKind(sys.argv[2]), [flat(index, width, height) for index in range(30)])
"""
    checked = {**os.environ, "LD_PRELOAD": "libc_malloc_debug.so.0", "MALLOC_CHECK_": "3"}  # if there is such
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path), kind.value],
        stderr=subprocess.PIPE,
        text=True,
        timeout=PROGRAM,
        env=checked,
    )
    assert done.returncode == 0, done.stderr[-300:]
    assert len(list(tmp_path.glob("*.mp4"))) == 5


LIMIT = 300_000
FULL = f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({LIMIT}, {resource.RLIM_INFINITY}))\n"
FULL += WRITE.replace(
    "    writer.write(frame)",
    """    try:
        writer.write(frame)
    except OSError as error:
        writer.close()
        raise SystemExit(repr(error))""",
)


@pytest.mark.parametrize("kind", [RecordingKind.H264, RecordingKind.LOSSLESS, RecordingKind.FFV1])
def test_a_movie_on_a_full_disk_ends_and_is_played(tmp_path, kind):
    path = tmp_path / "x.mp4"
    ended = subprocess.run(
        [sys.executable, "-c", FULL, str(path), kind.value], capture_output=True, text=True, timeout=PROGRAM
    )
    assert ended.stderr.strip() == "OSError(27, 'File too large')"
    assert path.stat().st_size <= LIMIT
    recording = open_recording(path)
    last = len(recording) - 1
    assert last > 20 and recording.frame(last, 0).frame_id == last
    recording.close()


def noisy(index):
    frame = flat(index)
    frame.payload = np.random.default_rng(index).integers(0, 256, frame.payload.size, np.uint8)
    return frame


@pytest.mark.parametrize(("room", "least"), [(20_000, 2), (180_000, 26)])
@pytest.mark.parametrize("kind", [RecordingKind.LOSSLESS, RecordingKind.FFV1])
def test_no_more_frames_are_counted_than_a_full_disk_has(tmp_path, monkeypatch, kind, room, least):
    really = Path.open
    monkeypatch.setattr(
        Path,
        "open",
        lambda path, mode="r", **options: (
            FullDisk(really(path, mode), room) if mode == "xb" else really(path, mode, **options)
        ),
    )
    writer = create_writer(kind, tmp_path / "x.mp4", INFO, 25)
    given = 0
    with pytest.raises(OSError, match="space"):
        for given in range(1000):
            writer.write(noisy(given))
    writer.close()
    with contextlib.closing(open_recording(tmp_path / "x.mp4")) as recording:
        last = len(recording) - 1
        assert least <= playable_frames(tmp_path / "x.mp4") == last + 1 < given
        assert recording.frame(last, 0).frame_id == last


def test_unwritten_bytes_of_a_movie_count_as_used_space(tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: SimpleNamespace(free=10**9))
    writer = create_writer(RecordingKind.LOSSLESS, tmp_path / "x.mp4", INFO, 25)
    assert writer.free() == 10**9
    for index in range(10):
        writer.write(noisy(index))
    until(lambda: writer.size() > 7 * 64 * 48, "the encoder")
    assert 10**9 - writer.free() > 6 * 64 * 48
    writer.close()
    assert writer.free() == 10**9


def test_a_movie_that_was_cut_short_after_its_index_is_played_up_to_there(tmp_path):
    """As a download that broke off: its index has more frames than the file."""
    frames = [noisy(index) for index in range(20)]
    with (
        av.open(written(tmp_path / "x.mp4", RecordingKind.LOSSLESS, frames)) as whole,
        av.open(tmp_path / "y.mp4", "w", options={"movflags": "faststart"}) as copy,
    ):
        stream = copy.add_stream_from_template(whole.streams.video[0])
        for packet in whole.demux(video=0):
            if packet.dts is not None:
                packet.stream = stream
                copy.mux(packet)
    os.truncate(tmp_path / "y.mp4", (tmp_path / "y.mp4").stat().st_size // 2)
    with contextlib.closing(open_recording(tmp_path / "y.mp4")) as recording:
        last = len(recording) - 1
        assert 5 < last < 12
        assert np.array_equal(recording.frame(last, 0).mono(), frames[last].mono())


@pytest.mark.parametrize("kind", [RecordingKind.H264, RecordingKind.FFV1])
def test_broken_bytes_never_give_a_traceback(tmp_path, kind):
    content = written(tmp_path / "x.mp4", kind, [flat(index) for index in range(20)]).read_bytes()
    notes_beside(tmp_path / "x.mp4").unlink()
    random, read = np.random.default_rng(5), 0
    for round_ in range(120):
        broken = bytearray(content)
        for at in random.integers(0, len(content), 3):
            broken[at] = random.integers(0, 256)
        if round_ % 3 == 0:
            del broken[random.integers(0, len(content)) :]
        (tmp_path / "y.mp4").write_bytes(broken)
        try:
            recording = open_recording(tmp_path / "y.mp4")
        except GrabberError:
            continue
        for index in (0, len(recording) - 1):
            with contextlib.suppress(GrabberError):
                read += recording.frame(index, 0).width == 64
        recording.close()
    assert read > 20


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"no movie",
        b"#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nother.mp4\n#EXT-X-ENDLIST\n",
        b"ffconcat version 1.0\nfile other.mp4\n",
    ],
)
def test_a_file_that_is_no_movie_is_refused_and_opens_no_other_file(tmp_path, content):
    written(tmp_path / "other.mp4", RecordingKind.H264, [flat(0)])
    (tmp_path / "x.mp4").write_bytes(content)
    with pytest.raises(UsageError, match=r"x\.mp4"):
        open_recording(tmp_path / "x.mp4")


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (lambda movie: b"", "is no movie: it is empty"),
        (lambda movie: b"no movie", "is no movie that can be read"),
        (lambda movie: movie[:40], "is a movie that cannot be read: it was cut off or is damaged"),
        (
            lambda movie: movie[: len(movie) // 2],
            "is a movie that cannot be read: it was cut off or is damaged",
        ),
    ],
)
def test_the_reason_why_a_movie_cannot_be_read_is_plain(tmp_path, content, reason):
    """FFmpeg has one text for all of them: `[Errno 1094995529] Invalid data found when processing input`."""
    with av.open(str(tmp_path / "whole.mp4"), "w") as container:
        stream = container.add_stream("libx264", rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        container.mux(stream.encode(av.VideoFrame.from_ndarray(np.zeros((48, 64, 3), np.uint8), "rgb24")))
        container.mux(stream.encode(None))
    path = tmp_path / "x.mp4"
    path.write_bytes(content((tmp_path / "whole.mp4").read_bytes()))
    with pytest.raises(UsageError) as refused:
        open_recording(path)
    assert str(refused.value) == f"{path} {reason}"


def test_movies_of_others_are_played_in_the_order_of_their_times(tmp_path):
    """With B frames, whose order in the file is another, in Matroska, which has no index of all frames."""
    for name, codec in (("x.mp4", "libx264"), ("x.mkv", "libx264"), ("y.mp4", "libx265")):
        with av.open(str(tmp_path / name), "w") as container:
            stream = container.add_stream(codec, rate=25, options={"bf": "3", "g": "12"})
            stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
            for index in range(40):
                grey = np.full((48, 64, 3), level(index), np.uint8)
                container.mux(stream.encode(av.VideoFrame.from_ndarray(grey, "rgb24")))
            container.mux(stream.encode(None))
        recording = open_recording(tmp_path / name)
        assert len(recording) == 40
        assert recording.duration == pytest.approx(39 / 25, abs=0.002)
        for index in (39, 13, 0, 26):
            assert abs(float(recording.frame(index, 0).mono().mean()) - level(index)) < 6
        recording.close()
