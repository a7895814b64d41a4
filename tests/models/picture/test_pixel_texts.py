import numpy as np

from frames import frame_of
from grabbergui.core.region import Region
from grabbergui.models.picture.geometry import Orientation
from grabbergui.models.picture.rendering import value_texts


def test_each_pixel_has_the_sensors_value_where_it_is_seen():
    picture = np.arange(100, dtype=np.uint16).reshape(10, 10) * 40
    frame = frame_of(picture, "Mono12")
    texts = value_texts(frame, Region(2, 3, 2, 1), Orientation())
    assert texts == {(2, 3): str(picture[3, 2]), (3, 3): str(picture[3, 3])}
    turned = value_texts(frame, Region(0, 0, 1, 1), Orientation(1))
    assert turned == {(0, 0): str(picture[9, 0])}


def test_colour_has_a_line_for_each_component():
    frame = frame_of(np.array([[[3, 2, 1]]], np.uint8), "BGR8")
    assert value_texts(frame, Region(0, 0, 1, 1), Orientation()) == {(0, 0): "1\n2\n3"}


def test_nothing_is_written_on_a_large_region_or_an_unreadable_frame():
    frame = frame_of(np.zeros((100, 100), np.uint8))
    assert value_texts(frame, Region(0, 0, 100, 100), Orientation()) == {}
    frame.payload = frame.payload[:5]
    assert value_texts(frame, Region(0, 0, 3, 3), Orientation()) == {}
