"""What the window does where there is little room, and that nothing in it jumps."""

from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from PyQt5.QtCore import QPoint, QRect, Qt
from PyQt5.QtGui import QKeySequence
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import (
    QAbstractButton,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QDockWidget,
    QLineEdit,
    QScrollArea,
    QToolBar,
    QToolButton,
    QWidget,
)

from grabbergui import sources
from grabbergui.core.features import FeatureDescription, FeatureKind
from grabbergui.core.grabber import DeviceInfo
from grabbergui.models.diagnosis import Stage
from grabbergui.models.messages import Message, Offer, Severity
from grabbergui.models.status import Tone
from grabbergui.recording.recorder import RecordingProgress
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.views.measuring_panels import FocusPanel
from grabbergui.ui.views.panel_layout import SETTLING_MS
from grabbergui.ui.views.picture_view import PictureView
from grabbergui.ui.views.recording_bar import RecordingBar
from grabbergui.ui.widgets.labels import ElidedComboBox, ElidedLabel, TaskStack
from grabbergui.ui.widgets.message_stack import MessageBar
from grabbergui.ui.widgets.plots import LABEL_ROOM, CurveRow, SecondsAxis
from grabbergui.ui.widgets.status_strip import StatusStrip
from grabbergui.ui.widgets.tab_order import reading_order

LEAST_CHOICE = 60
"Pixels of a choice whose text ends in dots."


@pytest.fixture
def strip(qtbot):
    made = StatusStrip()
    qtbot.addWidget(made)
    made.resize(940, 28)
    made.show()
    made.setState("Live", Tone.GOOD)
    made.setFormat("2448 × 2048  BayerRG12p")
    made.setRates(9.9, 9)
    made.setBandwidth(40e6)
    made.setLosses("0 lost · 0 incomplete", Tone.IDLE, "")
    return made


def test_the_whole_window_fits_800_pixels(window_desk):
    window_desk.connect()
    window = window_desk.window
    window_desk.program.connection.open_additional("sim:colour")
    window_desk.until(lambda: len(window.gallery.tiles) == 2)
    window.recordingBar.setPlayable("what was recorded")
    window.resize(800, 600)
    window_desk.until(lambda: window.width() == 800)
    assert window.height() == 600
    assert window.centre.minimumSizeHint().width() < 500


def clipped(window):
    """Controls that have less room than they need, or are not seen whole though no scroll bar helps."""
    kinds = (QAbstractButton, QAbstractSpinBox, QComboBox, QLineEdit)
    controls = [each for kind in kinds for each in window.findChildren(kind)]
    return [
        (each.objectName(), type(each).__name__)
        for each in controls
        if each.isVisible() and not isinstance(each.parent(), kinds) and not is_whole(each)
    ]


def is_whole(control):
    """Whether a control is large enough, and seen whole, where it scrolls once it is scrolled to."""
    above = control.parentWidget()
    while not isinstance(above, (QScrollArea, QDockWidget, QToolBar)) and above is not control.window():
        above = above.parentWidget()
    if isinstance(above, QScrollArea):
        above.ensureWidgetVisible(control)
    elif control.visibleRegion().isEmpty():
        return isinstance(above, (QDockWidget, QToolBar))  # behind another panel, or behind the arrow
    top, bottom = (
        control.visibleRegion().boundingRect().top(),
        control.visibleRegion().boundingRect().bottom(),
    )
    least = control.minimumSizeHint()
    if isinstance(control, ElidedComboBox):
        least.setWidth(LEAST_CHOICE)
    whole = top == 0 and bottom == control.height() - 1
    return whole and control.width() >= least.width() and control.height() >= least.height()


@pytest.mark.parametrize("theme", [Theme.LIGHT, Theme.DARK])
def test_each_tool_with_tiles_and_three_controls_fits_800_by_600(desks, qapp, request, theme):
    request.addfinalizer(lambda: qapp.setStyleSheet(""))
    dress(qapp, theme)
    window_desk = desks()
    window = window_desk.window
    window_desk.connect("sim:colour")
    window_desk.program.connection.open_additional("sim:")
    window_desk.until(lambda: len(window.gallery.tiles) == 2 and len(window.favourites._shown) == 3)
    window_desk.qtbot.keyClick(window, Qt.Key_F2)  # and opened in the large window
    window.resize(800, 600)
    docks = (window.histogramDock, window.focusDock, window.profileDock, window.valuesDock,
             window.changesDock, window.logDock)  # fmt: skip
    keys = (Qt.Key_F3, Qt.Key_F4, "Ctrl+T", "Ctrl+H", Qt.Key_F12)
    for dock, key in zip(docks, (None, *keys), strict=True):
        if key is not None:
            QTest.keySequence(window, QKeySequence(key))
        window_desk.until(lambda dock=dock: not dock.visibleRegion().isEmpty())
        window_desk.until(lambda: (window.width(), window.height()) == (800, 600))
        window_desk.until(lambda: window.picture.canvas.height() >= 90)
        window_desk.until(lambda: not clipped(window))
        needed = dock.widget().layout().minimumSize()
        window_desk.until(
            lambda d=dock, n=needed: d.widget().height() >= n.height() and d.width() >= n.width()
        )


