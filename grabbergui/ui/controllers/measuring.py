"""Joins the panels that measure to the image and the camera. Only visible panels are measured for."""

from __future__ import annotations

import math
import time
from functools import partial
from pathlib import Path

from PyQt5.QtCore import QLineF, QObject, QRectF
from PyQt5.QtWidgets import QAction, QDockWidget

from grabbergui.core.environment import write_whole
from grabbergui.core.features import FeatureDescription
from grabbergui.core.frame import Frame
from grabbergui.core.pixels import Region
from grabbergui.models.camera_events import CameraEvents
from grabbergui.models.features.value_history import MOST_WATCHED, ValueHistory, ValueWatch, to_csv
from grabbergui.models.image.orientation import Orientation
from grabbergui.models.language import localized
from grabbergui.models.measuring import FocusHistory, Line, Measurement, MeasuringModel, Wanted
from grabbergui.models.open_source import OpenSource
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.views.bases import Dock, ReadoutImageView, StatusView
from grabbergui.ui.views.measuring_panels import MeasuringPanels, ValuesPanel
from grabbergui.ui.widgets.drawing_tool import Purpose
from grabbergui.ui.widgets.image_overlays import Mark


class MeasuringController(QObject):
    """Measures only for the panels that are visible."""

    def __init__(
        self,
        view: ReadoutImageView,
        panels: MeasuringPanels,
        strip: StatusView,
        clipping: QAction,
        context: SourceContext,
        measuring: MeasuringModel,
    ) -> None:
        super().__init__(context.window)
        self._view = view
        self._panels = panels
        self._strip = strip
        self._clipping = clipping
        self._image = context.image
        self._measuring = measuring
        self._history = FocusHistory()
        self._focus_region: Region | None = None
        self._line: Line | None = None
        self._size = (0, 0)
        "Size of the frames on which region and line were drawn."
        bridge = Bridge(self)
        bridge.bind(measuring.measured, self._on_measured)
        bridge.bind(context.open_sources.opened, lambda _: self._forget())
        bridge.bind(context.open_sources.closing, lambda _: self._forget())
        # A dock behind another one counts as visible for Qt; its signal is reliable.
        self._seen_docks = dict.fromkeys((panels.histogramDock, panels.focusDock, panels.profileDock), False)
        for dock in self._seen_docks:
            dock.visibilityChanged.connect(partial(self._on_dock_seen, dock))
        clipping.toggled.connect(self._update_wanted)
        view.drawing.regionDrawn.connect(self._on_region_drawn)
        view.drawing.lineDrawn.connect(self._on_line_drawn)
        panels.focus.regionRequested.connect(lambda: view.draw(Purpose.FOCUS_REGION))
        panels.focus.wholeRequested.connect(lambda: self._focus_on(None))
        panels.focus.resetRequested.connect(self._begin_again)
        panels.profile.rawToggled.connect(self._update_wanted)
        panels.profile.lineRequested.connect(lambda: view.draw(Purpose.PROFILE_LINE))
        self._focus_on(None)

    def show_marks(self) -> None:
        """Draw the region and the line in the orientation that is shown."""
        frame, marks = self._image.shown, self._view.canvas.marks
        focus = self._focus_region if self._seen_docks[self._panels.focusDock] else None
        line = self._line if self._seen_docks[self._panels.profileDock] else None
        marks.setShape(Mark.FOCUS, self._seen(focus, frame) if focus and frame else None)
        marks.setShape(Mark.PROFILE, self._seen_line(line, frame) if line and frame else None)

    def _on_dock_seen(self, dock: QDockWidget, seen: bool) -> None:
        opened = seen and not self._seen_docks[dock]
        self._seen_docks[dock] = seen
        self._update_wanted()
        purposes = {
            self._panels.focusDock: Purpose.FOCUS_REGION,
            self._panels.profileDock: Purpose.PROFILE_LINE,
        }
        if opened and dock is self._panels.profileDock and self._line is None and not self._view.empty:
            self._view.draw(Purpose.PROFILE_LINE)  # as its hint asks for a line
        elif not seen and self._view.drawing.purpose is purposes.get(dock):
            self._view.drawing.cancel()

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
            self._strip.setClipping("")
        self.show_marks()

    def _on_region_drawn(self, purpose: Purpose, region: Region) -> None:
        frame = self._image.shown
        if purpose is Purpose.FOCUS_REGION and frame is not None:
            self._size = (frame.width, frame.height)
            self._focus_on(self._orientation.to_frame(region, frame.width, frame.height))

    def _on_line_drawn(self, purpose: Purpose, line: Line) -> None:
        frame = self._image.shown
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
        self._begin_again()
        self._update_wanted()

    def _begin_again(self) -> None:
        self._history.clear()
        self._panels.focus.clear()

    def _forget(self) -> None:
        """Discard the region and the line: on another source's image they mean nothing."""
        self._line = None
        self._panels.profile.setLine(None)
        self._panels.profile.clear()
        self._panels.histogram.clear()
        self._view.drawing.cancel()
        self._focus_on(None)

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
                self._strip.setClipping(localized(text))
        if measured.sharpness is not None:
            self._history.add(measured.sharpness)
            panels.focus.setScores(self._history.scores, self._history.best)
        if measured.profile is not None:
            panels.profile.setProfile(measured.profile)

    @property
    def _orientation(self) -> Orientation:
        return self._image.settings.orientation

    def _seen(self, region: Region, frame: Frame) -> QRectF:
        seen = self._orientation.to_view(region, frame.width, frame.height)
        return QRectF(seen.x, seen.y, seen.width, seen.height)

    def _seen_line(self, line: Line, frame: Frame) -> QLineF:
        ends = (Region(line.x0, line.y0, 1, 1), Region(line.x1, line.y1, 1, 1))
        first, last = (self._seen(end, frame).center() for end in ends)
        return QLineF(first, last)


