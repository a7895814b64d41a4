"""F11: the image alone, with the pinned controls over it; and the cameras of the last time."""

import pytest
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtGui import QKeySequence
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QDockWidget

from grabbergui.ui.preferences import LAYOUT_VERSION
from grabbergui.ui.run.window import FIRST_URI, first_sources
from grabbergui.ui.views import full_screen


def visible_docks(window):
    return {dock for dock in window.findChildren(QDockWidget) if dock.isVisible()}


@pytest.mark.parametrize("maximised", [False, True])
def test_f11_shows_the_image_alone_and_escape_returns_to_what_was(app, maximised):
    window = app.window
    app.connect()
    app.watch()
    if maximised:
        window.showMaximized()
        app.until(window.isMaximized)
    docks = visible_docks(window)
    QTest.keySequence(window, QKeySequence("F11"))
    app.until(window.isFullScreen)
    app.until(lambda: window.image.height() == window.height() and window.image.width() == window.width())
    assert not visible_docks(window) and not window.header.isVisible() and not window.statusbar.isVisible()
    kept = bytes(window.saveState())
    app.qtbot.keyClick(window.image.canvas, Qt.Key_Escape)
    app.until(lambda: not window.isFullScreen())
    assert window.isMaximized() is maximised and not window.actionFullScreen.isChecked()
    assert visible_docks(window) == docks and window.header.isVisible() and window.statusbar.isVisible()
    app.until(lambda: window.favouritesArea.geometry().bottom() < window.image.y() + 1)
    assert window.restoreState(kept, LAYOUT_VERSION), "what a program closed in full screen had kept"
    assert visible_docks(window) == docks


def test_controls_appear_over_the_image_on_a_movement_and_fade(app, monkeypatch):
    monkeypatch.setattr(full_screen, "FADE_MS", 1)
    window = app.window
    app.connect()
    app.wait_for_cards(3)
    window._full_screen._staying.setInterval(1000)
    window.actionFullScreen.setChecked(True)
    app.until(lambda: window.isFullScreen() and not window.favouritesArea.isVisible())
    for place in (QPoint(300, 300), QPoint(310, 310)):
        app.qtbot.mouseMove(window.image.canvas.viewport(), place)
    app.until(window.favouritesArea.isVisible)
    app.until(lambda: window.image.height() == window.height())  # over the image, which stays as large
    app.until(lambda: not window.favouritesArea.isVisible())
    QTest.keySequence(window, QKeySequence("F7"))  # a key of the menus, which are hidden
    app.until(lambda: window.actionStart.isEnabled())
    window.actionFullScreen.setChecked(False)
    app.until(window.favouritesArea.isVisible)


def test_open_cameras_come_back_at_the_next_start(make_app):
    first = make_app()
    first.connect("sim:?width=64&height=48")
    first.program.opener.open_additional("sim:colour?width=64&height=48")
    first.until(lambda: len(first.program.open_sources.all) == 2)
    first.until(lambda: all(source.state.connected for source in first.program.open_sources.all))
    first.program.open_sources.make_current(first.program.open_sources.all[1])
    first.window.close()
    preferences = first.preferences
    assert first_sources(None, preferences) == [
        "sim:colour?width=64&height=48", "sim:?width=64&height=48"]  # fmt: skip
    assert first_sources("sim:", preferences) == ["sim:"], "only what was asked for"
    app = make_app()
    assert first_sources(None, app.preferences) == [FIRST_URI]
    app.program.begin(*first_sources(None, preferences))
    app.until(lambda: len(app.program.open_sources.all) == 2)
    app.until(lambda: str(app.program.open_sources.current.uri).startswith("sim:colour"))
