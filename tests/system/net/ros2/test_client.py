"""Our client on a server of ours."""

import os
import queue
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
pytest.importorskip("grabber_interfaces", reason="the interface package is not built: make setup-ros2")
pytestmark = pytest.mark.ros2

from grabbergui import sources  # noqa: E402
from grabbergui.core.errors import (  # noqa: E402
    DeviceLostError,
    FeatureAccessError,
    FeatureNotFoundError,
    FeatureValueError,
    FrameTimeoutError,
    SourceUnavailableError,
)
from grabbergui.core.grabber import Access, ConnectionState  # noqa: E402
from grabbergui.net.ros2 import client, client_link  # noqa: E402
from grabbergui.net.ros2.client_link import CameraLink  # noqa: E402
from grabbergui.net.ros2.grabber_services import GrabberServices  # noqa: E402
from grabbergui.net.ros2.server import Ros2GrabberServer  # noqa: E402
from patience import PATIENCE, attempts  # noqa: E402
from ros2_peers import until  # noqa: E402

SERVICE_TIMEOUT = client_link.SERVICE_TIMEOUT
"""Other tests have a longer one."""


def _run(*arguments, **environment):
    return subprocess.run(
        [sys.executable, "-m", "grabbergui", *arguments],
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
    )


def test_a_program_leaves_no_log_of_ros(tmp_path):
    listed = _run("list", "--timeout", "0.5", ROS_LOG_DIR=str(tmp_path / "log"))
    assert (listed.returncode, listed.stderr) == (0, "") and "sim:" in listed.stdout
    assert not list(tmp_path.iterdir())


