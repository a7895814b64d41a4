"""A camera's look-up tables: read, written, made, and kept in files (SFNC 2.7, LUT Control)."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.errors import (
    CameraFileError,
    FeatureAccessError,
    FeatureError,
    TransferCancelledError,
    UsageError,
)
from grabbergui.core.file_access import TURN, Progress
from grabbergui.core.grabber import FrameGrabber

_SELECTOR, _INDEX, _VALUE, _ALL = "LUTSelector", "LUTIndex", "LUTValue", "LUTValueAll"
_PUT_BACK = (_SELECTOR, _INDEX)
MOST_ENTRIES = 1 << 17
"Of a table; a camera that announces more is refused."
_PROBES = 5
"Entries by which the byte order of LUTValueAll is recognised."

Table = NDArray[np.int64]
"One value for each index, 1-D."


@dataclass(frozen=True)
class LutShape:
    """Size and range of a camera's table."""

    entries: int
    maximum: int
    "Largest value."
    whole: bool
    "Whether LUTValueAll moves all entries at once; else each is a write of its own."


def has_lut(grabber: FrameGrabber) -> bool:
    """Whether a camera has a look-up table whose entries can be set."""
    return grabber.has_feature(_INDEX) and grabber.has_feature(_VALUE)


def selectors_of(grabber: FrameGrabber) -> tuple[str, ...]:
    """Return the entries of LUTSelector; one empty text where there is no selector. Blocks."""
    if not grabber.has_feature(_SELECTOR):
        return ("",)
    return tuple(entry.name for entry in grabber.feature(_SELECTOR).entries if entry.available)


def shape_of(grabber: FrameGrabber) -> LutShape:
    """Return the shape of the selected table. Raises UsageError for a camera without one."""
    if not has_lut(grabber):
        raise UsageError(f"{grabber.info.title} has no look-up table (no LUTIndex and LUTValue)")
    last, largest = grabber.feature(_INDEX).maximum, grabber.feature(_VALUE).maximum
    entries = int(last or 0) + 1
    if largest is None or not 2 <= entries <= MOST_ENTRIES:
        raise UsageError(
            f"{grabber.info.title} announces a look-up table of {entries} entries up to {largest};"
            f" tables of 2 to {MOST_ENTRIES} entries can be edited"
        )
    return LutShape(entries, int(largest), _register_length(grabber) in (2 * entries, 4 * entries))


def read_table(
    grabber: FrameGrabber,
    selector: str = "",
    *,
    progress: Progress = lambda done, of: None,
    cancelled: threading.Event | None = None,
) -> Table:
    """Return a table of the camera. Blocks; selectors are put back.

    Raises TransferCancelledError after `cancelled` was set, FeatureError, TransportError, UsageError.
    """
    with grabber.exclusive(_PUT_BACK):
        _select(grabber, selector)
        shape = shape_of(grabber)
        if shape.whole:
            dtype = _layouts(grabber, shape)[0]
            content = grabber.read_register(_ALL, dtype.itemsize * shape.entries)
            progress(shape.entries, shape.entries)
            return np.frombuffer(content, dtype).astype(np.int64)
    table = np.zeros(shape.entries, np.int64)

    def read(index: int) -> None:
        value = _entry(grabber, index)
        if value is None:
            problem = grabber.feature(_VALUE).access_problem()
            raise FeatureAccessError(
                f"entry {index} of the look-up table cannot be read: it {problem}", _VALUE
            )
        table[index] = value

    _each(grabber, selector, shape.entries, read, "reading", progress, cancelled)
    return table


def write_table(
    grabber: FrameGrabber,
    table: Table,
    selector: str = "",
    *,
    progress: Progress = lambda done, of: None,
    cancelled: threading.Event | None = None,
) -> None:
    """Write a table, only entries that differ where each is a write of its own, and read it back. Blocks.

    After `cancelled` was set the entries before are written and the others are not. Raises as `read_table`,
    CameraFileError if what is read back differs, and UsageError for a table of another shape.
    """
    with grabber.exclusive(_PUT_BACK):
        _select(grabber, selector)
        shape = shape_of(grabber)
        _require_fit(table, shape, "this one")
        if shape.whole:
            _write_whole(grabber, table, _layouts(grabber, shape))
            progress(shape.entries, shape.entries)
            return
    values = table.tolist()

    def write(index: int) -> None:
        if _entry(grabber, index) != values[index]:
            grabber.write_feature(_VALUE, values[index])

    _each(grabber, selector, shape.entries, write, "writing", progress, cancelled)


def gamma_table(shape: LutShape, gamma: float) -> Table:
    """Return the curve output = input ** gamma over the whole range; 1 is linear. Raises UsageError."""
    if not 0.05 <= gamma <= 20:
        raise UsageError(f"a gamma of {gamma:g} is not possible; allowed: 0.05 to 20")
    places = np.arange(shape.entries) / (shape.entries - 1)
    return np.rint(places**gamma * shape.maximum).astype(np.int64)


def load_table(path: Path, shape: LutShape) -> Table:
    """Read a table from a file: CSV (values, or index and value a line), or 16-bit values, little-endian.

    Raises UsageError for a file that does not fit.
    """
    try:
        if path.suffix.lower() in (".csv", ".txt"):
            table = _from_text(path.read_text(encoding="utf-8"))
        else:
            table = np.frombuffer(path.read_bytes(), "<u2").astype(np.int64)
    except (OSError, ValueError, OverflowError) as error:
        raise UsageError(f"{path} cannot be read as a look-up table: {error}") from error
    _require_fit(table, shape, str(path))
    return table


