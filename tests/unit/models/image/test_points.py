"""Points on pixels: where the camera sees them, from elsewhere, the nearest in front."""

import numpy as np
import pytest

from grabbergui.core.point_cloud import PointCloud
from grabbergui.models.image.points import BACKGROUND, Viewpoint, draw


def drawn(points, colours, view=None):
    cloud = PointCloud(np.array(points, np.float32), np.array(colours, np.uint8))
    return draw(cloud, view or Viewpoint(), (100, 80)).pixels


SQUARE = [[-1, -1, 5], [1, -1, 5], [-1, 1, 5], [1, 1, 5]]
COLOURS = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 0]]


def place(pixels, colour):
    lines, columns = np.nonzero((pixels == colour).all(axis=2))
    assert len(lines) == 1
    return int(columns[0]), int(lines[0])


def test_from_the_camera_x_is_right_and_y_is_down():
    pixels = drawn(SQUARE, COLOURS)
    (left, top), (right, _), (_, bottom), _ = (place(pixels, colour) for colour in COLOURS)
    assert left < 50 < right and top < 40 < bottom
    assert (pixels == BACKGROUND).all(axis=2).sum() == 100 * 80 - 4


def test_of_points_on_one_pixel_the_nearest_is_seen():
    points = [[0, 0, 4], [0, 0, 6], [0, 0, 5], [-1, 0, 5], [1, 0, 5]]
    pixels = drawn(points, [[1, 2, 3], [9, 9, 9], [8, 8, 8], [7, 7, 7], [6, 6, 6]])
    assert place(pixels, [1, 2, 3]) == (50, 40)
    assert not (pixels == 9).all(axis=2).any()


def test_half_a_turn_exchanges_left_and_right():
    before = place(drawn(SQUARE, COLOURS), COLOURS[0])[0]
    after = place(drawn(SQUARE, COLOURS, Viewpoint(yaw=180.0)), COLOURS[0])[0]
    assert before < 50 < after


def test_a_viewpoint_stays_within_what_can_be_looked_at():
    view = Viewpoint().turned(350, 200).turned(20, 0).zoomed(1e9)
    assert (view.yaw, view.pitch, view.zoom) == (10.0, 89.0, 20.0)


@pytest.mark.parametrize("count", [0, 1])
def test_few_points_and_none(count):
    pixels = draw(PointCloud(np.ones((count, 3), np.float32)), Viewpoint(), (20, 10)).pixels
    assert pixels.shape == (10, 20, 3)
