"""Boards and AprilTags as the arm's goal: found in rendered images, and as sure as they say."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

import servo_scene
from grabbergui.calibration import geometry
from grabbergui.calibration.marker_boards import BoardDetector, MarkerBoard
from grabbergui.calibration.marker_pose import MarkerDetection, located, pose_covariance
from grabbergui.calibration.markers import ArucoDetector, dictionary_named
from grabbergui.core.errors import UsageError
from grabbergui.driver.sim.rendered_scene import RenderedScene, Things, at
from grabbergui.driver.sim.sensor import Sensor
from grabbergui.servo import closed_loop
from grabbergui.servo.config import Config, MarkerConfig
from grabbergui.servo.state_machine import State

GRID = MarkerConfig(kind="grid", size=0.04, columns=3, rows=2, dictionary="tag36h11", first=5)
CHARUCO = MarkerConfig(kind="charuco", size=0.03, columns=5, rows=4)
PLACE = at(0.7, -0.05, 0.52, yaw=25, pitch=-10)


def seen(marker, board=PLACE, binning=2, spoil=None):
    """Return the detections of a configured target in a rendered image, and the calibration."""
    of = servo_scene.settings(binning)
    scene = RenderedScene(closed_loop.things_for(marker, Things(lambda _: None, lambda _: board)))
    scene.mount(lambda _: servo_scene.camera())
    grey = Sensor(scene).render(of, 1, 0, np.empty(of.image_bytes, np.uint8)).copy()
    if spoil is not None:
        spoil(grey)
    detector = closed_loop.detector(Config(marker=marker), servo_scene.calibration(of))
    return detector.markers.detect(grey)


@pytest.mark.parametrize(
    "marker",
    [
        GRID,
        CHARUCO,
        replace(CHARUCO, dictionary="tag25h9"),
        *(MarkerConfig(dictionary=f"tag{family}", id=3) for family in ("16h5", "25h9", "36h10", "36h11")),
    ],
    ids=lambda marker: f"{marker.kind} {marker.dictionary}",
)
def test_the_pose_of_a_target_is_true(marker):
    (found,) = seen(marker)
    assert (found.marker_id, found.problem) == (marker.target, "")
    true = geometry.inverse(servo_scene.camera()) @ PLACE
    assert geometry.distance(found.pose, true) < 0.002
    assert np.degrees(geometry.angle_between(found.pose, true)) < 0.6


@pytest.mark.parametrize("marker", [GRID, CHARUCO], ids=["grid", "charuco"])
def test_a_board_that_is_partly_hidden_is_where_it_is(marker):
    def hide(grey):
        across = seen(marker)[0].corners[:, 0]
        grey[:, int(across.min() + 0.68 * np.ptp(across)) :] = 128

    (found,) = seen(marker, spoil=hide)
    true = geometry.inverse(servo_scene.camera()) @ PLACE
    assert geometry.distance(found.pose, true) < 0.004
    assert np.degrees(geometry.angle_between(found.pose, true)) < 1.5
    assert np.trace(found.covariance) > np.trace(seen(marker)[0].covariance)


def test_two_boards_or_too_little_of_one_have_no_pose():
    board = GRID.board
    detector = BoardDetector(board, servo_scene.calibration(servo_scene.settings(2)))
    canvas = np.full((1024, 1216), 255, np.uint8)
    drawn = board.image(3000)
    canvas[100 : 100 + drawn.shape[0], 100 : 100 + drawn.shape[1]] = drawn
    assert detector.detect(canvas)[0].pose is not None
    canvas[600 : 600 + drawn.shape[0], 100 : 100 + drawn.shape[1]] = drawn
    (twice,) = detector.detect(canvas)
    assert (twice.pose, twice.problem) == (None, "several boards are seen")
    canvas[:] = 255
    canvas[100:220, 100:220] = drawn[:120, :120]
    (little,) = detector.detect(canvas)
    assert (little.pose, little.problem) == (None, "too little of the board is seen")


def test_other_markers_of_the_dictionary_are_not_the_board():
    detector = BoardDetector(replace(CHARUCO, first=0).board)
    number = dictionary_named("4X4_50")
    canvas = np.full((300, 300), 255, np.uint8)
    canvas[90:210, 90:210] = cv2.aruco.generateImageMarker(number, 30, 120)
    assert ArucoDetector().detect(canvas)
    assert detector.detect(canvas) == []


@pytest.mark.parametrize("points", ["marker", "board"])
def test_the_covariance_is_that_of_many_noisy_images(points):
    of, random = servo_scene.calibration(servo_scene.settings(4)), np.random.default_rng(3)
    half = 0.05
    corners = np.array([(-half, half, 0), (half, half, 0), (half, -half, 0), (-half, -half, 0)])
    if points == "board":
        corners = CHARUCO.board.centred(CHARUCO.board.pattern.getChessboardCorners())
    true = geometry.pose(
        np.diag([1.0, -1.0, -1.0]) @ geometry.rotation_from_vector((0.5, 0.3, 0.1)), (0.05, -0.02, 0.6)
    )
    turn = geometry.vector_from_rotation(true[:3, :3])
    exact = cv2.projectPoints(corners, turn, true[:3, 3], of.matrix, of.distortion)[0].reshape(-1, 2)
    off, stated = [], []
    for _ in range(400):
        pixels = exact + random.normal(0, 0.2, exact.shape)
        found = located(MarkerDetection(1, pixels[[0, 3, -1, -4]]), corners, pixels, of)
        if found.pose is not None:
            off.append(geometry.diff(true, found.pose))
            stated.append(np.sqrt(np.diag(found.covariance)))
    assert len(off) > 300
    measured = np.sqrt(np.mean(np.square(off), axis=0))
    assert np.mean(stated, axis=0) == pytest.approx(measured, rel=0.3)


def test_corners_on_a_line_have_no_covariance():
    of = servo_scene.calibration(servo_scene.settings(4))
    line = np.column_stack((np.linspace(0, 0.1, 5), np.zeros(5), np.zeros(5)))
    assert pose_covariance(geometry.pose(translation=(0, 0, 1.0)), line, of, 0.1) is None


def test_the_hand_reaches_a_charuco_board():
    config = Config(marker=CHARUCO)
    run = closed_loop.ClosedLoop(config=config, things=Things(face=lambda _: None), head=(-0.42, 0.1))
    assert run.run(20, State.REACHED).state is State.REACHED
    metres, radians = run.true_error()
    assert metres < 0.008
    assert np.degrees(radians) < 2


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"kind": "ring"}, "single and grid and charuco"),
        ({"kind": "grid", "columns": 1, "rows": 1}, "1×1 cannot be used"),
        ({"kind": "charuco", "columns": 2}, "3 to 50"),
        ({"kind": "charuco", "pitch": 0.05}, "overlap"),
        ({"kind": "grid", "columns": 10, "rows": 6}, "markers 0 to 49; the board needs 60 from 0 on"),
        ({"kind": "grid", "first": 45}, "needs 12 from 45 on"),
        ({"dictionary": "tag99h1"}, "APRILTAG_36H11"),
    ],
)
def test_a_target_that_cannot_be_is_refused(changes, complaint):
    with pytest.raises(UsageError, match=complaint):
        Config(marker=MarkerConfig(**changes))


def test_a_board_is_asked_for_by_the_configuration():
    text = "[marker]\nkind charuco\ncolumns 8\nrows 6\nsize 0.022\npitch 0.03\ndictionary 5X5_100"
    marker = Config.parse(text).marker
    assert marker.board == MarkerBoard("charuco", 8, 6, 0.022, "5X5_100", 0.03)
    assert marker.extent == pytest.approx((0.24, 0.18))
