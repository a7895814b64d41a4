"""Calibration from rendered views of a board, against the camera that drew them."""

import argparse
from functools import cache
from itertools import islice

import cv2
import numpy as np
import pytest

from grabbergui.calibration import camera_info
from grabbergui.calibration.boards import CharucoBoard, Chessboard
from grabbergui.calibration.collector import Collector, Coverage, ViewPlacement, ViewVerdict, placed
from grabbergui.cli import EXIT_FAILURE, CommandParser, calibrate, main
from grabbergui.core.errors import CalibrationError, UsageError
from grabbergui.core.identity import DeviceInfo
from grabbergui.driver.sim.rendered_scene import at
from grabbergui.driver.sim.rendered_world import Panel, draw
from grabbergui.ui.run import standalone

WIDTH, HEIGHT = 640, 480
CAMERA = np.array([[560.0, 0, 331], [0, 552.0, 228], [0, 0, 1]])
VIEW = np.linalg.inv(np.array([[0, 0, 1.0, 0], [-1.0, 0, 0, 0], [0, -1.0, 0, 0], [0, 0, 0, 1]]))
CHARUCO = CharucoBoard(8, 6, 0.03, 0.022, "5X5_100")


@cache
def texture(kind):
    if kind == "charuco":
        drawn = CHARUCO.pattern.generateImage((960, 720))
        drawn = cv2.copyMakeBorder(drawn, 60, 60, 60, 60, cv2.BORDER_CONSTANT, value=255)
    else:
        fields = (np.indices((6, 8)).sum(axis=0) % 2 * 255).astype(np.uint8)
        drawn = np.kron(fields, np.ones((120, 120), np.uint8))
        drawn = cv2.copyMakeBorder(drawn, 60, 60, 60, 60, cv2.BORDER_CONSTANT, value=255)
    grey = 0.05 + 0.9 * drawn.astype(np.float32) / 255
    return np.dstack((grey, grey, grey, np.ones_like(grey)))


def image(pattern, pose):
    out = np.full((HEIGHT, WIDTH, 3), 3000, np.uint16)
    panel = Panel(pose, 0.27, 0.21, pattern, fine=True)
    draw(panel, out, VIEW, CAMERA)
    return np.clip(out[..., 1] / 8192 * 255, 0, 255).astype(np.uint8)


