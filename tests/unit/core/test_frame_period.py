"""The frame period by a camera's features."""

import pytest

from fakes import ScriptedGrabber
from grabbergui.core.errors import FeatureAccessError
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.core.frame_period import FRAME_WAIT, frame_period, frame_rate, frame_wait, microseconds


def camera(**values):
    units = {"ExposureTime": "us", "ExposureTimeAbs": "ms"}
    return ScriptedGrabber(
        Feature(
            name=name,
            kind=FeatureKind.FLOAT,
            access=AccessMode.READ_WRITE,
            value=value,
            unit=units.get(name, "Hz"),
        )
        for name, value in values.items()
    )


@pytest.mark.parametrize(
    ("features", "hertz"),
    [
        ({}, 0),
        ({"AcquisitionFrameRate": 25.0}, 25),
        ({"AcquisitionFrameRate": -1.0}, 0),
        ({"AcquisitionLineRate": 5000.0, "Height": 100}, 50),
        ({"AcquisitionLineRate": 5000.0, "Height": 1}, 5000),
        ({"AcquisitionLineRate": 5000.0, "Height": 0}, 0),
        ({"AcquisitionFrameRate": True}, 0),
    ],
)
def test_the_frame_rate_is_that_of_frames_and_never_negative(features, hertz):
    assert frame_rate(camera(**features)) == hertz


def test_a_rate_that_cannot_be_read_is_none():
    blind = camera(AcquisitionFrameRate=25.0)
    blind.failures["AcquisitionFrameRate"] = FeatureAccessError("not now", "AcquisitionFrameRate")
    assert frame_rate(blind) == 0 and frame_wait(blind) == FRAME_WAIT


def test_the_period_is_the_longer_of_rate_and_exposure():
    assert frame_period(camera(AcquisitionFrameRate=4.0, ExposureTime=1e5)) == 0.25
    assert frame_period(camera(AcquisitionFrameRate=4.0, ExposureTime=5e5)) == 0.5
    assert frame_period(camera(ExposureTimeAbs=20.0)) == pytest.approx(0.02)
    assert frame_period(camera(Gain=1.0)) == 0
    assert frame_wait(camera(AcquisitionFrameRate=4.0), least=3.0) == 3.5


def test_units_of_time_are_read_in_any_spelling():
    assert [microseconds(unit) for unit in ("us", " MS ", "s", "Hz")] == [1, 1e3, 1e6, None]
