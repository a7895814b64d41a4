"""`grabbergui setup` and `grabbergui paths`."""

import json
import os
import shutil
import sys
from pathlib import Path

import pytest

from grabbergui.cli import main
from grabbergui.core import environment
from grabbergui.core.errors import GrabberError, SourceUnavailableError
from grabbergui.setup import desktop_entry, ros2, udev_rule


@pytest.fixture(autouse=True)
def folders(tmp_path, monkeypatch):
    for variable in ("XDG_DATA_HOME", "XDG_CONFIG_HOME", "XDG_CACHE_HOME"):
        monkeypatch.setenv(variable, str(tmp_path / variable))
    monkeypatch.setenv("SHELL", "/bin/bash")


@pytest.mark.parametrize("part", ["desktop", "completion"])
def test_a_part_is_added_and_taken_away(part, capsys):
    assert main(["setup", part, "--json"]) == 0
    files = [Path(file) for file in json.loads(capsys.readouterr().out)]
    assert files and all(file.is_file() for file in files)

    assert main(["setup", part, "--remove"]) == 0
    assert not any(file.exists() for file in files)
    assert all(f"removed {file}" in capsys.readouterr().out for file in files[:1])

    assert main(["setup", part, "--remove"]) == 0
    assert "nothing to remove" in capsys.readouterr().out


def test_an_option_of_another_part_is_refused(capsys):
    assert main(["setup", "desktop", "--shell", "zsh"]) == 2
    assert "setup completion" in capsys.readouterr().err


def test_ros2_is_not_installed_outside_an_environment(monkeypatch):
    monkeypatch.setattr(sys, "prefix", sys.base_prefix)
    with pytest.raises(SourceUnavailableError, match="not a virtual environment"):
        ros2.install_ros2(print)


def test_a_sourced_ros_whose_python_crashes_is_reported(tmp_path):
    """Its libraries are of another Python: there is no message, only a signal."""
    (tmp_path / "rclpy.py").write_text("import os\nos.abort()\n", "utf-8")
    with pytest.raises(SourceUnavailableError, match=r"cannot import its rclpy \(it ended with -6\)"):
        ros2._check_sourced_rclpy("jazzy", {**os.environ, "PYTHONPATH": str(tmp_path)})


def test_what_rebuilds_the_system_s_caches_may_hang(tmp_path, monkeypatch):
    for command in ("update-desktop-database", "udevadm"):
        tool = tmp_path / command
        tool.write_text("#!/bin/sh\nexec sleep 60\n", "utf-8")
        tool.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.setattr(desktop_entry, "_REFRESH_TIME", 0.05)
    monkeypatch.setattr(udev_rule, "_UDEV_TIME", 0.05)
    assert main(["setup", "desktop"]) == 0
    assert udev_rule.install_udev_rule(tmp_path / "rules.d").is_file()


def test_a_step_that_fails_shows_the_end_of_its_output(caplog):
    with pytest.raises(GrabberError, match="it does not work"):
        ros2._run([sys.executable, "-c", "print('no such thing'); exit(1)"], {}, "it does not work")
    assert "no such thing" in caplog.text


def test_the_folders_of_the_build_machine_are_forgotten(tmp_path):
    file = tmp_path / "a" / "export.cmake"
    file.parent.mkdir()
    file.write_text('set(x "/usr/include;/opt/python/cp311-cp311/include/python3.11;/b")', "utf-8")
    ros2._forget_build_machine(tmp_path)
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
