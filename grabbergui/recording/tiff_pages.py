"""The pages of a TIFF file (TIFF 6.0, and BigTIFF), each of which is a frame.

A page is an image file directory (IFD): tags with sizes, format and the places of strips. Uncompressed pages
in one piece are read directly, so that a stack of gigabytes plays page by page; OpenCV decodes others. ImageJ
writes stacks beyond 4 GiB as one page, whose description (`images=N`) has the number of images in it.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable
from dataclasses import dataclass
from io import BufferedReader
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.encoded_image import LARGEST_SIDE, MOST_PIXELS
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.core.regular_files import open_regular, read_bounded

SUFFIXES = (".tif", ".tiff")
MOST_PAGES = 1_000_000
MOST_TAGS = 500
MOST_VALUES = 5_000_000
"Most tags and strips of all pages; directories can overlap, and name the same strips again and again."
MAX_DESCRIPTION = 1 << 16
MAX_COMPRESSED_BYTES = 1 << 30
"Bytes of the largest file whose pages OpenCV decodes, which needs all of it in memory."
_WIDTH, _HEIGHT, _BITS, _COMPRESSION, _PHOTOMETRIC, _DESCRIPTION = 256, 257, 258, 259, 262, 270
_OFFSETS, _SAMPLES, _LENGTHS, _PLANAR, _TILE, _FORMAT = 273, 277, 279, 284, 322, 339
_SIZES = {
    1: 1,
    2: 1,
    3: 2,
    4: 4,
    5: 8,
    6: 1,
    7: 1,
    8: 2,
    9: 4,
    10: 8,
    11: 4,
    12: 8,
    13: 4,
    16: 8,
    17: 8,
    18: 8,
}
"Bytes of a value by its type."
_CODES = {1: "B", 3: "H", 4: "I", 13: "I", 16: "Q", 18: "Q"}
"How `struct` reads the types of whole numbers."
_KINDS = {1: "u", 2: "i", 3: "f"}
"NumPy's kind of each SampleFormat."
_IMAGEJ = re.compile(rb"\AImageJ=[^\n]*\n(?:[^\n]*\n)*?images=(\d{1,7})\n")


@dataclass(frozen=True)
class Page:
    """A page of a file."""

    number: int
    width: int
    height: int
    dtype: str = ""
    "NumPy's type of its samples, if it can be read directly; else empty."
    samples: int = 1
    offset: int = 0
    "Where its samples begin."


def pages_of(path: Path) -> list[Page]:
    """Return the pages of a file, up to the first that is damaged; none if it is no TIFF.

    Raises UsageError, OSError.
    """
    with open_regular(path) as file:
        return _pages(file)


def read_page(path: Path, page: Page) -> NDArray[Any]:
    """Return a page in OpenCV's layout: (height, width[, 3 or 4]), colours as B G R A.

    Raises RemoteProtocolError for a damaged one, UsageError, OSError.
    """
    if page.width > LARGEST_SIDE or page.height > LARGEST_SIDE or page.width * page.height > MOST_PIXELS:
        raise RemoteProtocolError(
            f"page {page.number} announces {page.width}×{page.height} pixels; "
            f"at most {MOST_PIXELS} are decoded"
        )
    if page.dtype:
        count = page.width * page.height * page.samples
        with open_regular(path) as file:
            file.seek(page.offset)
            content = file.read(count * np.dtype(page.dtype).itemsize)
        if len(content) < count * np.dtype(page.dtype).itemsize:
            raise RemoteProtocolError(f"page {page.number} was cut short")
        pixels = np.frombuffer(content, page.dtype)
        pixels = pixels.astype(pixels.dtype.newbyteorder("<"), copy=False)
        shape = (page.height, page.width, page.samples)[: 3 if page.samples > 1 else 2]
        colours = [2, 1, 0, 3][: page.samples]
        return pixels.reshape(shape)[..., colours] if page.samples > 1 else pixels.reshape(shape)
    content = read_bounded(path, MAX_COMPRESSED_BYTES, "compressed TIFF file")
    try:
        done, mats = cv2.imdecodemulti(
            np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED, range=(page.number, page.number + 1)
        )
    except cv2.error:
        done, mats = False, ()
    if not done or len(mats) != 1:
        raise RemoteProtocolError(f"page {page.number} is damaged, or of a kind that cannot be decoded")
    return np.asarray(mats[0])


def _pages(file: BufferedReader) -> list[Page]:
    size = file.seek(0, 2)
    file.seek(0)
    head = file.read(16)
    order = {b"II": "<", b"MM": ">"}.get(head[:2])
    if order is None or len(head) < 16:
        return []
    version = struct.unpack_from(f"{order}H", head, 2)[0]
    if version == 42:
        layout, at = _DirectoryLayout(order, "H", "I", 4), struct.unpack_from(f"{order}I", head, 4)[0]
    elif version == 43:
        layout, at = _DirectoryLayout(order, "Q", "Q", 8), struct.unpack_from(f"{order}Q", head, 8)[0]
    else:
        return []
    pages: list[Page] = []
    seen: set[int] = set()
    values = 0
    while at and at not in seen and len(pages) < MOST_PAGES and values < MOST_VALUES:
        seen.add(at)
        try:
            tags, at = layout.directory(file, at, size)
            page, strips = _page(len(pages), tags, order, size)
            pages.append(page)
            values += len(tags) + strips
        except (struct.error, ValueError, KeyError, IndexError):
            break
        if not at and len(pages) == 1:
            pages = _of_imagej(pages[0], tags, size)
    return pages


@dataclass(frozen=True)
class _DirectoryLayout:
    """The layout of directories: of TIFF or BigTIFF, in one byte order."""

    order: str
    count: str
    place: str
    "`struct`'s codes of the number of tags, and of counts and offsets."
    inline: int
    "Bytes of a value that is in the directory itself."

    def directory(
        self, file: BufferedReader, at: int, size: int
    ) -> tuple[dict[int, Callable[[], tuple[int, ...] | bytes]], int]:
        """Return readers of the tags' values, and where the next directory is.

        Raises struct.error, ValueError.
        """
        entry = 4 + 2 * struct.calcsize(f"={self.place}")
        file.seek(at)
        head = file.read(struct.calcsize(f"={self.count}"))
        (count,) = struct.unpack(f"{self.order}{self.count}", head)
        if count > MOST_TAGS:
            raise ValueError(count)
        content = file.read(count * entry + struct.calcsize(f"={self.place}"))
        tags: dict[int, Callable[[], tuple[int, ...] | bytes]] = {}
        for index in range(count):
            tag, kind, number = struct.unpack_from(f"{self.order}HH{self.place}", content, index * entry)
            value = content[(index + 1) * entry - self.inline : (index + 1) * entry]
            tags[tag] = self._reader(file, kind, number, value, size)
        (following,) = struct.unpack_from(f"{self.order}{self.place}", content, count * entry)
        return tags, int(following)

    def _reader(
        self, file: BufferedReader, kind: int, number: int, value: bytes, size: int
    ) -> Callable[[], tuple[int, ...] | bytes]:
        def read() -> tuple[int, ...] | bytes:
            if number > MOST_VALUES:
                raise ValueError(number)
            length = _SIZES[kind] * number if kind != 2 else min(number, MAX_DESCRIPTION)
            content = value[:length]
            if length > self.inline:
                (place,) = struct.unpack(f"{self.order}{self.place}", value)
                if place + length > size:
                    raise ValueError(place)
                file.seek(place)
                content = file.read(length)
            if kind == 2:
                return content
            return struct.unpack(f"{self.order}{number}{_CODES[kind]}", content)

        return read


def _page(number: int, tags: dict[int, Callable[[], Any]], order: str, size: int) -> tuple[Page, int]:
    """Return a page, and the number of its strips if they were read.

    Raises ValueError, KeyError, struct.error.
    """

    def values(tag: int, *default: int) -> tuple[int, ...]:
        return tuple(tags[tag]()) if tag in tags else default

    (width,), (height,) = values(_WIDTH), values(_HEIGHT)
    page = Page(number, width, height)
    bits, samples = values(_BITS, 1), values(_SAMPLES, 1)[0]
    kind = _KINDS.get(values(_FORMAT, 1)[0])
    dtype = f"{order}{kind}{bits[0] // 8}"
    direct = (
        values(_COMPRESSION, 1)[0] == 1
        and values(_PHOTOMETRIC, 1)[0] == (2 if samples > 1 else 1)
        and (samples == 1 or values(_PLANAR, 1)[0] == 1)
        and _TILE not in tags
        and len(set(bits)) == 1
        and kind is not None
        and bits[0] in ((8, 16, 32, 64) if kind != "f" else (32, 64))
        and samples in (1, 3, 4)
    )
    if not direct:
        return page, 0
    offsets, lengths = values(_OFFSETS), values(_LENGTHS)
    whole = width * height * samples * bits[0] // 8
    in_one_piece = all(
        place + length == after for place, length, after in zip(offsets, lengths, offsets[1:], strict=False)
    )
    if not in_one_piece or sum(lengths) < whole or offsets[0] + whole > size:
        return page, len(offsets)
    return Page(number, width, height, dtype, samples, offsets[0]), len(offsets)


def _of_imagej(page: Page, tags: dict[int, Callable[[], Any]], size: int) -> list[Page]:
    """Return the pages of a stack of ImageJ's that has one directory; else the page itself."""
    described = tags[_DESCRIPTION]() if _DESCRIPTION in tags and page.dtype else b""
    found = _IMAGEJ.match(described) if isinstance(described, bytes) else None
    if found is None:
        return [page]
    length = page.width * page.height * page.samples * np.dtype(page.dtype).itemsize
    count = min(int(found[1]), (size - page.offset) // max(length, 1))
    return [
        Page(number, page.width, page.height, page.dtype, page.samples, page.offset + number * length)
        for number in range(max(count, 1))
    ]