class ValuesController(QObject):
    """Reads the plotted features while the plots are visible, and nothing otherwise."""

    def __init__(self, panel: ValuesPanel, dock: Dock, context: SourceContext, events: CameraEvents) -> None:
        super().__init__(context.window)
        self._panel = panel
        self._events = events
        self._dock = dock
        self._files = context.files
        self._messages = context.messages
        self._open_sources = context.open_sources
        self._watch = ValueWatch()
        self._histories: dict[str, ValueHistory] = {}
        self._seen = False
        bridge = Bridge(self)
        bridge.bind(context.open_sources.opened, self._on_source_opened)
        bridge.bind(self._watch.sampled, self._on_sampled)
        # Not over the bridge: nothing more is to be asked of a grabber that is about to be closed.
        context.open_sources.closing.connect(self._on_source_closing, check_nargs=False)
        dock.visibilityChanged.connect(self._on_dock_seen)
        self._panel.removed.connect(self.remove)
        self._panel.pauseToggled.connect(self._update)
        self._panel.clearRequested.connect(self._clear)
        self._panel.saveRequested.connect(self._ask_save)
        self._panel.spanChanged.connect(self._show)

    @property
    def names(self) -> tuple[str, ...]:
        """The plotted features."""
        return self._watch.names

    def plot(self, description: FeatureDescription) -> None:
        """Plot one more value, and show the panel."""
        if self._watch.full and description.name not in self.names:
            text = self.tr("no more than {0} values can be plotted at once; remove one first")
            self._messages.error(text.format(MOST_WATCHED))
            return
        self._panel.addCurve(description)
        self._histories.setdefault(description.name, ValueHistory())
        self._watch.add(description.name)
        self._dock.show()
        self._dock.raise_()

    def remove(self, name: str) -> None:
        """Remove a value from the plot."""
        self._watch.remove(name)
        self._histories.pop(name, None)
        self._panel.removeCurve(name)

    def save(self, path: Path) -> None:
        """Save everything that was read as comma-separated values, the time in UTC."""
        with self._messages.saving(path, self.tr("Saved the values to {0}")):
            write_whole(path, to_csv(self._histories))

    def _on_source_opened(self, source: OpenSource) -> None:
        if source is not self._open_sources.current or source.grabber is None or source.features is None:
            return
        for name in self.names:
            if source.features.description(name) is None:
                self.remove(name)
        self._break()
        self._watch.attach(source.grabber, source.worker)

    def _on_source_closing(self, _: OpenSource) -> None:
        self._watch.detach()

    def _on_dock_seen(self, seen: bool) -> None:
        self._seen = seen
        self._update()

    def _update(self) -> None:
        wanted = self._seen and not self._panel.pauseButton.isChecked()
        if wanted:
            self._break()
        self._watch.want(wanted)

    def _on_sampled(self, moment: float, values: dict[str, float], units: dict[str, str]) -> None:
        self._panel.setUnits(units)
        for name, value in values.items():
            if (history := self._histories.get(name)) is not None:
                history.add(moment, value)
        self._show(moment)

    def _show(self, now: float | None = None) -> None:
        now = time.time() if now is None else now
        self._panel.setSamples(self._histories, now)
        self._panel.setMarks([(at - now, name) for at, name in self._events.since(now - self._panel.span)])

    def _break(self) -> None:
        """Interrupt the curves: nothing is known of the time in between."""
        for history in self._histories.values():
            if len(history):
                history.add(time.time(), math.nan)

    def _clear(self) -> None:
        self._histories = {name: ValueHistory() for name in self._histories}
        self._show()

    def _ask_save(self) -> None:
        kinds = self.tr("Comma-separated values (*.csv)")
        if path := self._files.to_save(self.tr("Save values"), "values.csv", kinds):
            self.save(path)
