"""How fast each kind of recording is written, and which kinds keep up with a camera.

    python -m benchmarks recording [--frames 24] [--folder DIR]

The images come from the simulated sensor, with noise. Without --folder they are written to memory
(/dev/shm), so the disk is not measured.
"""

from __future__ import annotations

import argparse
import os
import shutil
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from benchmarks import _document
from benchmarks._network_ends import cpu_seconds
from benchmarks._network_runs import rounds_text
from benchmarks._results import Chart, Goal, Section, Table, machine
from grabbergui import sources
from grabbergui.core.frame import Frame
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.pfnc import by_name
from grabbergui.driver.sim.registers import SENSOR_HEIGHT, SENSOR_WIDTH
from grabbergui.driver.sim.sensor import Sensor
from grabbergui.driver.sim.settings import FrameSettings, Optics
from grabbergui.recording.kinds import RecordingKind
from grabbergui.recording.recorder import Recorder, RecordingProgress, create_writer
from grabbergui.recording.writer import RecordingWriter

METHOD = """Frames of the simulated sensor, noise included, are written as fast as each kind of recording
accepts them to a folder {where}. CPU is that of the whole process, all threads. Then the simulated camera's
stream is recorded for {seconds:g} seconds with the recorder of the window and of
`grabbergui record`{rounds}. *21 frames per second* is what an 8.8 MP camera sends over USB3. The OpenCV rows
show how movies were written in earlier versions."""
READING = [
    "The disk limits MCAP and TIFF: 8.8 MP at 21 frames per second are 186 MB/s.",
    "PNG is compressed on up to four cores, since 8.8 MP take one core some 55 ms; with fewer than two "
    "cores to spare it does not keep up with 8.8 MP at 21 frames per second. A Bayer pattern is kept as "
    "it is.",
    "Lossless H.264 stores each frame by itself, which is faster than differences. FFV1 makes smaller "
    "files, and suits smaller frames or lower rates.",
    "A movie of a Bayer camera is in colour, which is computed first.",
    "A recording that is too slow loses frames at the recorder's queue, which counts and shows them; the "
    "camera and the window are not affected.",
]


@dataclass(frozen=True)
class Row:
    """One kind of recording of one pixel format."""

    title: str
    kind: RecordingKind | None
    "Kind of recording; None for a movie by OpenCV."
    name: str
    pixel_format: str = "Mono8"
    code: str = ""
    "OpenCV's code of the codec."
    live: bool = True
    "Whether a live stream is recorded, too, which is a goal."


ROWS = (
    Row("MCAP", RecordingKind.MCAP, "x.mcap", "BayerRG8"),
    Row("folder of TIFF", RecordingKind.TIFF, "tiff", "BayerRG8"),
    Row("folder of PNG", RecordingKind.PNG, "png", "BayerRG8"),
    Row("movie, H.264", RecordingKind.H264, "h264.mp4"),
    Row("movie, H.264 lossless", RecordingKind.LOSSLESS, "lossless.mp4"),
    Row("movie, H.264, of Bayer", RecordingKind.H264, "colour.mp4", "BayerRG8", live=False),
    Row("movie, FFV1", RecordingKind.FFV1, "ffv1.mp4", live=False),
    Row("movie, OpenCV MPEG-4", None, "opencv.mp4", code="mp4v", live=False),
    Row("movie, OpenCV FFV1", None, "opencv-ffv1.mp4", code="FFV1", live=False),
)
SIZES = (("3 MP", 2048, 1536), ("8.8 MP", SENSOR_WIDTH, SENSOR_HEIGHT))
CAMERA_RATE = 21.0


@dataclass(frozen=True)
class Speed:
    """Speed and cost of one kind of recording."""

    rate: float
    cpu: float
    "CPU seconds per frame."
    size: float
    "Bytes per frame."


def measure(arguments: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks recording", description=__doc__)
    parser.add_argument("--frames", type=int, default=24, help="written as fast as it goes")
    parser.add_argument("--seconds", type=float, default=4.0, help="recorded of the camera")
    parser.add_argument("--rounds", type=int, default=1, help="of all, of which the best counts")
    parser.add_argument("--folder", type=Path, help="where to write; it is left as it was")
    options = parser.parse_args(arguments)
    memory = Path("/dev/shm")
    folder = options.folder or (memory if memory.is_dir() else Path(tempfile.gettempdir()))
    before = machine()
    speeds: dict[tuple[str, Row], Speed] = {}
    for size, width, height in SIZES:
        frames = {name: images(width, height, name) for name in ("Mono8", "BayerRG8")}
        for row in list(ROWS) * options.rounds:
            speed = written(row, frames[row.pixel_format], options.frames, folder)
            speeds[size, row] = max(speeds.get((size, row), speed), speed, key=lambda one: one.rate)
            print(size, row.title, speed, flush=True)
    live = recorded(folder, options.seconds, options.rounds)
    where = "in memory" if folder == memory else "on a disk"
    return Section(
        "Recording",
        "python -m benchmarks recording          # half a minute",
        METHOD.format(where=where, seconds=options.seconds, rounds=rounds_text(options.rounds)),
        [_table(speeds), _live_table(live)],
        [_chart(speeds)],
        [_goal(row, progress) for row, progress in live.items()],
        READING,
        before,
    )


def images(width: int, height: int, name: str = "BayerRG8", count: int = 6) -> list[Frame]:
    """Return consecutive images of the simulated studio."""
    sensor, pixel_format = Sensor(), by_name(name)
    left, top = (SENSOR_WIDTH - width) // 2, (SENSOR_HEIGHT - height) // 2
    optics = Optics(ratios=(1.6, 1.0, 1.3))
    settings = FrameSettings(width, height, left, top, pixel_format, optics, 5_000.0, 6.0, 2.0)
    frames = []
    for index in range(count):
        payload = np.empty(settings.image_bytes, np.uint8)
        sensor.render(settings, index, index * 33_000_000, payload)
        frames.append(Frame(payload, width, height, pixel_format))
    return frames


class OpenCvMovie:
    """Writes a movie with OpenCV."""

    def __init__(self, path: Path, code: str, frame: Frame) -> None:
        size, colour = (frame.width, frame.height), [cv2.VIDEOWRITER_PROP_IS_COLOR, 0]
        fourcc = cv2.VideoWriter.fourcc(*code)
        self._movie = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, fourcc, CAMERA_RATE, size, colour)
        if not self._movie.isOpened():
            raise OSError(f"OpenCV cannot write {path}")

    def write(self, frame: Frame) -> None:
        self._movie.write(frame.mono())

    def close(self) -> None:
        self._movie.release()


