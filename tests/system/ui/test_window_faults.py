"""No message outlives its cause: each fault is said while it lasts, and nothing of it when it is over.

Losses by power and by cable at the real window: tests/day.
"""

from contextlib import ExitStack

import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QAbstractButton

from grabbergui import sources
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.faults import GigeFaults, PacketFaults
from grabbergui.driver.sim.gige.server import GigeCamera
from grabbergui.models.messages import ERROR_SECONDS
from grabbergui.models.open_source import LinkState
from grabbergui.models.source_messages import BACK_SECONDS
from grabbergui.models.status import Tone
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import NameServer
from grabbergui.net.yarp.server import YarpGrabberServer

SIM = "sim:?width=320&height=240"
ADDRESS = "127.21.2.1"
NAME_SERVER_HOST, NAME_SERVER_PORT = "127.21.2.97", 11_997
SMALL = {reg.WIDTH: 64, reg.HEIGHT: 48, reg.FRAME_RATE: 20.0}


class Bench:
    """A window, and a camera on the network that can be switched off; what else a fault needs, on a stack."""

    def __init__(self, app, folder):
        self.app, self.folder = app, folder
        self._camera = None
        self.stack = ExitStack()

    def switch_on(self):
        self._camera = GigeCamera(ADDRESS, power_on=SMALL)

    def switch_off(self):
        if self._camera is not None:
            self._camera.close()
            self._camera = None

    def lose_packets(self, share):
        """Let this share of the stream's packets get lost from now on."""
        stream = self._camera._stream
        stream._faults = GigeFaults(loss=share)
        stream._packet_faults = PacketFaults(stream._faults)

    def until_it_streams(self):
        self.app.until(lambda: self.app.program.open_sources.state is LinkState.STREAMING)


@pytest.fixture
def bench(app, tmp_path):
    bench = Bench(app, tmp_path)
    yield bench
    bench.switch_off()
    bench.stack.close()


def power_lost(bench):
    """The camera's power goes and comes back."""
    bench.switch_on()
    bench.app.connect(f"gige:{ADDRESS}")
    bench.switch_off()
    yield "reconnecting since"
    bench.switch_on()
    bench.until_it_streams()
    yield BACK_SECONDS


def all_packets_lost(bench):
    """Nothing of the stream arrives for a while, as behind a firewall that is switched on."""
    bench.switch_on()
    bench.app.connect(f"gige:{ADDRESS}")
    bench.app.watch()
    bench.lose_packets(1.0)
    yield "No frame for"
    bench.lose_packets(0.0)
    yield 0


def taken(bench):
    """Another program controls the camera, and closes it."""
    bench.switch_on()
    other = sources.create(f"gige:{ADDRESS}")
    other.open()
    bench.app.program.source_controls.sources.connect_to(f"gige:{ADDRESS}")
    yield "read only"
    other.close()
    bench.app.until(
        lambda: not bench.app.program.open_sources.current.held
    )  # otherwise the window asks first
    messages = bench.app.window.messages
    bench.app.until(lambda: messages.findChildren(QAbstractButton, "offerButton"))
    bench.app.qtbot.mouseClick(messages.findChildren(QAbstractButton, "offerButton")[-1], Qt.LeftButton)
    bench.until_it_streams()
    yield 0


def name_server_lost(bench):
    """YARP's name server ends; then the camera's server does, too, which is found again only by its name."""

    def begin_name_server():
        name_server = NameServer(NAME_SERVER_HOST, NAME_SERVER_PORT)
        name_server.open()
        bench.stack.callback(name_server.close)
        return name_server

    def serve():
        server = YarpGrabberServer(camera, "/faults", names=NameClient.find(address))
        server.start()
        bench.stack.callback(server.stop)
        return server

    address = f"{NAME_SERVER_HOST}:{NAME_SERVER_PORT}"
    camera = sources.create(SIM)
    camera.open()
    bench.stack.callback(camera.close)
    name_server, server = begin_name_server(), serve()
    bench.app.connect(f"yarp:/faults?nameserver={address}")
    bench.app.watch()
    name_server.close()
    bench.app.watch(10)
    assert not bench.app.errors, "nothing is the matter with what is open"
    server.stop()
    yield "reconnecting since"
    begin_name_server()
    serve()
    bench.until_it_streams()
    bench.app.watch()
    yield BACK_SECONDS


def disk_full(bench):
    """A recording is cut off by a disk that takes no more."""
    resource, app = pytest.importorskip("resource"), bench.app
    app.connect(SIM)
    bar, before = app.window.recordingBar, resource.getrlimit(resource.RLIMIT_FSIZE)
    app.until(bar.recordButton.isEnabled)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, before[1]))
    try:
        app.qtbot.mouseClick(bar.recordButton, Qt.LeftButton)
        app.until(lambda: any("recording" in text for text in app.errors))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    yield "recording"
    yield ERROR_SECONDS


def settings_broken(bench):
    """A file of settings cannot be read."""
    bench.app.connect(SIM)
    (bench.folder / "broken.yaml").write_bytes(b"\x00 no settings")
    bench.app.program.feature_controls.settings_files.load(bench.folder / "broken.yaml")
    yield "broken.yaml"
    yield ERROR_SECONDS


def opening(uri, said):
    """A source that is not there; then one that is."""

    def fault(bench):
        bench.app.program.source_controls.sources.connect_to(uri)
        yield said
        bench.app.connect(SIM)
        yield 0

    return fault


FAULTS = {
    "the camera's power": power_lost,
    "all packets lost": all_packets_lost,
    "another program": taken,
    "a full disk": disk_full,
    "a broken file": settings_broken,
    "no such camera": opening("gige:127.21.2.99", "127.21.2.99"),
    "a name server that ends later": name_server_lost,
    "no name server": opening("yarp:/nowhere?nameserver=127.21.2.98:10000", "no YARP name server"),
}


@pytest.mark.parametrize("fault", FAULTS.values(), ids=FAULTS)
def test_no_message_outlives_its_cause(bench, fault):
    app, messages = bench.app, bench.app.program.messages
    passed, clock = [0.0], messages.clock
    messages.clock = lambda: clock() + passed[0]
    course = fault(bench)

    said = next(course)
    app.until(lambda: any(said in text for text in app.errors))
    passed[0] += next(course)
    app.until(lambda: not app.errors and not app.window.messages.isVisible())


def test_a_loss_of_packets_is_shown_while_it_lasts(bench):
    bench.switch_on()
    bench.app.connect(f"gige:{ADDRESS}")
    bench.app.watch()
    losses = bench.app.window.status.lossLabel
    bench.app.until(lambda: losses.property("tone") == Tone.IDLE.value)  # a busy machine loses some itself

    bench.lose_packets(0.3)
    bench.app.until(lambda: losses.property("tone") != Tone.IDLE.value and losses.text())

    bench.lose_packets(0.0)
    bench.app.until(lambda: losses.property("tone") == Tone.IDLE.value)
    assert not bench.app.errors
