import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui.core.pixels import Region
from grabbergui.models.image.orientation import Orientation

ALL = [Orientation(turns, x, y) for turns in range(4) for x in (False, True) for y in (False, True)]
IMAGE = np.arange(12, dtype=np.uint8).reshape(3, 4)


@every_case("orientation", ALL, ids=str)
def test_every_pixel_is_where_the_view_shows_it(orientation):
    view = orientation.applied(IMAGE)
    height, width = view.shape
    assert (width, height) == orientation.view_size(4, 3)
    for y in range(height):
        for x in range(width):
            column, line = orientation.pixel(x, y, 4, 3)
            assert IMAGE[line, column] == view[y, x]
            assert orientation.to_view(Region(column, line, 1, 1), 4, 3) == Region(x, y, 1, 1)


@given(st.sampled_from(ALL), st.integers(0, 30), st.integers(0, 20), st.integers(1, 9), st.integers(1, 9))
def test_regions_go_there_and_back(orientation, x, y, width, height):
    region = Region(x, y, width, height)
    assert orientation.to_frame(orientation.to_view(region, 40, 30), 40, 30) == region


@every_case("orientation", ALL, ids=str)
def test_mirroring_and_turning_act_on_the_view(orientation):
    seen = orientation.applied(IMAGE)
    assert np.array_equal(orientation.mirrored(x=True).applied(IMAGE), seen[:, ::-1])
    assert np.array_equal(orientation.mirrored(y=True).applied(IMAGE), seen[::-1])
    assert np.array_equal(orientation.turned(1).applied(IMAGE), np.rot90(seen, -1))
    assert np.array_equal(orientation.turned(-1).applied(IMAGE), np.rot90(seen))


def test_colour_keeps_its_components():
    rgb = np.dstack([IMAGE, IMAGE + 100, IMAGE + 200])
    turned = Orientation(1).applied(rgb)
    assert turned.shape == (4, 3, 3)
    assert turned[0, 0].tolist() == [8, 108, 208]