def test_in_a_low_window_pinned_controls_scroll_and_the_keyboard_reaches_all(window_desk):
    window = window_desk.window
    window_desk.connect("sim:colour")
    window_desk.program.connection.open_additional("sim:")
    window_desk.until(lambda: len(window.gallery.tiles) == 2 and len(window.favourites._shown) == 3)
    window_desk.until(lambda: window.favouritesArea.height() == window.favourites.height())
    window.resize(800, 600)
    window_desk.qtbot.keyClick(window, Qt.Key_F2)
    window_desk.until(lambda: window.favouritesArea.height() < window.favourites.height())
    area = window.favouritesArea
    window_desk.until(area.verticalScrollBar().isVisible)
    strip = window.favourites
    window_desk.until(lambda: strip.height() == strip.heightsOfLines(strip.width())[-1])  # all are there
    last = window.favourites.rows.rows("AcquisitionFrameRate")[0]
    window_desk.until(lambda: last.editor is not None)
    assert last.visibleRegion().isEmpty()
    before = window.favourites.rows.rows("Gain")[0]
    rows = (before, last)
    window_desk.until(lambda: all(row.editor is not None and row.editor.field.isVisible() for row in rows))
    before.editor.field.setFocus()
    window_desk.until(before.editor.field.hasFocus)
    for _ in range(20):
        QTest.keyClick(QApplication.focusWidget(), Qt.Key_Tab)
        if last.isAncestorOf(QApplication.focusWidget()):
            break
    assert last.isAncestorOf(QApplication.focusWidget())
    window_desk.until(lambda: not QApplication.focusWidget().visibleRegion().isEmpty())


@pytest.mark.parametrize("name", ["the_camera_on_the_left_of_the_head_" * 4, "the camera on the left " * 6])
def test_long_names_of_cameras_push_nothing_out(desks, name):
    def taken(name):
        """Least width, and clipped controls, with two cameras of this name."""

        def named(uri):
            camera = sources.create(uri)
            really = camera.open

            def opened(*arguments):
                granted = really(*arguments)
                camera.info = replace(camera.info, user_name=name, serial=name)
                return granted

            camera.open = opened
            return camera

        desk = desks()
        desk.program.connection._create = named
        desk.window.resize(800, 600)
        desk.connect("sim:?width=320&height=240")
        desk.program.connection.open_additional("sim:colour?width=320&height=240")
        desk.until(lambda: len(desk.window.gallery.tiles) == 2)
        desk.watch()
        assert desk.program.connection.source.title == name
        assert (desk.window.width(), desk.window.height()) == (800, 600)
        found = desk.window.minimumSizeHint().width(), clipped(desk.window)
        desk.window.hide()
        return found

    assert taken(name) == taken("left")


def test_nothing_is_squeezed_or_covered_in_a_low_window_with_tiles(window_desk):
    window = window_desk.window
    window_desk.connect()
    window_desk.program.connection.open_additional("sim:colour")
    window_desk.until(lambda: len(window.gallery.tiles) == 2)
    window.resize(800, 600)
    window_desk.until(lambda: window.centre.height() >= window.centre.minimumSizeHint().height() > 0)
    cards = window.favourites._shown
    window_desk.until(lambda: all(card.height() >= card.minimumSizeHint().height() for card in cards))
    first = window.gallery.tiles[0]
    window_desk.until(lambda: first.visibleRegion().boundingRect().bottom() == first.rect().bottom())
    assert window.picture.canvas.height() >= 120
    window.resize(1280, 800)
    window_desk.until(lambda: window.gallery.tiles[0].height() > 120)


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
    assert not any(label.isHidden() for label in strip._figures)
    strip.resize(strip.stateLabel.sizeHint().width() + 330, 28)
    assert not strip.lossLabel.isHidden()
    assert strip.bandwidthLabel.isHidden()
    strip.resize(940, 28)
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
    strip.resize(890, strip.height())
    assert not strip.bandwidthLabel.isHidden()
    strip.setMessages([Message("the file could not be written to a folder that is not there")])
    assert strip.bandwidthLabel.isHidden() and strip.messages.isVisible() and not strip.titleLabel.isVisible()
    assert strip.messages.sizeHint().height() <= strip.height() == strip.maximumHeight()
    strip.setMessages([])
    assert not strip.bandwidthLabel.isHidden() and strip.titleLabel.isVisible()


