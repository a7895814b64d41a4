"""Joins the panels that measure the picture to the measuring."""

from __future__ import annotations

from functools import partial

from PyQt5.QtCore import QLineF, QObject, QRectF
from PyQt5.QtWidgets import QDockWidget

from grabbergui.core.frame import Frame
from grabbergui.core.region import Region
from grabbergui.models.connection import Connection
from grabbergui.models.language import localized
from grabbergui.models.measuring.channels import Line
from grabbergui.models.measuring.measurement import FocusHistory, Measurement, MeasuringModel, Wanted
from grabbergui.models.picture.geometry import Orientation
from grabbergui.models.picture.picture import PictureModel
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.views.main_window import MainWindow
from grabbergui.ui.widgets.drawing import Purpose
from grabbergui.ui.widgets.picture_marks import Mark


class MeasuringController(QObject):
    """Measures what can be seen in a panel, and nothing else."""

    def __init__(
        self, window: MainWindow, connection: Connection, picture: PictureModel, measuring: MeasuringModel
    ) -> None:
        super().__init__(window)
        self._window = window
        self._picture = picture
        self._measuring = measuring
        self._history = FocusHistory()
        self._focus_region: Region | None = None
        self._line: Line | None = None
        self._size = (0, 0)
        "Of the frames that region and line were drawn on."
        bridge = Bridge(self)
        bridge.bind(measuring.measured, self._on_measured)
        bridge.bind(connection.opened, lambda _: self._forget())
        bridge.bind(connection.closing, lambda _: self._forget())
        # A dock behind another one counts as visible for Qt; its signal tells better.
        self._seen_docks = dict.fromkeys((window.histogramDock, window.focusDock, window.profileDock), False)
        for dock in self._seen_docks:
            dock.visibilityChanged.connect(partial(self._on_dock_seen, dock))
        window.actionClipping.toggled.connect(self._update_wanted)
        drawing = window.picture.drawing
        drawing.regionDrawn.connect(self._on_region_drawn)
        drawing.lineDrawn.connect(self._on_line_drawn)
        window.focus.regionRequested.connect(lambda: window.picture.draw(Purpose.FOCUS_REGION))
        window.focus.wholeRequested.connect(lambda: self._focus_on(None))
        window.focus.resetRequested.connect(self._begin_anew)
        window.profile.rawToggled.connect(self._update_wanted)
        window.profile.lineRequested.connect(lambda: window.picture.draw(Purpose.PROFILE_LINE))
        self._focus_on(None)

    def show_marks(self) -> None:
        """Draw the region and the line where they are seen."""
        frame, marks = self._picture.frame, self._window.picture.canvas.marks
        focus = self._focus_region if self._seen_docks[self._window.focusDock] else None
        line = self._line if self._seen_docks[self._window.profileDock] else None
        marks.setShape(Mark.FOCUS, self._seen(focus, frame) if focus and frame else None)
        marks.setShape(Mark.PROFILE, self._seen_line(line, frame) if line and frame else None)

    # -- what is wanted ------------------------------------------------------------------------------
    def _on_dock_seen(self, dock: QDockWidget, seen: bool) -> None:
        self._seen_docks[dock] = seen
        self._update_wanted()

    def _update_wanted(self) -> None:
        window, seen = self._window, self._seen_docks
        self._measuring.want(
            Wanted(
                histogram=seen[window.histogramDock] or window.actionClipping.isChecked(),
                focus=seen[window.focusDock],
                focus_region=self._focus_region,
                line=self._line if seen[window.profileDock] else None,
                raw_line=window.profile.rawBox.isChecked(),
            )
        )
        if not window.actionClipping.isChecked():
            window.picture.setClippingText("")
        self.show_marks()

    def _on_region_drawn(self, purpose: Purpose, region: Region) -> None:
        frame = self._picture.frame
        if purpose is Purpose.FOCUS_REGION and frame is not None:
            self._size = (frame.width, frame.height)
            self._focus_on(self._orientation.to_frame(region, frame.width, frame.height))

    def _on_line_drawn(self, purpose: Purpose, line: Line) -> None:
        frame = self._picture.frame
        if purpose is not Purpose.PROFILE_LINE or frame is None:
            return
        size = self._size = (frame.width, frame.height)
        line = line.clipped(*self._orientation.view_size(*size))
        first = self._orientation.pixel(line.x0, line.y0, *size)
        self._line = Line(*first, *self._orientation.pixel(line.x1, line.y1, *size))
        self._window.profile.setLine(self._line)
        self._update_wanted()

    def _focus_on(self, region: Region | None) -> None:
        self._focus_region = region
        text = ""
        if region is not None:
            text = self.tr("of {0} × {1} pixels at ({2}, {3})")
            text = text.format(region.width, region.height, region.x, region.y)
        self._window.focus.setWhat(text)
        self._begin_anew()
        self._update_wanted()

    def _begin_anew(self) -> None:
        self._history.clear()
        self._window.focus.clear()

    def _forget(self) -> None:
        """Another picture: what was drawn on the one before means nothing there."""
        self._line = None
        self._window.profile.setLine(None)
        self._window.profile.clear()
        self._window.histogram.clear()
        self._window.picture.drawing.cancel()
        self._focus_on(None)

    # -- what was measured ---------------------------------------------------------------------------
    def _on_measured(self, measured: Measurement) -> None:
        window, size = self._window, (measured.frame.width, measured.frame.height)
        if size != self._size and (self._focus_region is not None or self._line is not None):
            self._forget()
            return
        if measured.histogram is not None:
            if self._seen_docks[window.histogramDock]:
                window.histogram.setHistogram(measured.histogram)
            if window.actionClipping.isChecked():
                saturated, black = measured.histogram.saturated, measured.histogram.black
                text = self.tr("{0:.2%} saturated · {1:.2%} black").format(saturated, black)
                window.picture.setClippingText(localized(text))
        if measured.sharpness is not None:
            self._history.add(measured.sharpness)
            window.focus.setScores(self._history.scores, self._history.best)
        if measured.profile is not None:
            window.profile.setProfile(measured.profile)

    # -- where it is seen ----------------------------------------------------------------------------
    @property
    def _orientation(self) -> Orientation:
        return self._picture.settings.orientation

    def _seen(self, region: Region, frame: Frame) -> QRectF:
        seen = self._orientation.to_view(region, frame.width, frame.height)
        return QRectF(seen.x, seen.y, seen.width, seen.height)

    def _seen_line(self, line: Line, frame: Frame) -> QLineF:
        ends = (Region(line.x0, line.y0, 1, 1), Region(line.x1, line.y1, 1, 1))
        first, last = (self._seen(end, frame).center() for end in ends)
        return QLineF(first, last)
