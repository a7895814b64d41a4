"""Calibration of the current camera from views that are taken automatically."""

from __future__ import annotations

import logging
import queue
import re
import threading
import time
from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from psygnal import Signal

from grabbergui.calibration import camera_info
from grabbergui.calibration.boards import BoardSettings
from grabbergui.calibration.collector import Collector, Coverage, Result, ViewVerdict
from grabbergui.calibration.frame_geometry import GeometryReader
from grabbergui.core.errors import CalibrationError, GrabberError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameSink
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.pixels import DisplayImage, Region, for_display
from grabbergui.models.error_text import error_text
from grabbergui.models.image.display_settings import DisplaySettings
from grabbergui.models.image.rendering import render
from grabbergui.models.language import translate

log = logging.getLogger(__name__)

WANTED = 20
"Number of views after which the calibration is computed automatically."
FRAME_WAIT = 0.2
SILENCE = 2.0
"Seconds without a frame after which the silence is reported."
TAKE_WAIT = 0.5
"Seconds to wait for the window; a hidden window takes no previews."
KEPT_SIZE = (960, 720)
"Largest width and height in pixels of the images kept of views."


@dataclass(frozen=True, eq=False)
class Preview:
    """The newest frame in a calibration dialog, with the corners detected in it."""

    image: DisplayImage | None
    "None if no frames arrive."
    size: tuple[int, int]
    "Width and height of the whole image."
    corners: NDArray[np.floating[Any]] | None
    "(n, 2) pixels of the whole image; None if no board is seen."


@dataclass(frozen=True, eq=False)
class BoardPreview(Preview):
    """The newest frame and the state of the collection."""

    verdict: ViewVerdict | None
    coverage: Coverage
    views: int
    "Number of views kept so far."
    hint: str
    "The next step for the user, as display text."


@dataclass(frozen=True, eq=False)
class CalibrationSolution:
    """A calibration with the views it was computed from."""

    result: Result
    used: frozenset[int]
    "Numbers of the views that were used."
    corners: list[NDArray[np.float32]]
    "(n, 2) of each view."
    request: int = 0
    "Number of the request that it answers, from 1."


class CalibratingModel:
    """Collects views from a source's frames and computes the calibration, on a thread of its own.

    Only `close` waits; signals are emitted on that thread.
    """

    ready = Signal()
    """`take` returns a new preview."""
    solved = Signal(CalibrationSolution)
    saved = Signal(Path)
    unsolved = Signal(str)
    """The newest request to solve failed; a sentence as display text."""
    failed = Signal(str)
    """Another request failed; a sentence as display text."""

    def __init__(self, grabber: FrameGrabber, settings: BoardSettings | None = None) -> None:
        self.settings = settings or BoardSettings()
        self.name = camera_name(grabber.info)
        "The camera's name in the calibration file."
        self.wanted = WANTED
        self.images: list[DisplayImage] = []
        "Reduced images of the kept views."
        self.requests = 0
        "Number of calls of `solve`; a solution of an earlier request is outdated."
        self._grabber = grabber
        self._geometries = GeometryReader(grabber)
        self._board = self.settings.board()
        self._collector = Collector(self._board, self.wanted, still=True)
        self._collecting = False
        self._result: Result | None = None
        self._left_out: frozenset[int] = frozenset()
        "Numbers of the views that the user excluded."
        self._jobs: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._view: tuple[Region | None, tuple[int, int] | None] = (None, None)
        self._offer: BoardPreview | None = None
        self._taken = threading.Event()
        self._lock = threading.Lock()
        self._sink: FrameSink | None = None
        self._closed = False
        self._seen = 0.0
        "Time of the last frame on the monotonic clock."

    def open(self) -> None:
        """Start to examine frames. The source must be streaming."""
        self._seen = time.monotonic()
        self._sink = FrameSink(
            self._grabber,
            self._consume,
            name="calibrating",
            depth=1,
            wait=FRAME_WAIT,
            between=self._work,
            failed=self._on_sink_failed,
        )
        self._sink.start()

    def close(self, timeout: float = 2.0) -> bool:
        """Stop; return whether the thread ended within `timeout` seconds. May be called twice."""
        self._closed = True
        self._taken.set()
        self._geometries.close()
        return self._sink is None or self._sink.stop(timeout)

    def take(self) -> BoardPreview | None:
        """Return the newest preview, once."""
        with self._lock:
            offer, self._offer = self._offer, None
        self._taken.set()
        return offer

    def set_viewport(self, region: Region | None, size: tuple[int, int] | None) -> None:
        """Set the viewport: a region of the image (None: all of it), in `size` screen pixels."""
        self._view = region, size

    def choose(self, settings: BoardSettings) -> None:
        """Choose a board, and discard the views of the previous one. Raises UsageError for an invalid one."""
        board = settings.board()
        self.settings = settings

        def change() -> None:
            self._board = board
            self._begin()

        self._jobs.put(change)

    def collect(self, on: bool) -> None:
        """Collect views, or only show what is detected."""

        def change() -> None:
            if on and self._collector.complete:
                self._collector.wanted += WANTED // 2
                self.wanted = self._collector.wanted
            self._collecting = on

        self._jobs.put(change)

    def begin_again(self) -> None:
        """Discard all views."""
        self._jobs.put(self._begin)

    def solve(self, used: Collection[int] | None = None) -> None:
        """Compute the calibration from these views, by default from all that fit and were not excluded.

        `solved` or `unsolved` follows, unless another request does.
        """
        chosen = None if used is None else frozenset(used)
        self.requests += 1
        request = self.requests
        self._jobs.put(lambda: self._solve(chosen, request))

    def save(self, path: Path) -> None:
        """Write the calibration as camera_info YAML; `saved` or `failed` follows."""

        def write() -> None:
            if self._result is None:
                self.failed.emit(translate("Calibrating", "there is no calibration to save yet"))
                return
            try:
                camera_info.save(self._result.calibration.made_with(self._grabber.info), path)
            except OSError as error:
                text = translate("Calibrating", "the calibration could not be saved: {0}")
                self.failed.emit(text.format(error.strerror or error))
            else:
                self.saved.emit(path)

        self._jobs.put(write)

    def _consume(self, frame: Frame) -> bool:
        self._seen = time.monotonic()
        if not frame.complete:
            return False
        try:
            self._see(frame)
        except CalibrationError:  # the image size changed, which makes the earlier views useless
            self._begin()
            raise
        return True

    def _on_sink_failed(self, error: Exception, frame: Frame) -> None:
        if isinstance(error, GrabberError):
            self.failed.emit(error_text(error))
            return
        text = translate("Calibrating", "frame {0} cannot be evaluated: {1}")
        self.failed.emit(text.format(frame.frame_id, error))

    def _work(self) -> None:
        """Run the queued jobs, and report a silent source."""
        while True:
            try:
                job = self._jobs.get_nowait()
            except queue.Empty:
                break
            job()
        if time.monotonic() - self._seen > SILENCE and not self._closed:
            self._put(self._preview(None, (0, 0), None))

    def _see(self, frame: Frame) -> None:
        collector = self._collector
        geometry = self._geometries.of(frame)
        verdict = collector.look(frame.mono(), keep=self._collecting, geometry=geometry)
        if verdict is ViewVerdict.KEPT and self._collecting:
            self.images.append(for_display(frame, None, KEPT_SIZE))
        image = render(frame, *self._view, DisplaySettings())
        self._put(self._preview(image, (frame.width, frame.height), verdict))
        if self._collecting and collector.complete:
            self._collecting = False
            self._solve(None, self.requests)

    def _preview(
        self, image: DisplayImage | None, size: tuple[int, int], verdict: ViewVerdict | None
    ) -> BoardPreview:
        collector = self._collector
        hint = hint_text(collector.coverage.missing()) if image is not None else ""
        seen = collector.last if image is not None else None
        corners = None if seen is None else seen.image
        return BoardPreview(
            image, size, corners, verdict, collector.coverage.copy(), len(collector.views), hint
        )

    def _put(self, preview: BoardPreview) -> None:
        with self._lock:
            self._taken.clear()
            self._offer = preview
        self.ready.emit()
        self._taken.wait(TAKE_WAIT)

    def _begin(self) -> None:
        self._collector = Collector(self._board, WANTED, still=True)
        self.wanted = WANTED
        self.images = []
        self._result, self._left_out = None, frozenset()

    def _solve(self, used: frozenset[int] | None, request: int) -> None:
        if request != self.requests:  # a newer request follows
            return
        try:
            result = self._collector.solve(self.name, used, self._left_out)
        except GrabberError as error:
            self.unsolved.emit(error_text(error))
            return
        self._result = result
        if used is not None:
            self._left_out = frozenset(range(len(result.errors))) - used
        chosen = frozenset(number for number, error in enumerate(result.errors) if np.isfinite(error))
        self.solved.emit(
            CalibrationSolution(result, chosen, [view.image for view in self._collector.views], request)
        )


