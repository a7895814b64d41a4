"""The cost of `camera.frames()` compared with the bare queue, and the wait for a frame with a new setting.

python -m benchmarks library [--seconds 5] [--rounds 3]
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from contextlib import closing
from typing import NamedTuple

import grabbergui
from benchmarks import _document
from benchmarks._gige_camera import ADDRESS, GIGABIT, Conditions, camera_process
from benchmarks._results import Goal, Section, Table, machine

DEAREST = 1.03
"Goal: CPU time of the iterator as a multiple of the queue's."

METHOD = """A simulated GigE camera in another process sends frames of 4 MiB at 4 Gbit/s. They are read for
{seconds:g} s in turn by a bare loop over `queue.get()` and by `for frame in camera.frames()`; medians of
{rounds} turns. CPU is that of the reading process, driver included, per frame, and that of the reading
thread alone: the rest does not depend on the reader, and varies by more than the thread takes. The goal
compares the threads' difference with the whole cost of a frame. *With a setting* is
`camera.grab(ExposureTime=…)` at 100 frames/s with a sensor that applies settings two frames later: from the
call to the first frame with that exposure. The first call switches chunk data on."""


class Turn(NamedTuple):
    """Frames per second, and CPU seconds per frame of the process and of its reading thread."""

    rate: float
    process: float
    thread: float


def measure(argv: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks library", description=__doc__)
    parser.add_argument("--seconds", type=float, default=3.0, help="of each turn")
    parser.add_argument("--rounds", type=int, default=7, help="turns of each")
    options = parser.parse_args(argv)
    before = machine()
    turns: dict[str, list[Turn]] = {"queue.get()": [], "camera.frames()": []}
    with camera_process(Conditions(bandwidth=4 * GIGABIT)), grabbergui.open(f"gige:{ADDRESS}") as camera:
        camera.start()
        ways = {"queue.get()": _by_queue, "camera.frames()": _by_frames}
        for turn in range(options.rounds):
            for name in sorted(ways, reverse=bool(turn % 2)):
                turns[name].append(_timed(ways[name], camera, options.seconds))
    rows, figures = [], dict[str, Turn]()
    for name, measured in turns.items():
        usual = Turn(*(statistics.median(column) for column in zip(*measured, strict=True)))
        figures[name] = usual
        rows.append(
            [name, f"{usual.rate:.0f}", f"{usual.process * 1e6:.0f} µs", f"{usual.thread * 1e6:.0f} µs"]
        )
    queue, frames = figures["queue.get()"], figures["camera.frames()"]
    ratio = 1 + (frames.thread - queue.thread) / queue.process
    goal = Goal(f"CPU of the iterator at most {DEAREST:g} × the queue's", f"{ratio:.3f} ×", ratio <= DEAREST)
    delays = Table(
        ["a frame with a setting", "median", "longest", "first call"],
        [_delay("ExposureTime", "by chunk data"), _delay("BlackLevel", "by counting")],
    )
    return Section(
        "The Python library",
        "python -m benchmarks library             # half a minute",
        METHOD.format(seconds=options.seconds, rounds=options.rounds),
        [Table(["read by", "frames/s", "CPU per frame", "CPU of the reading thread"], rows), delays],
        goals=[goal],
        machine=before,
    )


def _timed(
    run: Callable[[grabbergui.Camera, float], int], camera: grabbergui.Camera, duration: float
) -> Turn:
    began, process, thread = time.monotonic(), time.process_time(), time.thread_time()
    frames = run(camera, duration)
    return Turn(
        frames / (time.monotonic() - began),
        (time.process_time() - process) / frames,
        (time.thread_time() - thread) / frames,
    )


def _by_queue(camera: grabbergui.Camera, seconds: float) -> int:
    with closing(camera.grabber.open_queue(8)) as queue:
        count, end = 0, time.monotonic() + seconds
        while time.monotonic() < end:
            _frame = queue.get(5.0)  # held until the next one comes, as a loop does
            count += 1
    return count


def _by_frames(camera: grabbergui.Camera, seconds: float) -> int:
    count, end = 0, time.monotonic() + seconds
    for _frame in camera.frames():
        count += 1
        if time.monotonic() >= end:
            break
    return count


def _delay(setting: str, name: str) -> list[str]:
    took = []
    uri = "sim:?width=640&height=480&fps=100&exposure=1000&setting_latency=2"
    with grabbergui.open(uri) as camera:
        for turn in range(40):
            value = (1 + turn % 3) * (1000 if setting == "ExposureTime" else 1)
            began = time.monotonic()
            camera.grab(**{setting: value})
            took.append(1e3 * (time.monotonic() - began))
    first, *later = took
    return [name, f"{statistics.median(later):.0f} ms", f"{max(later):.0f} ms", f"{first:.0f} ms"]


if __name__ == "__main__":
    print(_document.markdown(measure()))
