"""A change is seen everywhere within 200 ms: each pair of ways to a camera, in both directions."""

import itertools
import time
from contextlib import ExitStack, closing, contextmanager

import pytest

from grabbergui import sources
from grabbergui.core.errors import DeviceLostError
from grabbergui.core.features import AccessMode
from grabbergui.core.grabber import ConnectionState
from grabbergui.core.settings import SettingKey
from grabbergui.core.shared import SharedGrabber
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.models.features.worker import FeatureWorker
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import NameServer
from grabbergui.net.yarp.server import YarpGrabberServer
from grabbergui.terminal import Interpreter
from lost_camera import away
from patience import PATIENCE, attempts, until
from ros2_domain import own_domain
from ros2_patience import be_patient

AT_ONCE = 0.2
"""Seconds."""

VALUES = itertools.cycle(tenth / 10 for tenth in range(1, 240))
"""Gains in dB, each another than the one before."""

LOCAL = ("camera", "window", "terminal", "YARP client", "YARP terminal")
ROS2 = ("ROS 2 client", "ROS 2 service", "ROS 2 parameter")
GAIN_REGISTER = 0x100404
"""The simulated camera's register, in hundredths of a decibel."""


@pytest.fixture(autouse=True)
def patience_with_ros(monkeypatch):
    """Others may have the machine's cores."""
    be_patient(monkeypatch)


class Way:
    """One way to the gain: `write` returns when it is set, `heard` returns the value reported since."""

    def __init__(self, write, heard):
        self.write = write
        self.heard = heard


def reports_of(grabber, stack):
    """The gain as a listener to a grabber knows it: like the window, it reads only after a signal."""
    changed = []
    stack.enter_context(
        connected(grabber.features_changed, lambda names: "Gain" in names and changed.append(1))
    )

    def heard():
        if changed:
            changed.clear()
            return grabber.feature("Gain").value
        return None

    return heard


@contextmanager
def connected(signal, listener):
    signal.connect(listener)
    yield
    signal.disconnect(listener)


@pytest.fixture(scope="module")
def camera():
    camera = sources.create("sim:?width=64&height=48&fps=30")
    camera.open()
    yield camera
    camera.close()


@pytest.fixture(scope="module")
def yarp_client(camera):
    """The camera over YARP."""
    with ExitStack() as stack:
        name_server = NameServer("127.0.0.1", 0)
        name_server.open()
        stack.callback(name_server.close)
        address = f"127.0.0.1:{name_server.port_number}"
        names = NameClient.find(address)
        stack.enter_context(YarpGrabberServer(camera, "/everywhere", names=names))
        yield opened(f"yarp:/everywhere?nameserver={address}", stack)


@pytest.fixture(scope="module")
def ways(camera, yarp_client):
    """The ways without ROS 2, by name."""
    remote = yarp_client
    with ExitStack() as stack:
        terminal = Interpreter(camera)
        window = stack.enter_context(closing(Window(camera)))
        remote_terminal = Interpreter(remote)
        yield {
            "camera": Way(lambda value: regulate(camera, value), lambda: register(camera)),
            "window": Way(window.write, window.heard),
            "terminal": Way(lambda value: terminal.execute(f"set Gain {value}"), typed(terminal)),
            "YARP client": Way(lambda value: remote.write_feature("Gain", value), reports_of(remote, stack)),
            "YARP terminal": Way(
                lambda value: remote_terminal.execute(f"set Gain {value}"), typed(remote_terminal)
            ),
        }


def opened(uri, stack):
    grabber = sources.create(uri)
    grabber.open()
    stack.callback(grabber.close)
    return grabber


def register(camera):
    """Return the value in the camera itself, past all caches."""
    return int.from_bytes(camera.device.read(GAIN_REGISTER, 4), "big") / 100


def regulate(camera, value):
    """Let the camera's own regulation arrive at a value, of which nobody notifies the host."""
    for name, setting in (
        ("GainAuto", "Off"),
        ("AutoGainLowerLimit", 0.0),
        ("AutoGainUpperLimit", value),
        ("AutoGainLowerLimit", value),
        ("GainAuto", "Continuous"),
    ):
        camera.write_feature(name, setting)
    until(lambda: register(camera) == pytest.approx(value))


