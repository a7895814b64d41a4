"""Sheets of paper with a calibration board, printed at its true size.

A page is a PDF (version 1.4, black and white rectangles; ISO 32000, 8.5), or a PNG with its resolution
(pixels per metre in a pHYs chunk). A ruler of 100 mm below the board shows whether the printer changed the
scale.
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
from grabbergui.core.environment import write_whole
from grabbergui.core.errors import UsageError

_PAPERS = {"A4": (210, 297), "A3": (297, 420), "A2": (420, 594), "A1": (594, 841), "A0": (841, 1189)}
"Width and height, mm."
_MARGIN = 10.0
"White space around the board, mm, for detectors and printers."
_FOOT = 10.0
"Space for ruler and title below the board, mm."
_RULE = 100.0
"Length of the ruler, mm."
_DPI = 300
"Resolution of a PNG."
_POINTS = 72 / 25.4
"PDF's points in a millimetre."


@dataclass(frozen=True)
class PrintedSheet:
    """A page and the position of the board on it, mm."""

    paper: str
    width: float
    height: float
    left: float
    top: float


def sheet_for(board: Board) -> PrintedSheet:
    """Return the smallest page, upright or landscape, for a board. Raises UsageError if it fits on none."""
    width, height = 1e3 * board.columns * board.square, 1e3 * board.rows * board.square
    for paper, (short, long) in _PAPERS.items():
        for page_width, page_height in ((long, short), (short, long)):
            if width + 2 * _MARGIN <= page_width and height + 2 * _MARGIN + _FOOT <= page_height:
                left, top = (page_width - width) / 2, (page_height - _FOOT - height) / 2
                return PrintedSheet(paper, page_width, page_height, left, top)
    raise UsageError(
        f"a board of {width:g}×{height:g} mm does not fit on A0; choose smaller squares or fewer of them"
    )


def save(board: Board, path: Path) -> PrintedSheet:
    """Write `.pdf` or `.png`; return the paper. Raises UsageError for another kind of file, OSError."""
    kind = path.suffix.lower()
    if kind not in (".pdf", ".png"):
        raise UsageError(f"a board is saved as .pdf or .png, not as '{path.name}'")
    sheet = sheet_for(board)
    write_whole(path, pdf(board, sheet) if kind == ".pdf" else png(board, sheet))
    return sheet


def pdf(board: Board, sheet: PrintedSheet) -> bytes:
    """Return the page as a PDF file."""
    lines = []
    dark = True
    for part in _parts(board, sheet):
        if part.dark is not dark:
            dark = part.dark
            lines.append("0 g" if dark else "1 g")
        x, y = part.x * _POINTS, (sheet.height - part.y - part.height) * _POINTS
        lines.append(f"{x:.4f} {y:.4f} {part.width * _POINTS:.4f} {part.height * _POINTS:.4f} re f")
    x, y = (sheet.left + _RULE + 6) * _POINTS, 8 * _POINTS
    lines.append(f"0 g BT /F1 8 Tf {x:.2f} {y:.2f} Td ({_caption(board)}) Tj ET")
    content = "\n".join(lines).encode("latin-1")
    page = (
        f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {sheet.width * _POINTS:.4f} "
        f"{sheet.height * _POINTS:.4f}] /Contents 4 0 R /Resources << /Font << /F1 5 0 R >> >> >>"
    )
    objects = [
        # Viewers must not fit the page to the paper's margins, which would change the scale.
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


def png(board: Board, sheet: PrintedSheet) -> bytes:
    """Return the page as a PNG file. Raises UsageError if it is too large."""
    image = raster(board, sheet, _DPI)
    place = round((sheet.left + _RULE + 6) / 25.4 * _DPI), round((sheet.height - 8) / 25.4 * _DPI)
    text = _caption(board).encode("ascii", "replace").decode()
    cv2.putText(image, text, place, cv2.FONT_HERSHEY_SIMPLEX, _DPI / 300, 0, max(1, _DPI // 150), cv2.LINE_AA)
    encoded, content = cv2.imencode(".png", image)
    if not encoded:
        raise UsageError(f"a page of {image.shape[1]}×{image.shape[0]} pixels is too large for PNG; take PDF")
    file = content.tobytes()
    # It follows the signature of 8 bytes and the IHDR chunk of 25 (PNG specification, 11.3.4.3).
    body = b"pHYs" + struct.pack(">IIB", *[round(_DPI / 0.0254)] * 2, 1)
    chunk = struct.pack(">I", len(body) - 4) + body + struct.pack(">I", zlib.crc32(body))
    return file[:33] + chunk + file[33:]


def raster(board: Board, sheet: PrintedSheet, dpi: int) -> NDArray[np.uint8]:
    """Return the page's rectangles as a grey image, with edges rounded to whole pixels."""
    scale = dpi / 25.4
    image = np.full((round(sheet.height * scale), round(sheet.width * scale)), 255, np.uint8)
    for part in _parts(board, sheet):
        left, top = round(part.x * scale), round(part.y * scale)
        right, bottom = round((part.x + part.width) * scale), round((part.y + part.height) * scale)
        image[top:bottom, left:right] = 0 if part.dark else 255
    return image


def _parts(board: Board, sheet: PrintedSheet) -> list[Rectangle]:
    """Return all rectangles of the page, in mm from its upper left corner."""
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
    parts.append(Rectangle(sheet.left, y, _RULE, 0.3, dark=True))
    for tick in range(11):
        high = 3.0 if tick % 5 == 0 else 1.8
        parts.append(Rectangle(sheet.left + tick * _RULE / 10 - 0.1, y - high, 0.2, high, dark=True))
    return parts


def _caption(board: Board) -> str:
    """Return the text below the board, in characters that both fonts have."""
    return f"{board.title.replace('×', ' x ')}. The ruler is {_RULE:g} mm long."
