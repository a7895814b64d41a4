"""Features under YARP's numbers: the unit is SFNC's, whatever the camera counts in."""

from __future__ import annotations

import pytest

from every_case import every_case
from fakes import ScriptedGrabber
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.net.numbered_features import FeatureId, NumberedFeatures


def exposure(unit: str, value: float = 0.02, low: float = 0.001, high: float = 10.0) -> ScriptedGrabber:
    return ScriptedGrabber([
        Feature(
            name="ExposureTime",
            kind=FeatureKind.FLOAT,
            access=AccessMode.READ_WRITE,
            value=value,
            minimum=low,
            maximum=high,
            unit=unit,
        )
    ])  # fmt: skip


@every_case(("unit", "factor"), [("s", 1e6), ("ms", 1e3), ("us", 1), ("", 1), ("ticks", 1)])
@every_case("number", [FeatureId.EXPOSURE, FeatureId.SHUTTER])
def test_an_exposure_time_is_in_microseconds(unit, factor, number):
    camera = exposure(unit)
    features = NumberedFeatures(camera)

    assert features.value(number) == pytest.approx(0.02 * factor)
    assert features.values(number) == pytest.approx((0.001 * factor, 10 * factor))
    features.set_value(number, 0.5 * factor)
    assert camera.known["ExposureTime"].value == pytest.approx(0.5)
    assert features.feature(number).unit == ("us" if factor != 1 else unit)


def test_normalised_values_are_places_in_the_range():
    camera = exposure("s", value=0.5, low=0.0, high=1.0)
    features = NumberedFeatures(camera, normalised=True)

    assert features.value(FeatureId.EXPOSURE) == pytest.approx(0.5)
    features.set_value(FeatureId.EXPOSURE, 0.25)
    assert camera.known["ExposureTime"].value == pytest.approx(0.25)
