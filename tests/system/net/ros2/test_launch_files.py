"""The launch file and the parameter file that we ship."""

import os
import runpy
import signal
import subprocess
import sys
from pathlib import Path
from unittest.mock import MagicMock

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
pytest.importorskip("grabber_interfaces", reason="the interface package is not built: make setup-ros2")
pytestmark = pytest.mark.ros2

from grabbergui.net.ros2.server import Ros2GrabberServer  # noqa: E402
from patience import PROGRAM  # noqa: E402
from ros2_peers import until  # noqa: E402

LAUNCH = """
import sys
from launch import LaunchDescription, LaunchService
from launch.actions import IncludeLaunchDescription

file, *given = sys.argv[1:]
service = LaunchService()
arguments = zip(given[::2], given[1::2])
service.include_launch_description(
    LaunchDescription([IncludeLaunchDescription(file, launch_arguments=arguments)])
)
sys.exit(service.run())
"""
SHIPPED = Path(__file__).parents[4] / "resources" / "ros2"


def test_the_parameter_file_is_applied(camera, probe, caplog):
    camera.write_feature("ExposureAuto", "Continuous")
    with Ros2GrabberServer(camera, "/camera", ros_args=["--params-file", str(SHIPPED / "camera.yaml")]):
        assert until(lambda: probe.node.get_publishers_info_by_topic("/camera/image_raw"))

    assert (camera.feature("ExposureAuto").value, camera.feature("ExposureTime").value) == ("Off", 8000)
    assert not [record for record in caplog.records if "parameter file" in record.message]


def test_the_launch_file_starts_the_server(probe, tmp_path):
    pytest.importorskip("launch_ros.actions", reason="launch_ros has no wheel; a system ROS 2 has it")
    program = tmp_path / "grabbergui"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m grabbergui "$@"\n')
    program.chmod(0o755)
    arguments = {
        "source": "sim:?width=64&height=48",
        "name": "/launched",
        "program": program,
        "parameters": SHIPPED / "camera.yaml",
        "calibration": tmp_path / "info.yaml",
    }
    given = [word for name, value in arguments.items() for word in (name, str(value))]
    launched = subprocess.Popen(
        [sys.executable, "-c", LAUNCH, str(SHIPPED / "camera.launch.py"), *given],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    try:
        until(lambda: probe.node.get_publishers_info_by_topic("/launched/image_raw"))
    finally:
        launched.send_signal(signal.SIGINT)
        said, _ = launched.communicate(timeout=PROGRAM)
    assert "finished cleanly" in said


def test_the_launch_file_may_be_given_by_a_relative_path(monkeypatch):
    """`ros2 launch camera.launch.py` hands on the path as it was typed."""
    for name in ("launch", "launch.actions", "launch.substitutions", "launch_ros", "launch_ros.actions"):
        monkeypatch.setitem(sys.modules, name, MagicMock())
    monkeypatch.chdir(SHIPPED)
    names = runpy.run_path("camera.launch.py")
    assert names["PROGRAM"] == "grabbergui", "beside no installed one"


def test_the_package_is_in_the_index_with_its_programs_and_launch_file(tmp_path):
    """As `setup ros2` installs it: `ros2 run` and `ros2 launch` look in these places."""
    from ament_index_python.packages import get_package_prefix, get_package_share_directory

    from grabbergui.setup import ros2

    pytest.importorskip("ament_package", reason="ament_cmake is not installed: make setup-ros2")
    ros2._build(ros2.PROGRAM, tmp_path, f"{tmp_path}:{sys.prefix}", dict(os.environ))

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
        programs = Path(get_package_prefix("grabbergui")) / "lib" / "grabbergui"
        share = Path(get_package_share_directory("grabbergui"))
    said = subprocess.run([programs / "grabbergui", "--version"], capture_output=True, text=True, check=True)
    assert said.stdout.startswith("grabbergui ")
    said = subprocess.run([programs / "camera", "--help"], capture_output=True, text=True, check=True)
    assert "--ros2" in said.stdout
    assert (share / "launch" / "camera.launch.py").is_file() and (share / "config" / "camera.yaml").is_file()
    launch = (share / "launch" / "camera.launch.py").read_text()
    assert "parents[3]" in launch and share.parents[1] / "lib" == programs.parent
