"""The look-up table is a curve that is edited, kept in a file, written to the camera and taken back."""

from dataclasses import replace

import numpy as np
import pytest
from PyQt5.QtCore import Qt

from grabbergui.core.errors import CameraFileError
from grabbergui.core.lookup_table import (
    gamma_table,
    load_table,
    read_table,
    save_table,
    shape_of,
    write_table,
)


@pytest.fixture
def app(make_app):
    app = make_app()
    app.connect("sim:?width=160&height=120&fps=20")
    action = app.window.actionLookUpTable
    app.until(action.isEnabled)
    action.trigger()
    app.until(lambda: app.program.feature_controls.lut.dialog is not None)
    return app


def test_a_gamma_is_written_to_the_camera_and_taken_back(app):
    lut, dialog, camera = (
        app.program.feature_controls.lut,
        app.program.feature_controls.lut.dialog,
        app.grabber,
    )
    linear = read_table(camera)
    assert not dialog.writeButton.isEnabled() and not dialog.undoButton.isEnabled()
    assert not dialog.selectorBox.isVisible(), "one table needs no choice"
    dialog.gammaBox.setValue(0.5)
    assert dialog.writeButton.isEnabled() and "not written yet" in dialog.stateLabel.text()
    assert dialog.plot.values("edited").max() == 65535
    assert np.array_equal(read_table(camera), linear), "the camera is not touched before"
    dialog.writeButton.click()
    app.until(dialog.undoButton.isEnabled)
    assert np.array_equal(read_table(camera), lut.edited) and lut.edited[1024] > linear[1024]
    dialog.undoButton.click()
    app.until(lambda: np.array_equal(read_table(camera), linear))
    app.until(lambda: np.array_equal(lut.edited, linear))
    dialog.close()
    app.until(lambda: lut.dialog is None)


