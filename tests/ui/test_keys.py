"""Keys do what they say, and nothing while somebody types."""

import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QAction, QApplication


@pytest.fixture
def desk(window_desk):
    window_desk.connect("sim:colour")
    window_desk.watch()
    window_desk.window.activateWindow()
    window_desk.until(lambda: window_desk.window.isActiveWindow())
    return window_desk


def letters(window):
    """The window's actions whose keys are characters."""
    keys = {action: action.shortcut().toString() for action in window.findChildren(QAction)}
    return {action: key for action, key in keys.items() if len(key.removeprefix("Shift+")) == 1}


def give_focus(desk, widget):
    widget.setFocus()
    desk.until(widget.hasFocus)


def test_letters_work_while_the_image_has_the_focus(desk):
    window = desk.window
    give_focus(desk, window.picture.canvas)
    for key, action in (("p", window.actionPause), ("x", window.actionClipping), ("g", window.actionGrid)):
        desk.qtbot.keyClicks(window.picture.canvas, key)
        assert action.isChecked()


def test_letters_typed_beside_the_filter_do_nothing(desk):
    window, before = desk.window, desk.grabber.feature("ExposureAuto").value
    triggered = []
    for action in letters(window):
        action.triggered.connect(lambda _, action=action: triggered.append(action.text()))
    assert len(letters(window)) > 12
    panel = window.features
    for beside in (panel.levelBox, window.sources.sourceList, window.recordingBar.recordButton):
        give_focus(desk, beside)
        desk.qtbot.keyClicks(beside, "pixelformwxcg1,.")
        desk.qtbot.keyClicks(beside, "erwm", Qt.ShiftModifier)
    assert not triggered
    assert desk.grabber.feature("ExposureAuto").value == before


@pytest.mark.parametrize("key", [Qt.Key_Return, Qt.Key_Enter, Qt.Key_Escape])
def test_enter_and_escape_in_a_field_give_the_focus_to_the_image(desk, key):
    field = desk.window.favourites.rows.rows("Gain")[0].editor.field
    give_focus(desk, field)
    desk.qtbot.keyClicks(field, "3")
    desk.qtbot.keyClick(field, key)
    if key == Qt.Key_Escape:  # the first one gives up what was typed
        assert field.hasFocus()
        desk.qtbot.keyClick(field, key)
    assert QApplication.focusWidget() is desk.window.picture.canvas


def test_the_image_has_the_focus_at_first(window_desk):
    window_desk.window.activateWindow()
    window_desk.until(window_desk.window.picture.canvas.hasFocus)


def test_a_panels_key_brings_it_to_the_front_and_hides_it(desk):
    window = desk.window
    front = window.histogramDock
    for key in (Qt.Key_F2, Qt.Key_F4):
        desk.qtbot.keyClick(window.picture.canvas, key)
    assert front.visibleRegion().isEmpty(), "the histogram stands behind the line profile"
    desk.qtbot.keyClick(window.picture.canvas, Qt.Key_F2)
    desk.until(lambda: not front.visibleRegion().isEmpty())
    assert front.isVisible()
    desk.qtbot.keyClick(window.picture.canvas, Qt.Key_F2)
    desk.until(lambda: not front.isVisible())
    assert window.profileDock.isVisible()
