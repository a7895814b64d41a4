"""The dialog of the camera's files: what may be done with which, and what is asked first."""

from __future__ import annotations

import pytest
from PyQt5.QtWidgets import QMessageBox

from grabbergui.core.file_access import CameraFile
from grabbergui.ui.views.camera_files_dialog import CameraFilesDialog

TABLE = CameraFile("LUTLuminance", 8192, ("Read", "Write"), {"FileState": "Intact"})
LOG = CameraFile("DeviceLog", None, ("Read",))
FIRMWARE = CameraFile("Firmware", 24024, ("Write",))


@pytest.fixture
def dialog(qtbot):
    made = CameraFilesDialog()
    qtbot.addWidget(made)
    made.setFiles([TABLE, LOG, FIRMWARE], reachable=True)
    made.requested = []
    made.downloadRequested.connect(lambda name: made.requested.append(("download", name)))
    made.uploadRequested.connect(lambda name: made.requested.append(("upload", name)))
    made.deleteRequested.connect(lambda name: made.requested.append(("delete", name)))
    made.show()
    return made


def choose(dialog, row):
    dialog.table.setCurrentItem(dialog.table.topLevelItem(row))


def answer(dialog, text):
    """Press the button of the open question that has this text."""
    (button,) = (each for each in dialog.question.buttons() if text in each.text())
    button.click()


def usable(dialog):
    buttons = (dialog.downloadButton, dialog.uploadButton, dialog.deleteButton)
    return [button.isEnabled() for button in buttons]


def test_the_files_are_listed_with_size_and_details(dialog):
    rows = [[dialog.table.topLevelItem(row).text(column) for column in range(3)] for row in range(3)]
    assert rows == [
        ["LUTLuminance", "8,192 B", "FileState: Intact"],
        ["DeviceLog", "–", ""],
        ["Firmware", "24,024 B", ""],
    ]


@pytest.mark.parametrize(
    ("row", "expected", "reason"),
    [
        (0, [True, True, True], ""),
        (1, [True, False, False], "does not let this file be written"),
        (2, [False, True, False], "never deleted"),
    ],
)
def test_what_the_camera_allows_is_offered(dialog, row, expected, reason):
    choose(dialog, row)
    assert usable(dialog) == expected
    assert reason in dialog.deleteButton.toolTip()


def test_files_of_a_remote_camera_are_only_listed(dialog):
    dialog.setFiles([TABLE], reachable=False)
    assert usable(dialog) == [False] * 3
    assert "has the camera itself" in dialog.uploadButton.toolTip()


def test_one_transfer_at_a_time_with_its_progress(dialog):
    dialog.setBusy(True)
    dialog.setShare(0.5)
    assert dialog.progressBar.isVisible() and dialog.cancelButton.isVisible()
    assert dialog.progressBar.value() == dialog.progressBar.maximum() // 2
    assert usable(dialog) == [False] * 3
    dialog.setBusy(False)
    assert not dialog.progressBar.isVisible() and usable(dialog) == [True] * 3


def test_delete_asks_first(dialog):
    dialog.deleteButton.click()
    assert "LUTLuminance" in dialog.question.text()
    assert dialog.question.defaultButton() is dialog.question.button(QMessageBox.Cancel)
    dialog.question.button(QMessageBox.Cancel).click()
    assert dialog.requested == [] and dialog.question is None
    dialog.deleteButton.click()
    answer(dialog, "Delete")
    assert dialog.requested == [("delete", "LUTLuminance")]


@pytest.mark.parametrize(
    ("name", "agreement", "warned"), [("LUTLuminance", "Replace", False), ("Firmware", "firmware", True)]
)
def test_an_upload_asks_first_and_warns_of_firmware(dialog, name, agreement, warned):
    agreed = []
    dialog.confirmUpload(name, "/tmp/new.bin", lambda: agreed.append(name))
    assert "/tmp/new.bin" in dialog.question.text()
    assert ("power cut" in dialog.question.informativeText()) is warned
    answer(dialog, agreement)
    assert agreed == [name]


def test_the_choice_stays_when_the_list_is_read_again(dialog):
    choose(dialog, 1)
    dialog.setFiles([TABLE, LOG], reachable=True)
    assert dialog.chosen == LOG
    dialog.setFiles([TABLE], reachable=True)
    assert dialog.chosen == TABLE
    dialog.downloadButton.click()
    assert dialog.requested == [("download", "LUTLuminance")]
