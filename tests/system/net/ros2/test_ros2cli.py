"""The commands of ROS's own `ros2` on our server, as docs/ros2.md has them."""

import os
import shlex
import shutil
import signal
import subprocess
import sys

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
pytest.importorskip("grabber_interfaces", reason="the interface package is not built: make setup-ros2")
pytest.importorskip("ros2cli", reason="ros2cli has no wheel; a system ROS 2 has it")
pytestmark = pytest.mark.ros2

from documented_commands import ROOT, lines  # noqa: E402
from grabbergui.setup import ros2  # noqa: E402
from grabbergui.terminal import remote_terminal  # noqa: E402
from patience import PATIENCE, PROGRAM  # noqa: E402
from ros2_peers import until  # noqa: E402

ROS2 = (sys.executable, "-c", "import sys; from ros2cli.cli import main; sys.exit(main())")
"""The program `ros2` of the ros2cli that this Python has."""
COMMANDS = [words[1:] for words in lines(ROOT / "docs/ros2.md") if words[0] == "ros2"]
PROGRAMS = [words for words in COMMANDS if words[0] in ("run", "launch")]


@pytest.fixture(scope="module")
def prefix(tmp_path_factory):
    """Our package `grabbergui` beside those of the environment, as `setup ros2` installs it."""
    pytest.importorskip("ament_package", reason="ament_cmake is not installed: make setup-ros2")
    folder = tmp_path_factory.mktemp("prefix")
    ros2._build(ros2.PROGRAM, folder, f"{folder}:{sys.prefix}", dict(os.environ))
    return f"{folder}:{sys.prefix}"


@pytest.fixture
def environment(domain, prefix, tmp_path):
    """For `ros2`, whose daemon would outlive the test."""
    (tmp_path / "bin").mkdir()
    program = tmp_path / "bin" / "grabbergui"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m grabbergui "$@"\n')
    program.chmod(0o755)
    made = {**os.environ, "AMENT_PREFIX_PATH": prefix, "PYTHONUNBUFFERED": "1"}
    made["PATH"] = os.pathsep.join([str(program.parent), made["PATH"]])
    yield made
    run(made, ["daemon", "stop"])


def run(environment, words):
    return subprocess.run(
        [*ROS2, *words], env=environment, capture_output=True, text=True, timeout=PROGRAM, cwd=ROOT
    )


def of_group(group):
    """The commands of one of `ros2`'s, as they are written."""
    return [words for words in COMMANDS if words[0] == group]


def test_parameters_and_services_are_set_and_described(serve, camera, environment):
    serve("/camera", terminal=remote_terminal(camera))
    failed = []
    for words in of_group("param") + of_group("service"):
        if words[2] == "/grabbergui/servo/stop":
            continue
        done = run(environment, words)
        if done.returncode or "success=False" in done.stdout or "failed" in done.stdout.lower():
            failed.append((shlex.join(words), done.stdout + done.stderr))
    assert not failed
    assert camera.feature("ExposureAuto").value == "Continuous", "set by the last command about it"
    assert "Max value: 24.0" in run(environment, ["param", "describe", "/camera", "Gain"]).stdout


def test_a_managed_node_is_led_through_its_states(serve, camera, environment):
    serve("/camera", lifecycle=True)
    said = [run(environment, words).stdout.strip() for words in of_group("lifecycle")]
    assert said == ["Transitioning successful"] * 4
    assert not camera.streaming


def test_topics_are_listed_with_their_types(serve, environment):
    serve("/camera")
    listed = run(environment, ["topic", "list", "--show-types", "--spin-time", "2"]).stdout
    assert "/camera/image_raw [sensor_msgs/msg/Image]" in listed
    assert "/camera/image_raw/compressed [sensor_msgs/msg/CompressedImage]" in listed
    once = ["topic", "echo", "--once", "--field", "header.frame_id", "/camera/camera_info"]
    assert "camera" in run(environment, once).stdout.splitlines()


@pytest.mark.parametrize("words", PROGRAMS, ids=shlex.join)
def test_the_server_is_run_and_launched(words, probe, environment):
    if "rqt_reconfigure" in words:
        pytest.skip("rqt_reconfigure is not installed")
    if "launch" in words:
        pytest.importorskip("launch_ros.actions", reason="launch_ros has no wheel; a system ROS 2 has it")
    words = [word.replace("gige:", "sim:?width=64&height=48") for word in words]
    if words[-1] == "list":
        done = run(environment, words)
        assert done.returncode == 0 and "sim:" in done.stdout
        return
    name = next((word.removeprefix("name:=") for word in words if word.startswith("name:=")), "/camera")
    started = subprocess.Popen(
        [*ROS2, *words],
        env=environment,
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    try:
        until(lambda: probe.node.get_publishers_info_by_topic(f"{name}/image_raw"))
    finally:
        os.killpg(started.pid, signal.SIGINT)  # as a terminal does
        said, _ = started.communicate(timeout=PATIENCE)
    assert started.returncode in (0, 2, -signal.SIGINT), said
    assert "Traceback" not in said


def test_every_command_is_of_a_kind_that_is_tried():
    assert {words[0] for words in COMMANDS} == {"run", "launch", "lifecycle", "param", "service"}
    assert shutil.which("ros2") or len(COMMANDS) > 10