def poses():
    random = np.random.default_rng(3)
    for index in range(24):
        across, down = (-0.1, 0, 0.1)[index % 3], (-0.07, 0, 0.07)[index // 3 % 3]
        x = random.uniform(0.35, 0.6)
        yield at(x, across * x / 0.4, down * x / 0.4, *random.uniform(-35, 35, 2), random.uniform(-15, 15))


@pytest.mark.parametrize(("kind", "views"), [("charuco", 24), ("chessboard", 12)])
def test_the_camera_that_drew_the_views_is_found(kind, views):
    board = CHARUCO if kind == "charuco" else Chessboard(8, 6, 0.03)
    collector, pattern = Collector(board), texture(kind)
    for pose in islice(poses(), views):
        collector.look(image(pattern, pose))
    result = collector.solve("test")
    assert result.rms < 0.3
    matrix = result.calibration.matrix
    assert matrix[0, 0] == pytest.approx(560, rel=0.01)
    assert matrix[1, 1] == pytest.approx(552, rel=0.01)
    assert matrix[:2, 2] == pytest.approx([331, 228], abs=5)
    assert len(result.errors) == len(collector.views)
    assert abs(matrix[0, 0] - 560) < 6 * result.uncertainty[0] + 2
    assert collector.coverage.part > 0.5


def test_a_view_is_kept_once_and_the_same_again_is_not():
    collector, view = Collector(CHARUCO), image(texture("charuco"), at(0.45, 0, 0, yaw=20))
    assert collector.look(view) is ViewVerdict.KEPT
    assert collector.look(view) is not ViewVerdict.KEPT
    assert len(collector.views) == 1
    assert 0 < collector.coverage.part < 1
    assert collector.coverage.missing() == "at the top left"


def test_images_without_a_board_are_no_views():
    collector = Collector(CHARUCO)
    assert collector.look(np.zeros((HEIGHT, WIDTH), np.uint8)) is not ViewVerdict.KEPT
    assert collector.look(image(texture("charuco"), at(2.5, 0, 0))) is not ViewVerdict.KEPT
    with pytest.raises(CalibrationError, match="views of the board, not 0"):
        collector.solve()


def test_a_view_that_fits_badly_is_left_out():
    collector, pattern = Collector(CHARUCO), texture("charuco")
    for pose in poses():
        collector.look(image(pattern, pose))
    spoilt = collector.views[4]
    spoilt.image[:] += np.random.default_rng(1).normal(0, 8, spoilt.image.shape)
    result = collector.solve()
    assert np.isnan(result.errors[4])
    assert np.isnan(result.errors).sum() == 1
    assert result.calibration.matrix[0, 0] == pytest.approx(560, rel=0.01)
    assert result.error_of(4) > 5 > 10 * max(result.error_of(number) for number in (3, 5))
    chosen = collector.solve(used=[*range(4), *range(5, 12)])
    assert np.isfinite(chosen.errors).sum() == 11
    with pytest.raises(CalibrationError, match="views of the board, not 3"):
        collector.solve(used=[0, 1, 2, 2])


def test_images_of_another_size_are_refused():
    collector = Collector(CHARUCO)
    collector.look(np.zeros((HEIGHT, WIDTH), np.uint8))
    with pytest.raises(CalibrationError, match="begin again"):
        collector.look(np.zeros((HEIGHT, WIDTH // 2), np.uint8))


def test_only_a_board_at_rest_is_kept():
    collector, pattern = Collector(CHARUCO, still=True), texture("charuco")
    first, moved = image(pattern, at(0.45, 0, 0, yaw=20)), image(pattern, at(0.45, 0.02, 0, yaw=20))
    assert [collector.look(grey) for grey in (first, moved, moved, moved)] == [
        ViewVerdict.MOVING,
        ViewVerdict.MOVING,
        ViewVerdict.KEPT,
        ViewVerdict.KNOWN,
    ]
    assert collector.look(np.zeros_like(first)) is ViewVerdict.NOT_SEEN
    assert collector.look(first) is ViewVerdict.MOVING  # seen again: it may just have been put there


def test_a_look_without_keep_keeps_nothing():
    collector = Collector(CHARUCO)
    assert collector.look(image(texture("charuco"), at(0.45, 0, 0)), keep=False) is ViewVerdict.KEPT
    assert collector.views == []
    assert collector.last is not None


@pytest.mark.parametrize("kind", ["charuco", "chessboard"])
@pytest.mark.parametrize(("yaw", "slant"), [(-30, 1), (30, -1)])
def test_the_nearer_edge_is_reported(kind, yaw, slant):
    board = CHARUCO if kind == "charuco" else Chessboard(8, 6, 0.03)
    # About the vertical by a positive angle, the edge to the left in the image comes nearer.
    place = placed(board.find(image(texture(kind), at(0.45, 0, 0, yaw=yaw))), (WIDTH, HEIGHT))
    assert np.sign(place.slant_x) == slant
    assert abs(place.slant_x) > 2 * abs(place.slant_y)
    turned = placed(board.find(image(texture(kind), at(0.45, 0, 0, pitch=yaw))), (WIDTH, HEIGHT))
    assert abs(turned.slant_y) > 2 * abs(turned.slant_x)


def test_missing_views_are_reported_until_there_are_none():
    coverage, hints = Coverage(), []
    view = CHARUCO.find(image(texture("charuco"), at(0.3, 0, 0)))
    everywhere = np.stack(np.meshgrid(np.linspace(1, 638, 40), np.linspace(1, 478, 40)), axis=-1).reshape(
        -1, 2
    )
    whole = type(view)(view.board, everywhere.astype(np.float32), view.ids)
    for placement in (
        *[ViewPlacement(0.5, 0.5, 0.4, 0.0, 0.0)] * 4,
        ViewPlacement(0.5, 0.5, 0.4, -0.2, 0.0),
        ViewPlacement(0.5, 0.5, 0.4, 0.2, 0.0),
        ViewPlacement(0.5, 0.5, 0.4, 0.0, -0.2),
        ViewPlacement(0.5, 0.5, 0.4, 0.0, 0.2),
    ):
        coverage.add(view, placement, (WIDTH, HEIGHT))
        hints.append(coverage.missing())
    assert hints[0].startswith("at the ")
    assert [hint.split()[2] for hint in hints[3:7]] == ["left", "right", "upper", "lower"]
    coverage.add(whole, ViewPlacement(0.5, 0.5, 0.4, 0.0, 0.0), (WIDTH, HEIGHT))
    assert coverage.missing() == "nearer"
    coverage.add(whole, ViewPlacement(0.5, 0.5, 0.7, 0.0, 0.0), (WIDTH, HEIGHT))
    assert coverage.missing() == ""


def options(*arguments):
    parser = argparse.ArgumentParser()
    calibrate.add_commands(parser.add_subparsers(required=True, parser_class=CommandParser))
    return parser.parse_args(("calibrate", *arguments))


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("--columns", "2"), "2×6"),
        (("--square", "0"), "0 m"),
        (("--marker", "0.05"), "does not fit"),
        (("--columns", "30", "--rows", "30"), "has 100 markers"),
        (("--views", "1"), "1 views"),
        (("--out", "/nowhere/at/all.yaml"), "no folder"),
        (("--print", "board.jpg"), "as .pdf or .png"),
    ],
)
def test_the_command_says_what_is_wrong(arguments, complaint):
    chosen = options("sim:?width=640&height=480", *arguments)
    with pytest.raises(UsageError, match=complaint):
        chosen.run(chosen)


def test_a_board_that_is_not_seen_is_a_failure_not_wrong_usage(tmp_path, capsys):
    out = str(tmp_path / "camera.yaml")
    assert main(["calibrate", "sim:?width=320&height=240", "--seconds", "0.3", "--out", out]) == EXIT_FAILURE
    assert "no charuco board of 8×6 squares was seen; check --columns, --rows and --dictionary" in (
        capsys.readouterr().err
    )


def test_the_command_saves_what_it_found(tmp_path, monkeypatch, capsys):
    images = [image(texture("charuco"), pose) for pose in poses()]

    def collect(collector, chosen):
        for grey in images:
            collector.look(grey)
            collector.look(grey)  # at rest
        return DeviceInfo("sim:", model="SimCam", serial="0042")

    monkeypatch.setattr(calibrate, "_collect", collect)
    chosen = options("sim:", "--out", str(tmp_path / "left.yaml"), "--name", "left")
    assert chosen.run(chosen) == 0

    saved = camera_info.load(tmp_path / "left.yaml")
    assert saved.matrix[0, 0] == pytest.approx(560, rel=0.01)
    assert (saved.camera_name, saved.camera_model, saved.camera_serial) == ("left", "SimCam", "0042")
    assert "coverage" in capsys.readouterr().out


def test_the_command_says_what_it_waits_for(monkeypatch, capsys):
    monkeypatch.setattr(calibrate, "REMIND", 0.0)
    chosen = options("sim:?width=320&height=240&fps=50", "--seconds", "1", "--out", "/dev/null")
    with pytest.raises(CalibrationError, match="no charuco board of 8×6 squares was seen"):
        chosen.run(chosen)
    printed = capsys.readouterr().out.splitlines()
    assert printed[0].startswith(
        "show the charuco board (8×6 squares of 0.03 m) to grabbergui Simulated camera"
    )
    assert "no board is seen" in printed[1] and printed[1].endswith("s are left")


def test_the_command_prints_the_board(tmp_path, capsys):
    chosen = options("--print", str(tmp_path / "board.pdf"), "--board", "chessboard")
    assert chosen.run(chosen) == 0
    assert (tmp_path / "board.pdf").read_bytes().startswith(b"%PDF")
    assert "A4" in capsys.readouterr().out


def test_the_command_needs_a_source_or_something_to_print():
    chosen = options()
    with pytest.raises(UsageError, match="SOURCE"):
        chosen.run(chosen)


def test_the_command_has_a_window_that_takes_an_image_of_itself(tmp_path, qapp):
    file = tmp_path / "window.png"
    chosen = options("sim:board", "--screenshot", str(file), "--seconds", "2")
    assert chosen.run(chosen) == 0
    window = cv2.imread(str(file))
    assert window.shape[1] > 1000
    assert window.std() > 20


def test_a_window_that_is_closed_without_saving_is_no_success(monkeypatch):
    chosen = options("sim:board", "--window")
    monkeypatch.setattr(standalone, "calibrate", lambda *arguments: None)
    with pytest.raises(CalibrationError, match="no calibration saved"):
        chosen.run(chosen)
