import numpy as np
import pytest

from frames import frame_of
from grabbergui.core.pixels import Region, for_display
from grabbergui.models.image.clipping import BLACK_COLOUR, SATURATED_COLOUR, clipping_masks
from grabbergui.models.image.display_settings import DisplaySettings, with_levels
from grabbergui.models.image.orientation import Orientation
from grabbergui.models.image.quantities import COLOUR_MAPS, Levels
from grabbergui.models.image.rendering import render

RAMP = np.arange(4096, dtype=np.uint16).reshape(64, 64)


def test_without_settings_the_image_is_the_frame():
    frame = frame_of(np.arange(64, dtype=np.uint8).reshape(8, 8))
    image = render(frame, None, None, DisplaySettings())
    assert np.array_equal(image.pixels, for_display(frame).pixels)


def test_levels_of_deep_pixels_show_all_gradations_between_them():
    frame = frame_of(RAMP, "Mono12")
    settings = DisplaySettings(levels=Levels(1000 / 4095, 1255 / 4095))
    pixels = render(frame, None, None, settings).pixels.reshape(-1)
    assert set(pixels[:1001]) == {0} and set(pixels[1255:]) == {255}
    assert pixels[1000:1256].tolist() == list(range(256))


@pytest.mark.parametrize("order", ["RG", "GR", "BG", "GB"])
def test_levels_of_a_deep_mosaic_keep_its_colours(order):
    mosaic = np.full((16, 16), 1000, np.uint16)
    image = render(frame_of(mosaic, f"Bayer{order}12"), None, None, DisplaySettings(levels=Levels(0, 0.5)))
    assert image.pixels.shape == (16, 16, 3)
    assert set(image.pixels.reshape(-1)) == {125}


def test_levels_of_eight_bits_stretch_what_is_shown():
    frame = frame_of(np.array([[50, 100, 150, 200]], np.uint8))
    pixels = render(frame, None, None, DisplaySettings(levels=Levels(100 / 255, 150 / 255))).pixels
    assert pixels.tolist() == [[0, 0, 255, 255]]


@pytest.mark.parametrize(("black", "white"), [(-1, 2), (0.9, 0.1), (1, 1), (0, 0)])
def test_levels_stay_apart_and_within_the_range(black, white):
    levels = with_levels(DisplaySettings(), black, white).levels
    assert 0 <= levels.black < levels.white <= 1


@pytest.mark.parametrize("name", COLOUR_MAPS)
def test_colour_maps_colour_grey_and_leave_colour_alone(name):
    settings = DisplaySettings(colour_map=name)
    pixels = render(frame_of(np.arange(256, dtype=np.uint8).reshape(16, 16)), None, None, settings).pixels
    assert pixels.shape == (16, 16, 3)
    assert len({tuple(p) for p in pixels.reshape(-1, 3).tolist()}) > 100
    assert int(pixels[15, 15].sum()) > int(pixels[0, 0].sum()) or name in ("Turbo", "Jet")
    rgb = frame_of(np.full((4, 4, 3), 7, np.uint8), "RGB8")
    assert set(render(rgb, None, None, settings).pixels.reshape(-1)) == {7}


def test_a_map_is_in_the_order_of_the_screen():
    """Inferno is orange below its bright end: more red than blue."""
    settings = DisplaySettings(colour_map="Inferno")
    pixels = render(frame_of(np.full((2, 2), 200, np.uint8)), None, None, settings).pixels
    assert pixels[0, 0, 0] > pixels[0, 0, 2]


def test_one_clipped_pixel_of_a_large_image_is_seen_when_it_is_reduced():
    pixels = np.full((1000, 1000), 90, np.uint8)
    pixels[333, 444], pixels[700, 100] = 255, 0
    image = render(frame_of(pixels), None, (100, 100), DisplaySettings(show_clipping=True))
    assert image.pixels.shape == (100, 100, 3)
    assert tuple(image.pixels[33, 44]) == SATURATED_COLOUR
    assert tuple(image.pixels[70, 10]) == BLACK_COLOUR
    assert tuple(image.pixels[50, 50]) == (90, 90, 90)


@pytest.mark.parametrize(
    ("pixel_format", "pixels", "black", "saturated"),
    [
        ("Mono12", np.array([[0, 4095, 7]], np.uint16), [1, 0, 0], [0, 1, 0]),
        ("BGR8", np.array([[[0, 0, 0], [0, 0, 255], [0, 9, 9]]], np.uint8), [1, 0, 0], [0, 1, 0]),
        ("YUV422_8", np.array([[[0, 9], [255, 0]]], np.uint8), [1, 0], [0, 1]),
    ],
)
def test_what_counts_as_clipped(pixel_format, pixels, black, saturated):
    frame = frame_of(pixels, pixel_format)
    low, high = clipping_masks(frame, Region(0, 0, frame.width, frame.height))
    assert (low[0] > 0).tolist() == [bool(flag) for flag in black]
    assert (high[0] > 0).tolist() == [bool(flag) for flag in saturated]


def test_a_region_of_a_turned_view_is_that_of_the_frame():
    image = np.arange(200, dtype=np.uint8).reshape(10, 20)
    orientation = Orientation(1, mirrored_x=True)
    whole = render(frame_of(image), None, None, DisplaySettings(orientation=orientation))
    assert whole.region == Region(0, 0, 10, 20)
    part = render(frame_of(image), Region(2, 3, 4, 5), None, DisplaySettings(orientation=orientation))
    assert part.region == Region(2, 3, 4, 5)
    assert np.array_equal(part.pixels, whole.pixels[3:8, 2:6])