def test_while_a_figure_is_shown_the_message_beside_it_is_whole(strip, qtbot):
    strip.setMessages([Message("reconnecting since 12:38:16: the camera does not answer")])
    label = strip.messages.textLabel
    needed = label.fontMetrics().horizontalAdvance(label.text())
    for width in range(700, 1300, 7):
        strip.resize(width, strip.height())
        strip.layout().activate()
        strip.messages.layout().activate()
        assert label.width() >= needed or strip.lossLabel.isHidden(), width


def test_a_note_is_centred_and_its_colour_shows_its_severity(qtbot):
    view = PictureView()
    qtbot.addWidget(view)
    view.resize(640, 480)
    view.show()
    for note, tone in ((("Nothing is connected.",), "info"), (("No packet", "", Stage.PACKETS), "busy")):
        view.setNote(*note)
        middle = view.canvas.geometry().center().y()
        assert abs(view.note.geometry().center().y() - middle) < 5
        assert view.note.property("tone") == tone


def test_every_panel_can_be_open_on_800_pixels(window_desk):
    window = window_desk.window
    window_desk.connect()
    window.resize(800, 600)
    for dock in window.findChildren(QDockWidget):
        dock.show()
    window_desk.until(lambda: window.minimumSizeHint().width() > 700)  # they are laid out
    assert window.minimumSizeHint().width() <= 800 and window.width() == 800


@pytest.mark.parametrize(
    ("room", "taken"),
    [((1024, 600), (1024, 560)), ((1366, 768), (1280, 728)), ((1920, 1080), (1440, 800)),
     ((3840, 2160), (2880, 1590))],
)  # fmt: skip
def test_at_first_the_window_is_large_but_never_larger_than_the_screen(window_desk, monkeypatch, room, taken):
    window = window_desk.window
    screen = SimpleNamespace(availableGeometry=lambda: QRect(0, 0, *room))
    monkeypatch.setattr(window, "screen", lambda: screen)
    window.takeRoom()
    assert (window.width(), window.height()) == taken


def test_work_in_progress_with_a_long_name_fits_the_space(qtbot):
    stack = TaskStack()
    qtbot.addWidget(stack)
    row = stack.begin("Connecting")
    before = stack.minimumSizeHint().width()
    row.setText("file:/" + "a-very-long-name" * 20)
    assert stack.minimumSizeHint().width() == before < 450
    assert row.textLabel.toolTip() == row.textLabel.text()


def test_the_image_stays_where_it_is_under_a_message(window_desk):
    window = window_desk.window
    window_desk.connect()
    window_desk.watch()
    cards = window.favourites._shown
    window_desk.until(lambda: cards and all(card.editor and card.editor.isVisible() for card in cards))
    before = window.picture.geometry(), window.statusbar.geometry()
    for text in ("saved " * 40, "no space left on the disk"):
        window_desk.program.messages.error(text)
        window_desk.until(lambda text=text: text in window.messages.messages)
    assert window.messages.isVisible() and (window.picture.geometry(), window.statusbar.geometry()) == before
    corner = window.messages.mapTo(window, QPoint(0, 0)).y()
    assert corner > window.recordingBar.mapTo(window, QPoint(0, 0)).y(), "it lies over nothing"


