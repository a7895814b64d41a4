"""A simulated camera on a bus within the process."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator

import pytest

from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import TestPattern
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.u3v.backend import SimulatedBus
from grabbergui.driver.sim.u3v.device import SimulatedU3vDevice, U3vFaults
from grabbergui.driver.u3v.device import U3vDevice

CameraMaker = Callable[..., tuple[SimulatedU3vDevice, U3vDevice]]


@pytest.fixture
def plug_in() -> Iterator[CameraMaker]:
    """Makes a small fast camera and a host's device for it; all must be gone without a thread at the end."""
    before = set(threading.enumerate())
    made: list[tuple[SimulatedU3vDevice, U3vDevice, SimulatedBus]] = []

    def make(
        faults: U3vFaults | None = None, *, width: int = 64, height: int = 48, **options: int
    ) -> tuple[SimulatedU3vDevice, U3vDevice]:
        model = CameraModel(
            power_on={
                reg.WIDTH: width,
                reg.HEIGHT: height,
                reg.EXPOSURE_TIME: 1000.0,
                reg.FRAME_RATE: 300.0,
                reg.TEST_PATTERN: TestPattern.GREY_HORIZONTAL_RAMP_MOVING,
            }
        )
        host_options = {name: options.pop(name) for name in ("largest_transfer",) if name in options}
        camera = SimulatedU3vDevice(model, faults=faults, **options)
        bus = SimulatedBus(camera)
        device = U3vDevice(backend=bus, **host_options)
        camera.start()
        made.append((camera, device, bus))
        return camera, device

    yield make
    for camera, device, bus in made:
        device.close()
        camera.stop()
        assert bus.opened == 0, "a USB handle is still open"
    assert set(threading.enumerate()) <= before, "a thread is left"
