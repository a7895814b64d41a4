"""Settings and recordings in the window, as a person would use them."""

import threading
import time
from contextlib import ExitStack

import cv2
import pytest
from PyQt5.QtCore import QMimeData, QPoint, Qt, QUrl
from PyQt5.QtGui import QDragEnterEvent, QDropEvent
from PyQt5.QtWidgets import QApplication, QMessageBox

from grabbergui import sources
from grabbergui.core.settings import SettingKey
from grabbergui.models.open_source import LinkState
from grabbergui.models.settings import files
from grabbergui.models.settings.feature_set import FeatureSet
from grabbergui.recording.kinds import RecordingKind
from lost_camera import away
from patience import PATIENCE


@pytest.fixture
def app(make_app):
    app = make_app()
    app.connect("sim:?width=320&height=240&fps=15")
    return app


def rows(report):
    table = report.table
    items = [table.topLevelItem(index) for index in range(table.topLevelItemCount())]
    return {item.text(0): item.text(4) for item in items if not item.isHidden()}


def test_settings_are_saved_changed_loaded_and_rolled_back(app, tmp_path):
    keeping, path = app.program.feature_controls.settings_files, tmp_path / "settings.yaml"
    keeping.save(path)
    app.until(path.exists)
    app.grabber.write_feature("Gain", 6)
    keeping.load(path)
    app.until(lambda: keeping.report)
    assert rows(keeping.report) == {"Gain": "written"}
    table = keeping.report.table
    headers = [table.headerItem().text(column) for column in range(1, 4)]
    gain = next(table.topLevelItem(row) for row in range(table.topLevelItemCount())
                if table.topLevelItem(row).text(0) == "Gain")  # fmt: skip
    assert headers == ["Before", "File", "Now"] and not table.isColumnHidden(3)
    assert [gain.text(column) for column in range(1, 4)] == ["6 dB", "0 dB", "0 dB"]
    assert app.grabber.feature("Gain").value == 0
    keeping.report.equalBox.click()
    assert "equal" in rows(keeping.report).values()
    app.qtbot.mouseClick(keeping.report.rollBackButton, Qt.LeftButton)
    app.until(lambda: app.grabber.feature("Gain").value == 6)
    app.until(lambda: keeping.report is None)


@pytest.fixture
def switch_while_it_works(app):
    """Begin something with the first camera, make a second one current, and let the first one go on."""
    link, first = app.program.opener, app.program.open_sources.current
    link.open_additional("sim:colour?width=320&height=240")
    app.until(
        lambda: len(link.open_sources.all) == 2 and link.open_sources.all[1].state is LinkState.STREAMING
    )
    second = link.open_sources.all[1]

    def switch(begin):
        gate = threading.Event()
        first.worker.submit(lambda: gate.wait(PATIENCE))
        begin()
        link.open_sources.make_current(second)
        app.until(lambda: app.program.open_sources.current is second)
        gate.set()
        return first, second

    return switch


def test_what_was_loaded_onto_one_camera_is_not_rolled_back_on_another(app, tmp_path, switch_while_it_works):
    keeping, path = app.program.feature_controls.settings_files, tmp_path / "settings.yaml"
    files.save(FeatureSet({SettingKey("Gain"): 3.0}), path)
    app.grabber.write_feature("Gain", 6.0)
    first, second = switch_while_it_works(lambda: keeping.load(path))
    app.until(lambda: keeping.report)
    assert first.grabber.feature("Gain").value == 3.0
    second.grabber.write_feature("Gain", 1.0)
    app.qtbot.mouseClick(keeping.report.rollBackButton, Qt.LeftButton)
    app.until(lambda: first.grabber.feature("Gain").value == 6.0)
    assert second.grabber.feature("Gain").value == 1.0


def test_a_failure_is_reported_of_the_camera_that_it_happened_to(app, tmp_path, switch_while_it_works):
    path = tmp_path / "settings.yaml"
    path.write_text("nonsense: [")
    first, second = switch_while_it_works(lambda: app.program.feature_controls.settings_files.load(path))
    shown = app.program.messages.shown
    app.until(lambda: any(path.name in message.text for message in shown(first)))
    assert not shown(second)


