"""Questions for files, over a window."""

from pathlib import Path

import pytest
from PyQt5.QtWidgets import QFileDialog

from grabbergui.ui.windows import FileDialogs


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
