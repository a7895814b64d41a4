"""Painting pictures in the window's own view, offscreen: from a frame to pixels on the screen.

Each frame is made ready for the view (`core.pixels.for_display`), set, and painted before the next; CPU is
of the whole process, so a core is busy for that share when a camera sends at the rate named. The peer is
pyqtgraph's ImageItem, which most Python viewers use, given the finished RGB picture in the same run.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
import pyqtgraph as pg
from PyQt5.QtCore import QRectF
from PyQt5.QtWidgets import QApplication, QWidget

from benchmarks.conversion import random_frame
from grabbergui.core import pixels
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import by_name
from grabbergui.core.region import Region
from grabbergui.ui.views.picture_view import PictureView


@dataclass(frozen=True)
class Case:
    """A camera to watch."""

    label: str
    pixel_format: str
    width: int
    height: int
    rate: float
    "Frames per second at which its share of a core is stated."


CASES = (
    Case("3 MP", "Mono8", 2048, 1536, 60),
    Case("3 MP", "RGB8", 2048, 1536, 60),
    Case("3 MP", "BayerRG8", 2048, 1536, 60),
    Case("8.8 MP", "RGB8", 4096, 2160, 21),
    Case("8.8 MP", "BayerRG8", 4096, 2160, 21),
    Case("8.8 MP", "BayerRG12p", 4096, 2160, 21),
)


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks painting", description=__doc__)
    parser.add_argument("--seconds", type=float, default=1.0, help="spent on each figure")
    parser.add_argument("--view", default="1200x900", help="size of the view in screen pixels")
    arguments = parser.parse_args(argv)
    columns, rows = (int(side) for side in arguments.view.split("x"))
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    application = QApplication.instance() or QApplication([])
    cv2.setNumThreads(1)
    print(f"view {columns}×{rows}, platform {application.platformName()}, each frame painted before the next")
    print(
        f"{'camera':8}{'format':12}{'frames/s':>9}{'CPU ms':>8}{'of a core':>20}{'ImageItem/s':>13}"
        f"{'ratio':>7}"
    )
    for case in CASES:
        rate, cpu = in_the_window(case, columns, rows, arguments.seconds)
        peer = in_an_image_item(case, columns, rows, arguments.seconds)
        share = f"{cpu * case.rate:.0%} at {case.rate:g}/s"
        print(
            f"{case.label:8}{case.pixel_format:12}{rate:9.0f}{cpu * 1e3:8.2f}{share:>20}"
            f"{peer:13.0f}{rate / peer:7.1f}",
            flush=True,
        )


def in_the_window(case: Case, columns: int, rows: int, seconds: float) -> tuple[float, float]:
    """Frames per second through the window's picture view, and CPU seconds a frame."""
    frames = frames_of(case)
    view = PictureView()
    seen: list[tuple[Region, tuple[int, int]]] = []
    painted = [0]
    view.viewChanged.connect(lambda region, size: seen.append((region, size)))
    view.painted.connect(lambda: painted.__setitem__(0, painted[0] + 1))
    view.resize(columns, rows)
    view.show()

    def show_next(index: int) -> None:
        region, size = seen[-1] if seen else (None, (columns, rows))
        view.setPicture(
            pixels.for_display(frames[index % len(frames)], region, size), case.width, case.height
        )
        before = painted[0]
        deadline = time.monotonic() + 5
        while painted[0] == before:
            QApplication.processEvents()
            if time.monotonic() > deadline:
                raise SystemExit("the view painted nothing for five seconds")

    return measured(show_next, seconds, view)


def in_an_image_item(case: Case, columns: int, rows: int, seconds: float) -> float:
    """Frames per second through pyqtgraph's ImageItem: the whole picture in 8 bits, converted outside."""
    pictures = [pixels.for_display(frame).pixels for frame in frames_of(case)]
    view = pg.GraphicsView()
    box = pg.ViewBox(lockAspect=True, invertY=True)
    item = pg.ImageItem(axisOrder="row-major")
    view.setCentralItem(box)
    box.addItem(item)
    view.resize(columns, rows)
    view.show()
    box.setRange(QRectF(0, 0, case.width, case.height), padding=0)

    def show_next(index: int) -> None:
        item.setImage(pictures[index % len(pictures)], autoLevels=False, levels=(0, 255))
        view.viewport().repaint()
        QApplication.processEvents()

    return measured(show_next, seconds, view)[0]


def frames_of(case: Case) -> list[Frame]:
    """Two different frames, so that nothing can be kept from the one before."""
    frames = [random_frame(by_name(case.pixel_format), case.width, case.height) for _ in range(2)]
    frames[1].payload = np.roll(frames[1].payload, 12345)
    return frames


def measured(show: Callable[[int], None], seconds: float, widget: QWidget) -> tuple[float, float]:
    """Frames per second and CPU seconds a frame of showing one after the other."""
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
    main()
