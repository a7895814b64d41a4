"""A simulated camera, and the virtual machine in which cameras meet the real drivers of a kernel."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest
from guest import Guest

import isolation
from grabbergui import sources
from grabbergui.driver.device_grabber import DeviceGrabber


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The tests that look at what happened in the virtual machine come last: it takes minutes."""
    items.sort(key=lambda item: item.get_closest_marker("usb") is not None)


def pytest_collection_finish(session: pytest.Session) -> None:
    """The virtual machine works while the other tests run."""
    wanted = any(item.get_closest_marker("usb") for item in session.items)
    if wanted and os.name == "posix" and not session.config.option.collectonly and isolation.FIRST_WORKER:
        Guest(isolation.run_folder()).start()


@pytest.fixture(scope="session")
def guest() -> Guest:
    if os.name != "posix":
        pytest.skip("the virtual machine is made by programs of Unix")
    return Guest(isolation.run_folder())


@pytest.fixture
def camera() -> Iterator[DeviceGrabber]:
    """Return an open simulated camera of small, fast images."""
    grabber = sources.create("sim:?width=64&height=48&fps=100")
    assert isinstance(grabber, DeviceGrabber)
    grabber.open()
    yield grabber
    grabber.close()