def test_a_program_that_leaves_its_node_open_ends_well():
    """Python unwound the node's thread through C++, which ended the program by `terminate`."""
    program = (
        "import time; from grabbergui.net.ros2.runtime import Ros2Node; ros = Ros2Node('left_open'); "
        "ros.node.create_timer(0.002, lambda: None); ros.start(); time.sleep(0.3)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_log_of_ros_that_is_wanted_needs_its_folder(tmp_path):
    (tmp_path / "file").touch()
    served = _run(
        *("serve", "sim:", "--ros2", "/logged", "--ros-args", "--enable-external-lib-logs"),
        ROS_LOG_DIR=str(tmp_path / "file" / "log"),
    )
    assert served.returncode == 2
    assert "log directory" in served.stderr and "ROS_LOG_DIR" in served.stderr
    assert len(served.stderr.splitlines()) == 1


def test_a_middleware_that_is_not_installed_ends_no_other_search():
    listed = _run("list", "--timeout", "0.5", RMW_IMPLEMENTATION="rmw_none")
    assert (listed.returncode, listed.stderr) == (0, "") and "sim:" in listed.stdout
    served = _run("serve", "sim:", "--ros2", "/mute", RMW_IMPLEMENTATION="rmw_none")
    assert served.returncode == 1
    assert "ROS 2 cannot start: RMW_IMPLEMENTATION=rmw_none is not installed" in served.stderr
    assert len(served.stderr.splitlines()) == 1


def test_a_source_that_cannot_join_the_network_is_closed_again(monkeypatch):
    states = []

    def refuse(name):
        raise SourceUnavailableError("ROS 2 cannot start")

    monkeypatch.setattr(client, "Ros2Node", refuse)
    remote = sources.create("ros2:/cam")
    remote.connection_changed.connect(lambda state, reason: states.append(state))
    with pytest.raises(SourceUnavailableError, match="cannot start"):
        remote.open()
    assert states == [ConnectionState.OPENING, ConnectionState.CLOSED]


def test_our_client_has_the_whole_tree_and_the_images(remote, camera):
    assert remote.feature_tree() == camera.feature_tree()
    assert remote.info == replace(
        camera.info,
        **{name: getattr(remote.info, name) for name in ("uri", "bus", "address", "interface")},
    )
    assert remote.info.model == "Simulated camera"
    assert remote.info.interface == "/cam (reliable, volatile)"
    frames = remote.open_queue()
    begun = time.time_ns()
    remote.start()
    frame = frames.get(PATIENCE)
    assert (frame.pixel_format.name, frame.rgb().shape) == ("BayerRG8", (240, 320, 3))
    assert begun - 2e9 < frame.received_ns < time.time_ns()
    assert remote.write_feature("Gain", 3).value == 3 and camera.feature("Gain").value == 3
    assert remote.write_feature("DeviceUserID", "").value == ""
    with pytest.raises(FeatureValueError, match="allowed: 0 … 24 dB"):
        remote.write_feature("Gain", 100)
    with pytest.raises(FeatureNotFoundError, match="did you mean Gain"):
        remote.feature("Gian")
    remote.execute("TimestampLatch")


def test_a_read_only_client_writes_nothing(server, camera):
    remote = sources.create("ros2:/cam")
    remote.open(Access.MONITOR)
    try:
        assert remote.access is Access.MONITOR
        before = camera.feature("Gain").value
        with pytest.raises(FeatureAccessError, match="reading only"):
            remote.write_feature("Gain", before + 1)
        with pytest.raises(FeatureAccessError, match="reading only"):
            remote.execute("TimestampLatch")
        assert camera.feature("Gain").value == before
    finally:
        remote.close()


def test_others_changes_are_reported(remote, camera):
    reported = queue.Queue()
    remote.features_changed.connect(reported.put)

    def changed():
        camera.write_feature("Gain", camera.feature("Gain").value + 0.1)
        return not reported.empty() and "Gain" in reported.get()

    until(changed)


def test_its_calibration_is_the_servers(server, remote, camera):
    from grabbergui.core.calibration import Calibration

    assert remote.calibration() is None
    remote.start()
    server._calibration.calibration = Calibration.from_field_of_view(4096, 2160)
    calibration = until(remote.calibration)

    assert (calibration.width, calibration.height) == (320, 240)
    assert calibration.matrix[0, 2] == pytest.approx(2047.5 - camera.feature("OffsetX").value)


def test_a_server_that_vanishes_and_comes_back(serve, opened):
    server = serve("/cam")
    remote = opened("ros2:/cam")
    states = queue.Queue()
    remote.connection_changed.connect(lambda state, why: states.put((state, why)))
    frames = remote.open_queue()
    remote.start()
    frames.get(PATIENCE)

    server.stop()

    state, why = states.get(timeout=PATIENCE)
    assert state is ConnectionState.LOST and "nobody publishes /cam/image_raw any more" in why
    for watch in attempts(2.0):
        with watch, pytest.raises(DeviceLostError):
            remote.feature("Gain")
    frames.clear()
    serve("/cam")
    assert states.get(timeout=PATIENCE)[0] is ConnectionState.OPEN
    frames.get(PATIENCE)
    assert remote.write_feature("Gain", 2).value == 2


def test_a_server_that_is_back_with_other_values_reports_it(serve, camera, opened, caplog):
    server = serve("/cam")
    remote = opened("ros2:/cam")
    states = queue.Queue()
    remote.connection_changed.connect(lambda state, why: states.put((state, why)))
    assert remote.write_feature("Gain", 3).value == 3

    server.stop()
    assert states.get(timeout=PATIENCE)[0] is ConnectionState.LOST
    camera.write_feature("Gain", 0)
    serve("/cam")

    state, why = states.get(timeout=PATIENCE)
    assert state is ConnectionState.OPEN
    assert remote.unlike_before == ("Gain is 0 instead of 3",)
    assert why == "but not as before: Gain is 0 instead of 3"
    assert "Gain is 0 instead of 3" in caplog.text


def test_a_server_that_does_not_answer_on_its_return_leaves_nothing_behind(serve, opened, monkeypatch):
    server = serve("/mute")
    remote = opened("ros2:/mute")
    clients = len(list(remote._link.node.clients))
    server.stop()
    until(lambda: remote.lost)

    tries = []
    described = CameraLink.described

    def mute(link, info):
        tries.append(link)
        if len(tries) < 4:
            raise FrameTimeoutError("/mute/ask did not answer within 7 s")
        return described(link, info)

    monkeypatch.setattr(CameraLink, "described", mute)
    serve("/mute")
    until(lambda: not remote.lost)
    assert len(tries) == 4 and len(list(remote._link.node.clients)) == clients


@pytest.fixture
def going(monkeypatch):
    """Our servers answer requests only while it is set."""
    going = threading.Event()
    going.set()
    answer = GrabberServices._ask

    def ask(services, request, reply):
        going.wait(PATIENCE)
        return answer(services, request, reply)

    monkeypatch.setattr(GrabberServices, "_ask", ask)
    yield going
    going.set()


def test_a_server_that_neither_answers_nor_sends_is_lost_until_it_answers(serve, opened, going, monkeypatch):
    """As a killed or frozen one, which ROS lists for 20 s more."""
    monkeypatch.setattr(client, "SILENCE", 1.0)
    serve("/silent")
    remote = opened("ros2:/silent")
    going.clear()
    until(lambda: remote.lost)
    assert remote.lost.startswith("/silent") and remote.lost.endswith("does not answer any more")
    for watch in attempts(2.0):
        with watch, pytest.raises(DeviceLostError, match="does not answer any more"):
            remote.feature("Gain")
    going.set()
    until(lambda: not remote.lost)
    assert remote.write_feature("Gain", 2).value == 2


def test_a_server_that_sends_images_may_be_busy(serve, opened, going, monkeypatch):
    monkeypatch.setattr(client, "SILENCE", 0.5)
    serve("/busy")
    remote = opened("ros2:/busy")
    frames = remote.open_queue()
    remote.start()
    frames.get(PATIENCE)
    going.clear()
    until(lambda: remote._link.unanswered > 2.0)
    assert not remote.lost and frames.get(PATIENCE)


def test_closing_does_not_wait_for_a_server_that_hangs(serve, monkeypatch):
    """Nor do requests of other threads, whose waits end."""
    hanging, going = threading.Event(), threading.Event()
    going.set()
    answer = GrabberServices._ask

    def hang(services, request, reply):
        if not going.is_set():
            hanging.set()
        going.wait(PATIENCE)
        return answer(services, request, reply)

    monkeypatch.setattr(GrabberServices, "_ask", hang)
    serve("/hangs")
    states = []
    with ThreadPoolExecutor() as pool:
        for watch in attempts(0.7):
            remote = sources.create("ros2:/hangs")
            remote.connection_changed.connect(lambda state, why: states.append(state))
            remote.open()
            remote.start()
            states.clear()
            hanging.clear()
            going.clear()
            try:
                reading = pool.submit(remote.feature, "Gain")
                assert hanging.wait(PATIENCE)
                with watch:
                    remote.close()
                assert isinstance(reading.exception(PATIENCE), DeviceLostError)
                assert states == [ConnectionState.CLOSED]
            finally:
                going.set()


def test_closing_ends_a_search(domain):
    with ThreadPoolExecutor() as pool:
        for watch in attempts(0.7):
            remote = sources.create("ros2:/nobody")
            opening = pool.submit(remote.open)
            until(lambda remote=remote: remote._ros)
            with watch:
                remote.close()
                assert isinstance(opening.exception(PATIENCE), DeviceLostError)


def test_another_camera_in_its_place_is_refused_and_named_until_the_same_is_back(serve, opened, drive):
    server = serve("/other")
    remote = opened("ros2:/other")
    reported = queue.Queue()
    remote.connection_changed.connect(lambda state, why: reported.put((state, why)))
    server.stop()
    assert reported.get(timeout=PATIENCE)[0] is ConnectionState.LOST

    driver = drive()
    state, why = reported.get(timeout=PATIENCE)
    assert state is ConnectionState.LOST and "/other_driver" in why and "serial SIM001" in why

    driver.close()
    serve("/other")
    until(lambda: reported.get(timeout=PATIENCE)[0] is ConnectionState.OPEN)
    assert remote.has_feature("Gain") and remote.info.model == "Simulated camera"


def test_another_camera_is_refused_even_if_the_loss_was_not_noticed(serve, opened, monkeypatch):
    """As when a server is killed and started again: its publishers are listed for 20 s more."""
    server = serve("/other")
    remote = opened("ros2:/other")
    reported = queue.Queue()
    remote.connection_changed.connect(lambda state, why: reported.put((state, why)))
    frames = remote.open_queue(1)
    remote.start()
    frames.get(PATIENCE)
    monkeypatch.setattr(CameraLink, "published", lambda link: True)
    server.stop()
    other = sources.create("sim:?serial=OTHER")
    other.open()
    gain = other.feature("Gain").value
    try:
        with Ros2GrabberServer(other, "/other"):
            state, why = reported.get(timeout=PATIENCE)
            assert state is ConnectionState.LOST and "serial OTHER" in why and "serial SIM001" in why
            with pytest.raises(DeviceLostError, match="serial OTHER"):
                remote.write_feature("Gain", gain + 1)
            assert other.feature("Gain").value == gain
            until(lambda: stands_still(frames))
    finally:
        other.close()
    serve("/other")
    until(lambda: reported.get(timeout=PATIENCE)[0] is ConnectionState.OPEN)
    assert frames.get(PATIENCE).complete and remote.feature("Gain").value is not None


def stands_still(frames):
    try:
        frames.get(0.5)
    except FrameTimeoutError:
        return True
    return False


def test_a_frame_has_all_components_that_the_server_publishes(server, camera, opened):
    from grabbergui.core.scan3d import read_scan3d

    for name in ("Range", "Confidence"):
        camera.write_feature("ComponentSelector", name)
        camera.write_feature("ComponentEnable", True)
    remote = opened("ros2:/cam")
    frames = remote.open_queue()
    remote.start()

    def complete():
        """Now and then the simulated scene has no pixel without a measurement."""
        seen = frames.get(PATIENCE)
        return len(seen.components) == 3 and np.isnan(seen.components[1].raw()).any() and seen

    frame = until(complete)

    assert [part.name for part in frame.components] == ["intensity", "range", "confidence"]
    distances, scan = frame.components[1], read_scan3d(remote)
    assert scan.unit_of(distances.pixel_format) == "mm"
    found = scan.distances(distances.raw(), distances.pixel_format)
    assert np.isnan(found).any() and 550 < np.nanmin(found) < np.nanmax(found) < 1500
    assert frame.rgb().shape == (240, 320, 3)

    camera.write_feature("ComponentSelector", "Range")
    camera.write_feature("ComponentEnable", False)
    until(lambda: [part.name for part in frames.get(PATIENCE).components] == ["intensity", "confidence"])


def test_controls_are_there_though_dds_discovers_name_and_services_late(server, opened, monkeypatch):
    """It repeats what was lost after 3 s, and lists a publisher before its node."""
    from rclpy.node import Node

    monkeypatch.setattr(client_link, "SERVICE_TIMEOUT", SERVICE_TIMEOUT)
    monkeypatch.setattr(client_link, "SETTLED", 1.0)
    listed, offered, firsts = Node.get_publishers_info_by_topic, Node.get_service_names_and_types_by_node, {}

    def late(what):
        return time.monotonic() < firsts.setdefault(what, time.monotonic()) + 3.2

    def unnamed_at_first(node, topic):
        infos = listed(node, topic)
        for info in infos if infos and late("name") else ():
            info.node_name = "_NODE_NAME_UNKNOWN_"
        return infos

    monkeypatch.setattr(Node, "get_publishers_info_by_topic", unnamed_at_first)
    monkeypatch.setattr(
        Node,
        "get_service_names_and_types_by_node",
        lambda *arguments: [] if late("services") else offered(*arguments),
    )
    remote = opened("ros2:/cam")
    until(lambda: remote.has_feature("Gain"))
    assert remote.feature("Gain").value == 0


def test_components_are_found_where_the_first_topic_is_remapped(serve, camera, opened):
    camera.write_feature("ComponentSelector", "Confidence")
    camera.write_feature("ComponentEnable", True)
    serve("/cam", ros_args=["-r", "~/image_raw:=/robot/head/image_raw"])
    remote = opened("ros2:/robot/head")
    frames = remote.open_queue()
    remote.start()
    until(lambda: [part.name for part in frames.get(PATIENCE).components] == ["intensity", "confidence"])


def test_only_the_first_component_is_subscribed_to_where_one_asks_for_that(server, camera, opened):
    camera.write_feature("ComponentSelector", "Confidence")
    camera.write_feature("ComponentEnable", True)
    remote = opened("ros2:/cam?components=0")
    frames = remote.open_queue()
    remote.start()
    for _ in range(20):
        assert len(frames.get(PATIENCE).components) == 1
