"""The simulated camera within the process, as the tests of drivers use it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from grabbergui import sources
from grabbergui.driver.device_grabber import DeviceGrabber


@pytest.fixture
def camera() -> Iterator[DeviceGrabber]:
    """Return an open simulated camera of small, fast images."""
    grabber = sources.create("sim:?width=64&height=48&fps=100")
    assert isinstance(grabber, DeviceGrabber)
    grabber.open()
    yield grabber
    grabber.close()
