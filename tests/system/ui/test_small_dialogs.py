"""The data of the shown frame, and the IP address of a camera in the list."""

from dataclasses import replace

import pytest
from PyQt5.QtWidgets import QApplication

from grabbergui.core.identity import DeviceInfo
from grabbergui.driver.gige import address_commands
from grabbergui.recording.snapshot import SnapshotKind
from patience import PATIENCE

CAMERA = DeviceInfo(
    "gige:GV01", model="One", bus="GigE Vision", address="10.0.0.7", hardware_id="00:30:53:0a:0b:0c",
    note="its address 10.0.0.7 is in another subnet than eth0",
)  # fmt: skip


def shown(dialog):
    items = [dialog.table.topLevelItem(row) for row in range(dialog.table.topLevelItemCount())]
    return {item.text(0): item.text(1) for item in items}


def test_the_data_of_the_shown_frame_is_followed_until_the_image_is_paused(make_app):
    app = make_app()
    app.connect("sim:?width=64&height=48&fps=30")
    app.watch()
    app.window.actionFrameData.trigger()
    dialog = app.program.image_controls.frame_data.dialog
    first = shown(dialog)
    assert first["Size"] == "64 × 48" and dialog.hintLabel.isVisible()
    app.until(lambda: shown(dialog)["Frame id"] != first["Frame id"])
    app.window.actionPause.trigger()
    app.until(app.window.image.pauseBar.isVisible)
    paused = str(app.program.image.frame.frame_id)
    app.until(lambda: shown(dialog)["Frame id"] == paused)
    frames = app.grabber.statistics().frames
    app.until(lambda: app.grabber.statistics().frames > frames + 10)
    assert shown(dialog)["Frame id"] == paused
    dialog.copyButton.click()
    assert f"Frame id\t{paused}" in QApplication.clipboard().text()
    dialog.closeButton.click()
    assert app.program.image_controls.frame_data.dialog is None


def test_chunk_data_is_shown(make_app):
    app = make_app()
    app.connect("sim:?width=64&height=48&fps=30")
    for name, value in (("ChunkModeActive", True), ("ChunkSelector", "Gain"), ("ChunkEnable", True)):
        app.grabber.write_feature(name, value)
    app.window.actionFrameData.trigger()
    dialog = app.program.image_controls.frame_data.dialog
    app.until(lambda: "ChunkGain" in shown(dialog))
    assert dialog.hintLabel.isHidden()


@pytest.fixture
def dialog(make_app, monkeypatch):
    app = make_app()
    app.forced = []
    monkeypatch.setattr(address_commands, "force_ip", app.forced.append)
    app.window.sources.addressRequested.emit(CAMERA)
    yield app, app.program.source_controls.address.dialog
    assert app.program.source_controls.address.model.wait(PATIENCE)


def test_a_camera_in_another_subnet_is_given_an_address_with_the_reason_before_it(dialog):
    app, shown = dialog
    assert shown.reasonLabel.text() == "Its address 10.0.0.7 is in another subnet than eth0"
    assert "00:30:53:0a:0b:0c" in shown.cameraLabel.text()
    shown.ipEdit.setText("192.168.5.7")
    shown.maskEdit.setText("255.255.255.0")
    shown.setButton.click()
    app.until(lambda: "192.168.5.7 until it is switched off" in shown.resultLabel.text())
    assert [command.mac for command in app.forced] == [CAMERA.hardware_id]
    shown.closeButton.click()
    assert app.program.source_controls.address.dialog is None


def test_what_is_no_address_is_said_and_nothing_is_sent(dialog):
    app, shown = dialog
    shown.ipEdit.setText("10.0.0")
    shown.setButton.click()
    app.until(lambda: "10.0.0" in shown.resultLabel.text())
    assert shown.resultLabel.property("tone") == "bad" and app.forced == []
    assert shown.setButton.isEnabled()


def test_a_camera_that_is_reachable_has_its_address_as_the_reason(dialog):
    app, shown = dialog
    shown.closeButton.click()
    app.window.sources.addressRequested.emit(replace(CAMERA, note=""))
    assert app.program.source_controls.address.dialog.reasonLabel.text() == "Its address is 10.0.0.7."


def test_snapshots_are_of_the_chosen_kind(make_app):
    app = make_app()
    app.connect("sim:?width=64&height=48&fps=30")
    app.watch()
    app.program.image_controls.snapshot_kind.actions[SnapshotKind.RAW].trigger()
    app.window.actionSnapshot.trigger()
    folder = app.preferences.snapshot_folder
    app.until(lambda: {path.suffix for path in folder.glob("*")} == {".raw", ".json"})


def test_the_last_frames_are_saved_in_a_folder_of_their_own(make_app):
    app = make_app()
    app.connect("sim:?width=64&height=48&fps=30")
    app.until(lambda: len(app.program.image_controls.history.frames) >= 5)
    app.window.actionPause.trigger()
    app.until(app.window.image.pauseBar.isVisible)
    count = len(app.program.image_controls.history.frames)
    app.window.actionSaveLastFrames.trigger()
    assert app.program.image_controls.snapshots.wait(PATIENCE)
    (folder,) = app.preferences.snapshot_folder.iterdir()
    assert folder.is_dir() and len(list(folder.glob("*.png"))) == count
