"""Panels that measure: histogram, profile, sharpness, and values of features over time."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PyQt5.QtCore import QSignalBlocker, Qt, pyqtSignal
from PyQt5.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDockWidget,
    QLabel,
    QPushButton,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from grabbergui.core.features import FeatureDescription
from grabbergui.models.features.value_history import ValueHistory
from grabbergui.models.language import localized
from grabbergui.models.measuring import HISTORY_SECONDS, Histogram, Line
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.actions import set_available
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.shown_text import set_tooltip
from grabbergui.ui.widgets.curve_row import CurveRow
from grabbergui.ui.widgets.labels import ElidedLabel
from grabbergui.ui.widgets.plots import ChannelPlot, PlotPlace

HEADROOM = 1.1
"Height of the plot, as a multiple of the highest count between its ends."
_SPANS = (10.0, 60.0, 600.0, 3600.0)
"""Time spans in seconds, in the order of the form's box."""
COLOURS = ("#2f7ed8", "#d9480f", "#2b8a3e", "#9c36b5", "#c92a2a", "#0b7285")
"""Colours of the curves in one plot, in their order; legible on light and dark."""

FIGURES_GAP, NO_BREAK = "    ", "\N{NO-BREAK SPACE}"
"Between figures, and within one."


class HistogramPanel(QWidget):
    """Setters for the histogram and the levels; a signal for levels that were dragged."""

    levelsDragged = pyqtSignal(float, float)
    """The levels shown as black and as white, as fractions of the sensor's range."""
    levelsReset = pyqtSignal()

    figuresLabel: QLabel
    logBox: QCheckBox
    fitButton: QPushButton
    resetButton: QPushButton
    plotPlace: PlotPlace

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("histogram_panel", self)
        self._histogram: Histogram | None = None
        self._range = 256
        self.plotPlace.furnish = self._furnish
        self.levels = pg.LinearRegionItem((0, 256), swapMode="block", bounds=(0, 256))
        self.levels.setZValue(10)
        self.levels.setBrush(pg.mkBrush(128, 128, 128, 28))
        self.levels.setHoverBrush(pg.mkBrush(128, 128, 128, 48))
        self.levels.sigRegionChanged.connect(self._on_levels_region_changed)
        self.fitButton.clicked.connect(self._on_fit_clicked)
        self.resetButton.clicked.connect(self.levelsReset)
        self.logBox.toggled.connect(self._draw)

    @property
    def plot(self) -> ChannelPlot:
        """The counts of each value."""
        return self.plotPlace.plot

    def setHistogram(self, histogram: Histogram) -> None:
        """Show the counts of each value and their figures."""
        if 1 << histogram.depth != self._range:
            self._set_range(1 << histogram.depth)
        self._histogram = histogram
        titles = {"grey": self.tr("grey")}  # others are letters
        means = "  ".join(
            f"{titles.get(name, name)} {histogram.mean(name):.1f}" for name in histogram.channels
        )
        text = self.tr("Mean {0}    {1:.2%} saturated    {2:.2%} black")
        figures = localized(text.format(means, histogram.saturated, histogram.black))
        means, *shares = figures.split(FIGURES_GAP)
        # A narrow panel breaks the line between two figures, not within one.
        self.figuresLabel.setText(
            FIGURES_GAP.join([means, *(share.replace(" ", NO_BREAK) for share in shares)])
        )
        self._draw()

    def setLevels(self, black: float, white: float) -> None:
        """Show which values are shown as black and as white, as fractions of the range."""
        with QSignalBlocker(self.levels):
            self.levels.setRegion((black * self._range, white * self._range))

    def clear(self) -> None:
        """Show nothing."""
        self._histogram = None
        self.figuresLabel.clear()
        if (plot := self.plotPlace.made) is not None:
            plot.clearChannels()

    def _furnish(self, plot: ChannelPlot) -> None:
        plot.setFilled(True)
        plot.hideAxis("left")
        plot.addItem(self.levels)
        plot.setXRange(0, self._range, padding=0.01)

    def _set_range(self, values: int) -> None:
        black, white = (edge / self._range for edge in self.levels.getRegion())
        self._range = values
        self.plot.setXRange(0, values, padding=0.01)
        with QSignalBlocker(self.levels):
            self.levels.setBounds((0, values))
            self.levels.setRegion((black * values, white * values))

    def _draw(self) -> None:
        histogram = self._histogram
        if histogram is None:
            return
        counts = {name: histogram.binned(name) for name in histogram.channels}
        bins = next(iter(counts.values())).size
        if self.logBox.isChecked():
            counts = {name: np.log10(count + 1) for name, count in counts.items()}
        self.plot.setChannels(self._edges(bins), dict(counts))
        # Clipped values tower over all others: their bars may end above the plot.
        inner = max(count[1:-1].max() for count in counts.values())
        self.plot.setYRange(0, HEADROOM * (inner or max(count.max() for count in counts.values()) or 1))

    def _edges(self, bins: int) -> np.ndarray:
        return np.linspace(0, self._range, bins + 1)

    def _on_fit_clicked(self) -> None:
        if self._histogram is not None:
            black, white = self._histogram.levels()
            self.setLevels(black, white)
            self.levelsDragged.emit(black, white)

    def _on_levels_region_changed(self) -> None:
        black, white = self.levels.getRegion()
        self.levelsDragged.emit(black / self._range, white / self._range)


