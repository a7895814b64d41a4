"""Device events: the message channel's codec and socket, and events in the node map of an open camera."""

from __future__ import annotations

import itertools
import os
import queue
import socket
import struct
from collections.abc import Callable, Iterator
from contextlib import closing
from typing import Any

import pytest

from grabbergui import sources
from grabbergui.core.grabber import Access, ConnectionState, DeviceEvent
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.gige.bootstrap import BootstrapRegister
from grabbergui.driver.gige.device import GigeDevice
from grabbergui.driver.gige.gvcp import Ack
from grabbergui.driver.gige.gvcp_messages import Event
from grabbergui.driver.gige.interfaces import Interface
from grabbergui.driver.gige.message_channel import MessageChannel
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import EventSelector
from grabbergui.driver.sim.gige.server import GigeCamera
from patience import PATIENCE, until

_numbers = itertools.count(1)
EVENT = Event(0x9001, 7, 1234, data=struct.pack(">qq", 42, 1234))


@pytest.fixture
def simulate() -> Iterator[Callable[..., GigeCamera]]:
    """Starts a small simulated camera at an address of its own."""
    cameras: list[GigeCamera] = []

    def start(**options: Any) -> GigeCamera:
        power_on = {reg.WIDTH: 64, reg.HEIGHT: 48, reg.FRAME_RATE: 50.0, reg.EXPOSURE_TIME: 1000.0}
        address = f"127.79.{os.getpid() % 250 + 1}.{next(_numbers)}"
        cameras.append(GigeCamera(address, power_on=power_on, **options))
        return cameras[-1]

    yield start
    for camera in cameras:
        camera.close()


class Registers:
    """Memory that remembers writes."""

    def __init__(self) -> None:
        self.written: dict[int, int] = {}

    def write_register(self, register: int, value: int) -> None:
        self.written[register] = value

    def write_optional(self, register: int, value: int) -> bool:
        self.written[register] = value
        return True

    def read_optional(self, register: int) -> int:
        return 0


def test_only_the_device_is_heard() -> None:
    heard: queue.Queue[int] = queue.Queue()
    registers = Registers()
    channel = MessageChannel(
        registers,  # type: ignore[arg-type]
        "127.0.0.7",
        Interface("lo", "127.0.0.1", loopback=True),
        lambda event_id, message: heard.put(event_id),
    )
    port = registers.written[BootstrapRegister.MCP]
    assert registers.written[BootstrapRegister.MCDA] == 0x7F000001 and port == channel.port
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as stranger:
        stranger.sendto(Event(0x9999).encode(1), ("127.0.0.1", port))
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as device:
        device.bind(("127.0.0.7", 0))
        device.settimeout(PATIENCE)
        device.sendto(EVENT.encode(5), ("127.0.0.1", port))
        assert Ack.decode(device.recv(100)).ack_id == 5
    assert heard.get(timeout=PATIENCE) == 0x9001 and heard.empty()
    assert channel.inbox.ignored == 1
    channel.close()
    assert registers.written[BootstrapRegister.MCP] == 0


class Listener:
    """An open camera, the events that it sent, and the features that changed with them."""

    def __init__(self, camera: DeviceGrabber) -> None:
        self.camera = camera
        self.events: queue.Queue[DeviceEvent] = queue.Queue()
        self.changed: set[str] = set()
        camera.event_received.connect(lambda event: self.events.put(event))
        camera.features_changed.connect(lambda names: self.changed.update(names))

    def switch_on(self, event: str) -> None:
        self.camera.write_feature("EventSelector", event)
        self.camera.write_feature("EventNotification", "On")


