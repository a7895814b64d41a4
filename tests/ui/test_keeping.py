"""Settings and recordings in the window, as a person would use them."""

import pytest
from PyQt5.QtCore import QMimeData, QPoint, Qt, QUrl
from PyQt5.QtGui import QDragEnterEvent, QDropEvent
from PyQt5.QtWidgets import QApplication

from grabbergui import sources
from grabbergui.models import feature_set_files
from grabbergui.models.feature_set import FeatureSet, SettingKey
from grabbergui.models.recording_writers import RecordingKind


@pytest.fixture
def desk(window_desk):
    window_desk.connect("sim:?width=320&height=240&fps=60")
    return window_desk


def rows(report):
    table = report.table
    items = [table.topLevelItem(index) for index in range(table.topLevelItemCount())]
    return {item.text(0): item.text(3) for item in items if not item.isHidden()}


def test_settings_are_saved_changed_loaded_and_rolled_back(desk, tmp_path):
    keeping, path = desk.program.keeping, tmp_path / "settings.yaml"
    keeping.save(path)
    desk.until(path.exists)
    desk.grabber.write_feature("Gain", 6)
    keeping.load(path)
    desk.until(lambda: keeping.report)
    assert rows(keeping.report) == {"Gain": "written"}
    assert desk.grabber.feature("Gain").value == 0
    keeping.report.equalBox.click()
    assert "equal" in rows(keeping.report).values()
    desk.qtbot.mouseClick(keeping.report.rollBackButton, Qt.LeftButton)
    desk.until(lambda: desk.grabber.feature("Gain").value == 6)
    desk.until(lambda: keeping.report is None)


def test_comparing_changes_nothing_until_applied(desk, tmp_path):
    keeping, path = desk.program.keeping, tmp_path / "settings.pfs"
    feature_set_files.save(FeatureSet({SettingKey("Gain"): 3.0}), path)
    keeping.compare(path)
    desk.until(lambda: keeping.report)
    assert rows(keeping.report) == {"Gain": "would write"}
    assert desk.grabber.feature("Gain").value == 0
    desk.qtbot.mouseClick(keeping.report.applyButton, Qt.LeftButton)
    desk.until(lambda: desk.grabber.feature("Gain").value == 3)
    desk.until(lambda: keeping.report and keeping.report.rollBackButton.isVisible())


def test_a_file_of_settings_is_dropped_onto_the_window(desk, tmp_path):
    path = tmp_path / "settings.yaml"
    feature_set_files.save(FeatureSet({SettingKey("ExposureTime"): 1234.0}), path)
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path))])
    where = (QPoint(5, 5), Qt.CopyAction, data, Qt.LeftButton, Qt.NoModifier)
    entering = QDragEnterEvent(*where)
    QApplication.sendEvent(desk.window, entering)
    assert entering.isAccepted()
    QApplication.sendEvent(desk.window, QDropEvent(*where))
    desk.until(lambda: desk.grabber.feature("ExposureTime").value == pytest.approx(1234, rel=1e-2))


def test_what_is_no_file_of_settings_is_said(desk, tmp_path):
    (tmp_path / "diary.txt").write_text("dear diary\n")
    desk.program.keeping.load(tmp_path / "diary.txt")
    desk.until(lambda: any("diary.txt" in text for text in desk.errors))


def test_a_recording_is_made_and_played_back(desk, monkeypatch):
    monkeypatch.setitem(sources._KINDS, "file", "grabbergui.driver.playback.source")
    bar = desk.window.recordingBar
    bar.kindBox.setCurrentIndex(bar.kindBox.findData(RecordingKind.MCAP))
    desk.qtbot.mouseClick(bar.recordButton, Qt.LeftButton)
    desk.until(lambda: "frames" in bar.progressLabel.text() and bar.recordButton.isChecked())
    desk.qtbot.mouseClick(bar.recordButton, Qt.LeftButton)
    desk.until(bar.playButton.isVisible)
    assert not bar.recordButton.isChecked()
    desk.qtbot.mouseClick(bar.playButton, Qt.LeftButton)
    desk.until(lambda: str(desk.program.connection.source.uri).startswith("file:"))
    desk.watch()
    assert desk.grabber.feature("PlaybackFrameCount").value >= 1


def test_a_recording_ends_with_its_camera(desk):
    bar = desk.window.recordingBar
    bar.recordButton.click()
    desk.until(bar.recordButton.isChecked)
    desk.program.connection.disconnect()
    desk.until(lambda: not bar.recordButton.isChecked())
    assert not bar.recordButton.isEnabled()
