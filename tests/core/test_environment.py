"""Files that come with the program are found from any folder, by the names that the manual uses."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from grabbergui.core.environment import RESOURCES, find_file
from grabbergui.core.errors import MissingFileError
from patience import PROGRAM


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


@pytest.mark.skipif(sys.platform != "linux", reason="other systems count threads elsewhere")
def test_numpy_has_one_thread_in_the_program():
    code = (
        "import os, sys; from grabbergui.__main__ import main\n"
        "sys.argv[1:] = ['--complete', 'bash']; main()\n"
        "import numpy; print(); print(len(os.listdir('/proc/self/task')))"
    )
    variables = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    done = subprocess.run(
        [sys.executable, "-c", code], env=variables, stdout=subprocess.PIPE, timeout=PROGRAM, check=True
    )
    assert int(done.stdout.split()[-1]) == 1
