"""How fast recordings of each kind are written, and so which of them keep up with a camera.

    python -m benchmarks recording [--frames 24] [--folder DIR]

The pictures are the simulated sensor's, noise included. Without --folder they go to a folder in memory
(/dev/shm), so that the writers are measured and not the disk.
"""

from __future__ import annotations

import argparse
import os
import shutil
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks import _document
from benchmarks._network_ends import cpu_seconds
from benchmarks._network_runs import rounds_text
from benchmarks._results import Chart, Goal, Section, Table, machine
from grabbergui import sources
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import DeviceInfo
from grabbergui.core.pfnc import by_name
from grabbergui.driver.sim.registers import SENSOR_HEIGHT, SENSOR_WIDTH
from grabbergui.driver.sim.sensor import Sensor
from grabbergui.driver.sim.settings import FrameSettings, Optics
from grabbergui.recording.recorder import Recorder, RecordingProgress
from grabbergui.recording.writer import RecordingKind, create_writer

METHOD = """Pictures of the simulated sensor with its noise (BayerRG8), written as fast as each kind of
recording takes them into a folder {where}. CPU is of the whole process, all threads. Then the simulated
camera's stream for {seconds:g} seconds, by the recorder of the window and of `grabbergui record`{rounds}.
*21 frames a second* is what an 8.8 MP camera sends over USB3."""
READING = [
    "MCAP and TIFF are bounded by the disk: 8.8 MP at 21 frames a second are 186 MB/s.",
    "PNG is compressed on up to four cores, since one takes 8.8 MP some 55 ms; with fewer than two cores to "
    "spare it does not keep up with 8.8 MP at 21 frames a second. A Bayer pattern is kept as it is.",
    "A movie of a Bayer camera is of its colours, which are computed first. "
    "Lossless H.264 keeps each frame by itself, which is faster than differences. HEVC, AV1 and FFV1 make "
    "smaller files and are for smaller frames or lower rates.",
    "What is too slow loses frames at the recorder's queue, which counts and shows them; the camera and the "
    "picture do not notice.",
]
NAMES = {
    RecordingKind.MCAP: "x.mcap",
    RecordingKind.TIFF: "tiff",
    RecordingKind.PNG: "png",
    RecordingKind.H264: "h264.mp4",
    RecordingKind.HEVC: "hevc.mp4",
    RecordingKind.AV1: "av1.mp4",
    RecordingKind.LOSSLESS: "lossless.mp4",
    RecordingKind.FFV1: "ffv1.mp4",
}
KIND_NAMES = {
    RecordingKind.MCAP: "MCAP",
    RecordingKind.TIFF: "folder of TIFF",
    RecordingKind.PNG: "folder of PNG",
    RecordingKind.H264: "movie, H.264",
    RecordingKind.HEVC: "movie, HEVC",
    RecordingKind.AV1: "movie, AV1",
    RecordingKind.LOSSLESS: "movie, H.264 lossless",
    RecordingKind.FFV1: "movie, FFV1",
}
SIZES = (("3 MP", 2048, 1536), ("8.8 MP", SENSOR_WIDTH, SENSOR_HEIGHT))
CAMERA_RATE = 21.0


@dataclass(frozen=True)
class Speed:
    """What one kind of recording took."""

    rate: float
    cpu: float
    "Seconds a frame."
    size: float
    "Bytes a frame."


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
    speeds: dict[tuple[str, RecordingKind], Speed] = {}
    for size, width, height in SIZES:
        frames = pictures(width, height)
        for kind in list(NAMES) * options.rounds:
            speed = written(kind, frames, options.frames, folder)
            speeds[size, kind] = max(speeds.get((size, kind), speed), speed, key=lambda one: one.rate)
            print(size, kind.value, speed, flush=True)
    live = recorded(folder, options.seconds, options.rounds)
    where = "in memory" if folder == memory else "on a disk"
    return Section(
        "Recording",
        "python -m benchmarks recording          # half a minute",
        METHOD.format(where=where, seconds=options.seconds, rounds=rounds_text(options.rounds)),
        [_table(speeds), _live_table(live)],
        [_chart(speeds)],
        [_goal(kind, live[kind]) for kind in NAMES if kind is not RecordingKind.LOSSLESS],
        READING,
        before,
    )


def pictures(width: int, height: int, count: int = 6) -> list[Frame]:
    """A moment of the simulated studio."""
    sensor, pixel_format = Sensor(), by_name("BayerRG8")
    left, top = (SENSOR_WIDTH - width) // 2, (SENSOR_HEIGHT - height) // 2
    optics = Optics(ratios=(1.6, 1.0, 1.3))
    settings = FrameSettings(width, height, left, top, pixel_format, optics, 5_000.0, 6.0, 2.0)
    frames = []
    for index in range(count):
        payload = np.empty(settings.image_bytes, np.uint8)
        sensor.render(settings, index, index * 33_000_000, payload)
        frames.append(Frame(payload, width, height, pixel_format))
    return frames