@pytest.mark.parametrize("kind", ["sim", "gige"])
def test_an_event_arrives_in_the_node_map(kind: str, simulate: Callable[..., GigeCamera]) -> None:
    uri = "sim:?width=64&height=48&fps=50" if kind == "sim" else f"gige:{simulate().address}"
    camera = sources.create(uri)
    assert isinstance(camera, DeviceGrabber)
    camera.open()
    with closing(camera):
        listener = Listener(camera)
        listener.switch_on("ExposureEnd")
        frames = camera.open_queue(500)  # on a busy machine the first may not be dropped
        camera.start()
        event = listener.events.get(timeout=PATIENCE)
        frame = frames.get(PATIENCE)
        camera.stop()
        assert (event.name, event.event_id) == ("ExposureEnd", 0x9001)
        assert event.values["EventExposureEndFrameID"] == frame.frame_id == 1
        assert set(event.values) == {"EventExposureEndTimestamp", "EventExposureEndFrameID"}
        assert set(event.values) <= listener.changed
        assert camera.feature("EventExposureEndFrameID").value >= 1
        assert not camera.feature("EventFrameStartFrameID").access.readable, "this event was never sent"


def test_opening_a_message_channel_waits_for_an_event_to_be_wanted(
    simulate: Callable[..., GigeCamera],
) -> None:
    simulated = simulate()
    camera = DeviceGrabber(GigeDevice(simulated.address))
    camera.open()
    with closing(camera):
        camera.start()
        assert simulated.control.memory.read(BootstrapRegister.MCP, 4) == bytes(4)
        camera.write_feature("EventNotification", "On")
        assert simulated.control.memory.read(BootstrapRegister.MCP, 4) != bytes(4)
    assert simulated.control.memory.read(BootstrapRegister.MCP, 4) == bytes(4)


def test_an_event_that_was_left_switched_on_is_heard(simulate: Callable[..., GigeCamera]) -> None:
    simulated = simulate()
    simulated.model.memory.set(reg.EVENT_NOTIFICATION[EventSelector.FRAME_START], 1)
    camera = DeviceGrabber(GigeDevice(simulated.address))
    camera.open()
    with closing(camera):
        listener = Listener(camera)
        camera.start()
        assert listener.events.get(timeout=PATIENCE).name == "FrameStart"


def test_acknowledged_events_are_not_repeated(simulate: Callable[..., GigeCamera]) -> None:
    simulated = simulate()
    camera = DeviceGrabber(GigeDevice(simulated.address))
    camera.open()
    with closing(camera):
        listener = Listener(camera)
        listener.switch_on("Test")
        camera.execute("TestEventGenerate")
        assert listener.events.get(timeout=PATIENCE).name == "Test"
        until(lambda: not simulated.control._unheard)
        assert listener.events.empty()


def test_events_go_on_after_a_reboot(simulate: Callable[..., GigeCamera]) -> None:
    simulated = simulate()
    camera = DeviceGrabber(GigeDevice(simulated.address))
    states: queue.Queue[ConnectionState] = queue.Queue()
    camera.open()
    with closing(camera):
        camera.connection_changed.connect(lambda state, why: states.put(state))
        listener = Listener(camera)
        listener.switch_on("Test")
        simulated.cut_power()
        assert states.get(timeout=PATIENCE) is ConnectionState.LOST
        assert states.get(timeout=PATIENCE) is ConnectionState.OPEN
        camera.execute("TestEventGenerate")
        assert listener.events.get(timeout=PATIENCE).name == "Test"


def test_a_camera_without_events_is_left_alone(aravis_camera: Any) -> None:
    with closing(GigeDevice("127.0.0.1")) as device:
        device.open(Access.CONTROL)
        device.open_events()
        assert device._messages is None


def test_events_of_a_camera_that_others_wrote(viva_camera: Any) -> None:
    """It asks for no acknowledge and claims no capability for events, but has a message channel."""
    camera = DeviceGrabber(GigeDevice("127.0.0.1"))
    camera.open()
    with closing(camera):
        listener = Listener(camera)
        listener.switch_on("ExposureEnd")
        camera.start()
        numbers = [listener.events.get(timeout=PATIENCE).values["EventExposureEndFrameID"] for _ in range(5)]
        assert numbers == sorted(set(numbers))
        assert isinstance(camera.device, GigeDevice) and camera.device._messages is not None
        assert camera.device._messages.inbox.ignored == 0
