"""The room of `sim:scene`: perspective, and that the sensor's settings act on it."""

import numpy as np
import pytest

from grabbergui import sources
from grabbergui.core.pfnc import by_name
from grabbergui.driver.sim import rendered_world as world
from grabbergui.driver.sim.registers import SENSOR_HEIGHT, SENSOR_WIDTH
from grabbergui.driver.sim.rendered_scene import RenderedScene, Things, at, pinhole
from grabbergui.driver.sim.rendered_world import Panel, draw, marker_board
from grabbergui.driver.sim.sensor import Sensor
from grabbergui.driver.sim.settings import FrameSettings, Optics
from patience import PATIENCE

CAMERA = np.array([[0, 0, 1.0, 0], [-1.0, 0, 0, 0], [0, -1.0, 0, 0.5], [0, 0, 0, 1]])
"Looks along x from half a metre above the origin."


def settings(binning=4, x=0, y=0, width=608, height=512, pixel_format="Mono8", exposure=10_000.0, **optics):
    """A region that begins (x, y) pixels right of and below the middle 2432×2048 pixels' corner."""
    return FrameSettings(
        width,
        height,
        (SENSOR_WIDTH - 2432) // 2 // binning + x,
        (SENSOR_HEIGHT - 2048) // 2 // binning + y,
        by_name(pixel_format),
        Optics(binning, binning, **optics),
        exposure,
        0.0,
        2.0,
    )


def render(of, scene=None):
    out = np.empty(of.image_bytes, np.uint8)
    scene = scene or RenderedScene(Things(face=lambda _: None, board=lambda _: at(0.8, 0.0, 0.5)))
    scene.mount(lambda _: CAMERA)
    return Sensor(scene).render(of, 1, 0, out).astype(int)


def test_a_board_has_the_size_and_place_that_perspective_gives():
    matrix = pinhole(settings())
    image = np.zeros((512, 608, 3), np.uint16)
    board = Panel(at(0.8, 0.1, 0.45), 0.16, 0.10, marker_board(0, 20), fine=True)
    draw(board, image, np.linalg.inv(CAMERA), matrix)
    brightness = image[..., 1] / image[..., 1].max()
    focal, centre = matrix[0, 0], matrix[:2, 2]
    for axis, middle, size in ((0, -0.1, 0.16), (1, 0.05, 0.10)):
        # Along a line through the white rim, covered pixels count by how much of them is covered.
        covered = brightness.max(axis=axis)
        expected = focal * size / 0.8
        assert covered.sum() == pytest.approx(expected, abs=0.6)
        place = (covered * np.arange(covered.size)).sum() / covered.sum()
        assert place == pytest.approx(centre[axis] + focal * middle / 0.8, abs=0.3)


def test_a_region_is_cut_out_of_the_whole_image():
    whole = render(settings())
    part = render(settings(x=200, y=100, width=240, height=200))
    assert np.abs(whole[100:300, 200:440] - part).mean() < 1.5


def test_mirrored_images_are_mirrored():
    whole, mirrored = render(settings()), render(settings(reverse_x=True, reverse_y=True))
    assert np.abs(whole[::-1, ::-1] - mirrored).mean() < 1.5


def test_binning_keeps_directions():
    coarse, fine = render(settings(4)), render(settings(2, width=1216, height=1024))
    averaged = fine.reshape(512, 2, 608, 2).mean(axis=(1, 3))
    assert np.abs(averaged - coarse).mean() < 2.5


def test_exposure_still_acts():
    half, full = render(settings(exposure=5_000.0)), render(settings(exposure=10_000.0))
    assert (full - 2).mean() == pytest.approx(2 * (half - 2).mean(), rel=0.03)


@pytest.mark.parametrize("pixel_format", ["BayerRG8", "RGB8", "Mono12p", "YUV422_8"])
def test_every_kind_of_format_shows_it(pixel_format):
    values = render(settings(pixel_format=pixel_format))
    assert values.std() > 5


def test_the_back_of_a_board_and_what_is_behind_the_camera_are_not_seen():
    texture = marker_board(0, 20)
    view = np.linalg.inv(CAMERA)
    for pose in (at(0.8, 0, 0.5, yaw=180), at(-0.8, 0, 0.5), at(-0.8, 0, 0.5, yaw=180)):
        image = np.zeros((512, 608, 3), np.uint16)
        draw(Panel(pose, 0.16, 0.16, texture, fine=True), image, view, pinhole(settings()))
        assert not image.any()


def test_a_camera_anywhere_in_the_room_sees_something_everywhere():
    scene, random, of = RenderedScene(), np.random.default_rng(3), settings(width=304, height=256)
    for _ in range(20):
        turn = np.linalg.qr(random.standard_normal((3, 3)))[0]
        pose = np.eye(4)
        pose[:3, :3] = turn * np.linalg.det(turn)
        pose[:3, 3] = random.uniform((-1.5, -2, -0.6), (2.5, 2, 1.4))
        scene.mount(lambda _, pose=pose: pose)
        assert (scene.rendered(0, of).max(axis=2) > 0).mean() > 0.995


def test_a_grey_image_is_the_brightness_of_the_coloured_one():
    scene, of = RenderedScene(), settings()
    colour, grey = scene.rendered(0, of), scene.rendered(0, of, grey=True)
    assert np.abs(colour @ (0.299, 0.587, 0.114) - grey).max() < 3 < grey.std()


def test_things_move_with_the_device_s_clock():
    scene, of = RenderedScene(), settings()
    assert not np.array_equal(scene.rendered(0, of), scene.rendered(1_000_000_000, of))
    assert np.array_equal(scene.rendered(5, of), scene.rendered(5, of))


def test_the_scene_opens_by_its_uri():
    grabber = sources.create("sim:scene?width=608&height=512")
    grabber.open()
    try:
        queue = grabber.open_queue()
        grabber.start()
        frame = queue.get(PATIENCE)
        assert frame.mono().std() > 5
    finally:
        grabber.close()


def test_the_smaller_copies_of_a_texture_go_with_it():
    """A board drawn as large as it is printed takes 20 MB with them, and each camera has its own."""
    before = len(world.pyramids)
    texture = marker_board(0, 20).copy()
    image = np.zeros((512, 608, 3), np.uint16)
    draw(Panel(at(0.8, 0, 0.5), 0.16, 0.16, texture), image, np.linalg.inv(CAMERA), pinhole(settings()))
    assert image.any() and len(world.pyramids) == before + 1
    del texture
    assert len(world.pyramids) == before
