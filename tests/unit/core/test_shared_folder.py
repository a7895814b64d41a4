"""Folders that other users can write to: files there are opened without waiting, and only one's own."""

import os
import re
from pathlib import Path

import pytest

from grabbergui.core import shared_folder

PACKAGE = Path(shared_folder.__file__).parents[1]
OWNER = Path(shared_folder.__file__)


def test_a_regular_file_of_ones_own_is_opened_and_closed(tmp_path):
    (tmp_path / "file").write_text("text")
    with shared_folder.opened(tmp_path / "file") as file:
        assert os.read(file, 9) == b"text"
    with pytest.raises(OSError, match="Bad file descriptor"):
        os.fstat(file)
    with shared_folder.opened(tmp_path, folder=True) as file:
        assert os.path.sameopenfile(file, file)


def test_what_replaces_a_file_after_it_was_looked_at_is_refused(tmp_path, monkeypatch):
    """The descriptor decides: between `lstat` and `open`, a FIFO may take the place of the file."""
    path = tmp_path / "name"
    path.touch()
    really = os.lstat

    def look_then_replace(seen):
        state = really(seen)
        path.unlink()
        os.mkfifo(path)
        return state

    monkeypatch.setattr(os, "lstat", look_then_replace)
    with pytest.raises(PermissionError, match="a pipe"), shared_folder.opened(path):
        pass


def test_a_file_of_another_user_is_refused_unless_permitted(tmp_path, monkeypatch):
    path = tmp_path / "file"
    path.touch()
    uid = os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: uid + 1)
    with pytest.raises(PermissionError, match="another user's"), shared_folder.opened(path):
        pass
    with shared_folder.opened(path, of_others=True):
        pass
    assert shared_folder.foreign(path) == "another user's" and not shared_folder.foreign(path, of_others=True)


def test_only_the_owner_of_this_rule_knows_these_folders():
    """So every path in them comes from it, and the test below sees how each is opened."""
    named = re.compile(r"""gettempdir|tempfile\.mktemp|["']/(?:tmp["']|var/tmp|dev/shm)""")
    strays = [
        str(module.relative_to(PACKAGE))
        for module in sorted(PACKAGE.rglob("*.py"))
        if module != OWNER and named.search(module.read_text("utf-8"))
    ]
    assert not strays, "use grabbergui.core.shared_folder"
