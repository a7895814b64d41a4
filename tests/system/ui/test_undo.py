"""Undo, redo and the list of changes, as a person uses them."""

from dataclasses import replace

import pytest
from PyQt5.QtCore import QItemSelectionModel, Qt
from PyQt5.QtWidgets import QApplication

from grabbergui.core.errors import FeatureError
from grabbergui.core.pixels import Region
from grabbergui.core.settings import SettingKey
from grabbergui.models.change import Change, Origin
from grabbergui.models.change_journal import MOST_CHANGES
from grabbergui.ui.views.changes_panel import ChangeTable
from grabbergui.ui.views.help_views import ShortcutsDialog
from grabbergui.ui.widgets.drawing_tool import Purpose


@pytest.fixture
def app(make_app):
    app = make_app()
    app.connect("sim:?width=320&height=240&fps=15")
    QApplication.setActiveWindow(app.window)  # shortcuts are an active window's
    return app


def row(app, name):
    rows = app.window.favourites.rows
    app.until(lambda: rows.rows(name) and rows.rows(name)[0].editor is not None)
    app.until(rows.rows(name)[0].editor.isEnabled)
    return rows.rows(name)[0]


def type_value(app, name, text):
    field = row(app, name).editor.field
    field.setFocus()
    field.selectAll()
    app.qtbot.keyClicks(field, text)
    app.qtbot.keyClick(field, Qt.Key_Return)
    return field


def value(app, name):
    return app.grabber.feature(name).value


def shown(app):
    table = app.window.changes.table.model()
    return [[table.index(row, column).data() for column in range(1, 6)] for row in range(table.rowCount())]


def test_what_was_typed_is_undone_and_redone_by_keys_where_the_focus_is(app):
    window = app.window
    assert not window.actionUndo.isEnabled()
    field = type_value(app, "Gain", "6")
    app.until(lambda: value(app, "Gain") == 6)
    app.until(window.actionUndo.isEnabled)
    assert window.actionUndo.text() == "&Undo Gain 0 → 6"
    app.qtbot.keyClick(field, Qt.Key_Z, Qt.ControlModifier)
    app.until(lambda: value(app, "Gain") == 0)
    app.until(lambda: field.text().startswith("0"))
    app.until(window.actionRedo.isEnabled)
    assert not window.actionUndo.isEnabled()
    app.qtbot.keyClick(field, Qt.Key_Z, Qt.ControlModifier | Qt.ShiftModifier)
    app.until(lambda: value(app, "Gain") == 6)
    assert not app.errors


def test_while_something_is_typed_undo_is_the_texts(app):
    type_value(app, "Gain", "6")
    field = row(app, "Gain").editor.field
    app.until(app.window.actionUndo.isEnabled)
    field.selectAll()
    app.qtbot.keyClicks(field, "12")
    app.qtbot.keyClick(field, Qt.Key_Z, Qt.ControlModifier)
    app.watch()
    assert value(app, "Gain") == 6


def test_a_dragged_slider_is_undone_in_one_press(app):
    slider = row(app, "ExposureTime").editor.slider()
    before = value(app, "ExposureTime")
    slider.setSliderDown(True)
    for position in range(slider.value(), 900, 20):
        slider.setSliderPosition(position)
        app.qtbot.wait(5)
    slider.setSliderDown(False)
    last = 1000 * float(row(app, "ExposureTime").editor.field.text().removesuffix(" ms"))
    app.until(lambda: value(app, "ExposureTime") == pytest.approx(last))
    app.until(app.window.actionUndo.isEnabled)
    app.window.actionUndo.trigger()
    app.until(lambda: value(app, "ExposureTime") == before)
    app.until(lambda: not app.window.actionUndo.isEnabled())


def test_an_undo_refused_by_the_camera_is_reported(app, monkeypatch):
    type_value(app, "Gain", "6")
    app.until(app.window.actionUndo.isEnabled)

    def refuse(key, value):
        raise FeatureError(f"{key}={value}: the camera answered: busy", key.name)

    monkeypatch.setattr(app.grabber, "write_setting", refuse)
    app.window.actionUndo.trigger()
    app.until(lambda: app.errors)
    assert app.errors[0] == "Undo of Gain 0 → 6: Gain=0.0: the camera answered: busy"


