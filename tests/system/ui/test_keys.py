"""Keys do what they say, and nothing while somebody types."""

import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QAction, QApplication

from grabbergui.core.errors import DeviceLostError


@pytest.fixture
def app(make_app):
    app = make_app()
    app.connect("sim:colour?fps=15")
    app.watch()
    app.window.activateWindow()
    app.until(lambda: app.window.isActiveWindow())
    return app


def letters(window):
    """The window's actions whose keys are characters."""
    keys = {action: action.shortcut().toString() for action in window.findChildren(QAction)}
    return {action: key for action, key in keys.items() if len(key.removeprefix("Shift+")) == 1}


def give_focus(app, widget):
    widget.setFocus()
    app.until(widget.hasFocus)


def field_of_gain(app):
    rows = app.window.favourites.rows
    app.until(lambda: rows.rows("Gain") and rows.rows("Gain")[0].editor is not None)
    return rows.rows("Gain")[0].editor.field


def test_letters_work_while_the_image_has_the_focus(app):
    window = app.window
    give_focus(app, window.image.canvas)
    for key, action in (("p", window.actionPause), ("x", window.actionClipping), ("g", window.actionGrid)):
        app.qtbot.keyClicks(window.image.canvas, key)
        assert action.isChecked()


def test_letters_typed_beside_the_filter_do_nothing(app):
    window, before = app.window, app.grabber.feature("ExposureAuto").value
    triggered = []
    for action in letters(window):
        action.triggered.connect(lambda _, action=action: triggered.append(action.text()))
    assert len(letters(window)) > 12
    panel = window.features
    for beside in (panel.levelBox, window.sources.sourceList, window.recordingBar.recordButton):
        give_focus(app, beside)
        app.qtbot.keyClicks(beside, "pixelformwxcg1,.")
        app.qtbot.keyClicks(beside, "erwm", Qt.ShiftModifier)
    assert not triggered
    assert app.grabber.feature("ExposureAuto").value == before


@pytest.mark.parametrize("key", [Qt.Key_Return, Qt.Key_Enter, Qt.Key_Escape])
def test_enter_and_escape_in_a_field_give_the_focus_to_the_image(app, key):
    field = field_of_gain(app)
    give_focus(app, field)
    app.qtbot.keyClicks(field, "3")
    app.qtbot.keyClick(field, key)
    if key == Qt.Key_Escape:  # the first one gives up what was typed
        assert field.hasFocus()
        app.qtbot.keyClick(field, key)
    assert QApplication.focusWidget() is app.window.image.canvas


def test_escape_leaves_the_filter_once_it_is_empty(app):
    filter_edit = app.window.features.filterEdit
    give_focus(app, filter_edit)
    app.qtbot.keyClicks(filter_edit, "gain")
    app.qtbot.keyClick(filter_edit, Qt.Key_Escape)
    assert filter_edit.text() == ""
    assert filter_edit.hasFocus()
    app.qtbot.keyClick(filter_edit, Qt.Key_Escape)
    assert QApplication.focusWidget() is app.window.image.canvas


@pytest.mark.parametrize(
    "control", [field_of_gain, lambda app: app.window.recordingBar.recordButton], ids=["field", "button"]
)
def test_a_control_that_is_locked_by_a_loss_leaves_the_focus_to_the_image(app, monkeypatch, control):
    def refuse(access):
        raise DeviceLostError("still gone")

    widget = control(app)
    give_focus(app, widget)
    with monkeypatch.context() as away:
        away.setattr(app.grabber.device, "open", refuse)
        app.grabber.device.on_lost("its cable is out")
        app.until(lambda: not widget.isEnabled())
        app.until(app.window.image.canvas.hasFocus)
    app.until(widget.isEnabled)
    assert QApplication.focusWidget() is app.window.image.canvas


def test_the_image_has_the_focus_at_first(make_app):
    app = make_app()
    app.window.activateWindow()
    app.until(app.window.image.canvas.hasFocus)


def test_a_panels_key_brings_it_to_the_front_and_hides_it(app):
    window = app.window
    front = window.histogramDock
    for key in (Qt.Key_F2, Qt.Key_F4):
        app.qtbot.keyClick(window.image.canvas, key)
    # The histogram stands behind the line profile.
    app.until(lambda: front.visibleRegion().isEmpty())
    app.qtbot.keyClick(window.image.canvas, Qt.Key_F2)
    app.until(lambda: not front.visibleRegion().isEmpty())
    assert front.isVisible()
    app.qtbot.keyClick(window.image.canvas, Qt.Key_F2)
    app.until(lambda: not front.isVisible())
    assert window.profileDock.isVisible()


def test_a_letter_in_an_open_menu_chooses_its_entry_and_no_shortcut_of_the_image(app):
    window, chosen = app.window, []
    give_focus(app, window.image.canvas)
    window.actionPolarised.toggled.connect(chosen.append)
    window.menuPolarised.popup(window.mapToGlobal(window.rect().center()))
    app.until(window.menuPolarised.isVisible)
    for action in window.menuPolarised.actions():
        action.setText(action.text().replace("&", ""))
    window.actionPolarised.setText("The &crosshair's letter")
    app.qtbot.keyClick(window.menuPolarised, Qt.Key_C)
    assert chosen == [True] and not window.actionCrosshair.isChecked()
