"""The camera as a frame grabber, on the simulated device."""

import errno
import os
import queue as queue_module
import threading
import time
from contextlib import closing
from pathlib import Path

import pytest

from fakes import XmlDevice
from grabbergui import sources
from grabbergui.core.errors import (
    DeviceLostError,
    FeatureAccessError,
    FeatureNotFoundError,
    FeatureValueError,
    ResourceExhaustedError,
    TransportError,
)
from grabbergui.core.features import AccessMode
from grabbergui.core.grabber import Access, ConnectionState, return_text
from grabbergui.core.settings import SettingKey
from grabbergui.driver import camera as camera_module
from grabbergui.driver.camera import Camera
from grabbergui.driver.genapi.node_features import NodeFeature
from grabbergui.driver.genapi.node_map import CameraNodeMap
from patience import PATIENCE, attempts, until

DESCRIPTION = (Path(__file__).parents[1] / "data" / "genapi" / "test_camera.xml").read_bytes()


@pytest.fixture
def camera():
    grabber = sources.create("sim:?width=64&height=48&fps=100")
    grabber.open()
    yield grabber
    grabber.close()


def next_frames(queue, count):
    return [queue.get(PATIENCE) for _ in range(count)]


def test_opening_writes_nothing(monkeypatch):
    grabber = sources.create("sim:")
    written = []
    # Kept rather than raised: what a port raises does not survive its way through GenApi.
    monkeypatch.setattr(grabber.device, "write", lambda *arguments: written.append(arguments))
    grabber.open()
    grabber.features()
    grabber.close()

    assert written == []


def test_reading_under_another_selector_reports_no_change(camera):
    camera.write_feature("TriggerSelector", "FrameStart")
    reported = []
    camera.features_changed.connect(reported.append)

    assert (
        camera.read_setting(SettingKey.parse("TriggerDelay[TriggerSelector=FrameBurstStart]")).value
        is not None
    )
    assert camera.feature("TriggerSelector").value == "FrameStart"
    assert reported == []

    camera.write_setting(SettingKey.parse("TriggerDelay[TriggerSelector=FrameBurstStart]"), 1.5)
    assert "TriggerDelay" in frozenset().union(*reported)


def test_starting_changes_the_modes_and_nothing_else(camera):
    camera.write_feature("AcquisitionMode", "SingleFrame")
    camera.write_feature("TriggerSelector", "FrameBurstStart")
    camera.write_feature("TriggerMode", "On")
    camera.write_feature("TriggerSelector", "FrameStart")
    before = {feature.name: feature.value for feature in camera.features() if feature.streamable}

    camera.start()

    after = {feature.name: feature.value for feature in camera.features() if feature.streamable}
    assert {name for name in before if before[name] != after[name]} <= {"AcquisitionMode", "TriggerMode"}
    assert after["AcquisitionMode"] == "Continuous"
    camera.write_feature("TriggerSelector", "FrameBurstStart")
    assert camera.feature("TriggerMode").value == "Off"


def test_the_trigger_can_be_kept(camera):
    camera.write_feature("TriggerMode", "On")
    camera.start(keep_trigger=True)

    assert camera.feature("TriggerMode").value == "On"


def test_frames_flow_and_are_counted(camera):
    queue = camera.open_queue(8)
    camera.start()

    frames = next_frames(queue, 5)

    assert [frame.frame_id for frame in frames] == list(range(frames[0].frame_id, frames[0].frame_id + 5))
    assert all(frame.complete and frame.raw().shape == (48, 64) for frame in frames)
    assert camera.statistics().frames >= 5
    camera.stop()
    assert not camera.streaming


def test_writing_a_value_switches_its_automatic_mode_off(camera):
    camera.write_feature("ExposureAuto", "Continuous")
    assert camera.feature("ExposureTime").access is AccessMode.READ_ONLY

    assert camera.write_feature("ExposureTime", 1234).value == 1234
    assert camera.feature("ExposureAuto").value == "Off"


def test_a_wrong_value_switches_nothing_off(camera):
    camera.write_feature("ExposureAuto", "Continuous")

    with pytest.raises(FeatureValueError, match="ExposureTime=-5"):
        camera.write_feature("ExposureTime", -5)

    assert camera.feature("ExposureAuto").value == "Continuous"


