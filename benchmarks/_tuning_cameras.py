"""The cameras of `tuning`: one with 3,500 nodes on each kind of connection, which records its writes.

Each runs in a process of its own, except `sim:`, U3V and GenTL, which run in the process of the window.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks._wide_camera import BASE, create_wide, wide_description
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.uri import SourceUri
from grabbergui.driver.device import Device
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.device import SimulatedDevice
from grabbergui.driver.sim.enumerations import TransportLayer
from grabbergui.driver.sim.memory import Register, RegisterValue
from grabbergui.driver.sim.model import CameraModel, FramePlan

WIDTH, HEIGHT, PIXEL_FORMAT = 2048, 1536, "Mono8"
ADDRESS = "127.11.9.1"
NAME = "/tuning"
SIMULATED = f"sim:?width={WIDTH}&height={HEIGHT}&fps=37.5&pixel_format={PIXEL_FORMAT}&exposure=2000"
GIGABIT = 125e6
"Bandwidth of the camera's link, bytes per second."
LEAST_LEVEL, LEVELS = 20, 199
BYTES_OF_WIDE_REGISTERS = 16 << 10
PATIENCE = 60.0
WRITE_PAUSE = 0.18
"Seconds between two reference writes, as between those of a slider."

Writes = list[float]
"""Times at which a register was written (`time.monotonic`, common to all processes)."""


@dataclass(frozen=True)
class Tuned:
    """A camera that can be opened by its URI."""

    uri: str
    writes: Callable[[], Writes]
    "Returns all writes of the tuned feature."
    create: Callable[[SourceUri], FrameGrabber]
    feature: str = "Gain"
    own_write: Callable[[], float] = lambda: 0.0
    "Returns the seconds of a write to the served camera itself; 0 if the camera is not served."
    shown: bool = True
    "Whether the grey value of an image shows the value that it was exposed with."


@dataclass
class _Noted:
    """Records writes of the gain, which applies from the next frame on and sets its grey value."""

    writes: Writes = field(default_factory=list)

    def watch(self, model: CameraModel) -> None:
        model.memory.set(reg.SETTING_LATENCY, 0)  # less than a host may ask for
        model.memory.on_written(reg.GAIN_RAW, lambda: self.writes.append(time.monotonic()))
        model.render = _render_flat  # type: ignore[method-assign]


def _render_flat(plan: FramePlan, out: NDArray[np.uint8]) -> int:
    """Fill the frame with one grey value, so that rendering takes almost no CPU time."""
    size = plan.settings.image_bytes
    out[:size] = level_of(plan.settings.gain_db)
    return size


def level_of(gain: float) -> int:
    """Return the grey value for a gain in dB; it differs between neighbouring hundredths."""
    return LEAST_LEVEL + round(gain * 100) % LEVELS


def power_on() -> dict[Register, RegisterValue]:
    """Return the initial registers for as many frames as the link carries."""
    from grabbergui.core.pfnc import by_name

    return {
        reg.WIDTH: WIDTH,
        reg.HEIGHT: HEIGHT,
        reg.PIXEL_FORMAT: by_name(PIXEL_FORMAT).code,
        reg.FRAME_RATE_ENABLE: 0,
        reg.EXPOSURE_TIME: 2000.0,
        reg.LINK_THROUGHPUT_LIMIT_MODE: 1,
        reg.LINK_THROUGHPUT_LIMIT: int(GIGABIT * 0.95),
    }


@contextmanager
def simulated() -> Iterator[Tuned]:
    """Provide `sim:`, whose registers are memory of this process."""
    noted = _Noted()
    yield Tuned("sim:", lambda: noted.writes, lambda uri: _wide_grabber(noted))


def _wide_grabber(noted: _Noted) -> DeviceGrabber:
    camera = create_wide(SourceUri.parse(SIMULATED))
    device = camera.device
    assert isinstance(device, SimulatedDevice)
    noted.watch(device.model)
    return camera


@contextmanager
def u3v() -> Iterator[Tuned]:
    """Provide a camera with the whole USB3 Vision protocol, but without the kernel's USB stack."""
    from grabbergui.driver.sim.u3v.backend import SimulatedBus
    from grabbergui.driver.sim.u3v.device import SimulatedU3vDevice
    from grabbergui.driver.u3v.device import U3vDevice

    noted = _Noted()
    model = CameraModel(power_on={**power_on(), reg.DEVICE_TL_TYPE: int(TransportLayer.USB3_VISION)})
    noted.watch(model)
    device = SimulatedU3vDevice(model)
    device.start()
    try:
        yield Tuned(
            "u3v:", lambda: noted.writes, lambda uri: DeviceGrabber(U3vDevice(backend=SimulatedBus(device)))
        )
    finally:
        device.stop()