def test_what_was_compared_with_one_camera_is_not_written_to_another(app, tmp_path, switch_while_it_works):
    keeping, path = app.program.feature_controls.settings_files, tmp_path / "settings.yaml"
    files.save(FeatureSet({SettingKey("Gain"): 3.0}), path)
    first, second = switch_while_it_works(lambda: keeping.compare(path))
    app.until(lambda: keeping.report)
    app.qtbot.mouseClick(keeping.report.applyButton, Qt.LeftButton)
    app.until(lambda: first.grabber.feature("Gain").value == 3.0)
    assert second.grabber.feature("Gain").value == 0.0


@pytest.mark.parametrize("action", ["actionLookUpTable", "actionUserSets"])
def test_tables_and_sets_of_a_camera_that_is_no_longer_current_are_not_shown(
    app, action, switch_while_it_works
):
    entry = getattr(app.window, action)
    app.until(entry.isEnabled)
    switch_while_it_works(entry.trigger)
    app.until(lambda: not app.program.feature_controls.work._tasks.rows)
    assert (
        app.program.feature_controls.lut.dialog is None
        and app.program.feature_controls.user_sets.dialog is None
    )


def test_loading_waits_for_the_last_write_of_a_slider(app, tmp_path):
    keeping, path = app.program.feature_controls.settings_files, tmp_path / "settings.yaml"
    files.save(FeatureSet({SettingKey("Gain"): 3.0}), path)
    features = app.program.open_sources.current.features
    features._throttle.interval = 0.5  # so that loading would have all the time to come first
    features.write("Gain", 6.0)
    app.until(lambda: app.grabber.feature("Gain").value == 6)
    features.write("Gain", 12.0)
    keeping.load(path)
    app.until(lambda: keeping.report)
    assert rows(keeping.report) == {"Gain": "written"}
    assert keeping.report.table.topLevelItem(0).text(1) == "12 dB"
    assert not features._throttle.waiting()
    assert app.grabber.feature("Gain").value == 3


def test_comparing_changes_nothing_until_applied(app, tmp_path):
    keeping, path = app.program.feature_controls.settings_files, tmp_path / "settings.pfs"
    files.save(FeatureSet({SettingKey("Gain"): 3.0}), path)
    keeping.compare(path)
    app.until(lambda: keeping.report)
    assert rows(keeping.report) == {"Gain": "would be written"}
    assert app.grabber.feature("Gain").value == 0
    app.qtbot.mouseClick(keeping.report.applyButton, Qt.LeftButton)
    app.until(lambda: app.grabber.feature("Gain").value == 3)
    app.until(lambda: keeping.report and keeping.report.rollBackButton.isVisible())


def test_settings_that_the_program_was_started_with_are_compared_once(make_app, tmp_path):
    app = make_app()
    path = tmp_path / "settings.yaml"
    files.save(FeatureSet({SettingKey("Gain"): 3.0}), path)
    keeping = app.program.feature_controls.settings_files
    app.program.compare_once_open(path)
    app.connect("sim:?width=320&height=240&fps=15")
    app.until(lambda: keeping.report)
    assert rows(keeping.report) == {"Gain": "would be written"}
    assert app.grabber.feature("Gain").value == 0
    keeping.report.close()
    app.connect("sim:colour?width=320&height=240&fps=15")
    assert keeping.report is None


def test_the_file_of_settings_is_proposed_by_the_camera_s_name(app, monkeypatch):
    proposed = []
    monkeypatch.setattr(app.program.files, "to_save", lambda _, name, kinds: proposed.append(name))
    app.connect()
    app.window.actionSaveSettings.trigger()
    assert proposed == ["Simulated-camera_SIM001.yaml"]


