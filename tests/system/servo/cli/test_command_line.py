"""The guest's command lines: files that are missing or pipes, no display, and what strangers wrote."""

import os
import subprocess
import sys

import pytest

from grabbergui import sources
from grabbergui.cli import EXIT_FAILURE, EXIT_USAGE, main, serve
from grabbergui.config.serve_options import ServeOptions
from grabbergui.core.errors import SourceUnavailableError, UsageError
from grabbergui.servo.config import Config
from grabbergui.servo.hand_eye import hand_eye_file
from marked_camera import MORE_CONTROL
from patience import PROGRAM


def test_a_missing_configuration_is_named(capsys):
    assert main(["servo", "--robot", "sim-teo", "--headless", "--config", "MISSING.ini"]) == EXIT_USAGE
    out, err = capsys.readouterr()
    assert not out and "there is no" in err and "MISSING" in err and err.count("\n") == 1


@pytest.mark.skipif(sys.platform != "linux", reason="always has a display")
def test_without_a_display_servo_names_the_option_to_do_without():
    places = ("QT_QPA_PLATFORM", "DISPLAY", "WAYLAND_DISPLAY")
    env = {name: value for name, value in os.environ.items() if name not in places}
    command = [sys.executable, "-m", "grabbergui", "servo"]
    failed = subprocess.run(command, stderr=subprocess.PIPE, text=True, timeout=PROGRAM, env=env)
    assert failed.returncode == EXIT_FAILURE
    assert len(failed.stderr.splitlines()) == 1 and "--headless" in failed.stderr


@pytest.mark.parametrize("command", [["servo", "--headless"], ["hand-eye"]], ids=" ".join)
def test_a_stranger_does_not_control_the_terminal(command, monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)

    def refuse(uri):
        raise SourceUnavailableError(f"the peer says {MORE_CONTROL}")

    monkeypatch.setattr(sources, "create", refuse)
    arguments = ["--robot", "sim-teo", "--source", "refuse:", "--field-of-view", "60"]
    assert main([*command, *arguments]) == EXIT_FAILURE
    err = capsys.readouterr().err
    assert "the peer says" in err and all(line.isprintable() for line in err.splitlines()), ascii(err)


@pytest.mark.skipif(sys.platform == "win32", reason="it has no FIFOs")
@pytest.mark.parametrize("read", [hand_eye_file.load, Config.load], ids=["hand-eye", "configuration"])
def test_a_pipe_is_refused_instead_of_waited_for(read, tmp_path):
    os.mkfifo(path := tmp_path / "pipe.yaml")
    with pytest.raises(UsageError, match=r"pipe \(FIFO\)"):
        read(path)


@pytest.mark.parametrize("name", ["teo-sim-camera.yaml", "resources/servo/teo-sim-camera.yaml"])
def test_a_shipped_calibration_is_found_from_any_folder_but_never_written_to(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    camera = sources.create("sim:?width=64&height=48")
    camera.open()
    try:
        calibration = serve.served_calibration(camera, ServeOptions(calibration=name))
        assert calibration.calibration is not None
        calibration.close()
        # ROS 2's set_camera_info saves to the file that was named.
        calibration = serve.served_calibration(camera, ServeOptions(calibration=name, ros2="/cam"))
        assert calibration.calibration is None
        calibration.close()
    finally:
        camera.close()
