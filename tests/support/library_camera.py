"""A small, fast simulated camera."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import grabbergui

FAST = "sim:?width=64&height=48&fps=200&exposure=1000"


@pytest.fixture
def camera() -> Iterator[grabbergui.Camera]:
    with grabbergui.open(FAST) as camera:
        yield camera