def verdict_text(verdict: ViewVerdict) -> str:
    """Return the outcome of one detection, in the user's language."""
    return {
        ViewVerdict.NOT_SEEN: translate("Calibrating", "no board is seen"),
        ViewVerdict.MOVING: translate("Calibrating", "hold it still"),
        ViewVerdict.KNOWN: translate("Calibrating", "this view is there already"),
        ViewVerdict.KEPT: translate("Calibrating", "kept"),
    }[verdict]


def hint_text(missing: str) -> str:
    """Return the next step for what `Coverage.missing` lists, in the user's language."""
    if not missing:
        return translate("Calibrating", "Everything is covered")
    return {
        "with its left edge nearer": translate("Calibrating", "Next: tilt it, its left edge nearer"),
        "with its right edge nearer": translate("Calibrating", "Next: tilt it, its right edge nearer"),
        "with its upper edge nearer": translate("Calibrating", "Next: tilt it, its upper edge nearer"),
        "with its lower edge nearer": translate("Calibrating", "Next: tilt it, its lower edge nearer"),
        "at the top left": translate("Calibrating", "Next: hold it at the top left"),
        "at the top centre": translate("Calibrating", "Next: hold it at the top"),
        "at the top right": translate("Calibrating", "Next: hold it at the top right"),
        "at the middle left": translate("Calibrating", "Next: hold it at the left"),
        "at the middle centre": translate("Calibrating", "Next: hold it in the middle"),
        "at the middle right": translate("Calibrating", "Next: hold it at the right"),
        "at the bottom left": translate("Calibrating", "Next: hold it at the bottom left"),
        "at the bottom centre": translate("Calibrating", "Next: hold it at the bottom"),
        "at the bottom right": translate("Calibrating", "Next: hold it at the bottom right"),
        "nearer": translate("Calibrating", "Next: hold it nearer"),
        "farther away": translate("Calibrating", "Next: hold it farther away"),
    }[missing]


def camera_name(info: DeviceInfo) -> str:
    """Return a name as ROS allows it: letters, digits and underscores."""
    return re.sub(r"\W+", "_", info.short_title, flags=re.ASCII).strip("_").lower() or "camera"
