"""The files of the camera in the window: downloaded, uploaded, deleted, refused."""

import pytest

from grabbergui.core.file_access import list_files, read_file


@pytest.fixture
def app(make_app):
    app = make_app()
    app.connect("sim:?width=160&height=120&fps=20")
    app.until(app.window.actionCameraFiles.isEnabled)
    app.window.actionCameraFiles.trigger()
    app.until(lambda: app.program.feature_controls.camera_files.dialog.chosen is not None)
    return app


def choose(dialog, name):
    for row in range(dialog.table.topLevelItemCount()):
        if (item := dialog.table.topLevelItem(row)).text(0) == name:
            dialog.table.setCurrentItem(item)
    assert dialog.chosen.name == name


def answered(app, monkeypatch, path):
    """Let the dialogs of files answer with this path."""
    files = app.program.feature_controls.camera_files._files
    monkeypatch.setattr(files, "to_open", lambda *_: path)
    monkeypatch.setattr(files, "to_save", lambda *_: path)


def agree(dialog, text):
    (button,) = (each for each in dialog.question.buttons() if text in each.text())
    button.click()


def test_a_file_is_downloaded_uploaded_and_deleted(app, monkeypatch, tmp_path):
    dialog, camera = app.program.feature_controls.camera_files.dialog, app.grabber
    path = tmp_path / "table.bin"
    answered(app, monkeypatch, path)
    choose(dialog, "LUTLuminance")
    dialog.downloadButton.click()
    app.until(lambda: "saved as" in dialog.outcomeLabel.text())
    table = path.read_bytes()
    assert table == read_file(camera, "LUTLuminance") and len(table) == 8192

    other = bytes(reversed(table))
    path.write_bytes(other)
    dialog.uploadButton.click()
    app.until(lambda: dialog.question is not None)
    agree(dialog, "Replace")
    app.until(lambda: "read back" in dialog.outcomeLabel.text())
    assert read_file(camera, "LUTLuminance") == other
    app.until(dialog.deleteButton.isEnabled)

    dialog.deleteButton.click()
    agree(dialog, "Delete")
    app.until(lambda: "is deleted" in dialog.outcomeLabel.text())
    (size,) = (file.size for file in list_files(camera) if file.name == "LUTLuminance")
    assert size == 0
    app.until(lambda: dialog.chosen.size == 0)
    dialog.closeButton.click()
    assert app.program.feature_controls.camera_files.dialog is None


def test_a_refusal_is_shown_and_the_next_transfer_is_possible(app, monkeypatch, tmp_path):
    dialog = app.program.feature_controls.camera_files.dialog
    answered(app, monkeypatch, tmp_path / "missing.bin")
    choose(dialog, "LUTLuminance")
    dialog.uploadButton.click()
    app.until(lambda: dialog.question is not None)
    agree(dialog, "Replace")
    app.until(lambda: "missing.bin" in dialog.outcomeLabel.text())
    assert dialog.outcomeLabel.property("problem") is True
    app.until(dialog.uploadButton.isEnabled)


def test_the_dialog_closes_with_its_camera(app):
    controls = app.program.feature_controls
    app.program.open_sources.close_current()
    app.until(lambda: controls.camera_files.dialog is None)
    app.until(lambda: not app.window.actionCameraFiles.isEnabled())
    assert "No source is open" in app.window.actionCameraFiles.toolTip()