def written(kind: RecordingKind, frames: list[Frame], count: int, folder: Path) -> Speed:
    """Write some frames, closing included."""
    with tempfile.TemporaryDirectory(dir=folder, prefix="recording-benchmark-") as place:
        writer = create_writer(kind, Path(place) / NAMES[kind], DeviceInfo("sim:"), CAMERA_RATE)
        began, cpu = time.perf_counter(), cpu_seconds()
        for index in range(count):
            source = frames[index % len(frames)]
            # A frame of its own, or its conversion would be kept from the time before.
            frame = Frame(source.payload, source.width, source.height, source.pixel_format, index, index + 1)
            frame.received_ns = 1_700_000_000_000_000_000 + index * 47_619_047
            writer.write(frame)
        writer.close()
        took, cpu = time.perf_counter() - began, cpu_seconds() - cpu
        size = sum(file.stat().st_size for file in Path(place).rglob("*") if file.is_file())
        _require_room(folder)
    return Speed(count / took, cpu / count, size / count)


def recorded(folder: Path, seconds: float, rounds: int) -> dict[RecordingKind, RecordingProgress]:
    """The simulated camera's stream, 8.8 MP at its rate, by the recorder of window and command line."""
    _, width, height = SIZES[-1]
    uri = f"sim:?width={width}&height={height}&fps={CAMERA_RATE:g}&pixel_format=BayerRG8"
    grabber = sources.create(uri)
    grabber.open()
    try:
        grabber.start()
        found: dict[RecordingKind, RecordingProgress] = {}
        for kind in list(NAMES) * rounds:
            with tempfile.TemporaryDirectory(dir=folder, prefix="recording-benchmark-") as place:
                path = Path(place) / NAMES[kind]
                recorder = Recorder(grabber, create_writer(kind, path, grabber.info, CAMERA_RATE))
                recorder.start()
                time.sleep(seconds)
                recorder.stop()
                recorder.wait()
            progress = recorder.progress
            found[kind] = min(found.get(kind, progress), progress, key=lambda one: one.dropped)
            print(kind.value, recorder.progress, flush=True)
            _require_room(folder)
    finally:
        grabber.close()
    return found


def _require_room(folder: Path) -> None:
    if (free := shutil.disk_usage(folder).free) < 2 << 30:
        raise SystemExit(f"{folder} has {free >> 20} MiB left; name another with --folder")


def _table(speeds: dict[tuple[str, RecordingKind], Speed]) -> Table:
    rows = [
        [
            size,
            KIND_NAMES[kind],
            f"{speed.rate:.1f}",
            f"{speed.cpu * 1e3:.1f} ms",
            f"{speed.size / 1e6:.2f} MB",
            f"{speed.rate * speed.size / 1e6:.0f} MB/s",
        ]
        for (size, kind), speed in speeds.items()
    ]
    return Table(["picture", "recording", "frames/s", "CPU a frame", "size a frame", "written"], rows)


def _chart(speeds: dict[tuple[str, RecordingKind], Speed]) -> Chart:
    sizes = dict.fromkeys(size for size, _ in speeds)
    return Chart(
        "recording-speed",
        f"Frames a second that a recording takes, {os.cpu_count()} cores",
        "frames/s",
        [KIND_NAMES[kind] for kind in NAMES],
        {size: [speeds[size, kind].rate for kind in NAMES] for size in sizes},
        CAMERA_RATE,
        "8.8 MP over USB3",
        logarithmic=True,
    )


def _live_table(live: dict[RecordingKind, RecordingProgress]) -> Table:
    rows = [
        [KIND_NAMES[kind], str(progress.frames), str(progress.dropped), progress.reason or ""]
        for kind, progress in live.items()
    ]
    title = f"The camera at {CAMERA_RATE:g} frames a second, 8.8 MP:"
    return Table(["recording", "frames", "lost", "ended by itself"], rows, title)


def _goal(kind: RecordingKind, progress: RecordingProgress) -> Goal:
    return Goal(
        f"8.8 MP at {CAMERA_RATE:g} frames a second recorded as {KIND_NAMES[kind]} without a loss",
        f"{progress.frames} recorded, {progress.dropped} lost",
        progress.dropped == 0 and progress.frames > 0,
    )


if __name__ == "__main__":
    print(_document.markdown(measure()))