def test_a_frame_rate_turns_its_switch_on(camera):
    camera.write_feature("AcquisitionFrameRateEnable", False)

    assert camera.write_feature("AcquisitionFrameRate", 12.5).value == 12.5
    assert camera.feature("AcquisitionFrameRateEnable").value is True


@pytest.mark.parametrize(
    ("name", "value"), [("PixelFormat", "BayerRG12p"), ("Width", 128), ("BinningVertical", 2)]
)
def test_what_changes_the_payload_restarts_the_stream(camera, name, value):
    queue = camera.open_queue(2)
    camera.start()
    queue.get(PATIENCE)

    before = camera.feature(name).value
    for watch in attempts(1.0):
        camera.write_feature(name, before)
        with watch:
            assert camera.write_feature(name, value).value == value
            queue.clear()
            frame = queue.get(PATIENCE)
    assert (frame.width, frame.height, frame.pixel_format.name) == tuple(
        camera.feature(feature).value for feature in ("Width", "Height", "PixelFormat")
    )
    assert frame.raw().shape == (frame.height, frame.width)


def test_a_refused_format_leaves_the_stream_on(camera):
    queue = camera.open_queue(2)
    camera.start()

    with pytest.raises(FeatureValueError, match="PixelFormat=Mono9"):
        camera.write_feature("PixelFormat", "Mono9")

    queue.clear()
    assert queue.get(PATIENCE).pixel_format.name == "Mono8"


def test_a_camera_that_refuses_to_stop_for_a_write_streams_on(camera, monkeypatch):
    queue = camera.open_queue(2)
    camera.start()

    def refuse(nodes, name):
        monkeypatch.undo()
        raise FeatureAccessError("the camera is busy", name)

    monkeypatch.setattr(CameraNodeMap, "execute", refuse)
    with pytest.raises(FeatureAccessError, match="busy"):
        camera.write_feature("Width", 128)

    assert camera.streaming
    queue.clear()
    assert queue.get(PATIENCE).width == 64


def test_a_value_under_its_automatic_mode_is_reported(camera):
    reported = set()
    seen = threading.Event()

    def note(names: frozenset[str]) -> None:
        reported.update(names)
        if "ExposureTime" in reported:
            seen.set()

    camera.write_feature("ExposureTime", 100)
    camera.features_changed.connect(note)
    camera.start()
    camera.write_feature("ExposureAuto", "Continuous")
    reported.clear()
    seen.clear()

    assert seen.wait(PATIENCE)
    deadline = time.monotonic() + PATIENCE
    while camera.feature("ExposureTime").value == 100 and time.monotonic() < deadline:
        time.sleep(0.01)
    assert camera.feature("ExposureTime").value > 100


def test_nothing_is_polled_while_nobody_listens(camera, monkeypatch):
    camera.write_feature("ExposureAuto", "Continuous")
    reads = []
    read = camera.device.read
    monkeypatch.setattr(camera.device, "read", lambda *arguments: reads.append(arguments) or read(*arguments))

    time.sleep(0.5)

    assert reads == []


def test_read_only_beside_another_application():
    grabber = sources.create("sim:")
    grabber.open(Access.MONITOR)

    assert grabber.feature("Gain").access is AccessMode.READ_ONLY
    with pytest.raises(FeatureAccessError, match="open for reading only"):
        grabber.write_feature("Gain", 1)
    with pytest.raises(FeatureAccessError, match="open for reading only"):
        grabber.execute("TriggerSoftware")
    grabber.close()


def test_the_lock_of_the_transport_is_the_stream_s_alone(camera):
    assert camera.feature("TLParamsLocked").access is AccessMode.READ_ONLY
    with pytest.raises(FeatureAccessError, match="set by the stream alone"):
        camera.write_feature("TLParamsLocked", 1)
    camera.start()
    assert camera.feature("TLParamsLocked").value == 1
    camera.stop()
    assert camera.feature("TLParamsLocked").value == 0


def test_what_the_description_locks_only_while_it_streams_is_written_in_a_pause(camera):
    assert not camera.pauses_for("AcquisitionMode"), "nothing locks it yet"
    camera.start()
    changes = []
    camera.features_changed.connect(changes.append)
    pausing = {feature.name for feature in camera.features() if camera.pauses_for(feature.name)}
    assert {"AcquisitionMode", "PixelFormat", "Width", "BinningVertical"} <= pausing
    assert not pausing & {"HeightMax", "PayloadSize", "ExposureTime", "DeviceTemperature", "Gain"}
    assert camera.feature("TLParamsLocked").value == 1
    assert changes == [], "nobody hears of the question"
    camera.write_feature("ExposureTime", 1234.0)
    assert any("ExposureTime" in names for names in changes), "but of all that changes after it"
    assert camera.write_feature("AcquisitionMode", "MultiFrame").value == "MultiFrame"
    assert camera.streaming and camera.feature("TLParamsLocked").value == 1


