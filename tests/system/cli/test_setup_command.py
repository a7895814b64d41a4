"""`grabbergui setup` and `grabbergui paths`."""

import json
import os
import sys
from pathlib import Path

import pytest

from grabbergui.cli import main
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
