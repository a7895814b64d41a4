"""Boards: what they look like, on paper and in images."""

import shutil
import subprocess

import cv2
import numpy as np
import pytest

from grabbergui.calibration import printed_sheet
from grabbergui.calibration.boards import CharucoBoard, Chessboard
from patience import PROGRAM

CHARUCO = CharucoBoard(8, 6, 0.03, 0.022, "5X5_100")
CHESSBOARD = Chessboard(8, 6, 0.03)


@pytest.mark.skipif(shutil.which("pdftoppm") is None, reason="needs poppler-utils")
@pytest.mark.parametrize("board", [CHARUCO, CHESSBOARD], ids=["charuco", "chessboard"])
def test_another_program_prints_the_pdf_at_its_true_size(board, tmp_path):
    printed_sheet.save(board, tmp_path / "board.pdf")
    command = ["pdftoppm", "-r", "150", "-gray", "-singlefile", tmp_path / "board.pdf", tmp_path / "page"]
    subprocess.run(command, check=True, timeout=PROGRAM)
    page = cv2.imread(str(tmp_path / "page.pgm"), cv2.IMREAD_GRAYSCALE)
    view = board.find(page)
    apart = np.linalg.norm(view.image[-1] - view.image[0]) / 150 * 0.0254
    assert apart == pytest.approx(np.linalg.norm(view.board[-1] - view.board[0]), abs=0.0003)
