"""Boards: what they look like, on paper and in images."""

import re
import struct
import zlib
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from grabbergui.calibration import boards, printed_sheet
from grabbergui.calibration.boards import SEARCH_PIXELS, BoardSettings, CharucoBoard, Chessboard
from grabbergui.calibration.collector import placed
from grabbergui.calibration.printed_sheet import pdf, raster, sheet_for
from grabbergui.core.errors import UsageError

CHARUCO = CharucoBoard(8, 6, 0.03, 0.022, "5X5_100")
CHESSBOARD = Chessboard(8, 6, 0.03)


def drawn(board, pixels_per_metre):
    """Return the page that `drawing` describes, as pixels."""
    scale = pixels_per_metre
    size = round(board.rows * board.square * scale), round(board.columns * board.square * scale)
    out = np.full(size, 255, np.uint8)
    for part in board.drawing():
        left, top = round(part.x * scale), round(part.y * scale)
        right, bottom = round((part.x + part.width) * scale), round((part.y + part.height) * scale)
        out[top:bottom, left:right] = 0 if part.dark else 255
    return out


@pytest.mark.parametrize(
    ("columns", "rows", "dictionary", "cells"),
    [(8, 6, "5X5_100", 7), (7, 5, "4X4_50", 6), (5, 8, "6X6_250", 8), (4, 4, "ARUCO_ORIGINAL", 7)],
)
def test_a_charuco_board_looks_as_opencv_draws_it(columns, rows, dictionary, cells):
    board = CharucoBoard(columns, rows, 0.03, 0.022, dictionary)
    field = 30 * cells  # then a cell of the marker is 22 pixels
    ours = drawn(board, field / 0.03)
    theirs = board.pattern.generateImage((columns * field, rows * field))
    assert np.array_equal(ours, theirs)


@pytest.mark.parametrize("board", [CHARUCO, CHESSBOARD], ids=["charuco", "chessboard"])
def test_a_board_on_paper_is_found_at_its_true_size(board):
    sheet = sheet_for(board)
    dpi = 150
    view = board.find(raster(board, sheet, dpi))
    assert len(view.ids) == 35
    metres = view.image / dpi * 0.0254
    apart = np.linalg.norm(metres - metres[0], axis=1)
    true = np.linalg.norm(view.board - view.board[0], axis=1)
    assert np.abs(apart - true).max() < 0.0002


def test_the_pdf_holds_the_board_and_the_rule_in_points():
    sheet = sheet_for(CHARUCO)
    file = pdf(CHARUCO, sheet).decode("latin-1")
    assert "/MediaBox [0 0 841.8898 595.2756]" in file
    rectangles = [
        tuple(map(float, found)) for found in re.findall(r"([-\d.]+) ([-\d.]+) ([-\d.]+) ([-\d.]+) re", file)
    ]
    first = rectangles[0]
    assert np.multiply(first, 25.4 / 72) == pytest.approx((28.5, 210 - 10 - 30, 30, 30), abs=1e-3)
    assert any(width * 25.4 / 72 == pytest.approx(100, abs=1e-3) for _, _, width, _ in rectangles)
    # Every object is where the table says.
    table = file[file.index("xref\n") :].splitlines()[3:8]
    for number, line in enumerate(table, 1):
        assert file[int(line[:10]) :].startswith(f"{number} 0 obj")
    assert int(file.split("startxref\n")[1].split()[0]) == file.index("xref\n")


def test_the_png_knows_its_resolution(tmp_path):
    sheet = printed_sheet.save(CHESSBOARD, tmp_path / "board.png")
    file = (tmp_path / "board.png").read_bytes()
    place = file.index(b"pHYs")
    along_x, along_y, unit, check = struct.unpack_from(">IIBI", file, place + 4)
    assert (along_x, along_y, unit) == (11811, 11811, 1)
    assert check == zlib.crc32(file[place : place + 13])
    image = cv2.imread(str(tmp_path / "board.png"), cv2.IMREAD_GRAYSCALE)
    assert image.shape[1] / along_x == pytest.approx(sheet.width / 1e3, rel=1e-3)
    assert CHESSBOARD.find(image) is not None