def test_a_file_of_settings_is_dropped_onto_the_window(app, tmp_path):
    path = tmp_path / "settings.yaml"
    files.save(FeatureSet({SettingKey("ExposureTime"): 1234.0}), path)
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path))])
    where = (QPoint(5, 5), Qt.CopyAction, data, Qt.LeftButton, Qt.NoModifier)
    entering = QDragEnterEvent(*where)
    QApplication.sendEvent(app.window, entering)
    assert entering.isAccepted()
    QApplication.sendEvent(app.window, QDropEvent(*where))
    app.until(lambda: app.grabber.feature("ExposureTime").value == pytest.approx(1234, rel=1e-2))


def test_a_file_without_settings_is_reported(app, tmp_path):
    (tmp_path / "diary.txt").write_text("dear diary\n")
    app.program.feature_controls.settings_files.load(tmp_path / "diary.txt")
    app.until(lambda: any("diary.txt" in text for text in app.errors))
    assert app.program.feature_controls.settings_files.report is None
    assert not app.window.actionUndo.isEnabled()


def test_a_recording_is_made_and_played_back(app, monkeypatch):
    monkeypatch.setitem(sources.MODULES, "file", "grabbergui.recording.playback")
    bar = app.window.recordingBar
    bar.kindBox.setCurrentIndex(bar.kindBox.findData(RecordingKind.MCAP))
    app.qtbot.mouseClick(bar.recordButton, Qt.LeftButton)
    app.until(lambda: "frames" in bar.progressLabel.text() and bar.recordButton.isChecked())
    app.qtbot.mouseClick(bar.recordButton, Qt.LeftButton)
    app.until(bar.playButton.isVisible)
    assert not bar.recordButton.isChecked()
    camera = app.program.open_sources.current
    app.qtbot.mouseClick(bar.playButton, Qt.LeftButton)
    app.until(lambda: str(app.program.open_sources.current.uri).startswith("file:"))
    app.watch()
    played = app.program.open_sources.current
    assert app.grabber.feature("PlaybackFrameCount").value >= 1
    app.program.open_sources.close_current()
    app.until(lambda: app.program.open_sources.current not in (played, None))
    assert app.program.open_sources.all == (camera,) == (app.program.open_sources.current,)
    assert camera.state is LinkState.STREAMING, "it was never closed"


def test_a_recording_ends_with_its_camera(app):
    bar = app.window.recordingBar
    bar.recordButton.click()
    app.until(bar.recordButton.isChecked)
    app.program.open_sources.close_current()
    app.until(lambda: not bar.recordButton.isChecked())
    assert not bar.recordButton.isEnabled()


def test_closing_the_window_does_not_cut_a_recording_off(app, monkeypatch):
    finish = threading.Event()
    from grabbergui.recording.movie_writer import MovieWriter

    close = MovieWriter.close
    monkeypatch.setattr(MovieWriter, "close", lambda writer: finish.wait(PATIENCE) and close(writer))
    bar = app.window.recordingBar
    bar.kindBox.setCurrentIndex(bar.kindBox.findData(RecordingKind.H264))
    bar.recordButton.click()
    app.until(lambda: "frames" in bar.progressLabel.text())
    folder = app.program.preferences.snapshot_folder
    app.until(lambda: list(folder.glob("*.mp4")))  # the encoder makes it on a thread of its own
    (movie,) = folder.glob("*.mp4")

    app.window.close()  # waits a moment, not for ever
    assert "a recording" in app.program.shut_down(0)
    finish.set()

    assert app.program.shut_down(PATIENCE) == []
    assert cv2.VideoCapture(str(movie)).read()[0]


def test_a_snapshot_folder_that_cannot_be_made_is_named(app, tmp_path):
    occupied = tmp_path / "file"
    occupied.touch()
    app.program.preferences.snapshot_folder = occupied / "snapshots"
    app.window.actionOpenSnapshotFolder.trigger()
    (message,) = app.program.messages.shown(None)
    assert message.text == f"{occupied / 'snapshots'} could not be opened: Not a directory"


