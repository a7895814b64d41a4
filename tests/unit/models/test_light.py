"""The light of a region: its mean, what is saturated, its colours."""

import numpy as np
import pytest

from frames import frame_of
from grabbergui.core.pixels import Region
from grabbergui.models.light import measure_light


@pytest.mark.parametrize(("name", "dtype", "white"), [("Mono8", np.uint8, 255), ("Mono12", np.uint16, 4095)])
def test_light_is_measured_in_the_region_alone(name, dtype, white):
    pixels = np.zeros((40, 60), dtype)
    pixels[10:20, 20:40] = white // 2
    pixels[10:15, 20:40] = white
    light = measure_light(frame_of(pixels, name), Region(20, 10, 20, 10))
    assert light.mean == pytest.approx(0.75, abs=0.01)
    assert light.saturated == 0.5
    assert not light.coloured
    assert measure_light(frame_of(pixels, name)).mean == pytest.approx(0.75 * 200 / 2400, abs=0.01)


@pytest.mark.parametrize("order", ["RG", "GR", "GB", "BG"])
def test_the_colours_of_a_mosaic_are_separated_for_every_origin_of_the_region(order):
    planes = {"R": 200, "G": 100, "B": 50}
    second = {"RG": "GB", "BG": "GR", "GR": "BG", "GB": "RG"}[order]
    pixels = np.empty((20, 20), np.uint8)
    for line, colours in enumerate((order, second)):
        for column, name in enumerate(colours):
            pixels[line::2, column::2] = planes[name]
    for region in (Region(0, 0, 20, 20), Region(7, 5, 4, 6), Region(19, 19, 1, 1)):
        light = measure_light(frame_of(pixels, f"Bayer{order}8"), region)
        assert {name: round(mean * 255) for name, mean in light.channels.items()} == planes
