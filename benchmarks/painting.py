"""Showing a camera: the whole window at the camera's rate, and the image view alone without a limit.

    python -m benchmarks painting [--seconds 4] [--window 1600x1000]

The window is offscreen; graphics cards are not measured. The figures are compared with pyqtgraph's ImageItem,
which most Python viewers use, with the converted RGB image in the same run.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection

import cv2
import numpy as np
import pyqtgraph as pg
from PyQt5.QtCore import QRectF, QTimer
from PyQt5.QtWidgets import QApplication, QWidget

from benchmarks import _document
from benchmarks._network_ends import SENSOR_THREAD, cpu_seconds, thread_cpu_seconds
from benchmarks._results import Chart, Goal, Section, Table, machine
from benchmarks.conversion import random_frame
from grabbergui.core import pixels
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import by_name
from grabbergui.core.pixels import Region
from grabbergui.ui.views.image_view import ImageView

WARM = 30
"""Images painted before the measurement begins; by then the controls are filled."""
METHOD = """The whole window ({window}, as it opens), offscreen, on the simulated camera at the camera's own
rate for {seconds:g} seconds: frames received, images painted, and CPU of the process without the camera's
own thread. The camera shows a still pattern; nothing is reused from one frame to the next.

Then the image view alone, fed as fast as it paints ({view}, OpenCV on one thread): each frame is converted
to what the view shows, set, and painted before the next. *ImageItem* is pyqtgraph's; it receives the
finished RGB image, so its figures exclude the conversion."""


@dataclass(frozen=True)
class Case:
    """A camera to show."""

    label: str
    pixel_format: str
    width: int
    height: int
    rate: float
    "Frames per second."
    asked: bool = False
    "Whether there is a goal: shown with less than one core."

    @property
    def title(self) -> str:
        return f"{self.label} {self.pixel_format} at {self.rate:g}"


CASES = (
    Case("3 MP", "Mono8", 2048, 1536, 60),
    Case("3 MP", "RGB8", 2048, 1536, 60, asked=True),
    Case("3 MP", "BayerRG8", 2048, 1536, 60),
    Case("8.8 MP", "RGB8", 4096, 2160, 21),
    Case("8.8 MP", "BayerRG8", 4096, 2160, 21, asked=True),
    Case("8.8 MP", "BayerRG12p", 4096, 2160, 21),
)


@dataclass(frozen=True)
class Watched:
    """Frames that the whole window received and painted, and their cost."""

    came: float
    "Frames received per second."
    painted: float
    "Frames painted per second."
    cores: float
    "Cores used by the process, without the simulated sensor."
    sensor: float


def measure(argv: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks painting", description=__doc__)
    parser.add_argument("--seconds", type=float, default=4.0, help="that a camera is watched")
    parser.add_argument("--window", default="1600x1000", help="size in screen pixels")
    parser.add_argument("--view", default="1200x900", help="size of the view alone in screen pixels")
    options = parser.parse_args(argv)
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    before = machine()
    watched = {case: _in_a_process(case, options.window, options.seconds) for case in CASES}
    for case, seen in watched.items():
        print(case.label, case.pixel_format, seen, flush=True)
    application = QApplication.instance() or QApplication([])
    cv2.setNumThreads(1)
    columns, rows = (int(side) for side in options.view.split("x"))
    alone = {}
    for case in CASES:
        rate, cpu = in_the_view(case, columns, rows, 1.0)
        alone[case] = rate, cpu, in_an_image_item(case, columns, rows, 1.0)
    del application
    return Section(
        "Painting",
        "python -m benchmarks painting          # one minute",
        METHOD.format(window=options.window, seconds=options.seconds, view=options.view),
        [_watched_table(watched), _alone_table(alone)],
        [
            Chart(
                "painting-cpu",
                "The whole window showing a camera at its rate",
                "percent of one core",
                [case.title for case in CASES],
                {"CPU without the camera": [100 * watched[case].cores for case in CASES]},
                100.0,
                "one core",
            )
        ],
        [_goal(case, watched[case]) for case in CASES if case.asked],
        machine=before,
    )


def _goal(case: Case, seen: Watched) -> Goal:
    return Goal(
        f"{case.title} shown with less than one core",
        f"{seen.painted:.1f} of {seen.came:.1f} frames/s painted, {seen.cores:.0%}",
        seen.cores < 1 and seen.painted >= 0.95 * case.rate,
    )


def _watched_table(watched: dict[Case, Watched]) -> Table:
    rows = [
        [
            case.title,
            f"{seen.came:.1f}",
            f"{seen.painted:.1f}",
            f"{seen.cores:.0%}",
            f"{1e3 * seen.cores / max(seen.painted, 1):.1f} ms",
            f"{seen.sensor:.0%}",
        ]
        for case, seen in watched.items()
    ]
    header = ["camera", "received, fps", "painted, fps", "CPU", "CPU per image", "CPU of the camera"]
    return Table(header, rows, "The whole window:")


def _alone_table(alone: dict[Case, tuple[float, float, float]]) -> Table:
    rows = [
        [case.title, f"{rate:.0f}", f"{cpu * 1e3:.1f} ms", f"{peer:.0f}", f"{rate / peer:.1f}"]
        for case, (rate, cpu, peer) in alone.items()
    ]
    header = ["camera", "view alone, fps", "CPU per image", "ImageItem, fps", "ratio"]
    return Table(header, rows, "The image view alone, as fast as it paints:")


def _in_a_process(case: Case, window: str, seconds: float) -> Watched:
    """Each camera gets a new window in a new process."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=watch, args=(theirs, case, window, seconds))
    process.start()
    theirs.close()
    seen: Watched = ours.recv()
    process.join()
    return seen


