import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui.core import pfnc, pixels
from grabbergui.core.colour import measured_bounds
from grabbergui.core.pfnc import Family
from grabbergui.core.pixels import Region
from images import frame_of, random_values
from pixel_formats import CONVERTIBLE

GREY = (Family.MONO, Family.COORDINATES)
"What is shown without colour."
regions = st.builds(
    Region, st.integers(-30, 60), st.integers(-30, 60), st.integers(0, 70), st.integers(0, 70)
)


@every_case("pixel_format", CONVERTIBLE, ids=str)
def test_an_unreduced_image_equals_the_frames_own(pixel_format):
    frame = frame_of(random_values(pixel_format, 24, 18), pixel_format)
    whole = frame.mono() if pixel_format.family in GREY else frame.rgb()
    assert np.array_equal(pixels.for_display(frame).pixels, whole)
    if pixel_format.family is Family.SPARSE:
        return  # its margin is wider than this image
    shown = pixels.for_display(frame, Region(5, 3, 9, 8))
    cut = whole[shown.region.y : shown.region.bottom, shown.region.x : shown.region.right]
    assert np.array_equal(shown.pixels, cut)


@given(
    pixel_format=st.sampled_from(CONVERTIBLE),
    width=st.integers(1, 40),
    height=st.integers(1, 40),
    region=st.none() | regions,
    size=st.none() | st.tuples(st.integers(1, 50), st.integers(1, 50)),
)
def test_any_region_at_any_size(pixel_format, width, height, region, size):
    frame = frame_of(random_values(pixel_format, width, height), pixel_format)
    shown = pixels.for_display(frame, region, size)
    covered = shown.region
    assert 0 <= covered.x < covered.right <= width
    assert 0 <= covered.y < covered.bottom <= height
    rows, columns = shown.pixels.shape[:2]
    assert shown.pixels.dtype == np.uint8 and shown.pixels.flags.c_contiguous
    assert shown.pixels.ndim == (2 if pixel_format.family in GREY else 3)
    assert 1 <= columns <= min(covered.width, size[0] if size else width)
    assert 1 <= rows <= min(covered.height, size[1] if size else height)


@every_case("name", ["Mono8", "Mono12p", "BayerRG8", "BayerGB12p", "BGR8", "YUV422_8"])
@every_case("size", [(200, 200), (63, 100), (31, 31), (16, 5)])
def test_a_reduced_image_looks_like_the_image(name, size):
    """A brightness ramp, so smooth that every honest reduction gives nearly the same."""
    pixel_format = pfnc.by_name(name)
    ramp = np.linspace(20, 230, 128)[None, :] * np.linspace(0.5, 1, 96)[:, None]
    values = (ramp * (1 << pixel_format.depth - 8)).astype(int)
    if pixel_format.components > 1:
        values = np.stack([values] * pixel_format.components, axis=-1)
    if pixel_format.family is Family.YUV:
        values[..., 1] = 128
    shown = pixels.for_display(frame_of(values, pixel_format), size=size)
    rows, columns = shown.pixels.shape[:2]
    assert shown.region == Region(0, 0, 128, 96)
    assert columns / rows == pytest.approx(128 / 96, rel=0.15)
    grey = shown.pixels if shown.pixels.ndim == 2 else shown.pixels.mean(axis=2)
    for row in range(rows):
        for column in range(columns):
            y, x = (row + 0.5) * 96 / rows - 0.5, (column + 0.5) * 128 / columns - 0.5
            assert grey[row, column] == pytest.approx(np.interp(x, range(128), ramp[round(y)]), abs=8)


def test_halving_averages_four_pixels():
    values = np.array([[0, 100, 8, 8], [100, 200, 8, 8]])
    shown = pixels.for_display(frame_of(values, pfnc.by_name("Mono8")), size=(2, 1))
    assert shown.pixels.tolist() == [[100, 8]]


def test_a_bayer_cell_becomes_one_pixel():
    values = np.array([[10, 20, 50, 60], [30, 40, 70, 80]])
    shown = pixels.for_display(frame_of(values, pfnc.by_name("BayerRG8")), size=(2, 1))
    assert shown.pixels.tolist() == [[[10, 25, 40], [50, 65, 80]]]


def test_a_region_outside_becomes_the_nearest_pixel():
    assert Region(500, -9, 10, 5).clipped(20, 10) == Region(19, 0, 1, 1)
    assert Region(-5, -5, 10, 10).clipped(20, 10) == Region(0, 0, 5, 5)
    assert Region(2, 3, 4, 5).clipped(20, 10) == Region(2, 3, 4, 5)


def test_black_stays_black_without_a_bayer_pattern():
    black = frame_of(np.zeros((8, 8), int), pfnc.by_name("SCF1WBWG8"))
    assert not black.rgb().any() and not black.mono().any()


def test_bounds_are_those_of_finite_values():
    assert measured_bounds(np.array([3.0, np.nan, -2.0, np.inf])) == (-2.0, 3.0)
    assert measured_bounds(np.array([np.nan])) == (0.0, 1.0)
    assert measured_bounds(np.array([7, 9], np.uint16)) == (7.0, 9.0)
