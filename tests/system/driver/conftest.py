"""A simulated camera, and the virtual machine in which cameras meet the real drivers of a kernel."""

from __future__ import annotations

import os

import pytest

import isolation
from driver_camera import camera  # noqa: F401
from guest import Guest


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
