"""A connection whose sources are scripted; an operator and tunings on made-up and simulated cameras."""

import threading

import pytest

from grabbergui import sources
from grabbergui.models import tuning
from opener_bench import Bench
from operators import operator, sim  # noqa: F401
from patience import PATIENCE
from tuning_stage import PlainCamera, Stage


@pytest.fixture
def bench():
    bench = Bench()
    yield bench
    bench.source.opening.set()
    bench.sources.close_all()
    assert bench.sources.wait_closed(PATIENCE)
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("features ")]


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
def stage_on_sim(stage, monkeypatch):
    # On a busy machine two seconds pass between two frames of a camera that is far from silent.
    monkeypatch.setattr(tuning, "SILENT", PATIENCE)

    def build(options="pixel_format=RGB8"):
        camera = sources.create(f"sim:?width=320&height=240&fps=60&{options}")
        camera.open()
        camera.start()
        return stage(camera)

    return build