def test_a_window_that_is_closed_is_gone_before_anything_is_waited_for(app):
    seen = []
    stop = app.program.source_controls.source_list.stop

    def notice(timeout):
        seen.append(app.window.isVisible())
        return stop(timeout)

    app.program.source_controls.source_list.stop = notice
    app.window.close()
    assert seen and not any(seen)


def tick(table, name, ticked):
    (item,) = table.findItems(name, Qt.MatchExactly, 0)
    item.setCheckState(0, Qt.Checked if ticked else Qt.Unchecked)


def test_of_a_comparison_only_what_is_ticked_is_applied(app, tmp_path):
    keeping, path = app.program.feature_controls.settings_files, tmp_path / "settings.yaml"
    files.save(FeatureSet({SettingKey("Gain"): 3.0, SettingKey("Gamma"): 2.0}), path)
    keeping.compare(path)
    app.until(lambda: keeping.report)
    tick(keeping.report.table, "Gamma", False)
    app.qtbot.mouseClick(keeping.report.applyButton, Qt.LeftButton)
    app.until(lambda: app.grabber.feature("Gain").value == 3)
    app.until(lambda: keeping.report and keeping.report.rollBackButton.isVisible())
    assert app.grabber.feature("Gamma").value == 1
    assert rows(keeping.report) == {"Gain": "written"}


def test_loading_is_one_step_to_undo(app, tmp_path):
    keeping, path = app.program.feature_controls.settings_files, tmp_path / "settings.yaml"
    files.save(FeatureSet({SettingKey("Gain"): 3.0, SettingKey("Gamma"): 2.0}), path)
    keeping.load(path)
    app.until(lambda: keeping.report)
    keeping.report.close()
    app.until(lambda: app.window.actionUndo.text() == "&Undo Loaded settings.yaml")
    app.window.actionUndo.trigger()
    app.until(lambda: app.grabber.feature("Gain").value == 0 and app.grabber.feature("Gamma").value == 1)


def test_loading_that_a_loss_breaks_off_lists_what_was_written_and_what_was_not(app, tmp_path, monkeypatch):
    keeping, path, camera = (
        app.program.feature_controls.settings_files,
        tmp_path / "settings.yaml",
        app.grabber,
    )
    files.save(FeatureSet({SettingKey("Gain"): 3.0, SettingKey("Gamma"): 2.0}), path)
    write = camera.write_setting
    with ExitStack() as loss:

        def written_last(key, value):
            result = write(key, value)
            loss.enter_context(away(camera, "the cable is out"))
            return result

        monkeypatch.setattr(camera, "write_setting", written_last)
        keeping.load(path)
        app.until(lambda: keeping.report)
        assert rows(keeping.report) == {"Gain": "written", "Gamma": "not written"}
        headline = keeping.report.headline.text()
        assert "Written: 1, not written: 1. Interrupted: " in headline
        assert "are restored when the camera is back" in headline
    app.until(lambda: not camera.lost)
    assert camera.feature("Gain").value == 3.0 and camera.streaming


def test_loading_shows_how_far_it_is_and_can_be_cancelled(app, tmp_path, monkeypatch):
    keeping, path = app.program.feature_controls.settings_files, tmp_path / "settings.yaml"
    files.save(FeatureSet({SettingKey("Gain"): 3.0}), path)
    read, slow = app.grabber.feature, threading.Event()

    def slowly(name):
        if not slow.is_set():
            slow.wait(0.01)
        return read(name)

    monkeypatch.setattr(app.grabber, "feature", slowly)
    keeping.load(path)
    app.until(lambda: app.window.image.tasks.rows)
    row = app.window.image.tasks.rows[0]
    assert (row.titleLabel.text(), row.textLabel.text()) == ("Loading settings", "settings.yaml")
    app.until(lambda: row.bar.value() > 0)
    app.qtbot.mouseClick(row.cancelButton, Qt.LeftButton)
    app.until(lambda: keeping.report)
    slow.set()
    assert rows(keeping.report) == {"Gain": "cancelled"}
    assert read("Gain").value == 0
    assert not app.window.image.tasks.isVisible()


