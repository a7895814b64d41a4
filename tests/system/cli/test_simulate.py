"""The simulated camera as a process, opened over the wire."""

import signal
import socket
import subprocess
import sys

import pytest

from grabbergui import sources
from grabbergui.cli import main
from grabbergui.cli.name_servers import named_server
from grabbergui.core import pfnc
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige import server
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.rendered_scene import RenderedScene
from grabbergui.driver.sim.u3v import serve as u3v
from patience import PATIENCE


@pytest.fixture
def simulated(gvcp_port):
    """A camera on a bad network at 127.0.0.1."""
    command = [sys.executable, "-m", "grabbergui", "simulate", "--gige", "--serial", "WIRE7"]
    command += ["--loss", "2%", "--reorder", "--duplicate", "--camera", "sim:?width=320&height=240&fps=100"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert "WIRE7 is at 127.0.0.1" in process.stdout.readline()
    yield process
    process.kill()
    process.communicate()


def test_every_frame_of_a_bad_network_is_complete(simulated):
    grabber = sources.create("gige:WIRE7?packet_size=1500")
    grabber.open()
    queue = grabber.open_queue(64)
    grabber.start()

    frames = [queue.get(PATIENCE) for _ in range(60)]

    counters = grabber.statistics()
    grabber.close()
    assert all(frame.complete and frame.raw().shape == (240, 320) for frame in frames)
    assert (counters.incomplete, counters.lost) == (0, 0)
    assert counters.packets_resent > 0 and counters.packets_duplicate > 0

    simulated.send_signal(signal.SIGINT)
    assert simulated.wait(PATIENCE) == 0


@pytest.mark.parametrize(
    "arguments",
    [
        ["--loss", "much"],
        ["--delay", "-5ms"],
        ["--camera", "gige:"],
        ["--camera", "sim:?fps=x"],
        ["--bandwidth", "1e300"],
        ["--reboot-after", "1e300"],
        ["localhost"],
        ["127.0.0.300"],
    ],
    ids=" ".join,
)
def test_what_cannot_be_simulated_is_wrong_usage(capsys, arguments):
    try:
        code = main(["simulate", "--gige", *arguments])
    except SystemExit as error:
        code = error.code

    assert code == 2 and capsys.readouterr().err.strip()


def _served(monkeypatch, *arguments):
    """The model of each camera that the command would put on the wire."""
    models = []

    def on_gige(addresses, *, power_on, scene, **others):
        models.extend(CameraModel(scene=scene() if scene else None, power_on=power_on) for _ in addresses)

    monkeypatch.setattr(server, "serve", on_gige)
    monkeypatch.setattr(u3v, "serve", lambda via, *, model, **others: models.append(model))
    assert main(["simulate", *arguments]) == 0
    return models


@pytest.mark.parametrize(
    "transport", [["--gige"], ["--u3v", "--via", "tcp"], ["--u3v", "--serial", "X1"]], ids=" ".join
)
def test_a_camera_in_colour_or_of_a_room_is_so_on_the_wire_too(monkeypatch, transport):
    (colour,) = _served(monkeypatch, *transport, "--camera", "sim:colour?fps=5")
    assert colour.memory.get(reg.PIXEL_FORMAT) == pfnc.by_name("BayerRG8").code
    assert colour.memory.get(reg.DEVICE_MODEL_NAME) == "Simulated colour camera"
    assert colour.memory.get(reg.DEVICE_SERIAL_NUMBER) != "SIM002", "two on one network need two numbers"
    assert colour.memory.get(reg.FRAME_RATE) == 5.0

    (room,) = _served(monkeypatch, *transport, "--camera", "sim:scene")
    assert isinstance(room.sensor.scene, RenderedScene)


@pytest.mark.parametrize("transport", [["--gige"], ["--u3v", "--via", "tcp"]], ids=" ".join)
def test_a_simulated_camera_that_does_not_exist_is_not_another_one(monkeypatch, capsys, transport):
    assert main(["simulate", *transport, "--camera", "sim:color"]) == 1
    assert "no simulated camera 'color'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("configured", "warned"),
    [("127.0.0.1 {other}", True), ("192.0.2.1 {port}", True), ("localhost {port}", False), ("", False)],
)
def test_a_name_server_that_others_do_not_look_for_is_reported(
    configured, warned, monkeypatch, tmp_path, caplog
):
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    (tmp_path / "yarp.conf").write_text(configured.format(port=port, other=port - 1))
    monkeypatch.setenv("YARP_CONFIG_HOME", str(tmp_path))
    with named_server(f"127.0.0.1:{port}", ours=True):
        assert ("other programs do not see" in caplog.text) == warned