def watch(pipe: Connection, case: Case, size: str, seconds: float) -> None:
    """Open the window on a camera and measure for a while."""
    from grabbergui.ui.application import application
    from grabbergui.ui.preferences import Preferences
    from grabbergui.ui.run.program import Program
    from grabbergui.ui.theme import Theme, dress
    from grabbergui.ui.views.main_window import MainWindow

    app = application()
    dress(app, Theme.LIGHT)
    window = MainWindow()
    window.resize(*(int(side) for side in size.split("x")))
    program = Program(window, Preferences(None))
    painted = [0]
    window.image.painted.connect(lambda: painted.__setitem__(0, painted[0] + 1))
    window.show()
    program.begin(
        f"sim:?width={case.width}&height={case.height}&fps={case.rate:g}"
        f"&pixel_format={case.pixel_format}&test_pattern=GreyHorizontalRamp"
    )

    window.image.painted.connect(lambda: app.quit() if painted[0] == WARM else None)
    app.exec_()
    count, came = painted[0], program.image.received
    cpu, sensor, began = cpu_seconds(), thread_cpu_seconds(SENSOR_THREAD), time.monotonic()
    QTimer.singleShot(round(1000 * seconds), app.quit)
    app.exec_()
    took = time.monotonic() - began
    cpu, sensor = cpu_seconds() - cpu, thread_cpu_seconds(SENSOR_THREAD) - sensor
    came = program.image.received - came
    pipe.send(Watched(came / took, (painted[0] - count) / took, (cpu - sensor) / took, sensor / took))
    window.close()
    program.shut_down(10)
    program.open_sources.wait_closed(10)


def in_the_view(case: Case, columns: int, rows: int, seconds: float) -> tuple[float, float]:
    """Return frames per second through the window's image view, and CPU seconds per frame."""
    frames = frames_of(case)
    view = ImageView()
    seen: list[tuple[Region, tuple[int, int]]] = []
    painted = [0]
    view.viewChanged.connect(lambda region, size: seen.append((region, size)))
    view.painted.connect(lambda: painted.__setitem__(0, painted[0] + 1))
    view.resize(columns, rows)
    view.show()

    def show_next(index: int) -> None:
        region, size = seen[-1] if seen else (None, (columns, rows))
        view.setImage(pixels.for_display(frames[index % len(frames)], region, size), case.width, case.height)
        before = painted[0]
        deadline = time.monotonic() + 5
        while painted[0] == before:
            QApplication.processEvents()
            if time.monotonic() > deadline:
                raise SystemExit("the view painted nothing for five seconds")

    return measured(show_next, seconds, view)


def in_an_image_item(case: Case, columns: int, rows: int, seconds: float) -> float:
    """Return frames per second through pyqtgraph's ImageItem: whole 8-bit images, converted before."""
    images = [pixels.for_display(frame).pixels for frame in frames_of(case)]
    view = pg.GraphicsView()
    box = pg.ViewBox(lockAspect=True, invertY=True)
    item = pg.ImageItem(axisOrder="row-major")
    view.setCentralItem(box)
    box.addItem(item)
    view.resize(columns, rows)
    view.show()
    box.setRange(QRectF(0, 0, case.width, case.height), padding=0)

    def show_next(index: int) -> None:
        item.setImage(images[index % len(images)], autoLevels=False, levels=(0, 255))
        view.viewport().repaint()
        QApplication.processEvents()

    return measured(show_next, seconds, view)[0]


def frames_of(case: Case) -> list[Frame]:
    """Return two different frames, so that nothing can be reused from the previous one."""
    frames = [random_frame(by_name(case.pixel_format), case.width, case.height) for _ in range(2)]
    frames[1].payload = np.roll(frames[1].payload, 12345)
    return frames


def measured(show: Callable[[int], None], seconds: float, widget: QWidget) -> tuple[float, float]:
    """Return frames per second and CPU seconds per frame of showing one after the other."""
    for index in range(3):
        show(index)
    count, start, cpu = 0, time.perf_counter(), time.process_time()
    while time.perf_counter() - start < seconds:
        show(count)
        count += 1
    rate, share = count / (time.perf_counter() - start), (time.process_time() - cpu) / count
    widget.close()
    widget.deleteLater()
    return rate, share


if __name__ == "__main__":
    print(_document.markdown(measure()))
