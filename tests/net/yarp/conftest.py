"""The served camera that the tests of a module share."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from grabber_stage import Stage, stage


@pytest.fixture(scope="module")
def scene() -> Iterator[Stage]:
    with stage() as scene:
        yield scene


@pytest.fixture
def coloured(scene: Stage) -> Iterator[Stage]:
    """The camera in a format with colours, so that it has balance ratios; as it was behind the test."""
    before = scene.grabber.feature("PixelFormat").value
    assert before is not None
    scene.grabber.write_feature("PixelFormat", "RGB8")
    yield scene
    scene.grabber.write_feature("PixelFormat", before)
