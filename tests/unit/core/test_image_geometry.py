"""Where images lie on the sensor."""

import pytest

from grabbergui.core.errors import UsageError
from grabbergui.core.image_geometry import LARGEST_OFFSET, ImageGeometry


@pytest.mark.parametrize(
    ("whole", "more"),
    [
        ((0, 480), {}),
        ((640, 0), {}),
        ((640, 480), {"binning": (0, 1)}),
        ((640, 480), {"offset": (-1, 0)}),
        ((640, 480), {"offset": (0, LARGEST_OFFSET + 1)}),
    ],
)
def test_an_impossible_geometry_is_refused(whole, more):
    with pytest.raises(UsageError, match=f"at most {whole[0]}×{whole[1]} pixels"):
        ImageGeometry(whole, **more)


def test_the_largest_and_the_smallest_are_possible():
    assert ImageGeometry((1, 1)).sensor == (1, 1)
    assert ImageGeometry((640, 480), offset=(LARGEST_OFFSET, 0)).offset[0] == LARGEST_OFFSET


def test_the_same_sensor_with_a_rest_that_binning_leaves_over():
    assert ImageGeometry((320, 240), binning=(2, 2)).sensor == (640, 480)
    whole = ImageGeometry((641, 481))
    assert whole.same_sensor(ImageGeometry((320, 240), binning=(2, 2)))
    assert whole.same_sensor(ImageGeometry((213, 160), binning=(3, 3)))
    assert not whole.same_sensor(ImageGeometry((640, 481)))
    assert not whole.same_sensor(ImageGeometry((319, 240), binning=(2, 2)))