@contextmanager
def gentl() -> Iterator[Tuned]:
    """Provide EMVA's simulated producer; it has no gain, so the frame rate is changed."""
    import genicam

    from grabbergui.driver.gentl.device import create

    library = Path(genicam.__file__).with_name("viky.cti")
    writes: Writes = []

    def create_noted(uri: SourceUri) -> FrameGrabber:
        camera = create(uri)
        assert isinstance(camera, DeviceGrabber)
        _note_port(camera.device, writes)
        return camera

    yield Tuned(
        f"gentl:{library}#VikyTL_DEV_red", lambda: writes, create_noted, "AcquisitionFrameRate", shown=False
    )


def _note_port(device: Device, writes: Writes) -> None:
    write = device.write

    def noted(address: int, data: bytes) -> None:
        write(address, data)
        writes.append(time.monotonic())

    device.write = noted  # type: ignore[method-assign]


@contextmanager
def gige() -> Iterator[Tuned]:
    """Provide the simulated GigE Vision camera on the loopback, as fast as Gigabit Ethernet."""
    from grabbergui.driver.gige.device import create

    with _process(be_gige) as ask:
        yield Tuned(f"gige:{ADDRESS}", lambda: ask("writes"), create)


@contextmanager
def yarp() -> Iterator[Tuned]:
    """Provide `sim:`, served on YARP."""
    from grabbergui.net.yarp.client import create

    with _process(be_served, False) as ask:
        names = ask("names")
        yield Tuned(
            f"yarp:{NAME}?nameserver={names}",
            lambda: ask("writes"),
            create,
            own_write=lambda: ask("own write"),
        )


@contextmanager
def ros2() -> Iterator[Tuned]:
    """Provide `sim:`, served on ROS 2."""
    from grabbergui.net.ros2.client import create

    with _process(be_served, True) as ask:
        yield Tuned(f"ros2:{NAME}", lambda: ask("writes"), create, own_write=lambda: ask("own write"))


@contextmanager
def _process(target: Callable[..., None], *arguments: object) -> Iterator[Callable[[str], Any]]:
    ours, theirs = get_context("spawn").Pipe()
    process = get_context("spawn").Process(target=target, args=(theirs, *arguments), daemon=True)
    process.start()
    theirs.close()

    def ask(question: str) -> Any:
        ours.send(question)
        if not ours.poll(PATIENCE):
            raise SystemExit(f"the camera's process did not answer within {PATIENCE:g} s")
        return ours.recv()

    try:
        ask("ready")
        yield ask
    finally:
        ours.send(None)
        process.join(PATIENCE)


def be_gige(pipe: Connection) -> None:
    """Run the camera; the target of its process."""
    from grabbergui.driver.sim.gige import registers as gev
    from grabbergui.driver.sim.gige.server import GigeCamera

    noted = _Noted()
    description = gev.description()
    gev.description = lambda: wide_description(description)
    camera = GigeCamera(ADDRESS, bandwidth=GIGABIT, segmentation=True, power_on=power_on())
    camera.control.memory.add_block(BASE, b"\0\0\0\1" * (BYTES_OF_WIDE_REGISTERS // 4))
    noted.watch(camera.model)
    _answer(pipe, noted, {})
    camera.close()


def be_served(pipe: Connection, on_ros2: bool) -> None:
    """Run a camera and its server; the target of their process."""
    with ExitStack() as stack:
        noted = _Noted()
        camera = _wide_grabber(noted)
        camera.open()
        stack.callback(camera.close)
        camera.start()
        answers: dict[str, Callable[[], object]] = {"own write": lambda: _own_write(camera)}
        if on_ros2:
            from grabbergui.net.ros2.server import Ros2GrabberServer

            stack.enter_context(Ros2GrabberServer(camera, NAME))
        else:
            from grabbergui.net.yarp.os.name_client import NameClient
            from grabbergui.net.yarp.os.name_server import NameServer
            from grabbergui.net.yarp.server import YarpGrabberServer

            names = NameServer("127.0.0.1", 0)
            names.open()
            stack.callback(names.close)
            place = f"127.0.0.1:{names.port_number}"
            answers["names"] = lambda: place
            client = NameClient.find(place)
            stack.enter_context(YarpGrabberServer(camera, NAME, names=client))
        _answer(pipe, noted, answers)


def _own_write(camera: DeviceGrabber) -> float:
    """Return the median seconds of a write to the camera itself, with pauses like the operator's."""
    took = []
    for number in range(40):
        time.sleep(WRITE_PAUSE)
        began = time.monotonic()
        camera.write_feature("Gain", float(number % 2))
        took.append(time.monotonic() - began)
    return statistics.median(took)


def _answer(pipe: Connection, noted: _Noted, answers: dict[str, Callable[[], object]]) -> None:
    known = {"ready": lambda: None, "writes": lambda: list(noted.writes), **answers}
    while (question := pipe.recv()) is not None:
        pipe.send(known[question]())


SOURCES = {"sim": simulated, "GigE": gige, "U3V": u3v, "GenTL": gentl, "YARP": yarp, "ROS 2": ros2}