def save_table(path: Path, table: Table) -> None:
    """Write a table in the format of its suffix, as `load_table` reads it.

    Raises UsageError for values that do not fit into that format, and OSError.
    """
    if path.suffix.lower() in (".csv", ".txt"):
        lines = [f"{index},{value}" for index, value in enumerate(table.tolist())]
        path.write_text("index,value\n" + "\n".join(lines) + "\n", encoding="utf-8")
    elif table.max(initial=0) > 0xFFFF:
        raise UsageError(f"values up to {table.max()} do not fit into 16 bits; save it as .csv")
    else:
        path.write_bytes(table.astype("<u2").tobytes())


def _require_fit(table: Table, shape: LutShape, name: str) -> None:
    """Raise UsageError for a table that the camera's cannot hold; `name` is used in the message."""
    if table.shape != (shape.entries,) or table.min() < 0 or table.max() > shape.maximum:
        ends = f" from {table.min()} to {table.max()}" if table.size else ""
        raise UsageError(
            f"the camera's look-up table has {shape.entries} entries from 0 to {shape.maximum}; {name} has"
            f" {table.size} values{ends}"
        )


def _from_text(text: str) -> Table:
    rows = [line.replace(";", ",").split(",") for line in text.splitlines() if line.strip()]
    if rows and not rows[0][-1].strip().lstrip("-").isdigit():
        rows = rows[1:]  # the names of the columns
    if len(rows) == 1 and len(rows[0]) > 2:
        return np.array([int(value) for value in rows[0]], np.int64)
    values = [int(row[-1]) for row in rows]
    if any(len(row) == 2 and int(row[0]) != index for index, row in enumerate(rows)):
        raise ValueError("its indices do not count from 0")
    return np.array(values, np.int64)


def _select(grabber: FrameGrabber, selector: str) -> None:
    if selector and grabber.feature(_SELECTOR).value != selector:
        grabber.write_feature(_SELECTOR, selector)


def _entry(grabber: FrameGrabber, index: int) -> int | None:
    """Return an entry; None where it cannot be read."""
    grabber.write_feature(_INDEX, index)
    value = grabber.feature(_VALUE).value
    return int(value) if isinstance(value, int | float) else None


def _register_length(grabber: FrameGrabber) -> int:
    """Return the bytes of LUTValueAll; 0 where it cannot be had."""
    try:
        return grabber.register_length(_ALL)
    except FeatureError:
        return 0


_Dtype = np.dtype[np.unsignedinteger]


def _layouts(grabber: FrameGrabber, shape: LutShape) -> list[_Dtype]:
    """Return the types that the register's values may be of, as SFNC leaves their byte order to the maker.

    There are two where every value is the same in either order, such as 257 times its index.
    """
    size = _register_length(grabber) // shape.entries
    content = grabber.read_register(_ALL, size * shape.entries)
    dtypes: list[_Dtype] = [np.dtype(f"{order}u{size}") for order in "><"]
    tables = [np.frombuffer(content, dtype) for dtype in dtypes]
    places = _places(np.not_equal(*tables))
    values = [_entry(grabber, place) for place in places]
    fitting = [each for each, table in zip(dtypes, tables, strict=True) if table[places].tolist() == values]
    if not fitting:
        raise UsageError("LUTValueAll has other values than LUTIndex and LUTValue; its layout is not known")
    return fitting


def _places(telling: NDArray[np.bool_]) -> list[int]:
    """Return where to compare entries; one of them is `telling`, if any is."""
    spread = np.linspace(0, len(telling) - 1, _PROBES).astype(int)
    places: list[int] = np.unique(np.concatenate((spread, telling.nonzero()[0][:1]))).tolist()
    return places


def _write_whole(grabber: FrameGrabber, table: Table, layouts: list[_Dtype]) -> None:
    """Write LUTValueAll and read it back. Raises CameraFileError."""
    for dtype in layouts:
        content = table.astype(dtype).tobytes()
        grabber.write_register(_ALL, content)
        if grabber.read_register(_ALL, len(content)) != content:
            break
        places = _places(table != table.astype(dtype).byteswap()) if len(layouts) > 1 else []
        if [_entry(grabber, place) for place in places] == table[places].tolist():
            return
    raise CameraFileError("the look-up table reads back differently; write it again", _ALL, "Read")


def _each(
    grabber: FrameGrabber,
    selector: str,
    entries: int,
    act: Callable[[int], None],
    doing: str,
    progress: Progress,
    cancelled: threading.Event | None,
) -> None:
    """Call `act` with each index; now and then other callers get in between."""
    index = 0
    while index < entries:
        with grabber.exclusive(_PUT_BACK):
            _select(grabber, selector)
            end = time.monotonic() + TURN
            while index < entries and time.monotonic() < end:
                if cancelled is not None and cancelled.is_set():
                    raise TransferCancelledError(
                        f"{doing} the look-up table: cancelled after {index} of {entries} entries", _ALL
                    )
                act(index)
                index += 1
                progress(index, entries)
        time.sleep(0)