def test_the_list_says_what_was_changed_by_whom(app):
    window = app.window
    app.qtbot.keyClick(window, Qt.Key_H, Qt.ControlModifier)
    assert window.changesDock.isVisible()
    type_value(app, "Gain", "6")
    app.until(lambda: shown(app) == [["Gain", "0", "6", "operator", ""]])
    exposure = row(app, "ExposureTime")
    # Its mode is read after the value.
    app.until(lambda: exposure.auto is not None and exposure.auto.isEnabled())
    exposure.auto.click()
    app.until(lambda: ["ExposureAuto", "Off", "Continuous", "operator", ""] in shown(app))
    app.until(lambda: any(line[0] == "ExposureTime" and line[3] == "camera" for line in shown(app)))
    window.changes.whoseBox.setCurrentIndex(1)
    assert {line[3] for line in shown(app)} == {"operator"}
    window.changes.whoseBox.setCurrentIndex(0)
    app.qtbot.mouseClick(window.changes.clearButton, Qt.LeftButton)
    window.actionUndo.trigger()
    app.until(lambda: ["ExposureAuto", "Continuous", "Off", "operator", "Undo"] in shown(app))


def test_changes_are_copied_as_a_command_line_a_program_and_a_table(app, tmp_path):
    window = app.window
    type_value(app, "Gain", "6")
    app.until(lambda: len(shown(app)) == 1)
    type_value(app, "ExposureTime", "2500 us")
    app.until(lambda: len(shown(app)) == 2)
    command, program, table = window.changes.copyMenu.actions()
    command.trigger()
    line = "grabbergui set 'sim:?width=320&height=240&fps=15' Gain=6 ExposureTime=2500\n"
    assert QApplication.clipboard().text() == line
    window.changes.table.selectionModel().select(
        window.changes.table.model().index(0, 0), QItemSelectionModel.Select | QItemSelectionModel.Rows
    )
    program.trigger()
    text = QApplication.clipboard().text()
    assert "camera['Gain'] = 6.0" in text and "ExposureTime" not in text
    table.trigger()
    assert QApplication.clipboard().text().splitlines()[1].split("\t")[1:5] == ["Gain", "0", "6", "operator"]
    window.changes.table.clearSelection()
    app.program.feature_controls.changes.save(tmp_path / "again.sh")
    assert (tmp_path / "again.sh").read_text() == f"#!/bin/sh -e\n{line}"
    app.program.feature_controls.changes.save(tmp_path / "again.py")
    compile((tmp_path / "again.py").read_text(), "again.py", "exec")
    app.program.feature_controls.changes.save(tmp_path / "no" / "such" / "folder.py")
    app.until(lambda: any("could not be written" in text for text in app.errors))


def test_another_source_has_changes_of_its_own_and_those_of_a_closed_one_stay_to_be_seen(app):
    type_value(app, "Gain", "6")
    app.until(lambda: len(shown(app)) == 1)
    app.program.open_sources.close_current()
    app.until(lambda: not app.window.actionUndo.isEnabled())
    assert len(shown(app)) == 1
    app.connect("sim:?width=640&height=480")
    app.until(lambda: shown(app) == [])
    assert not app.window.actionUndo.isEnabled()


def test_a_region_of_the_sensor_is_one_step(app):
    app.until(app.window.actionRegion.isEnabled)
    app.watch()
    names = ("Width", "Height", "OffsetX", "OffsetY")
    before = [value(app, name) for name in names]
    app.program.image_controls.region._on_region_drawn(Purpose.SENSOR_REGION, Region(100, 50, 64, 48))
    app.until(lambda: app.window.actionUndo.text() == "&Undo Region of the sensor")
    assert (value(app, "Width"), value(app, "Height")) == (64, 48)
    app.window.actionUndo.trigger()
    app.until(lambda: [value(app, name) for name in names] == before)
    app.until(lambda: app.grabber.streaming)


def test_the_overview_of_keys_says_what_they_do_and_not_what_would_be_undone(app):
    type_value(app, "Gain", "6")
    app.until(app.window.actionUndo.isEnabled)
    dialog = ShortcutsDialog(app.window.menuBar(), app.window)
    text = dialog.leftLabel.text() + dialog.rightLabel.text()
    assert "<td>Undo</td>" in text and "→" not in text
    dialog.close()


def test_the_list_forgets_the_oldest(qtmodeltester):
    table = ChangeTable()
    key = SettingKey("Gain")
    for number in range(1, MOST_CHANGES + 300):
        table.note(Change(number, 0.0, key, 0, number, Origin.CAMERA))
    assert MOST_CHANGES - 300 < table.rowCount() <= MOST_CHANGES
    last = table.changes[-1]
    table.note(replace(last, after=-1))
    assert table.changes[-1].after == -1
    assert table.rowCount() <= MOST_CHANGES
    qtmodeltester.check(table)