def written(row: Row, frames: list[Frame], count: int, folder: Path) -> Speed:
    """Write some frames and close the file."""
    with tempfile.TemporaryDirectory(dir=folder, prefix="recording-benchmark-") as place:
        path = Path(place) / row.name
        writer: OpenCvMovie | RecordingWriter
        if row.kind is None:
            writer = OpenCvMovie(path, row.code, frames[0])
        else:
            writer = create_writer(row.kind, path, DeviceInfo("sim:"), CAMERA_RATE)
        began, cpu = time.perf_counter(), cpu_seconds()
        for index in range(count):
            source = frames[index % len(frames)]
            # A new frame each time; a reused one would keep its conversion.
            frame = Frame(source.payload, source.width, source.height, source.pixel_format, index, index + 1)
            frame.received_ns = 1_700_000_000_000_000_000 + index * 47_619_047
            writer.write(frame)
        writer.close()
        took, cpu = time.perf_counter() - began, cpu_seconds() - cpu
        size = sum(file.stat().st_size for file in Path(place).rglob("*") if file.is_file())
        _require_room(folder)
    return Speed(count / took, cpu / count, size / count)


def recorded(folder: Path, seconds: float, rounds: int) -> dict[Row, RecordingProgress]:
    """Record the simulated camera's stream, 8.8 MP at its own rate, as the program does."""
    _, width, height = SIZES[-1]
    grabber = sources.create(f"sim:?width={width}&height={height}&fps={CAMERA_RATE:g}")
    grabber.open()
    try:
        found: dict[Row, RecordingProgress] = {}
        for row in [row for row in ROWS if row.live and row.kind is not None] * rounds:
            grabber.stop()
            grabber.write_feature("PixelFormat", row.pixel_format)
            grabber.start()
            with tempfile.TemporaryDirectory(dir=folder, prefix="recording-benchmark-") as place:
                assert row.kind is not None
                writer = create_writer(row.kind, Path(place) / row.name, grabber.info, CAMERA_RATE)
                recorder = Recorder(grabber, writer)
                recorder.start()
                time.sleep(seconds)
                recorder.stop()
                recorder.wait()
            progress = recorder.progress
            found[row] = min(found.get(row, progress), progress, key=lambda one: one.dropped)
            print(row.title, recorder.progress, flush=True)
            _require_room(folder)
    finally:
        grabber.close()
    return found


def _require_room(folder: Path) -> None:
    if (free := shutil.disk_usage(folder).free) < 2 << 30:
        raise SystemExit(f"{folder} has {free >> 20} MiB left; name another with --folder")


def _table(speeds: dict[tuple[str, Row], Speed]) -> Table:
    rows = [
        [
            size,
            row.title,
            row.pixel_format,
            f"{speed.rate:.1f}",
            f"{speed.cpu * 1e3:.1f} ms",
            f"{speed.size / 1e6:.2f} MB",
            f"{speed.rate * speed.size / 1e6:.0f} MB/s",
        ]
        for (size, row), speed in speeds.items()
    ]
    return Table(
        ["frame", "recording", "pixel format", "frames/s", "CPU per frame", "size per frame", "written"], rows
    )


def _chart(speeds: dict[tuple[str, Row], Speed]) -> Chart:
    sizes = dict.fromkeys(size for size, _ in speeds)
    return Chart(
        "recording-speed",
        f"Frames per second that a recording accepts, {os.cpu_count()} cores",
        "frames/s",
        [row.title for row in ROWS],
        {size: [speeds[size, row].rate for row in ROWS] for size in sizes},
        CAMERA_RATE,
        "8.8 MP over USB3",
        logarithmic=True,
    )


def _live_table(live: dict[Row, RecordingProgress]) -> Table:
    rows = [
        [row.title, row.pixel_format, str(progress.frames), str(progress.dropped), progress.reason]
        for row, progress in live.items()
    ]
    title = f"The camera's stream, 8.8 MP at {CAMERA_RATE:g} frames per second:"
    return Table(["recording", "pixel format", "frames", "lost", "ended by itself"], rows, title)


def _goal(row: Row, progress: RecordingProgress) -> Goal:
    return Goal(
        f"8.8 MP {row.pixel_format} at {CAMERA_RATE:g} frames per second recorded as {row.title}, none lost",
        f"{progress.frames} recorded, {progress.dropped} lost",
        progress.dropped == 0 and progress.frames > 0,
    )


if __name__ == "__main__":
    print(_document.markdown(measure()))
