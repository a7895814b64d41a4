"""Shared memory of killed ROS 2 programs is seen and cleared; that of living ones is left alone."""

import fcntl
import mmap
import os
import time
from contextlib import ExitStack

import pytest

from grabbergui import doctor
from grabbergui.cli import machine, main
from grabbergui.doctor.findings import Level
from grabbergui.doctor.software import shared_memory
from grabbergui.net.ros2.shared_memory import clear, leftovers

SEGMENT, PORT = "fastdds_0123456789abcdef", "fastdds_port7411"
PARTS = {
    SEGMENT: (SEGMENT, f"{SEGMENT}_el"),
    PORT: (PORT, f"{PORT}_el", f"{PORT}_sl", f"sem.{PORT}_mutex"),
}


@pytest.fixture
def folder(tmp_path):
    """Shared memory left by a program that was killed a minute ago, beside files of others."""
    for name in (*PARTS[SEGMENT], *PARTS[PORT], "sem.other", "fastdds_notes.txt"):
        (tmp_path / name).write_bytes(bytes(100_000 if name == SEGMENT else 0))
        os.utime(tmp_path / name, (time.time() - 60,) * 2)
    return tmp_path


def names(found):
    return [leftover.name for leftover in found]


def test_what_nobody_holds_is_cleared_and_other_files_stay(folder):
    found = leftovers(folder)
    assert names(found) == [SEGMENT, PORT] and found[0].size >= 100_000

    assert clear(found) == found

    assert sorted(path.name for path in folder.iterdir()) == ["fastdds_notes.txt", "sem.other"]


@pytest.mark.parametrize(
    ("part", "kind"), [("_el", fcntl.LOCK_EX), ("_sl", fcntl.LOCK_SH)], ids=["owner", "readers"]
)
def test_what_is_locked_stays(folder, part, kind):
    before = leftovers(folder)
    with (folder / f"{PORT}{part}").open() as lock:
        fcntl.flock(lock, kind)
        assert names(leftovers(folder)) == [SEGMENT]
        assert names(clear(before)) == [SEGMENT], "also if it was taken between looking and clearing"
        assert all((folder / name).exists() for name in PARTS[PORT])


def test_what_a_living_process_has_in_its_memory_stays(folder):
    """As a port that it only sends to."""
    before = leftovers(folder)
    with ExitStack() as stack:
        file = stack.enter_context((folder / SEGMENT).open("r+b"))
        stack.enter_context(mmap.mmap(file.fileno(), 0))
        assert names(leftovers(folder)) == names(clear(before)) == [PORT]
    assert (folder / SEGMENT).exists()


def test_what_was_made_a_moment_ago_stays(folder):
    """Its owner may not have locked it yet."""
    os.utime(folder / SEGMENT)
    assert names(leftovers(folder)) == [PORT]


@pytest.mark.parametrize("name", [f"{PORT}_el", f"{PORT}_sl", f"{SEGMENT}_el", SEGMENT])
def test_a_fifo_or_link_among_them_is_neither_opened_nor_removed(folder, name, tmp_path_factory):
    """Before, `doctor` waited at the FIFO for ever."""
    elsewhere = tmp_path_factory.mktemp("elsewhere") / "file"
    elsewhere.write_text("of the user")
    for make in (os.mkfifo, lambda path: path.symlink_to(elsewhere)):
        (folder / name).unlink()
        make(folder / name)
        os.utime(folder / name, (time.time() - 60,) * 2, follow_symlinks=False)

        assert names(clear(leftovers(folder))) in ([], [SEGMENT], [PORT])

        assert os.path.lexists(folder / name) and elsewhere.read_text() == "of the user"
        findings = list(shared_memory(folder))
        assert findings[-1].level is Level.PROBLEM and str(folder / name) in findings[-1].text


def test_root_removes_those_of_others_only_when_asked_to(folder, monkeypatch):
    owner = os.geteuid()
    for user, expected in ((owner + 1, []), (owner, [SEGMENT, PORT])):
        monkeypatch.setattr(os, "geteuid", lambda user=user: user)
        assert names(leftovers(folder, own=True)) == expected


def test_the_report_says_how_much_and_what_to_do(folder, tmp_path):
    (finding,) = shared_memory(folder)
    assert finding.level is Level.NOTE and "0.1 MB" in finding.text and "2 segments and ports" in finding.text
    assert finding.remedy.endswith("grabbergui doctor --clear-shared-memory")

    clear(leftovers(folder))

    assert [finding.level for finding in shared_memory(folder)] == [Level.GOOD]
    assert not list(shared_memory(tmp_path / "missing"))


def test_it_is_among_all_doctor_which_command_and_window_show(folder, monkeypatch):
    for others in ("packages", "network", "usb", "webcams", "software"):
        monkeypatch.setattr(doctor, f"check_{others}", lambda: iter(()))
    monkeypatch.setattr(doctor, "MEMORY", folder)
    assert [finding.level for finding in doctor.check()] == [Level.NOTE]


def test_the_command_clears(folder, monkeypatch, capsys):
    monkeypatch.setattr(machine, "MEMORY", folder)

    assert main(["doctor", "--clear-shared-memory"]) == 0

    assert "freed 0.1 MB: 2 segments and ports" in capsys.readouterr().out
    assert not (folder / SEGMENT).exists()