@pytest.mark.parametrize(
    ("settings", "paper"),
    [
        (BoardSettings(), "A4"),
        (BoardSettings(columns=6, rows=8), "A4"),
        (BoardSettings(square=0.04), "A3"),
        (BoardSettings("chessboard", square=0.1), "A0"),
    ],
)
def test_the_smallest_paper_is_chosen(settings, paper):
    assert sheet_for(settings.board()).paper == paper


def test_a_board_that_fits_no_paper_and_a_file_of_another_kind_are_refused(tmp_path):
    with pytest.raises(UsageError, match="A0"):
        sheet_for(Chessboard(20, 20, 0.1))
    with pytest.raises(UsageError, match=r"\.pdf or \.png"):
        printed_sheet.save(CHESSBOARD, tmp_path / "board.jpg")


@pytest.mark.parametrize("name", ["board.pdf", "board.png"])
def test_a_full_disk_leaves_no_part_of_a_sheet(tmp_path, full_disk, name):
    with full_disk(), pytest.raises(OSError, match="too large"):
        printed_sheet.save(CHESSBOARD, tmp_path / name)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("board", [CHARUCO, CHESSBOARD], ids=["charuco", "chessboard"])
@pytest.mark.parametrize("side", [1, 4])
def test_corners_are_found_to_a_fraction_of_a_pixel_in_large_images_too(board, side):
    width, height = 720 * side, 540 * side
    assert (width * height > SEARCH_PIXELS) == (side == 4)
    page = cv2.copyMakeBorder(drawn(board, 16_000), 400, 400, 400, 400, cv2.BORDER_CONSTANT, value=255)
    corners = np.float32([(0, 0), (page.shape[1], 0), (page.shape[1], page.shape[0]), (0, page.shape[0])])
    seen = np.float32([(150, 60), (560, 110), (600, 430), (110, 480)]) * side
    tilt = cv2.getPerspectiveTransform(corners, seen)
    # Drawn four times finer and averaged, as a sensor's pixels do.
    fine = 4 if side == 1 else 2
    place = np.array([[fine, 0, (fine - 1) / 2], [0, fine, (fine - 1) / 2], [0, 0, 1]])
    image = cv2.warpPerspective(
        page, place @ tilt, (width * fine, height * fine), flags=cv2.INTER_AREA, borderValue=90
    )
    image = cv2.GaussianBlur(cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA), (0, 0), 0.7)
    view = board.find(image)
    flat = np.hstack((view.board[:, :2] * 16_000 + 400 - 0.5, np.ones((len(view.board), 1))))
    true = tilt @ flat.T
    error = np.linalg.norm(view.image - (true[:2] / true[2]).T, axis=1)
    if isinstance(board, Chessboard):  # the board does not say which corner is the first
        error = np.minimum(error, np.linalg.norm(view.image[::-1] - (true[:2] / true[2]).T, axis=1))
    assert np.sqrt((error**2).mean()) < 0.25


DIAGONAL = [(number, number) for number in range(1, 10)]
ROW = [(number, 1) for number in range(1, 10)]


@pytest.mark.parametrize(
    ("fields", "seen"),
    [
        (DIAGONAL, False),
        (ROW, False),
        ([*DIAGONAL, (3, 1)], False),
        ([*ROW, (3, 2)], False),
        ([*ROW, (3, 2), (4, 2)], True),
        ([*DIAGONAL, (3, 1), (9, 2)], True),
    ],
)
def test_a_view_determines_the_perspective_of_the_board(monkeypatch, fields, seen):
    ids = np.array([[(y - 1) * 11 + x - 1] for x, y in fields], np.int32)
    corners = np.array([[[40 * x, 40 * y]] for x, y in fields], np.float32)
    monkeypatch.setattr(boards, "_refined", lambda grey, board, image, factor, square: image)
    detector = SimpleNamespace(detectBoard=lambda grey: (corners, ids, (), None))
    monkeypatch.setattr(cv2.aruco, "CharucoDetector", lambda *_: detector)
    board = CharucoBoard(12, 12, 0.03, 0.022, "5X5_100")
    view = board.find(np.zeros((480, 480), np.uint8))
    assert (view is not None) == seen
    if view is not None:
        assert placed(view, (480, 480)).size > 0
