import numpy as np

from frames import frame_of
from grabbergui.core.coord3d import Coordinate, Scan3d
from grabbergui.core.pixels import DisplayImage, Region
from grabbergui.models.image.components import ShownImage
from grabbergui.models.image.display_settings import DisplaySettings
from grabbergui.models.image.orientation import Orientation
from grabbergui.models.image.pixel_text import cursor_text, value_texts
from grabbergui.models.image.rendering import render


def texts_of(frame, region, orientation):
    settings = DisplaySettings(orientation=orientation)
    image = DisplayImage(np.zeros((1, 1), np.uint8), region)
    return value_texts(ShownImage(frame, image, 0, 0, quantity=settings.quantity(frame)), settings)


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
    assert cursor_text(image, (1, 0), settings) == "x 1  y 0   1234.5 mm  (12345)"
    assert cursor_text(image, (0, 0), settings) == "x 0  y 0   no data  (0)"
    assert cursor_text(image, (2, 0), settings) == "x 2  y 0"
    assert value_texts(image, settings) == {(0, 0): "–", (1, 0): "1234.5\nmm"}


def test_light_is_read_as_the_sensor_gave_it():
    frame, settings = frame_of(np.array([[7]], np.uint8)), DisplaySettings()
    image = ShownImage(frame, render(frame, None, None, settings), 1, 1)
    assert cursor_text(image, (0, 0), settings) == "x 0  y 0   mono 7"
