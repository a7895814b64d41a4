"""Where the panels are: by the window's size, until the user moves one."""

import pytest
from PyQt5.QtCore import QSize, Qt
from PyQt5.QtGui import QKeySequence
from PyQt5.QtWidgets import QAction, QApplication, QDockWidget

from grabbergui.core.identity import DeviceInfo
from grabbergui.ui.interface_language import speak
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.views.panel_layout import SLACK, PanelArrangement, arrangement_for, column_width


@pytest.fixture(autouse=True)
def styled(qapp, request):
    """Fonts and margins are those of the program."""
    request.addfinalizer(lambda: qapp.setStyleSheet(""))
    dress(qapp, Theme.LIGHT)


@pytest.mark.parametrize(
    ("size", "tool", "expected"),
    [((1920, 1080), True, PanelArrangement.STACKED), ((1366, 768), False, PanelArrangement.STACKED),
     ((1366, 768), True, PanelArrangement.TABS), ((1024, 600), True, PanelArrangement.TABS),
     ((1199, 1080), True, PanelArrangement.TABS), ((640, 360), False, PanelArrangement.TABS),
     ((640, 360), True, PanelArrangement.ONE), ((1080, 1920), True, PanelArrangement.BELOW)],
)  # fmt: skip
def test_the_arrangement_is_the_one_for_the_size(size, tool, expected):
    assert arrangement_for(QSize(*size), tool=tool) is expected


def arranged(app, width, height, expected):
    app.window.resize(width, height)
    app.until(lambda: app.window._panels.arrangement is expected)
    assert (app.window.width(), app.window.height()) == (width, height)


def panel(app, key):
    return next(a for a in app.window.findChildren(QAction) if a.shortcut() == QKeySequence(key))


def seen(app):
    return {dock for dock in app.window.findChildren(QDockWidget) if not dock.visibleRegion().isEmpty()}


def test_panels_follow_the_size_of_the_window_and_stay_open(app):
    window = app.window
    arranged(app, 1920, 1080, PanelArrangement.STACKED)
    panel(app, "F2").trigger()
    app.until(lambda: seen(app) == {window.sourcesDock, window.featuresDock, window.histogramDock})
    app.until(lambda: window.sourcesDock.y() < window.featuresDock.y() < window.histogramDock.y())
    arranged(app, 1024, 600, PanelArrangement.TABS)
    app.until(lambda: window.histogramDock in seen(app) and len(seen(app)) == 2)
    assert window.featuresDock in window.tabifiedDockWidgets(window.sourcesDock)
    arranged(app, 640, 400, PanelArrangement.ONE)
    app.until(lambda: len(seen(app)) == 1)
    arranged(app, 1080, 1900, PanelArrangement.BELOW)
    app.until(lambda: window.featuresDock.y() > window.image.height())
    arranged(app, 1920, 1080, PanelArrangement.STACKED)
    app.until(lambda: seen(app) == {window.sourcesDock, window.featuresDock, window.histogramDock})


@pytest.mark.parametrize("language", ["en", "es"])
def test_a_plot_has_a_useful_height_wherever_it_is(make_app, qapp, request, language):
    request.addfinalizer(lambda: speak(qapp, "en"))
    speak(qapp, language)
    app = make_app()
    window = app.window
    for width, height in ((1920, 1080), (1366, 768), (1024, 600), (800, 600)):
        window.resize(width, height)
        app.settled(lambda: (window._panels.arrangement, window.featuresDock.geometry()))
        for key, plot, dock in (("F2", window.histogram.plot, window.histogramDock),
                                ("F3", window.focus.plot, window.focusDock)):  # fmt: skip
            action = panel(app, key)
            if not action.isChecked():
                action.trigger()
            app.until(lambda dock=dock: dock in seen(app))
            app.until(lambda plot=plot: plot.height() >= 105 and plot.width() >= 120)


