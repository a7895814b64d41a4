"""The program's command, its own files and its user's folders."""

import os
import shutil
import stat
import sys
from pathlib import Path

import pytest

from grabbergui.core import environment
from grabbergui.core.environment import (
    RESOURCES,
    cache_home,
    check_folder_of,
    config_home,
    data_home,
    expanded,
    find_file,
    home,
    program,
    shell_command,
    sudo_command,
    write_whole,
)
from grabbergui.core.errors import MissingFileError, UsageError


@pytest.mark.parametrize("name", ["resources/ros2/camera.yaml", "ros2/camera.yaml", "camera.yaml"])
def test_a_shipped_file_is_found_from_any_folder(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    assert find_file(Path(name)) == RESOURCES / "ros2" / "camera.yaml"


def test_the_users_own_file_takes_precedence(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("servo.ini").touch()
    assert find_file(Path("servo.ini")) == Path("servo.ini")


def test_a_bare_name_is_looked_for_in_the_folder_of_its_kind(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert find_file(Path("camera.yaml"), "file") == RESOURCES / "ros2" / "camera.yaml"
    with pytest.raises(MissingFileError, match=r"there is no calibration camera\.yaml"):
        find_file(Path("camera.yaml"), "calibration", "yarp")


@pytest.mark.parametrize("name", ["no.ini", "../ros2/camera.yaml", "/camera.yaml", "*.yaml", "ros2**"])
def test_no_other_path_finds_a_shipped_file(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(MissingFileError, match="there is no configuration"):
        find_file(Path(name), "configuration")


def test_a_full_disk_leaves_the_old_file(tmp_path, full_disk):
    (path := tmp_path / "camera.yaml").write_text("old")
    with full_disk(), pytest.raises(OSError, match="File too large") as failure:
        write_whole(path, "what does not fit")
    assert [each.read_text() for each in tmp_path.iterdir()] == ["old"]
    assert failure.value.filename == str(path)


def test_a_file_that_is_replaced_keeps_its_place_and_mode(tmp_path):
    (path := tmp_path / "camera.yaml").write_text("old")
    path.chmod(0o600)
    (link := tmp_path / "link").symlink_to(path)
    write_whole(link, "new")
    assert (path.read_text(), stat.S_IMODE(path.stat().st_mode)) == ("new", 0o600) and link.is_symlink()


@pytest.mark.parametrize(("umask", "mode"), [(0o022, 0o644), (0o077, 0o600), (0o002, 0o664)])
def test_a_new_file_has_the_mode_of_the_umask(tmp_path, umask, mode):
    before = os.umask(umask)
    try:
        write_whole(path := tmp_path / "camera.yaml", "new")
    finally:
        os.umask(before)
    assert stat.S_IMODE(path.stat().st_mode) == mode


def test_a_file_reaches_the_disk_before_it_replaces_the_old_one(tmp_path, monkeypatch):
    (path := tmp_path / "camera.yaml").write_text("old")
    synced = []
    monkeypatch.setattr(os, "fsync", lambda file: synced.append((os.fstat(file).st_size, path.read_text())))
    write_whole(path, b"new text")
    assert synced == [(8, "old")]


def test_a_file_with_a_long_name_is_written(tmp_path):
    write_whole(path := tmp_path / ("カ" * 83 + ".yaml"), "new")
    assert path.read_text() == "new"


def test_a_pipe_is_written_to(tmp_path):
    os.mkfifo(pipe := tmp_path / "pipe")
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    write_whole(pipe, "text")
    assert os.read(reader, 99) == b"text" and stat.S_ISFIFO(pipe.stat().st_mode)
    os.close(reader)


def test_a_writable_file_in_a_readonly_folder_is_written_in_place(tmp_path, monkeypatch):
    def refuse(path, flags, mode=0o777):
        raise PermissionError(13, "Permission denied")

    (path := tmp_path / "camera.yaml").write_text("old")
    with monkeypatch.context() as patch:
        patch.setattr(os, "open", refuse)
        write_whole(path, "new")
    assert path.read_text() == "new"


@pytest.fixture
def python(tmp_path, monkeypatch):
    """Return a Python in a folder of its own, beside which the command may lie."""
    (python := tmp_path / "bin" / "python3").parent.mkdir()
    monkeypatch.setattr(sys, "executable", str(python))
    return python


def test_the_command_is_the_one_beside_python(python, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert program() == [str(python), "-m", "grabbergui"]
    assert shell_command("show", "left eye") == f"{python} -m grabbergui show 'left eye'"
    (command := python.with_name("grabbergui")).touch()
    assert program() == [str(command)]
    assert shell_command("show") == f"{command} show"


def test_the_name_is_enough_where_the_shell_finds_this_command(python, monkeypatch, tmp_path):
    (command := python.with_name("grabbergui")).touch()
    (link := tmp_path / "grabbergui").symlink_to(command)
    (other := tmp_path / "other").touch()
    for found, shown in ((command, "grabbergui"), (link, "grabbergui"), (other, str(command))):
        monkeypatch.setattr(shutil, "which", lambda name, found=found: name and str(found))
        assert shell_command("show") == f"{shown} show"
    monkeypatch.setattr(shutil, "which", lambda name: str(command))
    assert shell_command("show", absolute=True) == f"{command} show", "sudo searches other folders"
    assert sudo_command("setup") == f"sudo {command} setup"


@pytest.mark.parametrize(
    ("folder", "variable", "default"),
    [
        (data_home, "XDG_DATA_HOME", ".local/share"),
        (config_home, "XDG_CONFIG_HOME", ".config"),
        (cache_home, "XDG_CACHE_HOME", ".cache"),
    ],
)
def test_a_users_folders_are_where_the_specification_has_them(monkeypatch, folder, variable, default):
    monkeypatch.setenv("HOME", "/home/ada")
    assert folder({variable: "/mnt/ada"}) == Path("/mnt/ada")
    for given in ({}, {variable: ""}, {variable: "relative/folder"}, {"XDG_OTHER": "/mnt/other"}):
        assert folder(given) == Path("/home/ada") / default


def test_a_user_without_a_home_has_the_root(monkeypatch):
    def no_home():
        raise RuntimeError("no home directory")

    monkeypatch.setattr(environment.Path, "home", no_home)
    assert home() == Path("/") and config_home({}) == Path("/.config")


def test_a_tilde_is_a_home(monkeypatch):
    monkeypatch.setenv("HOME", "/home/ada")
    assert expanded("~/left.yaml") == Path("/home/ada/left.yaml")
    assert expanded(Path("left.yaml")) == Path("left.yaml")
    with pytest.raises(
        UsageError, match=r"^~nobody-here/a: there is no such home directory; write the whole"
    ):
        expanded("~nobody-here/a")


def test_a_file_needs_its_folder(tmp_path):
    check_folder_of(tmp_path / "left.yaml")
    with pytest.raises(MissingFileError) as failure:
        check_folder_of(tmp_path / "none" / "left.yaml")
    assert str(failure.value) == f"there is no folder {tmp_path / 'none'} for left.yaml; create it first"
