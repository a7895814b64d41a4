"""The camera server as a process: shared over YARP, ended by a signal."""

import re
import signal
import subprocess
import sys
import urllib.request

import pytest

from grabbergui import sources
from grabbergui.cli import main
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.rpc_client import RpcClient
from patience import PATIENCE

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


def test_a_camera_on_yarp_and_its_remote_twin(serve):
    process = serve(SMALL, "--yarp", "/cam", "--with-name-server", "--nameserver", "127.0.0.1:0")
    address = re.search(r"at (\S+:\d+)", line_with(process, "name server"))[1]
    line_with(process, "serving")

    remote = sources.create(f"yarp:/cam?nameserver={address}")
    remote.open()
    queue = remote.open_queue()
    remote.start()
    assert queue.get(PATIENCE).rgb().shape == (48, 64, 3)
    assert remote.write_feature("Gain", 6).value == 6
    remote.close()

    with RpcClient("/cam/terminal", NameClient.find(address)) as terminal:
        assert str(terminal.call(Bottle(["get", "Gain"]), PATIENCE)[0]).startswith("Gain = 6 dB")

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

    out, _ = process.communicate("get PixelFormat\nexit\n", timeout=10)

    assert out.startswith("PixelFormat = BayerRG8")
    assert process.returncode == 0


def test_counters_and_a_structured_log(serve):
    process = serve(SMALL, "--introspection", "--metrics", "0", "--terminal", "--log-format", "json")
    url = line_with(process, "counters are at").split()[-1]
    with urllib.request.urlopen(url, timeout=PATIENCE) as page:
        assert b"grabbergui_frames_total{" in page.read()

    process.send_signal(signal.SIGTERM)

    assert process.wait(PATIENCE) == 0


@pytest.mark.parametrize(
    ("arguments", "code", "line"),
    [
        ([SMALL], 2, "serve on what?"),
        (["--from", "/no/such.ini"], 2, "no configuration file /no/such.ini"),
        (["--index", "7", "--terminal"], 1, "there is no camera 7"),
        ([SMALL, "--yarp", "/cam", "--nameserver", "127.0.0.1:1"], 1, "name server"),
        ([SMALL, "--yarp", "no slash", "--with-name-server", "--nameserver", "127.0.0.1:0"], 2, "no slash"),
        ([SMALL, "--yarp", "/cam", "--with-name-server", "--nameserver", "nowhere"], 2, "HOST:PORT"),
        ([SMALL, "--yarp", "/cam", "--period", "nan"], 2, "period nan"),
        ([SMALL, "--terminal", "--bind", "127.0.0.1"], 2, "--bind says nothing without --yarp"),
        ([SMALL, "--terminal", "--ros-args", "-p", "Gain:=1"], 2, "--ros-args says nothing without --ros2"),
        ([SMALL, "--terminal", "--metrics", "here"], 2, "write HOST:PORT"),
        ([SMALL, "--pixel-format", "Mono9", "--terminal"], 1, "PixelFormat=Mono9"),
    ],
)
def test_what_cannot_be_served_is_one_line(capsys, arguments, code, line):
    assert main(["serve", *arguments]) == code
    err = capsys.readouterr().err
    assert line in err and err.count("\n") == 1
