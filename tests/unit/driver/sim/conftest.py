import numpy as np
import pytest

from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.timing import SimulatedClock

MASTER_AHEAD = 1_700_000_000_000_000_000
"How far the network's time is ahead of the manual clock, in nanoseconds."


class ManualClock:
    """Nanoseconds that pass when the test says so."""

    def __init__(self):
        self.now = 10_000_000_000

    def __call__(self):
        return self.now

    def advance(self, seconds):
        self.now += int(seconds * 1e9)


class Bench:
    """A camera model, its clock and shorthands for registers and frames."""

    def __init__(self, power_on=None, scene=None):
        self.clock = ManualClock()
        self.model = CameraModel(
            power_on=power_on,
            scene=scene,
            clock=SimulatedClock(self.clock, lambda: self.clock.now + MASTER_AHEAD),
        )

    def set(self, register, value):
        self.model.write(register.address, register.encode(value))

    def get(self, register):
        return register.decode(self.model.read(register.address, register.length))

    def start(self):
        self.set(reg.ACQUISITION_START, 1)

    def stop(self):
        self.set(reg.ACQUISITION_STOP, 1)

    def plan(self):
        """The next frame, time advanced so that it is due; None where none is to come."""
        for _ in range(40):
            plan = self.model.next_frame(0)
            if plan is not None:
                return plan
            self.clock.advance(0.05)
        return None

    def payload(self):
        """The next frame and its bytes."""
        plan = self.plan()
        out = np.zeros(plan.payload_bytes, np.uint8)
        used = self.model.render(plan, out)
        return plan, out[:used]

    def image_with(self, register, value):
        """The first frame's values that was exposed with a register set so."""
        self.set(register, value)
        for _ in range(self.get(reg.SETTING_LATENCY)):
            self.plan()
        return self.image()

    def image(self):
        """The next frame's values as floats, for formats that are not packed: 0 to 1."""
        plan, payload = self.payload()
        settings = plan.settings
        deep = settings.pixel_format.depth > 8
        values = payload[: settings.image_bytes].view("<u2" if deep else np.uint8)
        shape = (settings.height, settings.width, settings.pixel_format.components)
        return values.reshape(shape).squeeze() / ((1 << settings.pixel_format.depth) - 1)


@pytest.fixture
def bench():
    return Bench()


@pytest.fixture
def make_bench():
    return Bench
