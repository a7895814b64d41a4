"""The served camera that the tests of a module share."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from grabber_stage import Stage, stage


@pytest.fixture(scope="module")
def scene() -> Iterator[Stage]:
    with stage() as scene:
        yield scene