class FocusPanel(QWidget):
    """Setters for the scores; signals for the requested region."""

    regionRequested = pyqtSignal()
    """The user wants to draw a region."""
    wholeRequested = pyqtSignal()
    resetRequested = pyqtSignal()

    scoreLabel: ElidedLabel
    regionButton: QPushButton
    wholeButton: QPushButton
    resetButton: QPushButton
    plotPlace: PlotPlace

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("focus_panel", self)
        self._best = pg.InfiniteLine(
            angle=0, movable=False, pen=pg.mkPen("#30a46c", style=Qt.PenStyle.DashLine)
        )
        self.plotPlace.furnish = self._furnish
        self.regionButton.clicked.connect(self.regionRequested)
        self.wholeButton.clicked.connect(self.wholeRequested)
        self.resetButton.clicked.connect(self.resetRequested)
        self.clear()

    @property
    def plot(self) -> ChannelPlot:
        """The scores of the last seconds."""
        return self.plotPlace.plot

    def setScores(self, scores: Sequence[tuple[float, float]], best: float) -> None:
        """Show scores with their times in seconds, the newest last, and the best so far."""
        times, values = np.array(scores).T
        self.plot.setChannels(times - times[-1], {"sharpness": values})
        self._best.setValue(best)
        self._best.setVisible(best > 0)
        share = values[-1] / best if best else 0
        texts = (
            self.tr("Sharpness {0:.2f}    best {1:.2f}    {2:.0%} of the best"),
            self.tr("Sharpness {0:.2f}    best {1:.2f}"),
            "{0:.2f}",
            "{0:.0f}",
        )
        tip = self.scoreLabel.toolTip()
        self.scoreLabel.setTexts(*(localized(text.format(values[-1], best, share)) for text in texts))
        set_tooltip(self.scoreLabel, tip)

    def setWhat(self, region: str) -> None:
        """Show the scored region as text."""
        set_available(self.wholeButton, None if region else Unavailable.WHOLE)
        set_tooltip(self.scoreLabel, region or self.tr("of the whole image"))

    def clear(self) -> None:
        """Show nothing."""
        if (plot := self.plotPlace.made) is not None:
            plot.clearChannels()
        self._best.hide()
        self.scoreLabel.setText("–")

    def _furnish(self, plot: ChannelPlot) -> None:
        plot.addItem(self._best)
        plot.showSeconds()
        plot.setXRange(-HISTORY_SECONDS / 2, 0, padding=0)
        set_tooltip(plot, self.tr("Sharpness over the last seconds; dashed: the best"))


class ProfilePanel(QWidget):
    """Setters for the values; a signal for a request to draw another line."""

    lineRequested = pyqtSignal()
    rawToggled = pyqtSignal()
    """The sensor's own values are wanted, or the colours shown: see `rawBox`."""

    lineLabel: QLabel
    rawBox: QCheckBox
    lineButton: QPushButton
    plotPlace: PlotPlace

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("profile_panel", self)
        self.plotPlace.furnish = self._furnish
        self.rawBox.toggled.connect(self.rawToggled)
        self.lineButton.clicked.connect(self.lineRequested)
        self.setLine(None)
        self.clear()

    @property
    def plot(self) -> ChannelPlot:
        """The values along the line."""
        return self.plotPlace.plot

    def setLine(self, line: Line | None) -> None:
        """Show the ends of the line, in the frame's pixels."""
        if line is None:
            self.lineLabel.setText(self.tr("Draw a line through the image to see its values."))
        else:
            self.lineLabel.setText(f"({line.x0}, {line.y0}) … ({line.x1}, {line.y1})")

    def setProfile(self, profile: dict[str, NDArray[Any]]) -> None:
        """Show the values of each channel along the line."""
        samples = len(next(iter(profile.values())))
        self.plot.setChannels(np.arange(samples), profile)
        self.plot.showAxes((True, False, False, True))

    def clear(self) -> None:
        """Remove the values."""
        if (plot := self.plotPlace.made) is not None:
            plot.clearChannels()

    def _furnish(self, plot: ChannelPlot) -> None:
        set_tooltip(plot, self.tr("The sensor's values over the pixels along the line"))


@dataclass(frozen=True)
class MeasuringPanels:
    """The three panels and their docks."""

    histogram: HistogramPanel
    focus: FocusPanel
    profile: ProfilePanel
    histogramDock: QDockWidget
    focusDock: QDockWidget
    profileDock: QDockWidget


