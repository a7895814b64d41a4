"""Sharing an open camera from the window: servers, readers, their changes, and their end."""

from __future__ import annotations

import threading
from dataclasses import replace

import pytest

from grabbergui import sources
from grabbergui.core.errors import FeatureAccessError, SourceUnavailableError
from grabbergui.models.change import Origin
from grabbergui.models.open_source import LinkState
from grabbergui.models.share import Network, ReaderMeter, Remedy, ShareOptions, ShareState
from grabbergui.models.sharing import Served, Sharing, peer_changes
from grabbergui.models.source_opener import SourceOpener
from grabbergui.models.undo_steps import Direction
from grabbergui.net.readers import Reader
from grabbergui.net.yarp.os.name_server import NameServer
from patience import PATIENCE, attempts, until

URI = "sim:?width=64&height=48&fps=50&serial=SHARE1"
FIRST_IMAGE = 1.0
"""Seconds from the request to the first remote image."""


@pytest.fixture
def connection():
    link = SourceOpener()
    link.connect_to(URI)
    until(lambda: link.open_sources.state is LinkState.STREAMING)
    yield link
    link.open_sources.close_all()
    assert link.open_sources.wait_closed(PATIENCE)


@pytest.fixture
def sharing(connection):
    model = Sharing(connection.open_sources, connection.stream)
    yield model
    assert model.close(PATIENCE)


@pytest.fixture
def name_server():
    """The address of a running name server."""
    with NameServer(port=0) as server:
        yield f"{server.contact.host}:{server.contact.port}"


def status(sharing, source, *states):
    """Wait until the source's only share is in one of these states."""

    def found():
        shown = sharing.of(source)
        return shown[0] if shown and shown[0].state in states else None

    return until(found, f"one of {states}")


@pytest.fixture
def remote(name_server):
    """Opens the shared camera as another program does."""
    opened = []

    def open_remote(name="/cam"):
        grabber = sources.create(f"yarp:{name}?nameserver={name_server}")
        grabber.open()
        opened.append(grabber)
        grabber.start()
        return grabber

    yield open_remote
    for grabber in opened:
        grabber.close()


def test_a_shared_camera_is_read_and_set_over_yarp(connection, sharing, name_server, remote):
    source = connection.open_sources.current
    sharing.share(source, Network.YARP, ShareOptions("/cam", name_server))
    assert status(sharing, source, ShareState.ON).places[0].startswith("/cam at tcp://")
    other = remote()
    reader = until(lambda: [rate for rate in sharing.of(source)[0].readers if rate.images])[0]
    assert reader.reader.name.startswith("/grabbergui/")
    assert reader.reader.takes.startswith("/cam (fast_tcp")
    assert reader.bytes / reader.images == pytest.approx(64 * 48, rel=0.02)
    assert reader.reader.name in sharing.readers([source])
    other.write_feature("Gain", 5.0)
    assert source.grabber.feature("Gain").value == 5.0
    other.execute("AcquisitionStart")
    changes = until(lambda: len(found := peer_changes(source)) == 2 and found)
    assert [str(change) for change in changes] == ["AcquisitionStart run", "Gain 0 → 5"]
    assert {change.origin for change in changes} == {Origin.NETWORK}
    assert all(change.cause.startswith(("/", "127.0.0.1:")) for change in changes), "who it was"
    assert not source.journal.next_text(Direction.UNDO)


def test_the_first_remote_image_is_there_soon(connection, sharing, name_server, remote):
    for number, watch in enumerate(attempts(FIRST_IMAGE)):
        name = f"/soon{number}"
        with watch:
            sharing.share(connection.open_sources.current, Network.YARP, ShareOptions(name, name_server))
            status(sharing, connection.open_sources.current, ShareState.ON)
            queue = remote(name).open_queue(1)
            queue.get(PATIENCE)
        queue.close()
        sharing.stop(connection.open_sources.current, Network.YARP)
        until(lambda: not sharing.of(connection.open_sources.current))


def test_without_a_name_server_one_can_be_run_here(connection, sharing):
    with NameServer(port=0) as server:
        free = f"127.0.0.1:{server.port_number}"
    options = ShareOptions("/cam", free)
    sharing.share(connection.open_sources.current, Network.YARP, options)
    failed = status(sharing, connection.open_sources.current, ShareState.FAILED)
    assert failed.problem == f"no YARP name server answers at {free}"
    assert failed.remedy is Remedy.NAME_SERVER
    sharing.share(connection.open_sources.current, Network.YARP, replace(options, own_nameserver=True))
    assert status(sharing, connection.open_sources.current, ShareState.ON).places


def test_a_name_server_that_runs_already_is_used(connection, sharing, name_server):
    options = ShareOptions("/cam", name_server, own_nameserver=True)
    sharing.share(connection.open_sources.current, Network.YARP, options)
    assert status(sharing, connection.open_sources.current, ShareState.ON)


@pytest.mark.parametrize("address", ["nonsense", "host:0x10", "host:70000", ":1"])
def test_a_malformed_address_of_a_name_server_is_named(connection, sharing, address):
    sharing.share(
        connection.open_sources.current, Network.YARP, ShareOptions("/cam", address, own_nameserver=True)
    )
    assert address in status(sharing, connection.open_sources.current, ShareState.FAILED).problem


