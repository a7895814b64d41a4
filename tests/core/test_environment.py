"""Files that come with the program are found from any folder, by the names that the manual uses."""

from pathlib import Path

import pytest

from grabbergui.core.environment import RESOURCES, find_file
from grabbergui.core.errors import MissingFileError


@pytest.mark.parametrize("name", ["resources/servo/servo.ini", "servo/servo.ini", "servo.ini"])
def test_a_shipped_file_is_found_from_any_folder(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    assert find_file(Path(name)) == RESOURCES / "servo" / "servo.ini"


def test_a_file_of_ones_own_comes_first(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("servo.ini").touch()
    assert find_file(Path("servo.ini")) == Path("servo.ini")


def test_a_name_alone_is_looked_for_in_the_folder_of_its_kind(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert find_file(Path("camera.yaml"), "file") == RESOURCES / "ros2" / "camera.yaml"
    with pytest.raises(MissingFileError, match=r"there is no calibration camera\.yaml"):
        find_file(Path("camera.yaml"), "calibration", "servo")


@pytest.mark.parametrize("name", ["no.ini", "../resources/servo/servo.ini", "/servo.ini", "*.ini", "servo**"])
def test_nothing_else_is_taken_for_one(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(MissingFileError, match="there is no configuration"):
        find_file(Path(name), "configuration")