def test_closing_the_camera_ends_work_in_progress(app, tmp_path, monkeypatch):
    read = app.grabber.feature

    def slowly(name):
        time.sleep(0.01)
        return read(name)

    monkeypatch.setattr(app.grabber, "feature", slowly)
    app.program.feature_controls.settings_files.save(tmp_path / "settings.yaml")
    app.until(lambda: app.window.image.tasks.rows and app.window.image.tasks.rows[0].bar.value() > 0)
    app.program.open_sources.close_current()
    app.until(lambda: not app.window.image.tasks.rows)
    assert not (tmp_path / "settings.yaml").exists()


def test_saving_that_is_cancelled_leaves_no_file(app, tmp_path, monkeypatch):
    path = tmp_path / "settings.yaml"
    read = app.grabber.feature

    cancelled = threading.Event()

    def slowly(name):
        assert cancelled.wait(PATIENCE)
        return read(name)

    monkeypatch.setattr(app.grabber, "feature", slowly)
    app.program.feature_controls.settings_files.save(path)
    app.until(lambda: app.window.image.tasks.rows)
    app.window.image.tasks.rows[0].cancelButton.click()
    cancelled.set()
    app.until(lambda: not app.window.image.tasks.rows)
    assert not path.exists()


def test_two_files_are_compared_and_the_difference_is_applied(app, tmp_path):
    keeping = app.program.feature_controls.settings_files
    first, second = tmp_path / "day.yaml", tmp_path / "night.pfs"
    for path, gain, gamma in ((first, 3.0, 2.0), (second, 9.0, 1.5)):
        values = {SettingKey("Gain"): gain, SettingKey("Gamma"): gamma, SettingKey("Width"): 320}
        files.save(FeatureSet(values), path)
    keeping.compare_files(first, second)
    app.until(lambda: keeping.difference)
    dialog = keeping.difference
    table = dialog.table
    items = [table.topLevelItem(index) for index in range(table.topLevelItemCount())]
    assert [[item.text(column) for column in range(3)] for item in items] == [
        ["Gain", "3", "9"], ["Gamma", "2", "1.5"],
    ]  # fmt: skip
    assert dialog.secondButton.text() == "Set as in night.pfs"
    tick(table, "Gamma", False)
    app.qtbot.mouseClick(dialog.secondButton, Qt.LeftButton)
    app.until(lambda: app.grabber.feature("Gain").value == 9)
    app.until(lambda: keeping.report)
    assert app.grabber.feature("Gamma").value == 1
    assert keeping.difference is None
    keeping.compare_files(first, tmp_path / "nothing.yaml")
    app.until(lambda: any("nothing.yaml" in text for text in app.errors))


def test_files_are_not_read_in_the_gui_thread(app, tmp_path, monkeypatch):
    """Reading 64,000 lines there took five seconds."""
    threads, load = [], files.load
    monkeypatch.setattr(
        files, "load", lambda *given: threads.append(threading.current_thread()) or load(*given)
    )
    path = tmp_path / "a.yaml"
    files.save(FeatureSet({SettingKey("Gain"): 1.0}), path)
    app.program.feature_controls.settings_files.compare_files(path, path)
    app.until(lambda: app.program.feature_controls.settings_files.difference)
    assert len(threads) == 2 and threading.main_thread() not in threads
    app.program.feature_controls.settings_files.difference.close()


def test_without_a_camera_files_are_compared_all_the_same(make_app, tmp_path):
    app = make_app()
    paths = [tmp_path / "a.yaml", tmp_path / "b.yaml"]
    for path in paths:
        files.save(FeatureSet({SettingKey("Gain"): 1.0}), path)
    app.program.feature_controls.settings_files.compare_files(*paths)
    app.until(lambda: app.program.feature_controls.settings_files.difference)
    dialog = app.program.feature_controls.settings_files.difference
    assert "no difference" in dialog.headline.text()
    assert not dialog.firstButton.isVisible()
    dialog.close()
    app.program.feature_controls.settings_files.load(paths[0])
    assert any("connect to one first" in text for text in app.errors)


