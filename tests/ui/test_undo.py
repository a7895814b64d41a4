"""Undo, redo and the list of changes, as a person uses them."""

from dataclasses import replace

import pytest
from PyQt5.QtCore import QItemSelectionModel, Qt
from PyQt5.QtWidgets import QApplication

from grabbergui.core.errors import FeatureError
from grabbergui.core.pixels import Region
from grabbergui.core.selection import SettingKey
from grabbergui.models.changes.history import Change, Origin
from grabbergui.models.changes.journal import MOST_CHANGES
from grabbergui.ui.views.changes_panel import ChangeTable
from grabbergui.ui.views.help_views import ShortcutsDialog
from grabbergui.ui.widgets.drawing import Purpose


@pytest.fixture
def desk(window_desk):
    window_desk.connect("sim:?width=320&height=240&fps=60")
    QApplication.setActiveWindow(window_desk.window)  # shortcuts are an active window's
    return window_desk


def row(desk, name):
    rows = desk.window.favourites.rows
    desk.until(lambda: rows.rows(name) and rows.rows(name)[0].editor is not None)
    desk.until(rows.rows(name)[0].editor.isEnabled)
    return rows.rows(name)[0]


def type_value(desk, name, text):
    field = row(desk, name).editor.field
    field.setFocus()
    field.selectAll()
    desk.qtbot.keyClicks(field, text)
    desk.qtbot.keyClick(field, Qt.Key_Return)
    return field


def value(desk, name):
    return desk.grabber.feature(name).value


def shown(desk):
    table = desk.window.changes.table.model()
    return [[table.index(row, column).data() for column in range(1, 6)] for row in range(table.rowCount())]


def test_what_was_typed_is_undone_and_redone_by_keys_where_the_focus_is(desk):
    window = desk.window
    assert not window.actionUndo.isEnabled()
    field = type_value(desk, "Gain", "6")
    desk.until(lambda: value(desk, "Gain") == 6)
    desk.until(window.actionUndo.isEnabled)
    assert window.actionUndo.text() == "&Undo Gain 0 → 6"
    desk.qtbot.keyClick(field, Qt.Key_Z, Qt.ControlModifier)
    desk.until(lambda: value(desk, "Gain") == 0)
    desk.until(lambda: field.text().startswith("0"))
    desk.until(window.actionRedo.isEnabled)
    assert not window.actionUndo.isEnabled()
    desk.qtbot.keyClick(field, Qt.Key_Z, Qt.ControlModifier | Qt.ShiftModifier)
    desk.until(lambda: value(desk, "Gain") == 6)
    assert not desk.errors


def test_while_something_is_typed_undo_is_the_texts(desk):
    type_value(desk, "Gain", "6")
    field = row(desk, "Gain").editor.field
    desk.until(desk.window.actionUndo.isEnabled)
    field.selectAll()
    desk.qtbot.keyClicks(field, "12")
    desk.qtbot.keyClick(field, Qt.Key_Z, Qt.ControlModifier)
    desk.watch()
    assert value(desk, "Gain") == 6


def test_a_dragged_slider_is_undone_in_one_press(desk):
    slider = row(desk, "ExposureTime").editor.slider()
    before = value(desk, "ExposureTime")
    slider.setSliderDown(True)
    for position in range(slider.value(), 900, 20):
        slider.setSliderPosition(position)
        desk.qtbot.wait(5)
    slider.setSliderDown(False)
    last = 1000 * float(row(desk, "ExposureTime").editor.field.text().removesuffix(" ms"))
    desk.until(lambda: value(desk, "ExposureTime") == pytest.approx(last))
    desk.until(desk.window.actionUndo.isEnabled)
    desk.window.actionUndo.trigger()
    desk.until(lambda: value(desk, "ExposureTime") == before)
    desk.until(lambda: not desk.window.actionUndo.isEnabled())


def test_an_undo_refused_by_the_camera_is_reported(desk, monkeypatch):
    type_value(desk, "Gain", "6")
    desk.until(desk.window.actionUndo.isEnabled)

    def refuse(key, value):
        raise FeatureError(f"{key}={value}: the camera answered: busy", key.name)

    monkeypatch.setattr(desk.grabber, "write_setting", refuse)
    desk.window.actionUndo.trigger()
    desk.until(lambda: desk.errors)
    assert desk.errors[0] == "Undo of Gain 0 → 6: Gain=0.0: the camera answered: busy"