class Window:
    """The window's model beside the servers: that of its feature panel, with its thread."""

    def __init__(self, camera):
        self._grabber = SharedGrabber(camera)
        self._grabber.open()
        self._worker = FeatureWorker()
        self._shown = []
        self._model = FeatureTreeModel(self._grabber, self._worker)
        self._model.feature_changed.connect(self._on_feature_changed)
        self._model.watch(["Gain"])

    def _on_feature_changed(self, feature):
        if feature.name == "Gain":
            self._shown.append(feature.value)

    def write(self, value):
        self._model.write("Gain", value)
        until(lambda: self._shown and self._shown[-1] == pytest.approx(value))

    def heard(self):
        return self._shown[-1] if self._shown else None

    def close(self):
        self._model.close()
        self._worker.close(5)
        self._grabber.close()


def typed(terminal):
    return lambda: float(terminal.execute("get Gain").split()[2])


@pytest.fixture(scope="module")
def ros2_client(camera):
    """The camera over ROS 2."""
    pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
    pytest.importorskip("grabber_interfaces", reason="the interface package is not built: make setup-ros2")
    from grabbergui.net.ros2.server import Ros2GrabberServer

    with pytest.MonkeyPatch.context() as patch, ExitStack() as stack:
        for name, value in own_domain().items():
            patch.setenv(name, value)
        stack.enter_context(Ros2GrabberServer(camera, "/everywhere"))
        yield opened("ros2:/everywhere", stack)


@pytest.fixture(scope="module")
def ros2_ways(ros2_client):
    """The ways of ROS 2, by name."""
    from grabbergui.net.ros2.runtime import Ros2Node

    remote = ros2_client
    with ExitStack() as stack:
        probe = Ros2Node("everywhere_probe")
        probe.start()
        stack.callback(probe.close)
        yield {
            "ROS 2 client": Way(lambda value: remote.write_feature("Gain", value), reports_of(remote, stack)),
            "ROS 2 service": service_way(probe.node),
            "ROS 2 parameter": parameter_way(probe.node),
        }


def answer(client, request):
    """A service that has not discovered who reads its answer drops it, so it is asked again."""
    begun, futures = time.monotonic(), []

    def answered():
        if time.monotonic() >= begun + 3 * len(futures):
            futures.append(client.call_async(request))
        return next((future for future in futures if future.done()), None)

    return until(answered).result()


def service_way(node):
    """As any ROS program does it, which must ask to know."""
    from grabber_interfaces.srv import GetFeature, SetFeature

    get = node.create_client(GetFeature, "/everywhere/get_feature")
    put = node.create_client(SetFeature, "/everywhere/set_feature")
    assert get.wait_for_service(PATIENCE) and put.wait_for_service(PATIENCE)

    def write(value):
        assert answer(put, SetFeature.Request(name="Gain", value=float(value))).success

    return Way(write, lambda: answer(get, GetFeature.Request(name="Gain")).value)


def parameter_way(node):
    """As rqt_reconfigure does: the value by a service, news by /parameter_events."""
    from rcl_interfaces.msg import ParameterEvent
    from rcl_interfaces.srv import SetParameters
    from rclpy.parameter import Parameter

    client = node.create_client(SetParameters, "/everywhere/set_parameters")
    assert client.wait_for_service(PATIENCE)
    news = []

    def on_event(event):
        news.extend(p.value.double_value for p in event.changed_parameters if p.name == "Gain")

    node.create_subscription(ParameterEvent, "/parameter_events", on_event, 10)

    def write(value):
        parameters = [Parameter("Gain", value=float(value)).to_parameter_msg()]
        assert answer(client, SetParameters.Request(parameters=parameters)).results[0].successful

    return Way(write, lambda: news.pop() if news else None)


def pairs(*needed):
    """Every ordered pair of ways that has one of those needed in it."""
    found = itertools.permutations((*LOCAL, *ROS2) if needed == ROS2 else LOCAL, 2)
    return [pytest.param(*pair, id=" to ".join(pair)) for pair in found if set(pair) & set(needed)]


def check_pair(origin, witness):
    """From the moment that the writer has its answer to the witness knowing."""
    for watch in attempts(AT_ONCE):
        value = next(VALUES)
        origin.write(value)
        with watch:
            until(lambda value=value: witness.heard() == pytest.approx(value), f"{value} dB at the other end")