def test_the_image_stays_where_it_is_under_work_in_progress(window_desk):
    window, picture = window_desk.window, window_desk.window.picture
    window_desk.connect()
    window_desk.watch()
    places = picture.canvas.geometry(), picture.note.geometry()
    rows = [picture.tasks.begin(title) for title in ("Connecting", "Loading settings")]
    rows[0].setText("a long name " * 30)
    for size in ((1280, 800), (800, 600)):
        window.resize(*size)
        window_desk.until(lambda size=size: (window.width(), window.height()) == size)
        window_desk.until(lambda: picture.canvas.geometry().contains(picture.tasks.geometry()))
        window_desk.until(lambda: rows[0].geometry().bottom() < rows[1].y())
        window_desk.until(lambda: all(row.height() >= row.minimumSizeHint().height() for row in rows))
        assert all(not row.cancelButton.visibleRegion().isEmpty() for row in rows)
    window.resize(1280, 800)
    window_desk.until(lambda: (picture.canvas.geometry(), picture.note.geometry()) == places)
    for row in rows:
        picture.tasks.end(row)
    assert not picture.tasks.isVisible() and picture.canvas.geometry() == places[0]


def test_a_message_that_does_not_fit_and_those_behind_it_can_be_read_in_full(window_desk):
    window, messages = window_desk.window, window_desk.program.messages
    messages.error("a first failure")
    messages.error("a long one " * 30)
    window_desk.until(lambda: len(window.messages.messages) == 2)
    assert window.messages.moreButton.text() == "1 more"
    window_desk.qtbot.mouseClick(window.messages.moreButton, Qt.LeftButton)
    bars = window.messages._popup.findChildren(MessageBar)
    assert [bar.textLabel.text().strip() for bar in bars] == [("A long one " + "a long one " * 29).strip(),
                                                             "A first failure"]  # fmt: skip
    assert bars[0].textLabel.height() >= bars[0].textLabel.heightForWidth(bars[0].textLabel.width())
    assert not reading_order(bars), "the keyboard lands on no cross here either"
    window_desk.qtbot.mouseClick(bars[0].closeButton, Qt.LeftButton)
    window_desk.until(lambda: window.messages.messages == ["a first failure"])
    assert not window.messages.moreButton.isVisible(), "all of it is to be seen"


def test_the_keyboard_never_lands_on_a_cross_but_reaches_what_a_message_offers(window_desk):
    window, pressed = window_desk.window, []
    offers = (Offer("Do it", lambda: pressed.append(1)),)
    window_desk.program.messages.post(Message("it can be done", Severity.WARNING, offers=offers))
    window_desk.until(lambda: window.messages.messages)
    reached = reading_order([window.messages])
    assert [button.text() for button in reached] == ["Do it"]
    window_desk.qtbot.keyClick(reached[0], Qt.Key_Space)
    assert pressed == [1]
    window_desk.qtbot.mouseClick(window.messages.closeButton, Qt.LeftButton)
    window_desk.until(lambda: not window.messages.messages)
    assert not isinstance(QApplication.focusWidget(), QToolButton)


def test_with_tools_and_tiles_the_window_becomes_as_narrow_and_the_image_stays_the_largest(window_desk):
    window = window_desk.window
    window_desk.connect()
    window_desk.program.connection.open_additional("sim:colour")
    window_desk.until(lambda: len(window.gallery.tiles) == 2)
    window.valuesDock.show()
    for key in (Qt.Key_F2, Qt.Key_F3):
        window_desk.qtbot.keyClick(window, key)
    window_desk.until(lambda: window.focusDock.x() > window.histogramDock.x())
    sides = (window.sourcesDock, window.featuresDock)
    before = [dock.width() for dock in sides]
    docks = (window.focusDock, window.histogramDock)
    window_desk.until(
        lambda: all(dock.width() >= dock.widget().layout().minimumSize().width() for dock in docks)
    )
    for tile in window.gallery.tiles:
        tile.setState("15 fps, losing frames", Tone.BUSY)
        window_desk.until(lambda tile=tile: tile.titleLabel.shown in ("SIM001", "SIM002"))
        assert tile.stateLabel.shown.startswith("15 fps") and "…" not in tile.stateLabel.shown
    window_desk.until(lambda: window.picture.canvas.height() > 2 * window.gallery.tiles[0].height())
    window.resize(800, 600)
    window_desk.until(lambda: window.width() == 800)
    window_desk.until(lambda: window.focusDock in window.tabifiedDockWidgets(window.histogramDock))
    cards = window.favourites._shown
    window_desk.until(lambda: all(card.height() >= card.minimumSizeHint().height() for card in cards))
    for dock in (window.histogramDock, window.focusDock, window.valuesDock):
        needed = dock.widget().layout().minimumSize().width()
        window_desk.until(lambda dock=dock, needed=needed: dock.width() >= needed)
    window_desk.qtbot.wait(2 * SETTLING_MS)
    window.resize(1280, 800)
    window_desk.until(lambda: [dock.width() for dock in sides] == before)


