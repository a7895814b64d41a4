"""A connection whose sources are scripted; an operator and tunings on made-up and simulated cameras."""

import threading

import pytest
from opener_bench import Bench
from operator_bench import Bench as OperatorBench
from tuning_stage import PlainCamera, Stage

from fakes import ScriptedGrabber
from grabbergui import sources
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from patience import PATIENCE


@pytest.fixture
def bench():
    bench = Bench()
    yield bench
    bench.source.opening.set()
    bench.sources.close_all()
    assert bench.sources.wait_closed(PATIENCE)
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("features ")]


def number(name, value=1.0, **more):
    fields = {"minimum": 0.0, "maximum": 100.0, "access": AccessMode.READ_WRITE, **more}
    return Feature(name=name, kind=FeatureKind.FLOAT, value=value, **fields)


@pytest.fixture
def operator():
    """An operator on a made-up camera."""
    return OperatorBench(ScriptedGrabber([number("Gain"), number("Gamma"), number("Exposure", unit="us")]))


@pytest.fixture
def sim():
    """An operator on the simulated camera."""
    camera = sources.create("sim:?width=64&height=64&pixel_format=RGB8")
    camera.open()
    yield OperatorBench(camera)
    camera.close()


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
def stage_on_sim(stage):
    def build(options="pixel_format=RGB8"):
        camera = sources.create(f"sim:?width=320&height=240&fps=60&{options}")
        camera.open()
        camera.start()
        return stage(camera)

    return build
