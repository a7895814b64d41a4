"""A camera that is lost, at any moment, and returns as it was set; a camera that is closed meanwhile."""

import errno
import os
import queue as queue_module
import threading
from contextlib import closing
from pathlib import Path

import pytest

from fakes import XmlDevice
from grabbergui import sources
from grabbergui.core.errors import (
    DeviceLostError,
    ResourceExhaustedError,
    TransportError,
)
from grabbergui.core.grabber import Access, ConnectionState
from grabbergui.core.settings import SettingKey, return_text
from grabbergui.driver import reconnection
from grabbergui.driver.device_grabber import DeviceGrabber
from patience import PATIENCE, until

DESCRIPTION = (Path(__file__).parents[2] / "data" / "genapi" / "test_camera.xml").read_bytes()


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
    monkeypatch.setattr(reconnection.threading, "Thread", SlowThread)
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
    monkeypatch.setattr(reconnection, "return_text", returned)
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
    monkeypatch.setattr(reconnection, "RECONNECT_PERIOD", 0.01)
    camera = DeviceGrabber(device := Doorway())
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
    camera = DeviceGrabber(device := Doorway())
    device.fault = fault
    with pytest.raises(error, match=text):
        camera.open()


def test_one_that_is_lost_comes_back_once_the_machine_has_descriptors_again(monkeypatch):
    monkeypatch.setattr(reconnection, "RECONNECT_PERIOD", 0.01)
    camera = DeviceGrabber(device := Doorway())
    with closing(camera):
        camera.open()
        device.fault = errno.EMFILE
        device.on_lost("unplugged")
        until(lambda: device.opened > 2)
        device.fault = 0
        until(lambda: not camera.lost)
