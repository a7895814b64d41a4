"""The image to show: the newest frame, converted for the screen on a thread of its own."""

from __future__ import annotations

import logging
import threading
import time
from dataclasses import replace

import cv2
from psygnal import Signal

from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import FrameTimeoutError, PixelFormatError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameQueue, RateMeter
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.pixels import Region
from grabbergui.models.error_text import error_text
from grabbergui.models.image.components import ShownImage, beside, chosen, own_label
from grabbergui.models.image.components import labels as component_labels
from grabbergui.models.image.display_settings import DisplaySettings
from grabbergui.models.image.orientation import scaled_region
from grabbergui.models.image.rendering import render
from grabbergui.models.image.stream_channels import StreamChannels
from grabbergui.models.language import translate
from grabbergui.models.measuring import estimate_saturated

log = logging.getLogger(__name__)

FRAME_WAIT = 0.2
"Seconds to wait for a frame at a time."
COMPONENT_WAIT = 0.5
"""Seconds for which frames with fewer components are skipped: a network loses single components, and tabs
that appear and disappear are unreadable."""
SATURATED_PERIOD = 1.0
"Seconds between two estimates of how much is saturated."
PAINT_WAIT = 0.5
"Seconds to wait for the window to paint; a hidden window takes no images."


class ImageModel:
    """Converts the visible part of a source's newest frame, and offers it for painting.

    At most one image waits to be painted, and nothing is converted before the window has taken it, so a
    slow screen costs no CPU time and never delays the display. Methods may be called from any thread and
    never wait, except for a `timeout`; signals come from the display thread.
    """

    ready = Signal()
    """`take` returns a new image."""
    failed = Signal(str)
    """Frames cannot be converted, as display text; once for each cause."""
    not_undistorted = Signal(str)
    """The calibration of the settings does not fit the shown frame, as display text; for each frame."""

    def __init__(self) -> None:
        self._queue: FrameQueue | None = None
        self._thread: threading.Thread | None = None
        self._region: Region | None = None
        self._size: tuple[int, int] | None = None
        self._offer: ShownImage | None = None
        self._frame: Frame | None = None
        self._frozen: Frame | None = None
        self._latest: ShownImage | None = None
        self._components: tuple[Frame, dict[str, Frame]] | None = None
        "A frame, and its components as frames by their labels."
        self._channels = StreamChannels()
        self._most: tuple[int, float] = (0, 0.0)
        "The number of components that frames have, and `time.monotonic` of the last frame with that many."
        self._settings = DisplaySettings()
        self._again = threading.Event()
        "Set to convert the shown frame once more."
        self._problem = ""
        self._dropped = 0
        self._painted = RateMeter()
        self._lock = threading.Lock()
        self._taken = threading.Event()
        self.received = 0
        "Number of frames received since the source was attached."
        self.converted = 0
        "Number of frames converted since."
        self.mean: float | None = None
        "Mean of the 8-bit pixels of the last image; None before the first."
        self.saturated: float | None = None
        "Share of the samples at the highest value, estimated once a second; None before, and if unknown."
        self._estimated = 0.0
        "`time.monotonic` of that estimate."
        self.last_received: float | None = None
        "`time.monotonic` of the last frame; None before the first."

    @property
    def frame(self) -> Frame | None:
        """The newest frame, whole and as the sensor sent it, even after the source is closed."""
        return self._frame

    @property
    def shown(self) -> Frame | None:
        """The shown component of the newest frame, as a frame; the frame itself if it has only one."""
        frame, latest = self._frame, self._latest
        return latest.frame if frame is not None and frame.parts and latest is not None else frame

    @property
    def latest(self) -> ShownImage | None:
        """The last image of this source; None before the first."""
        return self._latest

    @property
    def problem(self) -> str:
        """Why the newest frame cannot be shown; empty if it can."""
        return self._problem

    @property
    def painted_rate(self) -> float:
        """Images painted per second, over the last two seconds."""
        return self._painted.rates()[0]

    def attach(self, grabber: FrameGrabber, other: ImageModel | None = None) -> None:
        """Show this source's frames, beginning with the last one that `other` received from it."""
        self.detach()
        queue = grabber.open_queue(depth=2)
        with self._lock:
            self._queue = queue
            self._frame = frame = other.frame if other is not None else None
        self._frozen = self._latest = self._components = None
        self._most = (0, 0.0)
        self._channels.clear()
        self._problem = ""
        self._dropped = 0
        self.received = self.converted = 0
        self.mean = self.saturated = None
        self.last_received = other.last_received if other is not None else None
        if frame is not None:
            queue.put(frame)
        self._painted.clear()
        self._thread = threading.Thread(target=self._show, args=(queue,), name="display", daemon=True)
        self._thread.start()

    def detach(self, timeout: float = 0.0) -> bool:
        """Stop taking frames, but keep the last one.

        Returns whether the thread ended within `timeout` seconds. May be called again.
        """
        with self._lock:
            queue, self._queue = self._queue, None
            self._offer = None
        if queue is not None:
            queue.close()
            self._taken.set()
        if (thread := self._thread) is not None and thread is not threading.current_thread():
            thread.join(timeout)
            return not thread.is_alive()
        return thread is None

    def restarted(self) -> None:
        """Reset the figures, because a new stream starts."""
        self.mean = self.saturated = self.last_received = None
        self.received = self.converted = 0

    @property
    def settings(self) -> DisplaySettings:
        """How the image is displayed."""
        return self._settings

    @settings.setter
    def settings(self, settings: DisplaySettings) -> None:
        with self._lock:
            if (settings.orientation.quarter_turns - self._settings.orientation.quarter_turns) % 2:
                self._region = None  # it referred to the previous orientation
            self._settings = settings
        self._show_again()

    def set_viewport(self, region: Region | None, size: tuple[int, int] | None) -> None:
        """Set the region of the frame that the view shows (None: all), and its `size` in screen pixels."""
        with self._lock:
            if (region, size) == (self._region, self._size):
                return
            self._region, self._size = region, size
        self._show_again()

    def freeze(self, frame: Frame | None) -> None:
        """Show this frame and ignore new ones; with None, show new frames again."""
        self._frozen = frame
        if frame is not None:
            self._frame = frame
        self._show_again()

    def _show_again(self) -> None:
        """Convert the shown frame once more, without waiting for another."""
        self._again.set()
        queue, frame = self._queue, self._frame
        if queue is not None and frame is not None:
            queue.put(frame)

    def take(self) -> ShownImage | None:
        """Return the newest image, once; None without a new one."""
        with self._lock:
            newest, self._offer = self._offer, None
        self._taken.set()
        return newest

    def painted(self) -> None:
        """Record that an image has reached the screen."""
        self._painted.add()

    def _show(self, queue: FrameQueue) -> None:
        while not queue.closed:
            try:
                frame = self._newest(queue)
            except FrameTimeoutError:
                continue
            if again := self._again.is_set():
                self._again.clear()  # before what is to be shown again is read, which may change meanwhile
            frozen = self._frozen
            if frozen is None:
                if self._lacks_components(frame):
                    continue
                self._convert(frame, queue)
            elif again:
                self._convert(frozen, queue)
            self._taken.wait(PAINT_WAIT)

    def _lacks_components(self, frame: Frame) -> bool:
        """Return whether the frames just before had more components."""
        count, now = len(frame.parts), time.monotonic()
        most, seen = self._most
        if count < most and now - seen < COMPONENT_WAIT:
            return True
        self._most = (count, now)
        return False

    def _newest(self, queue: FrameQueue) -> Frame:
        """Return the newest frame available; the shown one only if no other is queued."""
        newest = queue.get(FRAME_WAIT)
        arrived = int(newest is not self._frame)
        if arrived:
            newest = self._channels.merged(newest, time.monotonic())
        while True:
            try:
                frame = queue.get(0)
            except FrameTimeoutError:
                break
            if frame is not self._frame:
                newest = self._channels.merged(frame, time.monotonic())
                arrived += 1
        if arrived:
            dropped = queue.dropped
            self.received += arrived + dropped - self._dropped
            self._dropped = dropped
            self.last_received = time.monotonic()
        return newest

    def _convert(self, frame: Frame, queue: FrameQueue) -> None:
        with self._lock:
            if self._queue is not queue:
                return
            region, size, settings = self._region, self._size, self._settings
            self._frame = frame
        try:
            shown = self._shown_image(frame, region, size, settings)
            image = shown.image
        except PixelFormatError as error:
            self._report(error_text(error))
            return
        except Exception as error:
            # A damaged frame must not end the display of later ones.
            log.exception("a frame could not be converted")
            text = translate("Image", "frame {0} ({1}) cannot be shown: {2}")
            self._report(text.format(frame.frame_id, frame.pixel_format, error))
            return
        self._problem = ""
        # Every tenth line is enough to recognise a black image.
        lines = image.pixels[::10]
        self.mean = cv2.mean(lines.reshape(len(lines), -1))[0]
        self._estimate_saturated(shown)
        self.converted += 1
        with self._lock:
            if self._queue is not queue:
                return  # another source was attached
            self._latest = shown
            self._taken.clear()
            self._offer = shown
        self.ready.emit()

    def _estimate_saturated(self, shown: ShownImage) -> None:
        """Estimate the share of saturated samples now and then; quantities such as depth have none."""
        now = time.monotonic()
        if self.saturated is not None and now - self._estimated < SATURATED_PERIOD:
            return
        self._estimated = now
        try:
            self.saturated = estimate_saturated(shown.frame) if shown.quantity is None else None
        except PixelFormatError:
            self.saturated = None

    def _shown_image(
        self, frame: Frame, region: Region | None, size: tuple[int, int] | None, settings: DisplaySettings
    ) -> ShownImage:
        labels = component_labels(frame)
        label = settings.component if settings.component in labels else own_label(frame)
        part = self._component(frame, label) if labels else frame
        quantity = settings.quantity(part)
        calibration = self._calibration(part, settings)
        image = render(part, region, size, settings, quantity, calibration)
        seen = settings.orientation.view_size(part.width, part.height)
        shown = ShownImage(part, image, *seen, labels, label, quantity, calibration)
        if not (settings.side_by_side and labels):
            return shown
        return replace(shown, others=self._beside(frame, shown, region, size, settings))

    def _calibration(self, frame: Frame, settings: DisplaySettings) -> Calibration | None:
        """Return the calibration by which to show a frame undistorted; None shows it as it is."""
        if settings.calibration is None:
            return None
        try:
            forms = settings.calibration(frame)
        except UsageError as error:
            self.not_undistorted.emit(error_text(error))
            return None
        return None if forms is None else forms.image

    def _beside(
        self,
        frame: Frame,
        shown: ShownImage,
        region: Region | None,
        size: tuple[int, int] | None,
        settings: DisplaySettings,
    ) -> tuple[ShownImage, ...]:
        """Return the same part of the other components, without those that cannot be shown."""
        others = []
        for label in beside(shown.labels, shown.label):
            look = settings.of_other(label)
            try:
                part = self._component(frame, label)
                whole = look.orientation.view_size(part.width, part.height)
                view = region and scaled_region(region, (shown.width, shown.height), whole)
                quantity = look.quantity(part)
                # A lens has one calibration; components of another size are from another sensor.
                same = (part.width, part.height) == (shown.frame.width, shown.frame.height)
                calibration = shown.calibration if same else None
                image = render(part, view, size, look, quantity, calibration)
            except PixelFormatError as error:
                log.debug("%s cannot be shown: %s", label, error)
                continue
            others.append(ShownImage(part, image, *whole, shown.labels, label, quantity, calibration))
        return tuple(others)

    def _component(self, frame: Frame, label: str) -> Frame:
        """Return a component; the same object for the same frame, because it caches its conversions."""
        known = self._components
        if known is None or known[0] is not frame:
            self._components = known = (frame, {})
        parts = known[1]
        if label not in parts:
            parts[label] = chosen(frame, label)
        return parts[label]

    def _report(self, problem: str) -> None:
        self._taken.set()
        if problem != self._problem:
            self._problem = problem
            self.failed.emit(problem)