def test_who_may_only_look_changes_nothing(connection, sharing, name_server, remote):
    sharing.share(
        connection.open_sources.current, Network.YARP, ShareOptions("/cam", name_server, read_only=True)
    )
    status(sharing, connection.open_sources.current, ShareState.ON)
    with pytest.raises(FeatureAccessError, match="read-only"):
        remote().write_feature("Gain", 5.0)
    assert connection.open_sources.current.grabber.feature("Gain").value == 0.0
    assert peer_changes(connection.open_sources.current) == ()


def test_a_stopped_camera_starts_when_it_is_shared(connection, sharing, name_server, remote):
    connection.stream.stop()
    until(lambda: connection.open_sources.state is LinkState.OPEN)
    sharing.share(connection.open_sources.current, Network.YARP, ShareOptions("/cam", name_server))
    until(lambda: connection.open_sources.state is LinkState.STREAMING)
    sharing.stop(connection.open_sources.current, Network.YARP)
    until(lambda: not sharing.of(connection.open_sources.current))
    assert connection.open_sources.current.grabber.streaming


class Scripted:
    """A server that does what a test says, and notes its calls."""

    name = "/scripted"

    def __init__(self, calls, problem=None):
        self.calls, self.problem = calls, problem
        self.go_on = threading.Event()
        self.go_on.set()

    def start(self):
        self.go_on.wait(PATIENCE)
        self.calls.append("server started")
        if self.problem is not None:
            raise self.problem

    def stop(self):
        self.calls.append("server stopped")

    def places(self):
        return ["/scripted at nowhere"]

    def connected(self):
        return [Reader("/viewer", "/scripted")]


def scripted(connection, server):
    return Sharing(connection.open_sources, connection.stream, makers={Network.ROS2: lambda *_: server})


def test_the_server_stops_before_its_camera_is_closed(connection):
    calls = []
    sharing = scripted(connection, Scripted(calls))
    source = connection.open_sources.current
    sharing.share(source, Network.ROS2, ShareOptions("/scripted"))
    status(sharing, source, ShareState.ON)
    assert sharing.readers([source]) == sharing.all_readers == ("/viewer",)
    close = source.grabber.close
    source.grabber.close = lambda: (calls.append("camera closed"), close())
    connection.open_sources.close_current()
    until(lambda: "camera closed" in calls)
    assert calls == ["server started", "server stopped", "camera closed"]
    assert sharing.all_readers == ()
    assert sharing.close(PATIENCE)


def test_a_server_that_is_slow_to_start_holds_nobody_up(connection):
    server = Scripted([])
    server.go_on.clear()
    sharing = scripted(connection, server)
    sharing.share(connection.open_sources.current, Network.ROS2, ShareOptions("/scripted"))
    assert [shown.state for shown in sharing.of(connection.open_sources.current)] == [ShareState.STARTING]
    sharing.stop(connection.open_sources.current, Network.ROS2)
    assert [shown.state for shown in sharing.of(connection.open_sources.current)] == [ShareState.STOPPING]
    server.go_on.set()
    until(lambda: not sharing.of(connection.open_sources.current))
    assert server.calls == ["server started", "server stopped"]
    assert sharing.close(PATIENCE)


def test_a_missing_ros_2_comes_with_its_command(connection):
    missing = SourceUnavailableError("ROS 2 is not installed: run `grabbergui setup ros2`, or source it")
    sharing = scripted(connection, Scripted([], missing))
    sharing.share(connection.open_sources.current, Network.ROS2, ShareOptions("/scripted"))
    failed = status(sharing, connection.open_sources.current, ShareState.FAILED)
    assert (failed.remedy, failed.command) == (Remedy.COMMAND, "grabbergui setup ros2")
    assert sharing.close(PATIENCE)


def test_a_server_that_ran_before_the_window_is_shown_and_stopped(connection, sharing):
    server = Scripted([])
    sharing.adopt(Served(URI, Network.YARP, ShareOptions("/scripted"), server))
    assert status(sharing, connection.open_sources.current, ShareState.ON).names == ("/viewer",)
    sharing.stop(connection.open_sources.current, Network.YARP)
    until(lambda: not sharing.of(connection.open_sources.current))
    assert server.calls == ["server stopped"]


def test_rates_are_those_of_the_last_seconds():
    meter = ReaderMeter()
    slow, fast = Reader("/slow", "/cam", "", 0, 0), Reader("/fast", "/cam", "", 100, 1000)
    assert [rate.images for rate in meter.rates([slow, fast], 10.0)] == [0.0, 0.0]
    rates = meter.rates([replace(slow, images=1, bytes=10), replace(fast, images=150, bytes=6000)], 11.0)
    assert [(rate.reader.name, rate.images, rate.bytes) for rate in rates] == [
        ("/fast", 50.0, 5000.0),
        ("/slow", 1.0, 10.0),
    ]
    later = replace(fast, images=150, bytes=6000)
    assert meter.rates([later], 12.0)[0].images == 25.0
    assert meter.rates([later], 13.0)[0].images == 0.0
    again = replace(fast, images=3, bytes=30)
    assert meter.rates([again], 14.0)[0].images == 0.0  # it has connected again


def test_networks_are_loaded_once_before_somebody_shares_and_the_end_waits_for_it(connection):
    loaded, go = [], threading.Event()

    def load():
        assert go.wait(PATIENCE)
        loaded.append(1)

    model = Sharing(connection.open_sources, connection.stream, load=load)
    model.prepare()
    model.prepare()
    assert not model.close(0) and not loaded
    go.set()
    assert model.close(PATIENCE) and loaded == [1]
