"""Parts of the window where each alone has little room, and that nothing in them jumps."""

import gc
import itertools
import weakref
from itertools import pairwise

import numpy as np
import pytest
from PyQt5.QtCore import QSize
from PyQt5.QtGui import QIcon
from PyQt5.QtWidgets import QAction, QApplication, QToolButton, QWidget

from grabbergui.core.features import FeatureDescription, FeatureKind
from grabbergui.core.identity import DeviceInfo
from grabbergui.models.diagnosis import Stage
from grabbergui.models.measuring import Histogram
from grabbergui.models.messages import UserMessage
from grabbergui.models.status import Tone
from grabbergui.recording.recorder import RecordingProgress
from grabbergui.ui.theme import DARK, Theme, dress, icon, palette
from grabbergui.ui.views.image_view import ImageView
from grabbergui.ui.views.measuring_panels import NO_BREAK, FocusPanel, HistogramPanel
from grabbergui.ui.views.recording_bars import RecordingBar
from grabbergui.ui.widgets.curve_row import CurveRow
from grabbergui.ui.widgets.labels import ElidedLabel
from grabbergui.ui.widgets.plots import LABEL_ROOM, SecondsAxis
from grabbergui.ui.widgets.status_strip import StatusStrip
from grabbergui.ui.widgets.task_stack import TaskStack


@pytest.fixture
def strip(qtbot):
    made = StatusStrip()
    qtbot.addWidget(made)
    made.resize(1240, 28)
    made.show()
    made.setState("Live", Tone.GOOD)
    made.setFormat("2448 × 2048  BayerRG12p")
    made.setRates(9.9, 9)
    made.setBandwidth(40e6)
    made.setLosses("0 lost · 0 incomplete", Tone.IDLE, "")
    made.setSaturated(0.0)
    return made


@pytest.mark.parametrize(
    ("width", "shown"), [(400, "Acme One 40012345"), (110, "One 40012345"), (75, "40012345")]
)
def test_a_name_is_shortened_by_whole_words_to_its_distinctive_part(qtbot, width, shown):
    label = ElidedLabel()
    qtbot.addWidget(label)
    info = DeviceInfo("gige:1", vendor="Acme", model="One", serial="40012345")
    label.setTexts(info.title, info.short_title, info.mark)
    label.resize(round(width * label.fontMetrics().horizontalAdvance("40012345") / 70), 20)
    assert (label.shown, label.toolTip()) == (shown, "Acme One 40012345")
    label.resize(30, 20)
    assert label.shown != "40012345" and "…" in label.shown


def test_the_figures_that_matter_least_make_way(strip):
    figures = (strip.lossLabel, strip.rateLabel, strip.formatLabel, strip.bandwidthLabel)
    assert not any(label.isHidden() for label in figures)
    strip.resize(strip.stateLabel.sizeHint().width() + 330, 28)
    assert not strip.lossLabel.isHidden()
    assert strip.bandwidthLabel.isHidden()
    strip.resize(1240, 28)
    assert not strip.bandwidthLabel.isHidden()


def test_a_figure_with_a_digit_less_keeps_its_place(strip, qtbot):
    strip.setRates(100.0, 100)
    qtbot.waitUntil(lambda: strip.rateLabel.width() >= strip.rateLabel.sizeHint().width())
    before = strip.rateLabel.geometry()
    strip.setRates(1.0, 1)
    assert strip.rateLabel.minimumWidth() == before.width()
    strip.clearFigures()
    assert strip.rateLabel.minimumWidth() == 0


def test_figures_make_way_for_a_message_that_keeps_its_place(strip):
    while not strip.bandwidthLabel.isHidden():
        strip.resize(strip.width() - 10, strip.height())
    strip.resize(strip.width() + 10, strip.height())  # just enough, whatever the style
    assert not strip.bandwidthLabel.isHidden()
    strip.setMessages([UserMessage("the file could not be written to a folder that is not there")])
    assert strip.bandwidthLabel.isHidden() and strip.messages.isVisible() and not strip.titleLabel.isVisible()
    assert strip.messages.sizeHint().height() <= strip.height() == strip.maximumHeight()
    strip.setMessages([])
    assert not strip.bandwidthLabel.isHidden() and strip.titleLabel.isVisible()


@pytest.mark.parametrize("width", [600, 780, 984])
def test_a_message_hides_no_control_of_the_zoom(strip, width):
    actions = [QAction(name, strip) for name in ("fit", "1:1", "in", "out", "turn")]
    strip.addZoomActions(actions)
    QApplication.processEvents()  # which shows them
    strip.resize(width, strip.height())
    strip.setMessages([UserMessage("the camera refused to write 12000 to ExposureAutoUpperLimit: " * 3)])
    assert all(button.isVisible() for button in strip.zoomBox.findChildren(QToolButton))
    assert strip.messages.isVisible() and strip.rateLabel.isHidden()


def test_the_figures_of_a_histogram_are_whole_in_a_narrow_panel(qtbot):
    """On a laptop the shares of saturated and black pixels, and the mean of blue, were elided."""
    panel = HistogramPanel()
    qtbot.addWidget(panel)
    panel.resize(280, 200)
    panel.show()
    panel.setHistogram(Histogram(dict.fromkeys("RGB", np.full(256, 4)), 8))
    label = panel.figuresLabel
    assert label.text().replace(NO_BREAK, " ").endswith("0.39% saturated    0.39% black")
    qtbot.waitUntil(lambda: label.heightForWidth(label.width()) <= label.height() < panel.height() / 3)