def test_a_slider_costs_one_snapshot_and_one_register_a_step(camera, monkeypatch):
    """Each snapshot reads a dozen properties of a node: six of them took longer than the wire."""
    camera.write_feature("Gain", 1.0)
    snapshots, accesses = [], []
    snapshot, read, write = NodeFeature.snapshot, camera.device.read, camera.device.write
    monkeypatch.setattr(NodeFeature, "snapshot", lambda node: snapshots.append(node) or snapshot(node))
    monkeypatch.setattr(camera.device, "read", lambda *of: accesses.append("read") or read(*of))
    monkeypatch.setattr(camera.device, "write", lambda *of: accesses.append("write") or write(*of))

    assert camera.write_feature("Gain", 2.0).value == pytest.approx(2.0)
    assert len(snapshots) == 1
    assert accesses == ["write"]


def test_a_value_beyond_a_limit_that_moved_meanwhile_is_refused_with_the_limit_of_now(camera):
    """The limits that a write knows from the one before may be out of date."""
    before = camera.write_feature("OffsetX", 0).maximum
    camera.write_feature("Width", 128)
    now = before - 64

    with pytest.raises(FeatureValueError, match=rf"allowed: 0 … {now}\b"):
        camera.write_feature("OffsetX", before)
    assert camera.feature("OffsetX").value == 0
    assert camera.write_feature("OffsetX", now).value == now


def test_unknown_features_suggest_known_ones(camera):
    with pytest.raises(FeatureNotFoundError, match="did you mean ExposureTime"):
        camera.feature("ExposureTme")


def test_a_lost_device_comes_back_as_it_was_set(camera):
    states = queue_module.Queue()
    camera.connection_changed.connect(lambda state, why: states.put((state, why)))
    queue = camera.open_queue()
    camera.write_feature("PixelFormat", "BayerRG8")
    camera.write_feature("BalanceRatioSelector", "Blue")
    camera.write_feature("BalanceRatio", 1.5)
    camera.write_feature("BalanceRatioSelector", "Red")
    camera.write_feature("BalanceRatio", 1.25)
    camera.write_feature("Width", 128)
    camera.start()
    queue.get(PATIENCE)

    camera.device.model = sources.create("sim:?width=64&height=48&fps=100").device.model  # a reboot
    camera.device.on_lost("the cable is out")

    assert states.get(timeout=PATIENCE) == (ConnectionState.LOST, "the cable is out")
    assert states.get(timeout=PATIENCE)[0] is ConnectionState.OPEN
    assert camera.feature("BalanceRatioSelector").value == "Red"
    assert camera.feature("BalanceRatio").value == 1.25
    assert camera.write_feature("BalanceRatioSelector", "Blue").value == "Blue"
    assert camera.feature("BalanceRatio").value == 1.5
    assert camera.streaming
    queue.clear()
    assert queue.get(PATIENCE).width == 128


def test_a_device_lost_again_while_it_comes_back_comes_back_once_more(camera):
    states, really, opened = queue_module.Queue(), camera.device.open_stream, []
    camera.connection_changed.connect(lambda state, why: states.put(state))

    def open_stream(*args, **kwargs):
        stream = really(*args, **kwargs)
        opened.append(stream)
        if len(opened) == 1:
            camera.device.on_lost("out again, in the last step of its return")
        return stream

    queue = camera.open_queue()
    camera.start()
    camera.device.open_stream = open_stream
    camera.device.on_lost("the cable is out")

    lost, back = ConnectionState.LOST, ConnectionState.OPEN
    assert [states.get(timeout=PATIENCE) for _ in range(3)] == [lost, lost, back]
    assert len(opened) == 2 and camera.streaming
    queue.clear()
    assert queue.get(PATIENCE)


