"""The camera server as a process: shared over YARP, ended by a signal."""

import re
import signal
import socket
import subprocess
import sys
import threading
import urllib.request

import pytest

from grabbergui import sources
from grabbergui.calibration import camera_info
from grabbergui.cli import main
from grabbergui.cli.process import supervised
from grabbergui.cli.serve import narrow_discovery, served_calibration
from grabbergui.config.allowed_addresses import AllowedAddresses
from grabbergui.config.serve_options import ServeOptions
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import GrabberError
from grabbergui.core.features import AccessMode
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.rpc_client import RpcClient
from patience import PATIENCE, PROGRAM

SMALL = "sim:?width=64&height=48&fps=100"


@pytest.fixture
def serve():
    """Start `grabbergui serve …` and give the process and the name server's address."""
    running = []

    def start(*arguments):
        command = [sys.executable, "-m", "grabbergui", "serve", *arguments]
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        running.append(process)
        return process

    yield start
    for process in running:
        process.kill()
        process.communicate()


def line_with(process, text):
    for line in process.stdout:
        if text in line:
            return line
    raise AssertionError(f"the server ended without saying {text!r}")


def test_a_camera_on_yarp_and_its_remote_twin(serve, tmp_path):
    file = tmp_path / "camera.yaml"
    camera_info.save(Calibration.from_field_of_view(64, 48, 90), file)
    options = ("--with-name-server", "--nameserver", "127.0.0.1:0", "--calibration", str(file))
    process = serve(SMALL, "--yarp", "/cam", *options)
    address = re.search(r"at (\S+:\d+)", line_with(process, "name server"))[1]
    printed = line_with(process, "open it as ")
    assert printed.startswith("YARP: /cam at tcp://") and "/cam/rpc at tcp://" in printed
    uri = printed.split("open it as ")[1].strip()
    line_with(process, "serving")

    remote = sources.create(uri)
    remote.open()
    queue = remote.open_queue()
    remote.start()
    assert queue.get(PATIENCE).rgb().shape == (48, 64, 3)
    assert remote.write_feature("Gain", 6).value == 6
    remote.close()

    with RpcClient("/cam/terminal", NameClient.find(address)) as terminal:
        assert str(terminal.call(Bottle(["get", "Gain"]), PATIENCE)[0]).startswith("Gain = 6 dB")

    with RpcClient("/cam/rpc", NameClient.find(address)) as rpc:
        assert rpc.call(Bottle(["visr", "get", "fov"]), PATIENCE)[3] == pytest.approx(90)

    again = sources.create(f"yarp:/cam?nameserver={address}")
    again.open()
    assert again.feature("Gain").value == 6
    again.close()

    process.send_signal(signal.SIGTERM)
    assert process.wait(PATIENCE) == 0


def test_the_terminal_of_a_server_and_a_configuration_file(serve, tmp_path):
    (tmp_path / "camera.ini").write_text("fake\npixelFormat BayerRG8\nterminal\n")
    process = serve("--from", str(tmp_path / "camera.ini"))
    line_with(process, "serving")

    out, _ = process.communicate("get PixelFormat\nexit\n", timeout=PROGRAM)

    assert out.startswith("PixelFormat = BayerRG8")
    assert process.returncode == 0


def test_the_terminal_of_a_server_without_one_ends_and_the_server_goes_on(serve):
    process = serve(
        SMALL, "--yarp", "/cam", "--with-name-server", "--nameserver", "127.0.0.1:0", "--terminal"
    )
    address = re.search(r"at (\S+:\d+)", line_with(process, "name server"))[1]
    line_with(process, "serving")
    process.stdin.write("get Gain\n")
    process.stdin.close()
    process.stdin = None
    line_with(process, "Gain = ")

    remote = sources.create(f"yarp:/cam?nameserver={address}")
    remote.open()
    remote.close()
    process.send_signal(signal.SIGTERM)
    assert process.wait(PATIENCE) == 0


def test_counters_and_a_structured_log(serve):
    process = serve(SMALL, "--introspection", "--metrics", "0", "--terminal", "--log-format", "json")
    url = line_with(process, "counters are at").split()[-1]
    with urllib.request.urlopen(url, timeout=PATIENCE) as page:
        assert b"grabbergui_frames_total{" in page.read()

    process.send_signal(signal.SIGTERM)

    assert process.wait(PATIENCE) == 0


def test_a_camera_that_peers_may_see_and_not_change(serve):
    process = serve(
        SMALL, "--yarp", "/cam", "--with-name-server", "--nameserver", "127.0.0.1:0", "--read-only",
        "--allow", "127.15.0.0/16", "--allow", "10.1.1.1",
    )  # fmt: skip
    address = re.search(r"at (\S+:\d+)", line_with(process, "name server"))[1]
    line_with(process, "serving")
    remote = sources.create(f"yarp:/cam?nameserver={address}")
    remote.open()
    try:
        assert remote.feature("Gain").access is AccessMode.READ_ONLY
        with pytest.raises(GrabberError, match="read-only"):
            remote.write_feature("Gain", 1.0)
        with pytest.raises(GrabberError, match="read-only"):
            remote.execute("TriggerSoftware")
        queue = remote.open_queue(1)
        remote.start()
        assert queue.get(PATIENCE).width == 64
    finally:
        remote.close()
    process.send_signal(signal.SIGTERM)
    assert process.wait(PATIENCE) == 0