def test_the_list_says_what_was_changed_by_whom(desk):
    window = desk.window
    desk.qtbot.keyClick(window, Qt.Key_H, Qt.ControlModifier)
    assert window.changesDock.isVisible()
    type_value(desk, "Gain", "6")
    desk.until(lambda: shown(desk) == [["Gain", "0", "6", "operator", ""]])
    row(desk, "ExposureTime").auto.click()
    desk.until(lambda: ["ExposureAuto", "Off", "Continuous", "operator", ""] in shown(desk))
    desk.until(lambda: any(line[0] == "ExposureTime" and line[3] == "camera" for line in shown(desk)))
    window.changes.whoseBox.setCurrentIndex(1)
    assert {line[3] for line in shown(desk)} == {"operator"}
    window.changes.whoseBox.setCurrentIndex(0)
    desk.qtbot.mouseClick(window.changes.clearButton, Qt.LeftButton)
    window.actionUndo.trigger()
    desk.until(lambda: ["ExposureAuto", "Continuous", "Off", "operator", "Undo"] in shown(desk))


def test_changes_are_copied_as_a_command_line_a_program_and_a_table(desk, tmp_path):
    window = desk.window
    type_value(desk, "Gain", "6")
    desk.until(lambda: len(shown(desk)) == 1)
    type_value(desk, "ExposureTime", "2500 us")
    desk.until(lambda: len(shown(desk)) == 2)
    command, program, table = window.changes.copyMenu.actions()
    command.trigger()
    line = "grabbergui set 'sim:?width=320&height=240&fps=60' Gain=6 ExposureTime=2500\n"
    assert QApplication.clipboard().text() == line
    window.changes.table.selectionModel().select(
        window.changes.table.model().index(0, 0), QItemSelectionModel.Select | QItemSelectionModel.Rows
    )
    program.trigger()
    text = QApplication.clipboard().text()
    assert "write_feature('Gain', 6.0)" in text and "ExposureTime" not in text
    table.trigger()
    assert QApplication.clipboard().text().splitlines()[1].split("\t")[1:5] == ["Gain", "0", "6", "operator"]
    window.changes.table.clearSelection()
    desk.program.changes.save(tmp_path / "again.sh")
    assert (tmp_path / "again.sh").read_text() == f"#!/bin/sh -e\n{line}"
    desk.program.changes.save(tmp_path / "again.py")
    compile((tmp_path / "again.py").read_text(), "again.py", "exec")
    desk.program.changes.save(tmp_path / "no" / "such" / "folder.py")
    desk.until(lambda: any("could not be written" in text for text in desk.errors))


def test_another_source_has_changes_of_its_own_and_those_of_a_closed_one_stay_to_be_seen(desk):
    type_value(desk, "Gain", "6")
    desk.until(lambda: len(shown(desk)) == 1)
    desk.program.connection.disconnect()
    desk.until(lambda: not desk.window.actionUndo.isEnabled())
    assert len(shown(desk)) == 1
    desk.connect("sim:?width=640&height=480")
    desk.until(lambda: shown(desk) == [])
    assert not desk.window.actionUndo.isEnabled()


def test_a_region_of_the_sensor_is_one_step(desk):
    desk.until(desk.window.actionRegion.isEnabled)
    desk.watch()
    names = ("Width", "Height", "OffsetX", "OffsetY")
    before = [value(desk, name) for name in names]
    desk.program.region._on_region_drawn(Purpose.SENSOR_REGION, Region(100, 50, 64, 48))
    desk.until(lambda: desk.window.actionUndo.text() == "&Undo Region of the sensor")
    assert (value(desk, "Width"), value(desk, "Height")) == (64, 48)
    desk.window.actionUndo.trigger()
    desk.until(lambda: [value(desk, name) for name in names] == before)
    desk.until(lambda: desk.grabber.streaming)


def test_the_overview_of_keys_says_what_they_do_and_not_what_would_be_undone(desk):
    type_value(desk, "Gain", "6")
    desk.until(desk.window.actionUndo.isEnabled)
    dialog = ShortcutsDialog(desk.window.menuBar(), desk.window)
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
