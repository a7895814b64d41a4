"""The view without the lens's distortion, checked against the calibration's own model."""

import cv2
import numpy as np
import pytest

from frames import frame_of
from grabbergui.core.calibration import Calibration
from grabbergui.core.pixels import Region
from grabbergui.models.image.display_settings import DisplaySettings
from grabbergui.models.image.rendering import render
from grabbergui.models.image.undistortion import distorted_pixel, undistorted

WIDTH, HEIGHT = 320, 240
MATRIX = np.array([[260.0, 0, 161.0], [0, 262.0, 118.0], [0, 0, 1]])
BARREL = Calibration(WIDTH, HEIGHT, MATRIX, np.array([-0.3, 0.08, 0.001, -0.001, 0.0]))


def spot_at(x, y):
    """A frame that is black but for one pixel's surroundings."""
    pixels = np.zeros((HEIGHT, WIDTH), np.uint8)
    cv2.circle(pixels, (x, y), 3, 255, -1)
    return pixels


def centre(pixels):
    ys, xs = np.nonzero(pixels > 127)
    return xs.mean(), ys.mean()


@pytest.mark.parametrize(("x", "y"), [(160, 120), (60, 40), (300, 200), (20, 220)])
def test_a_pixel_of_the_view_is_the_pixel_of_the_frame_that_the_model_names(x, y):
    column, line = distorted_pixel(BARREL, x, y)
    seen = undistorted(spot_at(column, line), BARREL, Region(0, 0, WIDTH, HEIGHT), (WIDTH, HEIGHT))
    assert centre(seen) == (pytest.approx(x, abs=1.0), pytest.approx(y, abs=1.0))


def test_an_absurd_calibration_shows_pixels_outside_of_the_frame():
    absurd = Calibration(WIDTH, HEIGHT, MATRIX, np.array([1e9, 1e9, 0.0, 0.0, 1e9]))
    column, line = distorted_pixel(absurd, 10, 10)
    assert column < 0 and line < 0


def test_a_part_of_the_view_is_the_same_part_of_all_of_it():
    noise = cv2.GaussianBlur(np.random.default_rng(1).integers(0, 256, (HEIGHT, WIDTH), np.uint8), (0, 0), 2)
    region = Region(200, 100, 80, 60)
    whole = undistorted(noise, BARREL, Region(0, 0, WIDTH, HEIGHT), (WIDTH, HEIGHT))
    part = undistorted(noise, BARREL, region, (80, 60))
    difference = cv2.absdiff(part, whole[100:160, 200:280])
    assert difference.max() <= 1


def test_an_image_is_shown_undistorted():
    frame = frame_of(spot_at(60, 40))
    plain = render(frame, None, None, DisplaySettings())
    shown = render(frame, None, None, DisplaySettings(), calibration=BARREL)
    assert shown.region == plain.region and shown.pixels.shape == plain.pixels.shape
    assert centre(shown.pixels)[0] < 58, "a barrel's corners move outwards"


def test_a_reduced_view_lies_where_the_full_one_does():
    frame = frame_of(spot_at(100, 60))
    full = render(frame, None, None, DisplaySettings(), calibration=BARREL)
    half = render(frame, None, (WIDTH // 2, HEIGHT // 2), DisplaySettings(), calibration=BARREL)
    assert half.pixels.shape == (HEIGHT // 2, WIDTH // 2)
    assert np.array(centre(half.pixels)) * 2 == pytest.approx(np.array(centre(full.pixels)), abs=1.5)
