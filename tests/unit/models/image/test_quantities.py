"""Distances and polarisation in false colour: the scale, its range, and where nothing was measured."""

import numpy as np
import pytest

from frames import frame_of
from grabbergui.core.coord3d import Coordinate, Scan3d
from grabbergui.core.pixels import Region
from grabbergui.models.image.display_settings import DisplaySettings
from grabbergui.models.image.quantities import NO_DATA, ColourScale, Levels, PolarisedView, quantity_of
from grabbergui.models.image.rendering import render

TENTHS = Scan3d(True, (Coordinate(), Coordinate(), Coordinate(0.1, 0.0, 0.0)))
SLOPE = np.linspace(5000, 25000, 64 * 64).astype(np.uint16).reshape(64, 64)


def depth(values=SLOPE):
    return frame_of(values, "Coord3D_C16")


def test_light_is_no_quantity():
    for name in ("Mono8", "BayerRG8"):
        assert quantity_of(frame_of(np.zeros((4, 4), np.uint8), name)) is None
    view = PolarisedView.DEGREE
    assert quantity_of(frame_of(np.zeros((4, 4), np.uint8), "BayerRG8"), view=view) is None


def test_the_colours_go_from_the_nearest_to_the_farthest_in_round_millimetres_without_outliers():
    values = SLOPE.copy()
    values[::8] = 0
    values[1, 1] = 65535
    scale = quantity_of(depth(values), TENTHS).scale
    assert (scale.low, scale.high, scale.unit) == (400.0, 2600.0, "mm")
    assert scale.ticks == (500.0, 1000.0, 1500.0, 2000.0, 2500.0)
    assert scale.text(scale.ticks[0]) == "500"


def test_the_scale_holds_still_while_the_scene_moves_a_little():
    scales = {quantity_of(depth(SLOPE + shift), TENTHS).scale for shift in range(0, 400, 50)}
    assert len(scales) == 1


def test_colours_are_those_of_the_scale():
    image = render(depth(), None, None, DisplaySettings(scan=TENTHS))
    scale = quantity_of(depth(), TENTHS).scale
    for y, x in ((0, 0), (31, 17), (63, 63)):
        place = int((SLOPE[y, x] * 0.1 - scale.low) / (scale.high - scale.low) * 255)
        assert np.abs(image.pixels[y, x].astype(int) - scale.colours[place]).max() < 8


def test_missing_measurements_are_hatched_in_grey_in_every_size_and_map():
    values = SLOPE.copy()
    values[16:32, 16:32] = 0
    for colour_map in ("", "Bone"):
        for size in (None, (32, 32)):
            settings = DisplaySettings(scan=TENTHS, colour_map=colour_map)
            pixels = render(depth(values), Region(16, 16, 16, 16), size, settings).pixels
            assert set(pixels.reshape(-1).tolist()) == set(NO_DATA)
    nothing = render(depth(np.zeros((8, 8), np.uint16)), None, None, DisplaySettings())
    assert set(nothing.pixels.reshape(-1).tolist()) == set(NO_DATA)


def test_reducing_leaves_distances_out_and_invents_none_between_two():
    edge = np.where(np.arange(64) < 32, 5000, 25000).astype(np.uint16)
    pixels = render(depth(np.tile(edge, (64, 1))), None, (21, 21), DisplaySettings(scan=TENTHS)).pixels
    assert pixels.shape == (21, 21, 3)
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) == 2


def test_a_region_is_coloured_as_in_the_whole_image():
    settings = DisplaySettings(scan=TENTHS)
    whole = render(depth(), None, None, settings).pixels
    part = render(depth(), Region(10, 20, 30, 5), None, settings)
    assert part.region == Region(10, 20, 30, 5)
    assert np.array_equal(part.pixels, whole[20:25, 10:40])


def test_levels_that_somebody_set_are_fractions_of_the_sensors_range():
    scale = quantity_of(depth(), TENTHS, levels=Levels(10000 / 65535, 20000 / 65535)).scale
    assert (scale.low, scale.high) == pytest.approx((1000.0, 2000.0))


def test_points_are_coloured_by_their_distance():
    points = np.dstack([SLOPE * 0, SLOPE * 0, SLOPE]).astype(np.float32)
    quantity = quantity_of(frame_of(points, "Coord3D_ABC32f"), TENTHS)
    assert quantity.value_at(63, 63) == pytest.approx(2500)
    assert quantity.scale.low < 500 < 2500 <= quantity.scale.high


@pytest.mark.parametrize(
    ("view", "value", "text"),
    [(PolarisedView.DEGREE, 0.5, "0.500"), (PolarisedView.ANGLE, 30.0, "30.0°")],
)
def test_a_polarised_mosaic_as_degree_and_angle(view, value, text):
    filters = np.array([[90.0, 45.0], [135.0, 0.0]])
    cell = 1000 * (1 + 0.5 * np.cos(np.radians(2 * (filters - 30))))
    frame = frame_of(np.tile(cell, (6, 8)).astype(np.uint16), "Mono12")
    quantity = quantity_of(frame, view=view)
    assert quantity.value_at(15, 11) == pytest.approx(value, rel=0.01)
    assert quantity.text_at(3, 4, "") == text or abs(quantity.value_at(3, 4) - value) < 0.05
    image = render(frame, None, None, DisplaySettings(polarised=view))
    assert image.region == Region(0, 0, 16, 12) and image.pixels.shape == (6, 8, 3)
    part = render(frame, Region(3, 3, 2, 2), None, DisplaySettings(polarised=view))
    assert part.region == Region(2, 2, 4, 4), "whole cells"


def test_the_intensity_of_a_polarised_mosaic_is_grey_of_the_same_size():
    mosaic = np.tile(np.array([[10, 20], [30, 40]], np.uint8), (3, 4))[:5]
    image = render(frame_of(mosaic), None, None, DisplaySettings(polarised=PolarisedView.INTENSITY))
    assert image.pixels.shape == (5, 8)
    assert set(image.pixels.reshape(-1).tolist()) == {25}


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (0.0, 180.0), (612.0, 613.0), (-5000.0, 70000.0)])
def test_a_scale_has_a_few_round_ticks_whose_texts_differ(low, high):
    scale = ColourScale(low, high, "mm", "Turbo")
    texts = [scale.text(tick) for tick in scale.ticks]
    assert 3 <= len(texts) <= 7 and len(set(texts)) == len(texts)
    assert all(low <= tick <= high for tick in scale.ticks)