@pytest.mark.parametrize(
    ("allowed", "already", "range_then", "warning"),
    [
        (["10.0.0.7", "10.0.0.8"], None, "LOCALHOST", "looks for peers only on this machine and there"),
        (["10.0.0.0/24"], None, None, "answers everybody in its domain"),
        (["10.0.0.7"], "SUBNET", "SUBNET", "answers everybody in its domain"),
    ],
)
def test_ros2_looks_for_peers_only_where_they_are_allowed(
    allowed, already, range_then, warning, monkeypatch, caplog
):
    environment = {} if already is None else {"ROS_AUTOMATIC_DISCOVERY_RANGE": already}
    monkeypatch.setattr("grabbergui.cli.serve.os.environ", environment)
    narrow_discovery(AllowedAddresses.parse(allowed))
    assert environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE") == range_then
    assert environment.get("ROS_STATIC_PEERS") == ("10.0.0.7;10.0.0.8" if len(allowed) > 1 else None)
    assert warning in caplog.text


def test_systemd_hears_of_the_start_of_each_beat_and_of_the_end(serve, tmp_path, monkeypatch):
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(str(tmp_path / "notify"))
        manager.settimeout(PATIENCE)
        monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
        monkeypatch.setenv("WATCHDOG_USEC", "100000")
        process = serve(SMALL, "--metrics", "0", "--terminal")
        assert [manager.recv(100) for _ in range(3)] == [b"READY=1", b"WATCHDOG=1", b"WATCHDOG=1"]
        process.send_signal(signal.SIGTERM)
        assert b"STOPPING=1" in iter(lambda: manager.recv(100), b"")
        assert process.wait(PATIENCE) == 0


def test_a_server_that_is_stuck_gives_no_sign_of_life(tmp_path, monkeypatch):
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(str(tmp_path / "notify"))
        manager.settimeout(PATIENCE)
        monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
        monkeypatch.setenv("WATCHDOG_USEC", "20000")
        released = threading.Event()
        beats = iter([None, None])
        with supervised(lambda: next(beats, 0) is None or released.wait(PATIENCE)):
            assert [manager.recv(100) for _ in range(3)] == [b"READY=1", b"WATCHDOG=1", b"WATCHDOG=1"]
            manager.settimeout(0.3)
            with pytest.raises(TimeoutError):
                manager.recv(100)
            released.set()


def test_a_calibration_of_other_images_is_named_as_the_server_starts(tmp_path, caplog):
    file = tmp_path / "camera.yaml"
    camera_info.save(Calibration.from_field_of_view(100, 48, 90), file)
    camera = sources.create(SMALL)
    camera.open()
    try:
        calibration = served_calibration(camera, ServeOptions(calibration=str(file)))
        calibration.close()
    finally:
        camera.close()
    assert f"--calibration {file} is not used" in caplog.text
    assert "100×48 images" in caplog.text


def test_a_calibration_file_that_is_refused_stops_no_server(tmp_path, caplog):
    file = tmp_path / "camera.yaml"
    file.write_text("image_width: 4000000000\n")
    camera = sources.create(SMALL)
    camera.open()
    try:
        for ros2 in ("", "/cam"):
            calibration = served_calibration(camera, ServeOptions(calibration=str(file), ros2=ros2))
            assert calibration.calibration is None
            calibration.close()
    finally:
        camera.close()
    assert caplog.text.count("images are sent without this calibration") == 2


@pytest.mark.parametrize(
    ("arguments", "code", "line"),
    [
        ([SMALL], 2, "serve on what?"),
        (["--from", "/no/such.ini"], 2, "no configuration file /no/such.ini"),
        (["--index", "9999", "--terminal"], 1, "there is no camera 9999"),
        ([SMALL, "--yarp", "/cam", "--nameserver", "127.0.0.1:1"], 1, "--with-name-server"),
        ([SMALL, "--yarp", "no slash", "--with-name-server", "--nameserver", "127.0.0.1:0"], 2, "no slash"),
        ([SMALL, "--yarp", "/cam", "--with-name-server", "--nameserver", "nowhere"], 2, "HOST:PORT"),
        ([SMALL, "--yarp", "/cam", "--period", "nan"], 2, "period nan"),
        ([SMALL, "--terminal", "--bind", "127.0.0.1"], 2, "--bind has no effect without --yarp"),
        ([SMALL, "--terminal", "--ros-args", "-p", "Gain:=1"], 2, "--ros-args has no effect without --ros2"),
        ([SMALL, "--terminal", "--calibration", "cam.yaml"], 2, "without --yarp /NAME or --ros2 /NAME"),
        (
            [SMALL, "--yarp", "/cam", "--calibration", "/no/cam.yaml"],
            2,
            "/no/cam.yaml: there is no such file",
        ),
        ([SMALL, "--terminal", "--metrics", "here"], 2, "write HOST:PORT"),
        ([SMALL, "--terminal", "--metrics", "0", "--metrics-token", "/no/such"], 2, "/no/such"),
        (
            [SMALL, "--terminal", "--allow", "10.0.0.0/99"],
            2,
            "--allow 10.0.0.0/99: write an address",
        ),
        ([SMALL, "--yarp", "/cam", "--require-authentication"], 2, "write a file auth.conf with the lines"),
        ([SMALL, "--pixel-format", "Mono9", "--terminal"], 1, "PixelFormat=Mono9"),
    ],
)
def test_what_cannot_be_served_is_one_line(capsys, arguments, code, line):
    assert main(["serve", *arguments]) == code
    err = capsys.readouterr().err
    assert line in err and err.count("\n") == 1