def test_the_gamma_of_the_cameras_table_is_shown(app, tmp_path, monkeypatch):
    lut, box = app.program.feature_controls.lut, app.program.feature_controls.lut.dialog.gammaBox
    assert box.value() == 1.0
    write_table(app.grabber, gamma_table(shape_of(app.grabber), 0.45))
    lut.dialog.close()
    app.window.actionLookUpTable.trigger()
    app.until(lambda: lut.dialog is not None)
    assert lut.dialog.gammaBox.value() == 0.45
    path = tmp_path / "lut.csv"
    save_table(path, lut.edited // 2)
    monkeypatch.setattr(app.program.files, "to_open", lambda *_: path)
    lut.dialog.loadButton.click()
    assert lut.dialog.gammaBox.text() == "–", "no gamma has this curve"


def test_a_file_that_is_no_table_is_refused_where_it_was_asked_for(app, tmp_path, monkeypatch):
    path = tmp_path / "lut.csv"
    path.write_text("0,1\n1,two\n")
    dialog = app.program.feature_controls.lut.dialog
    monkeypatch.setattr(app.program.files, "to_open", lambda *_: path)
    dialog.loadButton.click()
    assert "two" in dialog.stateLabel.text() and str(path) in dialog.stateLabel.text()
    dialog.gammaBox.setValue(0.5)
    assert dialog.stateLabel.text() == "4096 entries · not written yet"


def test_a_gamma_below_the_least_is_the_least(app):
    box, lut = app.program.feature_controls.lut.dialog.gammaBox, app.program.feature_controls.lut
    box.selectAll()
    app.qtbot.keyClicks(box, "0.02")
    app.qtbot.keyClick(box, Qt.Key_Return)
    assert box.value() == 0.05
    assert np.array_equal(lut.edited, gamma_table(shape_of(app.grabber), 0.05))


def choose(app, word):
    box = app.program.feature_controls.lut.dialog.question
    app.qtbot.mouseClick(next(each for each in box.buttons() if word in each.text()), Qt.LeftButton)
    app.until(
        lambda: (
            app.program.feature_controls.lut.dialog is None
            or app.program.feature_controls.lut.dialog.question is None
        )
    )


def test_edits_are_not_lost_without_a_question(app):
    lut, dialog = app.program.feature_controls.lut, app.program.feature_controls.lut.dialog
    dialog.gammaBox.setValue(0.5)
    app.qtbot.keyClick(dialog, Qt.Key_Escape)
    choose(app, "Cancel")
    dialog.close()
    assert lut.dialog is dialog and dialog.isVisible()
    choose(app, "Discard")
    assert lut.dialog is None


def test_edits_in_a_file_can_be_left(app, tmp_path, monkeypatch):
    lut, dialog = app.program.feature_controls.lut, app.program.feature_controls.lut.dialog
    monkeypatch.setattr(app.program.files, "to_save", lambda *_: tmp_path / "lut.csv")
    dialog.gammaBox.setValue(0.5)
    dialog.saveButton.click()
    dialog.closeButton.click()
    assert lut.dialog is None


def test_another_table_is_not_read_over_edits_without_a_question(app, finish):
    dialog = app.program.feature_controls.lut.dialog
    asked = []
    dialog.selectorChosen.connect(asked.append)
    dialog.setSelectors(("Luminance", "Green"))
    dialog.gammaBox.setValue(0.5)
    dialog.selectorBox.setCurrentText("Green")
    choose(app, "Cancel")
    assert dialog.selectorBox.currentText() == "Luminance" and not asked
    dialog.selectorBox.setCurrentText("Green")
    choose(app, "Discard")
    assert dialog.selectorBox.currentText() == "Green" and asked == ["Green"]


def test_edits_whose_write_failed_are_not_lost(app, monkeypatch):
    lut, dialog = app.program.feature_controls.lut, app.program.feature_controls.lut.dialog
    dialog.gammaBox.setValue(0.5)
    monkeypatch.setattr("grabbergui.ui.controllers.lut.write_table", refuse)
    dialog.writeButton.click()
    app.until(lambda: any("reads back" in text for text in app.errors))
    dialog.close()
    assert lut.dialog is dialog
    choose(app, "Discard")


def refuse(*_, **__):
    raise CameraFileError("it reads back differently", "LUTValueAll", "Read")


def test_axes_and_curves_are_named(app):
    dialog = app.program.feature_controls.lut.dialog
    assert dialog.plot.getAxis("bottom").labelString().count("Input (LUTIndex)") == 1
    assert dialog.plot.getAxis("left").labelString().count("Output (LUTValue)") == 1
    assert "x1" not in dialog.plot.getAxis("left").labelString(), "values are not scaled by a power of ten"
    assert "in the camera" in dialog.legendLabel.text() and "edited" in dialog.legendLabel.text()


def test_its_use_is_switched_as_a_step_to_undo(app):
    dialog, camera = app.program.feature_controls.lut.dialog, app.grabber
    dialog.enableBox.click()
    app.until(lambda: camera.feature("LUTEnable").value is True)
    app.until(app.window.actionUndo.isEnabled)
    app.window.actionUndo.trigger()
    app.until(lambda: camera.feature("LUTEnable").value is False)


def test_a_table_is_saved_and_loaded(app, tmp_path, monkeypatch):
    lut, dialog = app.program.feature_controls.lut, app.program.feature_controls.lut.dialog
    path = tmp_path / "lut.csv"
    monkeypatch.setattr(app.program.files, "to_save", lambda *_: path)
    monkeypatch.setattr(app.program.files, "to_open", lambda *_: path)
    dialog.gammaBox.setValue(2.0)
    curve = lut.edited
    dialog.saveButton.click()
    assert np.array_equal(load_table(path, shape_of(app.grabber)), curve)
    dialog.linearButton.click()
    assert lut.edited[2048] != curve[2048] and dialog.gammaBox.value() == 1.0
    dialog.loadButton.click()
    assert np.array_equal(lut.edited, curve)
    path.write_text("1,2,3")
    dialog.loadButton.click()
    app.until(lambda: any("has 3 values" in text for text in app.errors))
    assert np.array_equal(lut.edited, curve)


def test_a_table_that_cannot_be_saved_is_reported_in_the_words_of_every_file(app, tmp_path, monkeypatch):
    path = tmp_path / "no" / "lut.csv"
    monkeypatch.setattr(app.program.files, "to_save", lambda *_: path)
    app.program.feature_controls.lut.dialog.saveButton.click()
    app.until(lambda: f"{path} could not be written: No such file or directory" in app.errors)


def test_a_window_that_is_closed_while_the_camera_is_written_stays_closed(app):
    lut, dialog = app.program.feature_controls.lut, app.program.feature_controls.lut.dialog
    dialog.gammaBox.setValue(0.5)
    dialog.writeButton.click()
    dialog.close()
    app.until(lambda: any("has the new look-up table" in text for text in app.errors))
    assert lut.dialog is None


def test_what_is_edited_survives_the_menus_entry(app):
    lut, dialog = app.program.feature_controls.lut, app.program.feature_controls.lut.dialog
    dialog.gammaBox.setValue(0.5)
    curve = lut.edited
    reads = []
    app.program.feature_controls.work.run = lambda title, *_, **__: reads.append(title)
    app.window.actionLookUpTable.trigger()
    assert lut.dialog is dialog and lut.edited is curve and not reads


def test_the_window_closes_with_its_camera(app):
    app.connect("sim:colour?width=160&height=120")
    app.until(lambda: app.program.feature_controls.lut.dialog is None)


@pytest.fixture
def finish(app, monkeypatch):
    """Collect the work that the dialog asks for; `finish(table)` ends the oldest with the camera's table."""
    asked = []
    monkeypatch.setattr(
        app.program.feature_controls.work, "run", lambda _, __, done, **___: asked.append(done)
    )
    present = app.program.feature_controls.lut._present
    return lambda table, **changes: asked.pop(0)(replace(present, table=table, **changes))


def test_edits_made_while_the_camera_is_written_stay(app, finish):
    lut, dialog = app.program.feature_controls.lut, app.program.feature_controls.lut.dialog
    dialog.gammaBox.setValue(0.5)
    written = lut.edited
    dialog.writeButton.click()
    dialog.gammaBox.setValue(2.0)
    edited = lut.edited
    finish(written)
    assert lut.edited is edited
    assert dialog.undoButton.isEnabled() and dialog.writeButton.isEnabled()


def test_the_undo_of_one_table_is_not_offered_for_another(app, finish):
    lut, dialog = app.program.feature_controls.lut, app.program.feature_controls.lut.dialog
    dialog.gammaBox.setValue(0.5)
    dialog.writeButton.click()
    dialog.selectorChosen.emit("Green")
    finish(lut.edited)
    finish(np.arange(4096), selector="Green")
    assert not dialog.undoButton.isEnabled()


def test_a_second_request_for_the_window_does_not_discard_what_was_edited(app, finish):
    lut, action = app.program.feature_controls.lut, app.window.actionLookUpTable
    lut.dialog.close()
    action.trigger()
    action.trigger()
    finish(np.arange(4096))
    lut.dialog.gammaBox.setValue(0.5)
    edited = lut.edited
    finish(np.arange(4096))
    assert lut.edited is edited
