"""Joins the panels that measure the picture to the measuring."""

from __future__ import annotations

from functools import partial

from PyQt5.QtCore import QLineF, QObject, QRectF
from PyQt5.QtWidgets import QAction, QDockWidget

from grabbergui.core.frame import Frame
from grabbergui.core.pixels import Region
from grabbergui.models.connection import Connection
from grabbergui.models.language import localized
from grabbergui.models.measuring.channels import Line
from grabbergui.models.measuring.measurement import FocusHistory, Measurement, MeasuringModel, Wanted
from grabbergui.models.picture.geometry import Orientation
from grabbergui.models.picture.picture import PictureModel
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.views.bases import PictureView
from grabbergui.ui.views.measuring_panels import MeasuringPanels
from grabbergui.ui.widgets.drawing import Purpose
from grabbergui.ui.widgets.picture_marks import Mark


class MeasuringController(QObject):
    """Measures what can be seen in a panel, and nothing else."""

    def __init__(
        self,
        view: PictureView,
        panels: MeasuringPanels,
        clipping: QAction,
        connection: Connection,
        picture: PictureModel,
        measuring: MeasuringModel,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._view = view
        self._panels = panels
        self._clipping = clipping
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
        # A dock behind another one counts as visible for Qt; its signal is reliable.
        self._seen_docks = dict.fromkeys((panels.histogramDock, panels.focusDock, panels.profileDock), False)
        for dock in self._seen_docks:
            dock.visibilityChanged.connect(partial(self._on_dock_seen, dock))
        clipping.toggled.connect(self._update_wanted)
        view.drawing.regionDrawn.connect(self._on_region_drawn)
        view.drawing.lineDrawn.connect(self._on_line_drawn)
        panels.focus.regionRequested.connect(lambda: view.draw(Purpose.FOCUS_REGION))
        panels.focus.wholeRequested.connect(lambda: self._focus_on(None))
        panels.focus.resetRequested.connect(self._begin_anew)
        panels.profile.rawToggled.connect(self._update_wanted)
        panels.profile.lineRequested.connect(lambda: view.draw(Purpose.PROFILE_LINE))
        self._focus_on(None)

    def show_marks(self) -> None:
        """Draw the region and the line where they are seen."""
        frame, marks = self._picture.shown, self._view.canvas.marks
        focus = self._focus_region if self._seen_docks[self._panels.focusDock] else None
        line = self._line if self._seen_docks[self._panels.profileDock] else None
        marks.setShape(Mark.FOCUS, self._seen(focus, frame) if focus and frame else None)
        marks.setShape(Mark.PROFILE, self._seen_line(line, frame) if line and frame else None)

    # -- what is wanted ------------------------------------------------------------------------------
    def _on_dock_seen(self, dock: QDockWidget, seen: bool) -> None:
        self._seen_docks[dock] = seen
        self._update_wanted()

    def _update_wanted(self) -> None:
        panels, seen = self._panels, self._seen_docks
        self._measuring.want(
            Wanted(
                histogram=seen[panels.histogramDock] or self._clipping.isChecked(),
                focus=seen[panels.focusDock],
                focus_region=self._focus_region,
                line=self._line if seen[panels.profileDock] else None,
                raw_line=panels.profile.rawBox.isChecked(),
            )
        )
        if not self._clipping.isChecked():
            self._view.setClippingText("")
        self.show_marks()

    def _on_region_drawn(self, purpose: Purpose, region: Region) -> None:
        frame = self._picture.shown
        if purpose is Purpose.FOCUS_REGION and frame is not None:
            self._size = (frame.width, frame.height)
            self._focus_on(self._orientation.to_frame(region, frame.width, frame.height))

    def _on_line_drawn(self, purpose: Purpose, line: Line) -> None:
        frame = self._picture.shown
        if purpose is not Purpose.PROFILE_LINE or frame is None:
            return
        size = self._size = (frame.width, frame.height)
        line = line.clipped(*self._orientation.view_size(*size))
        first = self._orientation.pixel(line.x0, line.y0, *size)
        self._line = Line(*first, *self._orientation.pixel(line.x1, line.y1, *size))
        self._panels.profile.setLine(self._line)
        self._update_wanted()

    def _focus_on(self, region: Region | None) -> None:
        self._focus_region = region
        text = ""
        if region is not None:
            text = self.tr("of {0} × {1} pixels at ({2}, {3})")
            text = text.format(region.width, region.height, region.x, region.y)
        self._panels.focus.setWhat(text)
        self._begin_anew()
        self._update_wanted()

    def _begin_anew(self) -> None:
        self._history.clear()
        self._panels.focus.clear()

    def _forget(self) -> None:
        """Another picture: what was drawn on the one before means nothing there."""
        self._line = None
        self._panels.profile.setLine(None)
        self._panels.profile.clear()
        self._panels.histogram.clear()
        self._view.drawing.cancel()
        self._focus_on(None)

    # -- what was measured ---------------------------------------------------------------------------
    def _on_measured(self, measured: Measurement) -> None:
        panels, size = self._panels, (measured.frame.width, measured.frame.height)
        if size != self._size and (self._focus_region is not None or self._line is not None):
            self._forget()
            return
        if measured.histogram is not None:
            if self._seen_docks[panels.histogramDock]:
                panels.histogram.setHistogram(measured.histogram)
            if self._clipping.isChecked():
                saturated, black = measured.histogram.saturated, measured.histogram.black
                text = self.tr("{0:.2%} saturated · {1:.2%} black").format(saturated, black)
                self._view.setClippingText(localized(text))
        if measured.sharpness is not None:
            self._history.add(measured.sharpness)
            panels.focus.setScores(self._history.scores, self._history.best)
        if measured.profile is not None:
            panels.profile.setProfile(measured.profile)

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
