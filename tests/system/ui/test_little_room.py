"""The window where there is little room; nothing in it jumps."""

import struct
from dataclasses import replace
from types import SimpleNamespace

import pytest
from PyQt5.QtCore import QByteArray, QRect, Qt
from PyQt5.QtGui import QKeySequence
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import (
    QAbstractButton,
    QAbstractSpinBox,
    QAction,
    QApplication,
    QComboBox,
    QDockWidget,
    QLineEdit,
    QScrollArea,
    QTabBar,
    QToolBar,
    QToolButton,
)

from grabbergui import sources
from grabbergui.models.diagnosis import Stage
from grabbergui.ui.interface_language import speak
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.widgets.labels import ElidedComboBox

LEAST_CHOICE = 60
"Pixels of a choice whose text ends in dots."


def test_the_whole_window_fits_800_pixels(app):
    app.connect()
    window = app.window
    app.program.opener.open_additional("sim:colour?fps=15")
    app.until(lambda: len(window.gallery.tiles) == 2)
    window.recordingBar.setPlayable("what was recorded")
    window.resize(800, 600)
    app.until(lambda: window.width() == 800)
    assert window.height() == 600
    assert window.centre.minimumSizeHint().width() < 500 and window.minimumSizeHint().width() <= 800


def clipped(window):
    """Controls that have less room than they need, or are not seen whole though no scroll bar helps."""
    kinds = (QAbstractButton, QAbstractSpinBox, QComboBox, QLineEdit)
    behind = [dock for dock in window.findChildren(QDockWidget) if dock.visibleRegion().isEmpty()]
    controls = [
        each
        for kind in kinds
        for each in window.findChildren(kind)
        if not any(dock.isAncestorOf(each) for dock in behind) and not isinstance(each.parent(), QTabBar)
    ]
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


@pytest.mark.parametrize(("theme", "language"), [(Theme.LIGHT, "en"), (Theme.DARK, "es")])
def test_each_tool_with_tiles_and_three_controls_fits_800_by_600(make_app, qapp, request, theme, language):
    request.addfinalizer(lambda: qapp.setStyleSheet(""))
    request.addfinalizer(lambda: speak(qapp, "en"))
    dress(qapp, theme)
    speak(qapp, language)
    app = make_app()
    window = app.window
    app.connect("sim:colour?fps=15")
    app.program.opener.open_additional("sim:?fps=15")
    app.until(lambda: len(window.gallery.tiles) == 2)
    app.wait_for_cards(3)
    app.qtbot.keyClick(window, Qt.Key_F2)  # and opened in the large window
    window.resize(800, 600)
    docks = (window.histogramDock, window.focusDock, window.profileDock, window.valuesDock,
             window.changesDock, window.logDock)  # fmt: skip
    keys = (Qt.Key_F3, Qt.Key_F4, "Ctrl+T", "Ctrl+H", Qt.Key_F12)
    for dock, key in zip(docks, (None, *keys), strict=True):
        if key is not None:
            QTest.keySequence(window, QKeySequence(key))
        app.until(lambda dock=dock: not dock.visibleRegion().isEmpty())
        app.until(lambda: (window.width(), window.height()) == (800, 600))
        app.until(lambda: window.image.canvas.height() >= 90)
        app.until(lambda: not clipped(window))
        needed = dock.widget().layout().minimumSize()
        app.until(lambda d=dock, n=needed: d.widget().height() >= n.height() and d.width() >= n.width())


TOOL_KEYS = (Qt.Key_F2, Qt.Key_F3, Qt.Key_F4, "Ctrl+T", "Ctrl+H", Qt.Key_F12)