def test_a_device_lost_in_a_pause_of_its_stream_streams_again(camera, monkeypatch):
    states, close_stream = queue_module.Queue(), camera.device.close_stream
    camera.connection_changed.connect(lambda state, why: states.put(state))
    camera.start()

    def close_and_lose():
        monkeypatch.undo()
        close_stream()
        camera.device.on_lost("the cable is out")

    monkeypatch.setattr(camera.device, "close_stream", close_and_lose)
    camera.write_feature("Width", 128)  # pauses the stream

    assert [states.get(timeout=PATIENCE) for _ in range(2)] == [ConnectionState.LOST, ConnectionState.OPEN]
    assert camera.streaming
    assert camera.feature("Width").value == 128


def test_a_device_stopped_while_it_is_lost_comes_back_stopped(camera, monkeypatch):
    states, reopen = queue_module.Queue(), camera.device.open
    camera.connection_changed.connect(lambda state, why: states.put(state))
    camera.start()

    def refuse(access):
        monkeypatch.undo()
        camera.stop()
        raise DeviceLostError("still gone")

    monkeypatch.setattr(camera.device, "open", refuse)
    camera.device.on_lost("the cable is out")

    assert [states.get(timeout=PATIENCE) for _ in range(2)] == [ConnectionState.LOST, ConnectionState.OPEN]
    assert camera.device.open == reopen and not camera.streaming


def test_a_device_lost_while_it_is_opened_is_not_taken_for_open(monkeypatch):
    grabber = sources.create("sim:?width=64&height=48")
    states, read = [], grabber.device.description
    grabber.connection_changed.connect(lambda state, why: states.append(state))

    def description():
        grabber.device.on_lost("the cable is out")
        return read()

    monkeypatch.setattr(grabber.device, "description", description)
    with pytest.raises(DeviceLostError, match="was lost while it was opened"):
        grabber.open()
    assert states == [ConnectionState.OPENING, ConnectionState.LOST, ConnectionState.CLOSED]
    with pytest.raises(DeviceLostError, match="is not open"):
        grabber.feature("Width")

    monkeypatch.undo()
    grabber.open()
    assert grabber.feature("Width").value == 64
    grabber.close()


def test_accesses_to_a_lost_device_say_why_it_is_lost_and_the_log_when_it_is_back(
    camera, monkeypatch, caplog
):
    def refuse(access):
        tried.append(access)
        raise DeviceLostError("still gone")

    states = queue_module.Queue()
    camera.connection_changed.connect(lambda state, why: states.put(state))
    tried = []
    with monkeypatch.context() as away:
        away.setattr(camera.device, "open", refuse)
        camera.device.on_lost("another application has it")
        until(lambda: tried, "an attempt to open it")
        for access in (
            lambda: camera.write_feature("Gain", 1.0),
            lambda: camera.write_setting(SettingKey("Gain"), 1.0),
            lambda: camera.execute("TimestampLatch"),
            lambda: camera.feature("Width"),
            lambda: camera.read_setting(SettingKey("Width")),
            lambda: camera.read_register("LUTValueAll", 16),
        ):
            with pytest.raises(DeviceLostError, match="is lost: another application has it"):
                access()
    assert [states.get(timeout=PATIENCE) for _ in range(2)] == [ConnectionState.LOST, ConnectionState.OPEN]
    assert camera.write_feature("Gain", 1.0).value == 1.0
    warnings = [record.getMessage() for record in caplog.records if record.levelname == "WARNING"]
    uri = camera.info.uri
    assert warnings == [f"{uri}: another application has it", f"{uri}: back, set as before"]


def test_a_lost_device_can_be_closed(camera, monkeypatch):
    def refuse(access: Access) -> Access:
        raise DeviceLostError("still gone")

    before = set(threading.enumerate())
    monkeypatch.setattr(camera.device, "open", refuse)
    camera.device.on_lost("the cable is out")

    camera.close()

    assert not [thread for thread in set(threading.enumerate()) - before if thread.is_alive()]


def test_a_device_closed_while_its_loss_is_reported_is_closed(camera, monkeypatch):
    errors, loss_seen = queue_module.Queue(), threading.Event()

    class SlowThread(threading.Thread):
        """Starts late, so that the camera is closed before."""

        def start(self):
            loss_seen.set()
            closing.join(0.2)
            super().start()

    def close():
        loss_seen.wait(PATIENCE)
        try:
            camera.close()
        except RuntimeError as error:
            errors.put(error)

    closing = threading.Thread(target=close)
    closing.start()
    monkeypatch.setattr(camera_module.threading, "Thread", SlowThread)
    camera.device.on_lost("the cable is out")
    closing.join(PATIENCE)

    assert not closing.is_alive() and errors.empty()


