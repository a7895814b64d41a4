"""An operator on a made-up camera, and one on the simulated camera."""

import pytest

from fakes import ScriptedGrabber
from grabbergui import sources
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from operator_bench import Bench


def number(name, value=1.0, **more):
    fields = {"minimum": 0.0, "maximum": 100.0, "access": AccessMode.READ_WRITE, **more}
    return Feature(name=name, kind=FeatureKind.FLOAT, value=value, **fields)


@pytest.fixture
def operator():
    """An operator on a made-up camera."""
    return Bench(ScriptedGrabber([number("Gain"), number("Gamma"), number("Exposure", unit="us")]))


@pytest.fixture
def sim():
    """An operator on the simulated camera."""
    camera = sources.create("sim:?width=64&height=64&pixel_format=RGB8")
    camera.open()
    yield Bench(camera)
    camera.close()