def test_a_panel_that_was_moved_stays_until_the_layout_is_reset(app):
    window = app.window
    arranged(app, 1920, 1080, PanelArrangement.STACKED)
    window.addDockWidget(Qt.LeftDockWidgetArea, window.sourcesDock)  # as the mouse does
    window.featuresDock.close()
    panel(app, "F2").trigger()
    arranged(app, 1024, 600, PanelArrangement.OWN)
    assert window.dockWidgetArea(window.sourcesDock) == Qt.LeftDockWidgetArea
    window.actionResetLayout.trigger()
    app.until(lambda: window._panels.arrangement is PanelArrangement.TABS)
    assert window.dockWidgetArea(window.sourcesDock) == Qt.RightDockWidgetArea
    assert not window.featuresDock.isHidden() and window.histogramDock.isHidden()


def test_the_arrangement_is_kept_and_so_is_a_panel_of_its_own(make_app):
    first = make_app().window
    first.resize(1920, 1080)
    first.histogramDock.show()
    first.histogramDock.setFloating(True)
    QApplication.processEvents()
    kept = first.saveState()
    app = make_app()
    app.window.resize(1920, 1080)
    assert app.window.restoreState(kept)
    assert app.window.histogramDock.isFloating() and not app.window.histogramDock.isHidden()
    first.addDockWidget(Qt.LeftDockWidgetArea, first.sourcesDock)
    assert app.window.restoreState(first.saveState())
    app.until(lambda: app.window._panels.arrangement is PanelArrangement.OWN)
    assert app.window.dockWidgetArea(app.window.sourcesDock) == Qt.LeftDockWidgetArea


def test_the_width_of_the_panels_is_the_users(app):
    window = app.window
    arranged(app, 1024, 600, PanelArrangement.TABS)
    arranged(app, 1920, 1080, PanelArrangement.STACKED)
    app.until(lambda: window.featuresDock.width() == 390)
    window.resizeDocks([window.featuresDock], [500], Qt.Horizontal)
    app.until(lambda: window.featuresDock.width() == 500)
    arranged(app, 1600, 900, PanelArrangement.STACKED)
    assert app.settled(window.featuresDock.width) == 500


def test_the_column_follows_the_width_of_the_window_until_it_is_dragged(app):
    """After *maximise* and back it kept the width that was meant for the whole screen."""
    window = app.window
    arranged(app, 1280, 800, PanelArrangement.STACKED)
    app.until(lambda: window.featuresDock.width() == 282)
    arranged(app, 1920, 1080, PanelArrangement.STACKED)
    app.until(lambda: window.featuresDock.width() == 390)
    arranged(app, 1280, 800, PanelArrangement.STACKED)
    app.until(lambda: window.featuresDock.width() == 282)


def test_the_sources_get_more_room_when_more_are_found(app):
    """On a laptop's screen one card could be seen of all."""
    window = app.window
    arranged(app, 1366, 768, PanelArrangement.STACKED)
    found = [DeviceInfo(f"gige:{n}", serial=str(n), bus="GigE") for n in range(6)]
    app.program.source_controls.source_list.note_found(found)
    cards = window.sources.sourceList
    app.until(lambda: cards.count() == 6)
    app.until(lambda: cards.viewport().visibleRegion().boundingRect().height() > 2 * cards.sizeHintForRow(0))
    app.until(lambda: window.featuresDock.height() > window.sourcesDock.height())


def test_a_larger_window_leaves_its_height_to_the_features(app):
    """Half of the sources' panel was empty on a screen of 1920 pixels."""
    window, sources, features = app.window, app.window.sourcesDock, app.window.featuresDock
    arranged(app, 1280, 800, PanelArrangement.STACKED)
    app.connect()
    before = app.settled(sources.height)
    arranged(app, 1920, 1300, PanelArrangement.STACKED)
    app.until(lambda: features.height() > window.height() / 2)
    assert abs(app.settled(sources.height) - before) < SLACK
    window.resizeDocks([sources, features], [before + 150, 400], Qt.Vertical)  # as the user drags
    app.until(lambda: sources.height() > before + 100)
    arranged(app, 1920, 1200, PanelArrangement.STACKED)
    assert app.settled(sources.height) > before + 50


@pytest.mark.parametrize(
    ("window", "column"), [(1024, 280), (1366, 301), (1920, 390), (2560, 390), (3840, 538)]
)
def test_the_column_has_a_width_that_suits_the_window(window, column):
    """On a screen of 3840 pixels the histogram had a plot of 250."""
    assert column_width(window) == column
