import numpy as np

from frames import frame_of
from grabbergui.core.coord3d import Coordinate, Scan3d
from grabbergui.core.pixels import DisplayImage, Region
from grabbergui.models.image.components import ShownImage
from grabbergui.models.image.display_settings import DisplaySettings
from grabbergui.models.image.orientation import Orientation
from grabbergui.models.image.pixel_text import TintedPart, cursor_text, plain_text, value_texts
from grabbergui.models.image.rendering import render


def texts_of(frame, region, orientation):
    settings = DisplaySettings(orientation=orientation)
    image = DisplayImage(np.zeros((1, 1), np.uint8), region)
    return plain(value_texts(ShownImage(frame, image, 0, 0, quantity=settings.quantity(frame)), settings))


def plain(texts):
    return {pixel: plain_text(lines, "\n") for pixel, lines in texts.items()}


def at(image, pixel, settings):
    return plain_text(cursor_text(image, pixel, settings))


def test_each_pixel_has_the_sensors_value_where_it_is_seen():
    image = np.arange(100, dtype=np.uint16).reshape(10, 10) * 40
    frame = frame_of(image, "Mono12")
    texts = texts_of(frame, Region(2, 3, 2, 1), Orientation())
    assert texts == {(2, 3): str(image[3, 2]), (3, 3): str(image[3, 3])}
    turned = texts_of(frame, Region(0, 0, 1, 1), Orientation(1))
    assert turned == {(0, 0): str(image[9, 0])}


def test_colour_has_a_line_for_each_component():
    frame = frame_of(np.array([[[3, 2, 1]]], np.uint8), "BGR8")
    assert texts_of(frame, Region(0, 0, 1, 1), Orientation()) == {(0, 0): "1\n2\n3"}


def test_nothing_is_written_on_a_large_region_or_an_unreadable_frame():
    frame = frame_of(np.zeros((100, 100), np.uint8))
    assert texts_of(frame, Region(0, 0, 100, 100), Orientation()) == {}
    frame.payload = frame.payload[:5]
    assert texts_of(frame, Region(0, 0, 3, 3), Orientation()) == {}


def test_a_distance_is_read_in_millimetres_with_the_sensors_value_behind_it():
    frame = frame_of(np.array([[0, 12345]], np.uint16), "Coord3D_C16")
    settings = DisplaySettings(scan=Scan3d(True, (Coordinate(), Coordinate(), Coordinate(0.1, 0, 0))))
    image = ShownImage(frame, render(frame, None, None, settings), 2, 1, quantity=settings.quantity(frame))
    assert at(image, (1, 0), settings) == "x 1  y 0   1234.5 mm  (12345)"
    assert at(image, (0, 0), settings) == "x 0  y 0   no data  (0)"
    assert at(image, (2, 0), settings) == "x 2  y 0"
    assert plain(value_texts(image, settings)) == {(0, 0): "–", (1, 0): "1234.5\nmm"}


def test_light_is_read_as_the_sensor_gave_it():
    frame, settings = frame_of(np.array([[7]], np.uint8)), DisplaySettings()
    image = ShownImage(frame, render(frame, None, None, settings), 1, 1)
    assert at(image, (0, 0), settings) == "x 0  y 0   mono 7"


def test_a_bayer_pattern_is_read_with_its_channel_and_the_interpolated_colour():
    values = np.array([[10, 20, 12], [30, 40, 32], [14, 24, 16]], np.uint8)  # R G R, G B G, R G R
    frame, settings = frame_of(values, "BayerRG8"), DisplaySettings()
    image = ShownImage(frame, render(frame, None, None, settings), 3, 3)
    assert at(image, (1, 1), settings) == "x 1  y 1   bayer B 40   (R 13, G 26, B 40)"
    assert at(image, (0, 0), settings) == "x 0  y 0   bayer R 10   (R 10, G 25, B 40)"
    assert at(image, (1, 0), settings) == "x 1  y 0   bayer G 20   (R 11, G 20, B 40)"
    tinted = {part.channel: part.text for part in cursor_text(image, (1, 1), settings) if part.channel}
    assert tinted == {"B": "B 40", "R": "R 13", "G": "G 26"}


def test_the_values_on_pixels_have_their_channels():
    mosaic = frame_of(np.zeros((2, 2), np.uint8), "BayerGB8")
    colour = frame_of(np.array([[[1, 2, 3, 4]]], np.uint8), "RGBa8")
    settings = DisplaySettings()
    for frame, channels in ((mosaic, ["G", "B", "R", "G"]), (colour, ["R", "G", "B", ""])):
        whole = Region(0, 0, frame.width, frame.height)
        shown = ShownImage(frame, DisplayImage(np.zeros((1, 1), np.uint8), whole), 0, 0)
        parts = [part for lines in value_texts(shown, settings).values() for part in lines]
        assert [part.channel for part in parts] == channels
    assert parts[0] == TintedPart("1", "R")
