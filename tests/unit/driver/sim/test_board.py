"""`sim:board`: what is shown there can be calibrated by."""

import cv2
import numpy as np
import pytest

from grabbergui.core.pfnc import by_name
from grabbergui.core.uri import SourceUri
from grabbergui.driver.sim import rendered_scene as board
from grabbergui.driver.sim.device import create
from grabbergui.driver.sim.rendered_scene import pinhole
from grabbergui.driver.sim.settings import FrameSettings, Optics
from patience import PATIENCE

PERIOD = board.MOVE_S + board.REST_S


def settings():
    optics = Optics(binning_horizontal=2, binning_vertical=2, ratios=(1.0, 1.0, 1.0))
    return FrameSettings(1216, 1024, 416, 28, by_name("Mono8"), optics, 10_000.0, 0.0, 2.0)


def seen(scene, seconds):
    """Corners found (ids, pixels) and corners that should be (35, 2)."""
    of = settings()
    image = scene.rendered(int(seconds * 1e9), of)[..., 1]
    pattern = cv2.aruco.CharucoBoard(
        (8, 6), board.SQUARE, board.MARKER, cv2.aruco.getPredefinedDictionary(board.DICTIONARY)
    )
    grey = np.clip(image // 32, 0, 255).astype(np.uint8)
    corners, ids, _, _ = cv2.aruco.CharucoDetector(pattern).detectBoard(grey)
    flat = np.array(pattern.getChessboardCorners())[:, :2] - (4 * board.SQUARE, 3 * board.SQUARE)
    points = np.column_stack((flat[:, 0], -flat[:, 1], np.zeros(35), np.ones(35)))
    true = pinhole(of) @ (scene.hold_at(seconds).pose @ points.T)[:3]
    return np.ravel(ids), np.reshape(corners, (-1, 2)), (true[:2] / true[2]).T


@pytest.mark.parametrize("number", [0, 1, 5, 13, 20])
def test_the_board_is_where_it_should_be(number):
    scene = board.BoardScene()
    ids, corners, true = seen(scene, number * PERIOD + 0.1)
    assert len(ids) >= 20
    assert np.abs(corners - true[ids]).mean() < 0.2


def test_the_board_rests_and_then_moves_on():
    scene = board.BoardScene()
    assert scene.hold_at(0.0) == scene.hold_at(board.REST_S) == board.holds()[0]
    between = scene.hold_at(board.REST_S + board.MOVE_S / 2)
    first, second = board.holds()[:2]
    assert between.across == pytest.approx((first.across + second.across) / 2)
    assert scene.hold_at(len(board.holds()) * PERIOD + 0.2) == first


def test_a_round_covers_the_image_and_every_tilt():
    cells = np.zeros((6, 8), bool)
    scene, holds = board.BoardScene(), board.holds()
    for number in range(len(holds)):
        ids, corners, _ = seen(scene, number * PERIOD + 0.1)
        assert len(ids) >= 8
        places = (corners / (1216, 1024) * (8, 6)).astype(int)
        cells[places[:, 1], places[:, 0]] = True
    assert cells.all()
    assert max(hold.yaw for hold in holds) > 25 > -25 > min(hold.yaw for hold in holds)
    assert max(hold.pitch for hold in holds) > 25 > -25 > min(hold.pitch for hold in holds)


def test_it_streams():
    grabber = create(SourceUri.parse("sim:board"))
    grabber.open()
    try:
        queue = grabber.open_queue(1)
        grabber.start()
        frame = queue.get(PATIENCE)
        assert (frame.width, frame.height) == (1216, 1024)
        assert frame.mono().std() > 10
    finally:
        grabber.close()
