"""Other waits of an operator of a GigE Vision camera: with this driver, with Aravis, and in the window."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from tempfile import NamedTemporaryFile, TemporaryDirectory

from benchmarks._tuning_cameras import ADDRESS, WIDTH, WRITE_PAUSE, Tuned, gige
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.uri import SourceUri
from grabbergui.driver.genapi.vetting import vetted

PATIENCE = 20.0
SYSTEM_PYTHON = Path("/usr/bin/python3")
PEER = Path(__file__).with_name("_aravis_operator.py")


def ours(rounds: int, writes: int) -> tuple[dict[str, float], list[float]]:
    """Return the median seconds of each action with this driver, and of each write of the gain.

    An action that leads to an image ends when the image is received.
    """
    gains: list[float] = []
    with gige() as tuned:
        runs = [_driven(tuned, writes, gains) for _ in range(rounds)]
    return {name: statistics.median(run[name] for run in runs) for name in runs[0]}, gains


def aravis(rounds: int, writes: int) -> tuple[dict[str, float], list[float]]:
    """Return the same with Aravis; the gain is written while it streams."""
    command = [str(SYSTEM_PYTHON), str(PEER), ADDRESS, str(writes), str(WRITE_PAUSE)]
    runs = []
    with gige():
        for _ in range(rounds):
            done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
            if done.returncode:
                return {}, []
            runs.append(json.loads(done.stdout))
    gains = [seconds for run in runs for seconds in run.pop("writes")]
    return {name: statistics.median(run[name] for run in runs) for name in runs[0]}, gains


def _driven(tuned: Tuned, writes: int, gains: list[float]) -> dict[str, float]:
    took: dict[str, float] = {}

    def timed(name: str, *actions: Callable[[], object]) -> None:
        began = time.monotonic()
        for action in actions:
            action()
        took[name] = time.monotonic() - began

    camera = tuned.create(SourceUri.parse(tuned.uri))
    with _forgotten_descriptions():
        timed("open first", camera.open)
        camera.close()
        timed("open", camera.open)
    try:
        queue = camera.open_queue(2)
        timed("start", camera.start, lambda: queue.get(PATIENCE))
        for number in range(writes):
            end = time.monotonic() + WRITE_PAUSE
            while time.monotonic() < end:
                queue.get(PATIENCE)  # as Aravis's side does
            began = time.monotonic()
            camera.write_feature("Gain", float(number % 2))
            gains.append(time.monotonic() - began)
        for name, feature, value in (("pixel format", "PixelFormat", "Mono16"), ("region", "Height", 768)):
            before = camera.feature(feature).value
            timed(name, partial(_change, camera, queue, feature, value))
            assert before is not None
            camera.write_feature(feature, before)
        timed("stop", camera.stop)
        timed("start and stop", camera.start, camera.stop)
        other = tuned.create(SourceUri.parse(tuned.uri))
        timed("take control", lambda: other.open(Access.TAKE_OVER))
        other.close()
    finally:
        camera.close()
    return took


@contextmanager
def _forgotten_descriptions() -> Iterator[None]:
    """Use an empty cache of camera descriptions."""
    vetted.cache_clear()
    before = os.environ.get("XDG_CACHE_HOME")
    with TemporaryDirectory() as folder:
        os.environ["XDG_CACHE_HOME"] = folder
        try:
            yield
        finally:
            del os.environ["XDG_CACHE_HOME"]
            if before is not None:
                os.environ["XDG_CACHE_HOME"] = before


def _change(camera: FrameGrabber, queue: FrameQueue, feature: str, value: str | int) -> None:
    """Write a feature and wait for the first frame with the new value."""
    camera.write_feature(feature, value)

    def changed(frame: Frame) -> bool:
        return value in (str(frame.pixel_format), frame.height)

    while not changed(queue.get(PATIENCE)):
        pass


_SCRIPT = """
import statistics, time
canvas, sources = app.window.image.canvas, app.program.open_sources
show, seen, painted = canvas.setImage, [0], []

def set_image(image, width, height):
    seen[0] = width
    show(image, width, height)

canvas.setImage = set_image
app.window.image.painted.connect(lambda: painted.append((time.monotonic(), seen[0])))
app.until(lambda: painted, {patience}, "an image")
first = painted[0][0]
app.program.opener.open_additional("sim:?width=640&height=480&fps=100")
app.until(lambda: len(sources.all) == 2, {patience}, "a second camera")
app.wait(1.0)
widths, switched = (640, {width}), []
for number in range(20):
    app.wait(0.1)
    painted.clear()
    other = next(source for source in sources.all if source is not sources.current)
    began = time.monotonic()
    sources.make_current(other)
    app.until(lambda: any(w == widths[number % 2] for _, w in painted), {patience}, "the other camera")
    switched.append(next(at for at, w in painted if w == widths[number % 2]) - began)
print(first, statistics.median(switched))
"""
"""Script for the window: prints when the first image was painted, and how long a switch of cameras took."""


def by_the_window(rounds: int) -> dict[str, float]:
    """Return the median seconds to the first painted image, and of a switch between cameras.

    The first time counts from the start of the program with the camera's address; the program is compiled,
    as after pip, and the camera's description is cached. A switch between two open cameras ends with the
    first painted image of the other one; the median of 20 in each round counts.
    """
    script = _SCRIPT.format(width=WIDTH, patience=PATIENCE)
    starts, switches = [], []
    with gige() as tuned, NamedTemporaryFile("w", suffix=".py") as file, TemporaryDirectory() as compiled:
        file.write(script)
        file.flush()
        environment = {**os.environ, "PYTHONPYCACHEPREFIX": compiled}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        program = [sys.executable, "-m", "grabbergui", "gui", tuned.uri, "--offscreen"]
        for _ in range(1 + rounds):  # the first one compiles
            began = time.monotonic()
            command = [*program, "--script", file.name]
            done = subprocess.run(
                command, env=environment, capture_output=True, text=True, timeout=60, check=True
            )
            first, switched = map(float, done.stdout.split()[-2:])
            starts.append(first - began)
            switches.append(switched)
    return {"program start": statistics.median(starts[1:]), "switch": statistics.median(switches[1:])}