class ValuesPanel(QWidget):
    """Setters for the curves and their samples; signals for the requested actions."""

    removed = pyqtSignal(str)
    """The user removed a curve."""
    pauseToggled = pyqtSignal(bool)
    clearRequested = pyqtSignal()
    saveRequested = pyqtSignal()
    spanChanged = pyqtSignal()
    """The user chose another time span; `setSamples` is expected."""

    spanBox: QComboBox
    togetherBox: QCheckBox
    overlayPlace: PlotPlace
    pauseButton: QPushButton
    saveButton: QPushButton
    clearButton: QPushButton
    hintLabel: QLabel
    scrollArea: QScrollArea
    content: QWidget
    curves: QVBoxLayout

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("values_panel", self)
        self._rows: dict[str, CurveRow] = {}
        if (viewport := self.scrollArea.viewport()) is not None:
            viewport.setAutoFillBackground(False)
        self.content.setAutoFillBackground(False)
        self.spanBox.currentIndexChanged[int].connect(lambda _: self.spanChanged.emit())
        self.pauseButton.toggled.connect(self.pauseToggled)
        self.overlayPlace.setAccessibleName(self.tr("All curves over time"))
        self.overlayPlace.furnish = self._furnish
        self.togetherBox.toggled.connect(lambda _: self._arrange())
        self.togetherBox.toggled.connect(lambda _: self.spanChanged.emit())
        self.clearButton.clicked.connect(self.clearRequested)
        self.saveButton.clicked.connect(self.saveRequested)
        self._arrange()

    @property
    def overlay(self) -> ChannelPlot:
        """The curves in one plot."""
        return self.overlayPlace.plot

    def row(self, name: str) -> CurveRow | None:
        """The row of a value."""
        return self._rows.get(name)

    def addCurve(self, description: FeatureDescription) -> None:
        """Add a curve; does nothing if it is shown already."""
        if description.name in self._rows:
            return
        row = CurveRow(description, self.content)
        row.removed.connect(self.removed)
        self._rows[row.name] = row
        self.curves.addWidget(row)
        self._arrange()

    def setUnits(self, units: Mapping[str, str]) -> None:
        """Show the units of the values."""
        for name, unit in units.items():
            if (row := self._rows.get(name)) is not None:
                row.setUnit(unit)

    def removeCurve(self, name: str) -> None:
        """Remove a curve."""
        row = self._rows.pop(name, None)
        if row is not None:
            self.curves.removeWidget(row)
            row.hide()
            row.deleteLater()
            self._remove_from_overlay(name)
            self._arrange()

    @property
    def span(self) -> float:
        """The seconds that are shown."""
        return _SPANS[self.spanBox.currentIndex()]

    def setMarks(self, marks: Sequence[tuple[float, str]]) -> None:
        """Mark events on all curves: seconds before now (negative) and name, oldest first."""
        if self.togetherBox.isChecked():
            self.overlay.setMarks(marks)
        for row in self._rows.values():
            row.plot.setMarks(marks)

    def setSamples(self, histories: Mapping[str, ValueHistory], now: float) -> None:
        """Show the samples up to `now`, in seconds since the epoch."""
        span = self.span
        if self.togetherBox.isChecked():
            self.overlay.setXRange(-span, 0, padding=0)
        for (name, row), colour in zip(self._rows.items(), itertools.cycle(COLOURS), strict=False):
            history = histories.get(name)
            if history is None or len(history) == 0:
                row.clear()
                self._remove_from_overlay(name)
                continue
            times, values = history.since(now - span)
            row.setSamples(times - now, values, span)
            if self.togetherBox.isChecked():
                self.overlay.setLine(name, times - now, over_own_range(values), colour)

    def _furnish(self, overlay: ChannelPlot) -> None:
        overlay.showSeconds()
        overlay.hideAxis("left")  # each curve has a range of its own

    def _remove_from_overlay(self, name: str) -> None:
        if (overlay := self.overlayPlace.made) is not None:
            overlay.removeLine(name)

    def _arrange(self) -> None:
        anything = bool(self._rows)
        self.hintLabel.setVisible(not anything)
        self.scrollArea.setVisible(anything)
        together = self.togetherBox.isChecked()
        self.overlayPlace.setVisible(anything and together)
        for row, colour in zip(self._rows.values(), itertools.cycle(COLOURS), strict=False):
            row.setOverlaid(colour if together else "")
        for button in (self.pauseButton, self.saveButton, self.clearButton):
            set_available(button, None if anything else Unavailable.ENTRIES)


def over_own_range(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return values as fractions of their range, 0 … 1; a value that never changes stays in the middle."""
    if not np.isfinite(values).any():
        return values
    low, high = np.nanmin(values), np.nanmax(values)
    return (values - low) / (high - low) if high > low else values - low + 0.5
