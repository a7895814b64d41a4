"""How panels share the window with the image: widths, places, and what has none."""

import time

import numpy as np
import pytest
from PyQt5.QtCore import QPoint, QSize, Qt
from PyQt5.QtGui import QKeySequence
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import (
    QApplication,
    QDockWidget,
    QSpinBox,
)

from grabbergui.models.status import Tone
from grabbergui.ui.interface_language import speak
from grabbergui.ui.views import panel_layout
from grabbergui.ui.views.main_window import TOOLS_HEIGHT
from grabbergui.ui.views.panel_layout import SETTLING_MS


def test_every_panel_can_be_open_on_800_pixels(app):
    window = app.window
    app.connect()
    window.resize(800, 600)
    for dock in window.findChildren(QDockWidget):
        dock.show()
    app.until(lambda: window.minimumSizeHint().width() > 700)  # they are laid out
    assert window.minimumSizeHint().width() <= 800 and window.width() == 800


def test_hundreds_of_controls_do_not_slow_the_layout_down(app, monkeypatch):
    """The status bar asks for one several times a second."""
    monkeypatch.setattr(panel_layout, "has_screen", lambda: True)
    monkeypatch.setattr(panel_layout, "screen_room", lambda _: QSize(1900, 1000))

    def cost():
        """Seconds of the processor, least of some tries."""
        tries = []
        for _ in range(7):
            begun = time.thread_time()
            app.window._panels.fit_screen()
            tries.append(time.thread_time() - begun)
        return min(tries)

    before = cost()
    for _ in range(500):
        QSpinBox(app.window.features.content)  # with parts that Python does not know yet
    assert cost() < 2 * before + 0.001


@pytest.mark.parametrize("language", ["en", "es"])
def test_no_text_below_the_image_widens_the_window(qapp, request, language):
    speak(qapp, language)
    request.addfinalizer(lambda: speak(qapp, "en"))
    app = request.getfixturevalue("app")
    window = app.window
    app.connect()
    window.resize(800, 600)
    app.until(lambda: window.width() == 800)
    window.actionClipping.trigger()
    app.until(window.image.clippingLabel.text)
    window.actionRegion.trigger()
    app.until(window.image.hintLabel.text)
    canvas = window.image.canvas
    for place in (QPoint(1, 1), canvas.rect().center()):  # where it is already, a mouse does not move
        app.qtbot.mouseMove(canvas, place)
    app.until(window.image.cursorLabel.text)
    QApplication.processEvents()
    assert window.minimumSizeHint().width() <= 800 and window.width() == 800


def test_with_tools_and_tiles_the_window_becomes_as_narrow_and_the_image_stays_the_largest(app):
    window = app.window
    app.connect()
    app.program.opener.open_additional("sim:colour?fps=15")
    app.until(lambda: len(window.gallery.tiles) == 2)
    window.valuesDock.show()
    for key in (Qt.Key_F2, Qt.Key_F3):
        app.qtbot.keyClick(window, key)
    app.until(lambda: window.focusDock.x() > window.histogramDock.x())
    sides = (window.sourcesDock, window.featuresDock)
    before = [dock.width() for dock in sides]
    docks = (window.focusDock, window.histogramDock)
    app.until(lambda: all(dock.width() >= dock.widget().layout().minimumSize().width() for dock in docks))
    for tile in window.gallery.tiles:
        tile.setState("15 fps, losing frames", Tone.BUSY)
        app.until(lambda tile=tile: tile.titleLabel.shown in ("SIM001", "SIM002"))
        assert tile.stateLabel.shown.startswith("15 fps") and "…" not in tile.stateLabel.shown
    app.until(lambda: window.image.canvas.height() > 2 * window.gallery.tiles[0].height())
    window.resize(800, 600)
    app.until(lambda: window.width() == 800)
    app.until(lambda: window.focusDock in window.tabifiedDockWidgets(window.histogramDock))
    cards = window.favourites._shown
    app.until(lambda: all(card.height() >= card.minimumSizeHint().height() for card in cards))
    for dock in (window.histogramDock, window.focusDock, window.valuesDock):
        needed = dock.widget().layout().minimumSize().width()
        app.until(lambda dock=dock, needed=needed: dock.width() >= needed)
    app.qtbot.wait(2 * SETTLING_MS)
    window.resize(1280, 800)
    app.until(lambda: [dock.width() for dock in sides] == before)


