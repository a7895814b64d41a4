"""Tunings on a made-up camera, and on the simulated one."""

import pytest
from stage import PlainCamera, Stage

from grabbergui import sources


@pytest.fixture
def stage():
    stages = []

    def build(grabber=None, **how):
        stages.append(Stage(grabber or PlainCamera(**how)))
        return stages[-1]

    yield build
    for made in stages:
        made.close()


@pytest.fixture
def sim(stage):
    def build(options="pixel_format=RGB8"):
        camera = sources.create(f"sim:?width=320&height=240&fps=60&{options}")
        camera.open()
        camera.start()
        return stage(camera)

    return build