@pytest.mark.parametrize("language", ["en", "es"])
def test_in_640_by_360_all_panels_are_tabs_at_the_right(make_app, qapp, request, language):
    request.addfinalizer(lambda: qapp.setStyleSheet(""))
    request.addfinalizer(lambda: speak(qapp, "en"))
    dress(qapp, Theme.LIGHT)
    speak(qapp, language)
    app = make_app()
    window = app.window
    window.resize(640, 360)
    app.connect("sim:colour?fps=15")
    app.until(lambda: window.featuresDock in window.tabifiedDockWidgets(window.sourcesDock))
    for key in TOOL_KEYS:
        QTest.keySequence(window, QKeySequence(key))
        app.until(lambda: (window.width(), window.height()) == (640, 360))
        app.until(lambda: not clipped(window))
    for key in ("F8", "F9", *TOOL_KEYS):
        action = next(a for a in window.findChildren(QAction) if a.shortcut() == QKeySequence(key))
        assert action in window.menuView.actions()
        app.qtbot.wait(10)
        if not action.isChecked():
            QTest.keySequence(window, QKeySequence(key))
        app.until(action.isChecked)
        app.until(lambda: not clipped(window))


def test_the_address_and_the_filter_come_to_the_front(app):
    window = app.window
    window.resize(640, 360)
    app.until(lambda: window.featuresDock in window.tabifiedDockWidgets(window.sourcesDock))
    app.connect()
    for key, field in (("Ctrl+L", window.sources.addressEdit), ("Ctrl+F", window.features.filterEdit)):
        QTest.keySequence(window, QKeySequence(key))
        app.until(lambda field=field: field.hasFocus() and not field.visibleRegion().isEmpty())


def test_in_a_low_window_pinned_controls_scroll_and_the_keyboard_reaches_all(app):
    window = app.window
    app.connect("sim:colour?fps=15")
    app.program.opener.open_additional("sim:?fps=15")
    for name in ("DeviceTemperature", "TriggerMode", "TriggerSource", "AcquisitionMode"):
        app.program.feature_controls.favourites.add(name)
    app.until(lambda: len(window.gallery.tiles) == 2)
    app.wait_for_cards(7)
    app.until(lambda: window.favouritesArea.height() == window.favourites.height())
    window.resize(640, 360)
    app.until(lambda: window.favouritesArea.height() < window.favourites.height())
    area = window.favouritesArea
    app.until(area.verticalScrollBar().isVisible)
    strip = window.favourites
    app.until(lambda: strip.height() == strip.heightsOfLines(strip.width())[-1])  # all are there
    last = window.favourites.rows.rows("AcquisitionMode")[0]
    app.until(lambda: last.editor is not None)
    assert last.visibleRegion().isEmpty()
    before = window.favourites.rows.rows("Gain")[0]
    rows = (before, last)
    app.until(lambda: all(row.editor is not None and row.isVisible() for row in rows))
    before.editor.field.setFocus()
    app.until(before.editor.field.hasFocus)
    for _ in range(60):
        QTest.keyClick(QApplication.focusWidget(), Qt.Key_Tab)
        if last.isAncestorOf(QApplication.focusWidget()):
            break
    assert last.isAncestorOf(QApplication.focusWidget())
    app.until(lambda: not QApplication.focusWidget().visibleRegion().isEmpty())


@pytest.mark.parametrize("name", ["the_camera_on_the_left_of_the_head_" * 4, "the camera on the left " * 6])
def test_long_names_of_cameras_push_nothing_out(make_app, name):
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

        app = make_app()
        app.program.opener.create = named
        app.window.resize(800, 600)
        app.connect("sim:?width=320&height=240")
        app.program.opener.open_additional("sim:colour?width=320&height=240")
        app.until(lambda: len(app.window.gallery.tiles) == 2)
        app.watch()
        assert app.program.open_sources.current.title.startswith(name)
        assert (app.window.width(), app.window.height()) == (800, 600)
        found = app.settled(lambda: (app.window.minimumSizeHint().width(), clipped(app.window)))
        app.window.hide()
        return found

    assert taken(name) == taken("left")


