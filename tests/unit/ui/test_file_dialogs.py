"""Questions for files, over a window, and the end of both."""

import threading
from pathlib import Path

import pytest
from PyQt5.QtCore import QTimer
from PyQt5.QtWidgets import QDialog, QFileDialog

from grabbergui.ui.application import closed_by
from grabbergui.ui.file_dialogs import FileDialogs


@pytest.mark.parametrize(
    ("before", "begins"),
    [("", ""), ("Images", "Images"), ("Images/new/newer", "Images"), ("file/new", "")],
)
def test_the_question_for_a_folder_begins_at_one_that_exists(monkeypatch, tmp_path, qtbot, before, begins):
    asked = []
    monkeypatch.setattr(
        QFileDialog, "getExistingDirectory", lambda parent, title, place: asked.append(place) or ""
    )
    (tmp_path / "Images").mkdir()
    (tmp_path / "file").touch()

    assert FileDialogs(None).folder("Folder for recordings", tmp_path / before) is None

    assert [Path(place) for place in asked] == [tmp_path / begins]


def test_a_signal_closes_a_window_below_a_question_for_a_file(qtbot, tmp_path):
    """The window waited for the answer: the program ended only with a second signal."""
    window, stop, answers = QDialog(), threading.Event(), []
    qtbot.addWidget(window)

    def ask():
        QTimer.singleShot(0, stop.set)
        answers.append(FileDialogs(window).to_open("Open", "All (*)", tmp_path))

    QTimer.singleShot(0, ask)
    with closed_by(stop, window.reject):
        window.exec_()
    assert answers == [None]


def test_a_question_is_over_the_active_window_which_gets_the_focus_back(monkeypatch, qtbot):
    """It was over the main window: who loaded a look-up table by keyboard lost its window."""
    parents, main = [], QDialog()
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda parent, *_: (parents.append(parent) or "", ""))
    qtbot.addWidget(main)
    files, table = FileDialogs(main), QDialog(main)
    files.to_open("Open", "All (*)")
    table.show()
    table.activateWindow()
    qtbot.waitUntil(table.isActiveWindow)
    files.to_open("Open", "All (*)")
    assert parents == [main, table]