@pytest.mark.parametrize(("origin", "witness"), pairs(*LOCAL))
def test_a_change_is_seen_within_200_ms(ways, origin, witness):
    check_pair(ways[origin], ways[witness])


@pytest.mark.ros2
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize(("origin", "witness"), pairs(*ROS2))
def test_a_change_is_seen_within_200_ms_over_ros2(ways, ros2_ways, origin, witness):
    both = ways | ros2_ways
    check_pair(both[origin], both[witness])


@pytest.mark.parametrize("client", ["yarp_client", "ros2_client"])
def test_what_only_the_stream_locks_is_offered_at_the_other_end(camera, client, request):
    remote, key = request.getfixturevalue(client), SettingKey("PixelFormat")
    camera.start()
    assert camera.feature("PixelFormat").access is AccessMode.READ_ONLY
    offered = remote.feature("PixelFormat")
    assert (offered.access, offered.pauses_stream) == (AccessMode.READ_WRITE, True)
    result = remote.write_setting(key, "Mono12")
    assert (result.feature.value, result.feature.pauses_stream) == ("Mono12", True)
    assert camera.streaming and camera.feature("PixelFormat").value == "Mono12"
    assert not remote.feature("PayloadSize").pauses_stream, "it can never be written"
    camera.stop()
    assert not remote.feature("PixelFormat").pauses_stream
    remote.write_setting(key, "Mono8")


@pytest.mark.parametrize("source", ["camera", "yarp_client", "ros2_client"])
def test_a_stopped_stream_has_no_rate(camera, source, request):
    source = request.getfixturevalue(source)
    frames = source.open_queue(4)
    camera.start()
    source.start()
    until(lambda: frames.get(PATIENCE) and source.statistics().frame_rate)
    source.stop()
    frames.close()
    stopped = source.statistics()
    assert (stopped.frame_rate, stopped.bandwidth) == (0.0, 0.0) and stopped.frames
    camera.stop()


@pytest.mark.parametrize("listened", [False, True], ids=["for images", "for features too"])
@pytest.mark.parametrize("client", ["yarp_client", "ros2_client"])
def test_the_loss_of_the_served_camera_and_its_return_are_reported(camera, client, listened, request):
    """A client that watches no feature asks less often: within two seconds, a window at once."""
    remote = request.getfixturevalue(client)
    reports = []
    with ExitStack() as stack:
        stack.enter_context(connected(remote.connection_changed, lambda *report: reports.append(report)))
        if listened:
            stack.enter_context(connected(remote.features_changed, lambda names: None))
        remote.start()
        stack.callback(remote.stop)
        for watch in attempts(2.0):
            reports.clear()
            reason = f"another application took control, try {time.monotonic_ns()}"
            with away(camera, reason):
                loss = (ConnectionState.LOST, reason)
                with watch:
                    # The return after the loss of the test before may be reported as late as now.
                    until(lambda loss=loss: loss in reports, "the loss")
                assert reports[-1] == loss and remote.lost == reason
                with pytest.raises(DeviceLostError, match="another application took control"):
                    remote.write_feature("Gain", 1.0)
            until(lambda loss=loss: reports[-1] != loss, "the return")
            assert reports[reports.index(loss) + 1 :] == [(ConnectionState.OPEN, "set as before")]
            assert remote.lost == "" and remote.streaming


@pytest.mark.parametrize("client", ["yarp_client", "ros2_client"])
def test_what_is_not_as_before_the_loss_is_reported_to_clients(camera, client, request, monkeypatch):
    remote, reports = request.getfixturevalue(client), []
    problems, changed = ["Gain=6: the camera answered: busy"], ["Gamma is 2 instead of 1"]
    monkeypatch.setattr(camera, "_set_as_before", lambda streaming, known: (problems, changed))
    loss = (ConnectionState.LOST, f"the cable is out, for the {client}")
    with connected(remote.connection_changed, lambda *report: reports.append(report)):
        with away(camera, loss[1]):
            # The loss of the test before may be reported as late as now.
            until(lambda: loss in reports, "the loss")
        until(lambda: reports[-1] != loss, "the return")
    assert reports[reports.index(loss) + 1] == (
        ConnectionState.OPEN,
        "but not as before: Gain=6: the camera answered: busy;"
        " changed meanwhile, not by us: Gamma is 2 instead of 1",
    )
    assert (remote.unlike_before, remote.changed_meanwhile) == (tuple(problems), tuple(changed))