def test_a_note_in_a_low_window_shows_its_beginning(app):
    window, image = app.window, app.window.image
    window.resize(window.minimumSizeHint())
    image.setNote("The camera sends its frames to another program", "close it, or " * 40, Stage.PACKETS)
    app.until(lambda: image.note.y() >= image.paneArea.y() and image.note.isVisible())
    summary, stages = image.note.summaryLabel, image.note.stageLabel
    app.until(lambda: summary.visibleRegion().boundingRect().top() == 0)
    app.until(lambda: stages.heightForWidth(stages.width()) <= stages.height())
    app.until(lambda: stages.minimumSizeHint().width() <= stages.width())  # no stage is cut off
    assert "another program" in image.note.toolTip() and "close it" in image.note.toolTip()


def test_nothing_is_squeezed_or_covered_in_a_low_window_with_tiles(app):
    window = app.window
    app.connect()
    app.program.opener.open_additional("sim:colour?fps=15")
    app.until(lambda: len(window.gallery.tiles) == 2)
    window.resize(800, 600)
    app.until(lambda: window.centre.height() >= window.centre.minimumSizeHint().height() > 0)
    cards = window.favourites.shownCards
    app.until(lambda: all(card.height() >= card.minimumSizeHint().height() for card in cards))
    app.until(lambda: window.featuresDock in window.tabifiedDockWidgets(window.sourcesDock))
    window.sourcesDock.raise_()
    first = window.gallery.tiles[0]
    app.until(lambda: first.visibleRegion().boundingRect().bottom() == first.rect().bottom())
    app.until(lambda: window.image.canvas.height() >= 120)


@pytest.mark.parametrize(
    ("room", "taken"),
    [((1024, 600), (1024, 560)), ((1366, 768), (1280, 728)), ((1920, 1080), (1440, 800)),
     ((3840, 2160), (2880, 1590))],
)  # fmt: skip
def test_at_first_the_window_is_large_but_never_larger_than_the_screen(app, monkeypatch, room, taken):
    window = app.window
    screen = SimpleNamespace(availableGeometry=lambda: QRect(0, 0, *room))
    monkeypatch.setattr(window, "screen", lambda: screen)
    window.takeRoom()
    assert (window.width(), window.height()) == taken


@pytest.mark.parametrize("refused", [True, False])
def test_a_window_left_on_a_screen_of_another_size_is_no_larger_than_this_one(app, monkeypatch, refused):
    window = app.window
    window.resize(1900, 1000)
    left = bytes(window.saveGeometry())
    width = struct.pack(">i", window.screen().size().width())
    assert left[46:50] == width, "the screen's width follows two rectangles, its number and two flags"
    if refused:
        left = left[:46] + struct.pack(">i", 1920) + left[50:]
    screen = SimpleNamespace(availableGeometry=lambda: QRect(0, 0, 1280, 720))
    monkeypatch.setattr(window, "screen", lambda: screen)
    assert window.restoreGeometry(QByteArray(left)) is not refused
    window.resize(1900, 1000)

    window.restorePlace(QByteArray(left))

    assert (window.width(), window.height()) == (1280, 680)


def test_the_overflow_arrow_of_the_tool_bar_is_whole(app, qapp, request):
    request.addfinalizer(lambda: qapp.setStyleSheet(""))
    dress(qapp, Theme.LIGHT)
    window = app.window
    window.resize(640, 480)
    arrow = window.toolBar.findChild(QToolButton, "qt_toolbar_ext_button")
    app.until(arrow.isVisible)
    app.until(lambda: arrow.width() >= 16 and window.toolBar.rect().contains(arrow.geometry()))


def test_the_choices_of_a_recording_can_be_read_beside_tiles_and_a_length(app):
    app.connect()
    app.program.opener.open_additional("sim:colour?fps=15")
    app.window.resize(1280, 800)
    bar = app.window.recordingBar
    bar.limitBox.setCurrentIndex(1)
    bar.setPlayable("what was recorded")
    app.until(lambda: bar.playButton.isVisible() and bar.amountBox.isVisible())
    needed = bar.limitBox.fontMetrics().horizontalAdvance(bar.limitBox.currentText())
    app.until(lambda: bar.limitBox.width() >= needed + 24)  # and its arrow
    assert not bar.progressLabel.isVisible()