def test_a_device_closed_at_the_moment_of_its_return_is_closed(camera, monkeypatch):
    states, closing = [], threading.Thread(target=camera.close)

    def returned(problems, changed):
        closing.start()
        closing.join(0.2)
        return return_text(problems, changed)

    camera.connection_changed.connect(lambda state, why: states.append(state))
    monkeypatch.setattr(camera_module, "return_text", returned)
    camera.device.on_lost("the cable is out")

    until(lambda: states[-1:] == [ConnectionState.CLOSED] and not closing.is_alive(), "closing")
    assert states == [ConnectionState.LOST, ConnectionState.OPEN, ConnectionState.CLOSED]


def test_a_device_lost_while_its_return_is_reported_comes_back_once_more(camera):
    states = queue_module.Queue()
    losses = iter(["out again"])

    def lose(state, why):
        if state is ConnectionState.OPEN:
            for reason in losses:
                camera.device.on_lost(reason)

    camera.connection_changed.connect(lambda state, why: states.put(state))
    camera.connection_changed.connect(lose)
    camera.start()
    camera.device.on_lost("the cable is out")

    seen = [states.get(timeout=PATIENCE) for _ in range(5)]
    lost, back = ConnectionState.LOST, ConnectionState.OPEN
    assert seen == [lost, back, lost, lost, back]
    assert camera.streaming and camera.feature("Width").value == 64


def test_closing_ends_every_thread_and_may_be_done_twice():
    before = set(threading.enumerate())
    for _ in range(3):
        grabber = sources.create("sim:")
        assert isinstance(grabber, Camera)
        grabber.open()
        queue = grabber.open_queue()
        grabber.start()
        queue.get(PATIENCE)
        grabber.close()
        grabber.close()
        assert queue.closed

    assert set(threading.enumerate()) == before


class Doorway(XmlDevice):
    """A device whose opening can be held up, or fail by the machine's fault."""

    def __init__(self) -> None:
        super().__init__(DESCRIPTION)
        self.opened = 0
        self.meanwhile = lambda: None
        self.fault = 0

    def open(self, access):
        self.opened += 1
        self.meanwhile()
        if self.fault:
            raise OSError(self.fault, os.strerror(self.fault))
        return access


def test_one_that_is_closed_while_it_opens_is_not_opened_again_when_it_is_lost(monkeypatch):
    monkeypatch.setattr(camera_module, "RECONNECT_PERIOD", 0.01)
    camera = Camera(device := Doorway())
    ending = threading.Thread(target=camera.close)
    waiting = threading.Event()
    real, camera._lock = camera._lock, NotedLock(camera._lock, ending, waiting)

    def close_meanwhile():
        ending.start()
        assert waiting.wait(PATIENCE)

    device.meanwhile = close_meanwhile
    # It is lost at its last command, before it is closed.
    monkeypatch.setattr(camera, "stop", lambda: device.on_lost("no answer"))
    camera.open()
    ending.join(PATIENCE)
    assert not ending.is_alive() and device.opened == 1
    with real:
        assert camera._reconnecting is None


class NotedLock:
    """A lock that notes when one thread begins to wait for it."""

    def __init__(self, lock, thread, waiting):
        self._lock, self._thread, self._waiting = lock, thread, waiting
        self.acquire, self.release = lock.acquire, lock.release

    def __enter__(self):
        if threading.current_thread() is self._thread:
            self._waiting.set()
        return self._lock.__enter__()

    def __exit__(self, *error):
        return self._lock.__exit__(*error)


@pytest.mark.parametrize(
    ("fault", "error", "text"),
    [
        (errno.EMFILE, ResourceExhaustedError, "as many files"),
        (errno.ENOSPC, TransportError, "No space left"),
    ],
)
def test_what_the_machine_lacks_is_an_error_of_ours(fault, error, text):
    camera = Camera(device := Doorway())
    device.fault = fault
    with pytest.raises(error, match=text):
        camera.open()


def test_one_that_is_lost_comes_back_once_the_machine_has_descriptors_again(monkeypatch):
    monkeypatch.setattr(camera_module, "RECONNECT_PERIOD", 0.01)
    camera = Camera(device := Doorway())
    with closing(camera):
        camera.open()
        device.fault = errno.EMFILE
        device.on_lost("unplugged")
        until(lambda: device.opened > 2)
        device.fault = 0
        until(lambda: not camera.lost)
