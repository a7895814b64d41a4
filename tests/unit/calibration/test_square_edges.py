"""Corners of markers in images whose truth is known: blurred, noisy, bent by a lens, half hidden."""

import cv2
import numpy as np
import pytest

from grabbergui.calibration.markers import ArucoDetector
from grabbergui.calibration.square_edges import intersected
from grabbergui.core.calibration import Calibration

SIZE = 0.1
WIDTH, HEIGHT, FOCAL = 640, 480, 600.0
SUPERSAMPLED = 4
SQUARE = np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]]) * SIZE / 2
MATRIX = np.array([[FOCAL, 0, WIDTH / 2 - 0.5], [0, FOCAL, HEIGHT / 2 - 0.5], [0, 0, 1]])


def paper():
    """A sheet of 1000 pixels with a marker of 600 in its middle."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    sheet = np.full((1000, 1000), 235, np.uint8)
    sheet[200:800, 200:800] = 20 + 215 * (cv2.aruco.generateImageMarker(dictionary, 3, 600) // 255)
    return sheet


def pictured(turn, place, *, blur, k1=0.0, noise=2.0):
    """A grey image of the sheet, and where the black square's corners are in it."""
    scale = SIZE / 600
    on_sheet = np.array([[scale, 0, -499.5 * scale], [0, -scale, 499.5 * scale], [0, 0, 1]])
    turned = cv2.Rodrigues(np.array([np.pi, 0, 0]))[0] @ cv2.Rodrigues(np.array(turn, float))[0]
    place = np.array(place, float)
    seen = np.linalg.inv(np.column_stack([turned[:, 0], turned[:, 1], place]) @ on_sheet)
    fine = (np.indices((HEIGHT * SUPERSAMPLED, WIDTH * SUPERSAMPLED))[::-1] + 0.5) / SUPERSAMPLED - 0.5
    pixels = fine.reshape(2, -1).T
    if k1:
        rays = cv2.undistortPoints(pixels[:, None], MATRIX, np.array([k1, 0, 0, 0.0]))[:, 0]
    else:
        rays = (pixels - MATRIX[:2, 2]) / FOCAL
    texture = seen @ np.column_stack([rays, np.ones(len(rays))]).T
    x, y = ((texture[:2] / texture[2]).astype(np.float32)).reshape(2, *fine.shape[1:])
    image = cv2.remap(paper(), x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=200)
    image = cv2.GaussianBlur(image, (0, 0), blur * SUPERSAMPLED)
    image = cv2.resize(image, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA).astype(float)
    image += np.random.default_rng(1).normal(0, noise, image.shape)
    corners, _ = cv2.projectPoints(SQUARE, cv2.Rodrigues(turned)[0], place, MATRIX, np.array([k1, 0, 0, 0.0]))
    return np.clip(image, 0, 255).astype(np.uint8), corners.reshape(4, 2)


def detected(image, k1=0.0):
    calibration = Calibration(WIDTH, HEIGHT, MATRIX, np.array([k1, 0.0, 0.0, 0.0, 0.0]))
    [marker] = ArucoDetector("4X4_50", SIZE, calibration).detect(image)
    return marker


@pytest.mark.parametrize("blur", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("away", [0.4, 0.8])
def test_blur_does_not_move_a_marker_away(blur, away):
    """Corners were found 0.2 to 0.6 pixels inside: at 0.8 m and a blur of two pixels, 6 mm too far away."""
    image, corners = pictured((0.3, -0.2, 0.4), (0.03, -0.02, away), blur=blur)
    marker = detected(image)
    outwards = corners - corners.mean(axis=0)
    outwards /= np.linalg.norm(outwards, axis=1)[:, None]
    assert abs(np.mean(np.sum((marker.corners - corners) * outwards, axis=1))) < 0.05
    assert marker.pose is not None
    assert np.linalg.norm(marker.pose[:3, 3] - (0.03, -0.02, away)) < 0.0015


def test_a_lens_that_bends_the_edges_does_not_move_the_corners():
    image, corners = pictured((0.1, 0.2, 0.3), (0.1, 0.05, 0.35), blur=0.7, k1=-0.25)
    assert np.abs(detected(image, -0.25).corners - corners).max() < 0.2


def test_an_edge_that_is_partly_hidden_counts_where_it_is_seen():
    image, corners = pictured((0.1, 0.2, 0.3), (0.0, 0.0, 0.4), blur=0.7)
    middle = (0.7 * corners[0] + 0.3 * corners[1]).round().astype(int)
    cv2.circle(image, middle.tolist(), 8, 120, -1)
    assert np.abs(intersected(image, corners + 0.4) - corners).max() < 0.2


@pytest.mark.parametrize("image", [np.zeros((480, 640), np.uint8), np.full((480, 640), 255, np.uint8)])
def test_corners_stay_where_the_image_shows_no_edge(image):
    corners = np.array([[100.0, 100], [200, 100], [200, 200], [100, 200]])
    assert np.array_equal(intersected(image, corners), corners)


def test_corners_of_a_small_marker_stay():
    image, corners = pictured((0.1, 0.2, 0.3), (0.0, 0.0, 3.5), blur=0.7)
    assert np.array_equal(intersected(image, corners), corners)


def test_corners_beside_the_image_stay_or_are_near():
    image, _ = pictured((0.1, 0.2, 0.3), (0.0, 0.0, 0.4), blur=0.7)
    corners = np.array([[-20.0, -20], [100, -20], [100, 100], [-20, 100]])
    assert np.abs(intersected(image, corners) - corners).max() <= 3.0


def test_corners_of_a_square_seen_from_the_edge_stay():
    image, _ = pictured((0.1, 0.2, 0.3), (0.0, 0.0, 0.4), blur=0.7)
    flat = np.array([[100.0, 100], [300, 100], [500, 100], [550, 100]])
    assert np.array_equal(intersected(image, flat), flat)