def test_the_width_of_a_floating_panel_is_not_the_one_that_it_has_at_the_side(app):
    window = app.window
    app.qtbot.wait(2 * SETTLING_MS)
    before = window._panels.side_widths
    window.featuresDock.setFloating(True)
    app.qtbot.wait(2 * SETTLING_MS)
    window.featuresDock.resize(555, 500)
    app.qtbot.wait(2 * SETTLING_MS)
    assert window.featuresDock.width() == 555
    assert window._panels.side_widths == before


@pytest.mark.parametrize("share", [0.05, 0.95])
def test_panels_beside_each_other_cannot_be_dragged_narrower_than_their_controls(app, share):
    window = app.window
    for key in (Qt.Key_F2, Qt.Key_F3):
        app.qtbot.keyClick(window, key)
    docks = (window.focusDock, window.histogramDock)
    app.until(lambda: window.focusDock.x() > window.histogramDock.x())
    QApplication.processEvents()
    widths = [round(share * window.centre.width()), round((1 - share) * window.centre.width())]
    window.resizeDocks(docks, widths, Qt.Horizontal)  # as the mouse does
    for dock in docks:
        needed = dock.widget().layout().minimumSize().width()
        app.until(lambda dock=dock, needed=needed: dock.width() >= needed)


def test_the_focus_aid_stays_where_it_was_put_by_hand(app):
    window = app.window
    for key in (Qt.Key_F2, Qt.Key_F3):
        app.qtbot.keyClick(window, key)
    window.addDockWidget(Qt.RightDockWidgetArea, window.focusDock)
    app.until(lambda: window.focusDock.width() >= window.focus.layout().minimumSize().width())
    window.resize(1000, 700)
    app.until(lambda: window.width() == 1000)
    app.qtbot.wait(SETTLING_MS)
    assert window.dockWidgetArea(window.focusDock) == Qt.RightDockWidgetArea
    assert window.focusDock.width() >= window.focus.layout().minimumSize().width()


def test_panels_that_were_squeezed_get_their_width_back(app):
    app.connect()
    window = app.window
    docks = (window.sourcesDock, window.featuresDock)
    app.until(lambda: window.features.watched)
    app.qtbot.wait(50)
    before = [dock.width() for dock in docks]
    window.resize(800, 600)
    app.until(lambda: sum(dock.width() for dock in docks) < sum(before) - 50)
    window.resize(1280, 800)
    app.until(lambda: [dock.width() for dock in docks] == before)


def test_histogram_and_focus_aid_are_seen_together(app):
    window = app.window
    for key in (Qt.Key_F2, Qt.Key_F3):
        app.qtbot.keyClick(window, key)
    app.until(lambda: not window.histogramDock.visibleRegion().isEmpty())
    assert not window.focusDock.visibleRegion().isEmpty()
    assert window.focusDock.x() > window.histogramDock.x()
    app.qtbot.keyClick(window, Qt.Key_F3)
    app.until(lambda: not window.focusDock.isVisible())
    assert window.focusDock in window.tabifiedDockWidgets(window.histogramDock)


def test_a_focus_aid_that_is_closed_leaves_the_panel_in_front_that_was(app):
    window = app.window
    QTest.keySequence(window, QKeySequence("Ctrl+H"))
    for key in (Qt.Key_F2, Qt.Key_F3):
        app.qtbot.keyClick(window, key)
    app.until(lambda: not window.focusDock.visibleRegion().isEmpty())
    assert not window.histogramDock.visibleRegion().isEmpty()
    app.qtbot.keyClick(window, Qt.Key_F3)
    app.until(lambda: not window.focusDock.isVisible())
    app.until(lambda: not window.histogramDock.visibleRegion().isEmpty())
    assert window.changesDock.visibleRegion().isEmpty()


def test_a_line_profile_without_a_line_takes_no_room(app):
    window = app.window
    window.profileDock.show()
    window.profileDock.raise_()
    app.until(lambda: window.profile.isVisible())
    assert window.profile.plotPlace.isHidden()
    assert window.profile.maximumHeight() < 60
    window.profile.setProfile({"Y": np.arange(5)})
    assert window.profile.plot.isVisible() and window.profile.maximumHeight() > 1000


def test_the_first_line_gives_its_profile_the_usual_height(app):
    window = app.window
    window.resize(1200, 800)
    app.qtbot.keyClick(window, Qt.Key_F4)
    app.until(lambda: 0 < window.profileDock.height() < 120)
    window.profile.setProfile({"Y": np.arange(5)})
    app.until(lambda: window.profileDock.height() >= TOOLS_HEIGHT)
    assert window.profile.plot.height() > TOOLS_HEIGHT / 2
