"""A board on paper at its true size: a PDF page, or a PNG that knows its resolution.

Both hold a rule of 100 mm below the board, to check what the printer made of it. The PDF is version 1.4,
drawn in black and white rectangles (ISO 32000, 8.5); the PNG says its pixels per metre in a pHYs chunk.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration.boards import Board, Rectangle
from grabbergui.core.errors import UsageError

PAPERS = {"A4": (210, 297), "A3": (297, 420), "A2": (420, 594), "A1": (594, 841), "A0": (841, 1189)}
"Width and height, mm."
MARGIN = 10.0
"Of white around the board, mm, which detectors need and printers too."
FOOT = 10.0
"For rule and title below the board, mm."
RULE = 100.0
"Length of the rule, mm."
DPI = 300
"Of the PNG."
_POINTS = 72 / 25.4
"In a millimetre."


@dataclass(frozen=True)
class Sheet:
    """A page and where the board lies on it, mm."""

    paper: str
    width: float
    height: float
    left: float
    top: float


def sheet_for(board: Board) -> Sheet:
    """The smallest paper that holds a board, upright or across. Raises UsageError where none does."""
    width, height = 1e3 * board.columns * board.square, 1e3 * board.rows * board.square
    for paper, (short, long) in PAPERS.items():
        for page_width, page_height in ((long, short), (short, long)):
            if width + 2 * MARGIN <= page_width and height + 2 * MARGIN + FOOT <= page_height:
                left, top = (page_width - width) / 2, (page_height - FOOT - height) / 2
                return Sheet(paper, page_width, page_height, left, top)
    raise UsageError(
        f"a board of {width:g}×{height:g} mm does not fit on A0; choose smaller fields or fewer of them"
    )


def save(board: Board, path: Path) -> Sheet:
    """Write `.pdf` or `.png`; the paper it is for. Raises UsageError for another kind of file, OSError."""
    kind = path.suffix.lower()
    if kind not in (".pdf", ".png"):
        raise UsageError(f"a board is saved as .pdf or .png, not as '{path.name}'")
    sheet = sheet_for(board)
    path.write_bytes(pdf(board, sheet) if kind == ".pdf" else png(board, sheet))
    return sheet


def pdf(board: Board, sheet: Sheet) -> bytes:
    """The page as a PDF file."""
    lines = []
    dark = True
    for part in _parts(board, sheet):
        if part.dark is not dark:
            dark = part.dark
            lines.append("0 g" if dark else "1 g")
        x, y = part.x * _POINTS, (sheet.height - part.y - part.height) * _POINTS
        lines.append(f"{x:.4f} {y:.4f} {part.width * _POINTS:.4f} {part.height * _POINTS:.4f} re f")
    x, y = (sheet.left + RULE + 6) * _POINTS, 8 * _POINTS
    lines.append(f"0 g BT /F1 8 Tf {x:.2f} {y:.2f} Td ({_words(board)}) Tj ET")
    content = "\n".join(lines).encode("latin-1")
    page = (
        f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {sheet.width * _POINTS:.4f} "
        f"{sheet.height * _POINTS:.4f}] /Contents 4 0 R /Resources << /Font << /F1 5 0 R >> >> >>"
    )
    objects = [
        # A viewer that fits pages to the paper's margins would spoil the scale.
        b"<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        page.encode(),
        b"<< /Length %d >>\nstream\n%s\nendstream" % (len(content), content),
        b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>",
    ]
    out, places = bytearray(b"%PDF-1.4\n"), []
    for number, body in enumerate(objects, 1):
        places.append(len(out))
        out += b"%d 0 obj\n%s\nendobj\n" % (number, body)
    start = len(out)
    out += b"xref\n0 %d\n0000000000 65535 f \n" % (len(objects) + 1)
    out += b"".join(b"%010d 00000 n \n" % place for place in places)
    out += b"trailer\n<< /Size %d /Root 1 0 R >>\nstartxref\n%d\n%%%%EOF\n" % (len(objects) + 1, start)
    return bytes(out)


def png(board: Board, sheet: Sheet, dpi: int = DPI) -> bytes:
    """The page as a PNG file."""
    picture = raster(board, sheet, dpi)
    place = round((sheet.left + RULE + 6) / 25.4 * dpi), round((sheet.height - 8) / 25.4 * dpi)
    text = _words(board).encode("ascii", "replace").decode()
    cv2.putText(picture, text, place, cv2.FONT_HERSHEY_SIMPLEX, dpi / 300, 0, max(1, dpi // 150), cv2.LINE_AA)
    file = cv2.imencode(".png", picture)[1].tobytes()
    # After the header chunk: 8 bytes of signature, 25 of IHDR (PNG specification, 11.3.4.3).
    body = b"pHYs" + struct.pack(">IIB", *[round(dpi / 0.0254)] * 2, 1)
    chunk = struct.pack(">I", len(body) - 4) + body + struct.pack(">I", zlib.crc32(body))
    return file[:33] + chunk + file[33:]


def raster(board: Board, sheet: Sheet, dpi: int) -> NDArray[np.uint8]:
    """The page's rectangles as a grey image; every edge lies on the nearest pixel's."""
    scale = dpi / 25.4
    picture = np.full((round(sheet.height * scale), round(sheet.width * scale)), 255, np.uint8)
    for part in _parts(board, sheet):
        left, top = round(part.x * scale), round(part.y * scale)
        right, bottom = round((part.x + part.width) * scale), round((part.y + part.height) * scale)
        picture[top:bottom, left:right] = 0 if part.dark else 255
    return picture


def _parts(board: Board, sheet: Sheet) -> list[Rectangle]:
    """Everything on the page in mm from its upper left corner."""
    parts = [
        Rectangle(
            sheet.left + 1e3 * part.x,
            sheet.top + 1e3 * part.y,
            1e3 * part.width,
            1e3 * part.height,
            part.dark,
        )
        for part in board.drawing()
    ]
    y = sheet.height - 8.0
    parts.append(Rectangle(sheet.left, y, RULE, 0.3, dark=True))
    for tick in range(11):
        high = 3.0 if tick % 5 == 0 else 1.8
        parts.append(Rectangle(sheet.left + tick * RULE / 10 - 0.1, y - high, 0.2, high, dark=True))
    return parts


def _words(board: Board) -> str:
    """The title in characters that both fonts have."""
    return f"{board.title.replace('×', ' x ')}. The rule is {RULE:g} mm long."