def sets_dialog(app):
    app.until(app.window.actionUserSets.isEnabled)
    app.window.actionUserSets.trigger()
    app.until(lambda: app.program.feature_controls.user_sets.dialog)
    return app.program.feature_controls.user_sets.dialog


def choose(app, dialog, name):
    (item,) = dialog.setList.findItems(name, Qt.MatchStartsWith)
    where = dialog.setList.visualItemRect(item).center()
    app.qtbot.mouseClick(dialog.setList.viewport(), Qt.LeftButton, pos=where)
    assert dialog.chosen.name == name


def test_settings_are_kept_in_the_camera_and_come_back(app):
    app.grabber.write_feature("Gain", 6.0)
    dialog = sets_dialog(app)
    assert not dialog.saveButton.isEnabled(), "the factory's set is selected at first"
    choose(app, dialog, "UserSet1")
    app.qtbot.mouseClick(dialog.saveButton, Qt.LeftButton)
    app.until(lambda: dialog.question is not None and dialog.question.isVisible())
    assert dialog.question.defaultButton() is dialog.question.button(QMessageBox.Cancel)
    app.qtbot.mouseClick(dialog.question.button(QMessageBox.Cancel), Qt.LeftButton)
    app.until(lambda: dialog.question is None)
    assert not any("in the camera as" in text for text in app.errors), "nothing was saved"
    app.qtbot.mouseClick(dialog.saveButton, Qt.LeftButton)
    (overwrite,) = [b for b in dialog.question.buttons() if b.text() == "Overwrite"]
    app.qtbot.mouseClick(overwrite, Qt.LeftButton)
    app.until(lambda: any("in the camera as UserSet1" in text for text in app.errors))
    app.qtbot.mouseClick(dialog.startButton, Qt.LeftButton)
    app.until(lambda: app.grabber.feature("UserSetDefault").value == "UserSet1")
    app.until(lambda: "starts with it" in dialog.setList.item(1).text())
    app.grabber.write_feature("Gain", 12.0)
    choose(app, dialog, "UserSet1")
    app.qtbot.mouseClick(dialog.loadButton, Qt.LeftButton)
    app.until(lambda: app.grabber.feature("Gain").value == 6)
    app.until(lambda: any("changed 1 setting" in text for text in app.errors))
    assert app.grabber.streaming
    app.until(lambda: app.window.actionUndo.text() == "&Undo UserSetLoad UserSet1")
    app.window.actionUndo.trigger()
    app.until(lambda: app.grabber.feature("Gain").value == 12)
    assert app.program.feature_controls.user_sets.dialog is None


def test_the_dialog_goes_with_its_camera(app):
    dialog = sets_dialog(app)
    assert dialog.isVisible()
    app.program.open_sources.close_current()
    app.until(lambda: app.program.feature_controls.user_sets.dialog is None)
    assert not app.window.actionUserSets.isEnabled()


def test_invalid_lines_of_files_that_are_compared_are_listed(make_app, tmp_path):
    """A damaged file counted as equal to a whole one, without a word."""
    app = make_app()
    whole, damaged = tmp_path / "a.yaml", tmp_path / "b.yaml"
    whole.write_text("features:\n  Gain: 1.0\n")
    damaged.write_text("features:\n  Gain: 1.0\n  Gamma: [1\n")
    app.program.feature_controls.settings_files.compare_files(whole, damaged)
    app.until(lambda: app.program.feature_controls.settings_files.difference)
    dialog = app.program.feature_controls.settings_files.difference
    rows = [dialog.table.topLevelItem(row).text(0) for row in range(dialog.table.topLevelItemCount())]
    assert [row.startswith(f"{damaged}, line 3: ") for row in rows] == [True]
    assert dialog.checked() == []
    dialog.close()
