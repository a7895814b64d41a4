"""An operator at work on a made-up camera, and on the simulated one."""

import pytest
from operator_bench import Bench

from fakes import ScriptedGrabber
from grabbergui import sources
from grabbergui.core.features import AccessMode, Feature, FeatureKind


def number(name, value=1.0, **more):
    fields = {"minimum": 0.0, "maximum": 100.0, "access": AccessMode.READ_WRITE, **more}
    return Feature(name=name, kind=FeatureKind.FLOAT, value=value, **fields)


@pytest.fixture
def bench():
    return Bench(ScriptedGrabber([number("Gain"), number("Gamma"), number("Exposure", unit="us")]))


@pytest.fixture
def sim():
    camera = sources.create("sim:?width=64&height=64&pixel_format=RGB8")
    camera.open()
    yield Bench(camera)
    camera.close()