@pytest.mark.parametrize("share", [0.05, 0.95])
def test_panels_beside_each_other_cannot_be_dragged_narrower_than_their_controls(window_desk, share):
    window = window_desk.window
    for key in (Qt.Key_F2, Qt.Key_F3):
        window_desk.qtbot.keyClick(window, key)
    docks = (window.focusDock, window.histogramDock)
    window_desk.until(lambda: window.focusDock.x() > window.histogramDock.x())
    QApplication.processEvents()
    widths = [round(share * window.centre.width()), round((1 - share) * window.centre.width())]
    window.resizeDocks(docks, widths, Qt.Horizontal)  # as the mouse does
    for dock in docks:
        needed = dock.widget().layout().minimumSize().width()
        window_desk.until(lambda dock=dock, needed=needed: dock.width() >= needed)


def test_the_focus_aid_stays_where_it_was_put_by_hand(window_desk):
    window = window_desk.window
    for key in (Qt.Key_F2, Qt.Key_F3):
        window_desk.qtbot.keyClick(window, key)
    window.addDockWidget(Qt.RightDockWidgetArea, window.focusDock)
    window_desk.until(lambda: window.focusDock.width() >= window.focus.layout().minimumSize().width())
    window.resize(1000, 700)
    window_desk.until(lambda: window.width() == 1000)
    window_desk.qtbot.wait(SETTLING_MS)
    assert window.dockWidgetArea(window.focusDock) == Qt.RightDockWidgetArea
    assert window.focusDock.width() >= window.focus.layout().minimumSize().width()


def test_panels_that_were_squeezed_get_their_width_back(window_desk):
    window_desk.connect()
    window = window_desk.window
    docks = (window.sourcesDock, window.featuresDock)
    window_desk.until(lambda: window.features.watched)
    window_desk.qtbot.wait(50)
    before = [dock.width() for dock in docks]
    window.resize(800, 600)
    window_desk.until(lambda: sum(dock.width() for dock in docks) < sum(before) - 50)
    window.resize(1280, 800)
    window_desk.until(lambda: [dock.width() for dock in docks] == before)


def test_the_overflow_arrow_of_the_tool_bar_is_whole(window_desk, qapp, request):
    request.addfinalizer(lambda: qapp.setStyleSheet(""))
    dress(qapp, Theme.LIGHT)
    window = window_desk.window
    window.resize(800, 600)
    arrow = window.toolBar.findChild(QToolButton, "qt_toolbar_ext_button")
    window_desk.until(arrow.isVisible)
    window_desk.qtbot.wait(50)
    assert arrow.width() >= 16
    assert window.toolBar.rect().contains(arrow.geometry())


def test_histogram_and_focus_aid_are_seen_together(window_desk):
    window = window_desk.window
    for key in (Qt.Key_F2, Qt.Key_F3):
        window_desk.qtbot.keyClick(window, key)
    window_desk.until(lambda: not window.histogramDock.visibleRegion().isEmpty())
    assert not window.focusDock.visibleRegion().isEmpty()
    assert window.focusDock.x() > window.histogramDock.x()
    window_desk.qtbot.keyClick(window, Qt.Key_F3)
    window_desk.until(lambda: not window.focusDock.isVisible())
    assert window.focusDock in window.tabifiedDockWidgets(window.histogramDock)


def test_a_line_profile_without_a_line_takes_no_room(window_desk):
    window = window_desk.window
    window.profileDock.show()
    window.profileDock.raise_()
    window_desk.until(lambda: window.profile.isVisible())
    assert window.profile.plot.isHidden()
    assert window.profile.maximumHeight() < 60
    window.profile.setProfile({"Y": np.arange(5)})
    assert window.profile.plot.isVisible() and window.profile.maximumHeight() > 1000


def test_the_choices_of_a_recording_can_be_read_beside_tiles_and_a_length(window_desk):
    window_desk.connect()
    window_desk.program.connection.open_additional("sim:colour")
    window_desk.window.resize(1280, 800)
    bar = window_desk.window.recordingBar
    bar.limitBox.setCurrentIndex(1)
    bar.setPlayable("what was recorded")
    window_desk.until(lambda: bar.playButton.isVisible() and bar.amountBox.isVisible())
    needed = bar.limitBox.fontMetrics().horizontalAdvance(bar.limitBox.currentText())
    window_desk.until(lambda: bar.limitBox.width() >= needed + 24)  # and its arrow
    assert not bar.progressLabel.isVisible()


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