def test_while_a_figure_is_shown_the_message_beside_it_is_whole(strip, qtbot):
    strip.setMessages([UserMessage("reconnecting since 12:38:16: the camera does not answer")])
    label = strip.messages.textLabel
    needed = label.fontMetrics().horizontalAdvance(label.text())
    for width in range(700, 1300, 7):
        strip.resize(width, strip.height())
        strip.layout().activate()
        strip.messages.layout().activate()
        assert label.width() >= needed or strip.lossLabel.isHidden(), width


def test_a_note_is_centred_and_its_colour_shows_its_severity(qtbot):
    view = ImageView()
    qtbot.addWidget(view)
    view.resize(640, 480)
    view.show()
    for note, tone in ((("Nothing is connected.",), "info"), (("No packet", "", Stage.PACKETS), "busy")):
        view.setNote(*note)
        middle = view.canvas.geometry().center().y()
        assert abs(view.note.geometry().center().y() - middle) < 5
        assert view.note.property("tone") == tone


def test_work_in_progress_with_a_long_name_fits_the_space(qtbot):
    stack = TaskStack()
    qtbot.addWidget(stack)
    row = stack.begin("Connecting")
    before = stack.minimumSizeHint().width()
    row.setText("file:/" + "a-very-long-name" * 20)
    assert stack.minimumSizeHint().width() == before < 450
    assert row.textLabel.toolTip() == row.textLabel.text()


@pytest.mark.parametrize("width", [345, 368, 420, 480, 640])
def test_parts_of_the_recording_bar_do_not_cover_each_other(qtbot, qapp, request, width):
    request.addfinalizer(lambda: qapp.setStyleSheet(""))
    dress(qapp, Theme.LIGHT)
    host = QWidget()  # which does not mind how much the bar needs
    qtbot.addWidget(host)
    bar = RecordingBar(host)
    bar.setGeometry(0, 0, width - 1, 40)
    host.show()
    bar.setPlayable("what was recorded")
    bar.setGeometry(0, 0, width, 40)
    parts = (bar.recordButton, bar.kindBox, bar.limitBox, bar.playButton)
    qtbot.waitUntil(lambda: not any(a.geometry().intersects(b.geometry()) for a, b in pairwise(parts)))
    assert bar.rect().contains(bar.playButton.geometry())


def test_figures_of_a_recording_are_whole_or_not_there(qtbot):
    bar = RecordingBar()
    qtbot.addWidget(bar)
    bar.setProgress(RecordingProgress(206, seconds=20.1, size=63_000_000, free=75_000_000_000))
    label, seen = bar.progressLabel, []
    for width in range(20, 600, 10):
        label.resize(width, 20)
        seen.append(label.shown)
    assert list(dict.fromkeys(seen)) == [
        "", "00:20.1", "00:20.1 · 206 frames", "00:20.1 · 206 frames · 63 MB",
        "00:20.1 · 206 frames · 63 MB · 75.0 GB free",
        "00:20.1 · 206 frames · 63 MB · 75.0 GB free · for 7 h",
    ]  # fmt: skip
    assert label.toolTip() == seen[-1]


def test_the_sharpness_is_never_half_a_number(qtbot):
    panel = FocusPanel()
    qtbot.addWidget(panel)
    panel.setScores([(0.0, 31.9), (1.0, 31.92)], 31.94)
    for width in range(40, 500, 10):
        panel.scoreLabel.resize(width, 20)
        assert "…" not in panel.scoreLabel.shown
    assert panel.scoreLabel.shown == "Sharpness 31.92    best 31.94    100% of the best"


@pytest.mark.parametrize("width", [70, 100, 300])
def test_times_beneath_a_plot_do_not_run_into_each_other(qtbot, width):
    axis = SecondsAxis("bottom")
    spacing, _ = axis.tickSpacing(-30.0, 0.0, width)[0]
    assert spacing / 30.0 * width >= LABEL_ROOM


def test_a_value_that_does_not_change_is_a_line_in_the_middle_of_its_plot(qtbot):
    row = CurveRow(FeatureDescription(name="ExposureTime", kind=FeatureKind.FLOAT))
    qtbot.addWidget(row)
    times = np.arange(-5.0, 1.0)
    row.setSamples(times, np.full(6, 10_000.0), 10.0)
    low, high = row.plot.viewRange()[1]
    assert (low, high) == pytest.approx((9_000, 11_000))
    row.setSamples(times, np.linspace(0, 10_000, 6), 10.0)
    assert row.plot.getViewBox().autoRangeEnabled()[1]


@pytest.mark.parametrize(
    ("mode", "colour"), [(QIcon.Mode.Normal, DARK.text), (QIcon.Mode.Disabled, DARK.faint)]
)
def test_an_icon_is_drawn_in_the_size_and_the_colour_that_it_is_shown_in(qapp, mode, colour):
    drawn = QIcon(icon("connect", palette(DARK))).pixmap(QSize(27, 27), mode).toImage()
    assert (drawn.width(), drawn.height()) == (27, 27)
    places = itertools.product(range(27), repeat=2)
    solid = {drawn.pixelColor(x, y).name() for x, y in places if drawn.pixelColor(x, y).alpha() == 255}
    assert solid == {colour}


def test_an_icon_without_a_drawing_is_refused_before_it_is_painted(qapp):
    with pytest.raises(FileNotFoundError):
        icon("nothing of the kind", qapp.palette())


def test_a_widget_stays_until_its_test_ends(qtbot):
    """A row with a plot consists of cycles, which the collector would take at any moment."""
    row = CurveRow(FeatureDescription(name="Gain", kind=FeatureKind.FLOAT))
    kept = weakref.ref(row)
    qtbot.addWidget(row)
    del row
    gc.collect()
    assert kept() is not None
