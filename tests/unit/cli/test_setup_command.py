"""`grabbergui setup` and `grabbergui paths`."""

import json
import shutil
import sys
from pathlib import Path

import pytest

from grabbergui.cli import main
from grabbergui.core import environment
from grabbergui.core.errors import SourceUnavailableError
from grabbergui.setup import ros2


@pytest.fixture(autouse=True)
def folders(tmp_path, monkeypatch):
    for variable in ("XDG_DATA_HOME", "XDG_CONFIG_HOME", "XDG_CACHE_HOME"):
        monkeypatch.setenv(variable, str(tmp_path / variable))
    monkeypatch.setenv("SHELL", "/bin/bash")


def test_an_option_of_another_part_is_refused(capsys):
    assert main(["setup", "desktop", "--shell", "zsh"]) == 2
    assert "setup completion" in capsys.readouterr().err


def test_ros2_is_not_installed_outside_an_environment(monkeypatch):
    monkeypatch.setattr(sys, "prefix", sys.base_prefix)
    with pytest.raises(SourceUnavailableError, match="not a virtual environment"):
        ros2.install_ros2(print)


def test_the_folders_of_the_build_machine_are_forgotten(tmp_path):
    file = tmp_path / "a" / "export.cmake"
    file.parent.mkdir()
    file.write_text('set(x "/usr/include;/opt/python/cp311-cp311/include/python3.11;/b")', "utf-8")
    ros2.forget_build_machine(tmp_path)
    assert file.read_text("utf-8") == 'set(x "/usr/include;/b")'


def test_the_interfaces_that_are_built_are_shipped():
    assert (ros2.INTERFACES / "package.xml").is_file() and list(ros2.INTERFACES.glob("srv/*.srv"))


def test_every_path_is_there(capsys):
    assert main(["paths", "--json"]) == 0
    paths = json.loads(capsys.readouterr().out)
    assert not [path for name, path in paths.items() if name != "cache" and not Path(path).exists()]
    assert main(["paths", "systemd"]) == 0
    assert Path(capsys.readouterr().out.strip()).name == "grabbergui.service"


def test_a_command_for_sudo_has_the_whole_path():
    words = environment.sudo_command("setup", "udev").split()
    assert words[0] == "sudo" and Path(words[1]).is_absolute() and words[-2:] == ["setup", "udev"]


def test_the_bare_name_is_proposed_where_the_shell_finds_it(tmp_path, monkeypatch):
    command = tmp_path / "grabbergui"
    command.touch(mode=0o755)
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    monkeypatch.setenv("PATH", str(tmp_path))
    assert shutil.which("grabbergui") == str(command)
    assert environment.shell_command("list") == "grabbergui list"
    monkeypatch.setenv("PATH", "/nowhere")
    assert environment.shell_command("list") == f"{command} list"
