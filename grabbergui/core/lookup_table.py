"""Reads, writes, computes, loads and saves a camera's look-up tables (SFNC 2.7, LUT Control)."""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.environment import write_whole
from grabbergui.core.errors import (
    CameraFileError,
    FeatureAccessError,
    FeatureError,
    TransferCancelledError,
    UsageError,
)
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.file_access import TURN, Progress
from grabbergui.core.register_source import RegisterSource
from grabbergui.core.regular_files import read_bounded

_SELECTOR, _INDEX, _VALUE, _ALL = "LUTSelector", "LUTIndex", "LUTValue", "LUTValueAll"
_RESTORED = (_SELECTOR, _INDEX)
MOST_ENTRIES = 1 << 17
"Entries of the largest table that is accepted."
_MOST_BYTES = 32 * MOST_ENTRIES
"Size of the largest file of a table; a line of text has an index and a value."
LEAST_GAMMA, MOST_GAMMA = 0.05, 20.0
"Exponents that `gamma_table` computes."
_PROBES = 5
"Entries that are compared to recognise the byte order of LUTValueAll."

Table = NDArray[np.int64]
"One value for each index, 1-D."
_SEPARATORS = re.compile(r"[,;\s]+")
_Dtype = np.dtype[np.unsignedinteger]


@dataclass(frozen=True)
class LutShape:
    """Size and range of a camera's table."""

    entries: int
    maximum: int
    "Largest value."
    whole: bool
    "Whether LUTValueAll transfers all entries in one go; else each needs a write of its own."


def has_lut(grabber: FeatureSource) -> bool:
    """Return whether a camera has a look-up table whose entries can be set."""
    return grabber.has_feature(_INDEX) and grabber.has_feature(_VALUE)


def selectors_of(grabber: FeatureSource) -> tuple[str, ...]:
    """Return the entries of LUTSelector, or one empty text without a selector. Blocks."""
    if not grabber.has_feature(_SELECTOR):
        return ("",)
    return tuple(entry.name for entry in grabber.feature(_SELECTOR).entries if entry.available)


def shape_of(grabber: RegisterSource) -> LutShape:
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
    grabber: RegisterSource,
    selector: str = "",
    *,
    progress: Progress = lambda done, of: None,
    cancelled: threading.Event | None = None,
) -> Table:
    """Return a table of the camera, and restore its selectors. Blocks.

    Raises TransferCancelledError after `cancelled` was set, FeatureError, TransportError, UsageError.
    """
    with grabber.exclusive(_RESTORED):
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
    grabber: RegisterSource,
    table: Table,
    selector: str = "",
    *,
    progress: Progress = lambda done, of: None,
    cancelled: threading.Event | None = None,
) -> None:
    """Write a table. Blocks.

    A table that is written as a whole is read back and compared; one that is written entry by entry, only
    where it differs. If `cancelled` is set, the entries before are written and the others are not. Raises as
    `read_table`, CameraFileError if the table reads back differently, and UsageError for another shape.
    """
    with grabber.exclusive(_RESTORED):
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
    if not LEAST_GAMMA <= gamma <= MOST_GAMMA:
        raise UsageError(f"a gamma of {gamma:g} is not possible; allowed: {LEAST_GAMMA:g} to {MOST_GAMMA:g}")
    inputs = np.arange(shape.entries) / (shape.entries - 1)
    return np.rint(inputs**gamma * shape.maximum).astype(np.int64)


def gamma_of(shape: LutShape, table: Table) -> float | None:
    """Return the gamma, to hundredths, whose curve the table is; None if it is another curve.

    Values may differ by one step of the input: cameras truncate, or multiply by a power of two.
    """
    step = max(shape.maximum / (shape.entries - 1), 1)
    inputs = np.arange(shape.entries) / (shape.entries - 1)
    outputs = table / shape.maximum
    inner = (inputs > 0) & (inputs < 1) & (outputs > 0) & (outputs < 1)
    if not inner.any():
        return None
    # The slope of log(output) over log(input); dark entries, which rounding changes most, count least.
    x, y, weight = np.log(inputs[inner]), np.log(outputs[inner]), outputs[inner] ** 2
    slope = float((weight * x * y).sum() / (weight * x * x).sum())
    for gamma in (round(slope, 2), slope):
        fits = LEAST_GAMMA <= gamma <= MOST_GAMMA
        if fits and np.abs(gamma_table(shape, gamma) - table).max() <= step:
            return round(gamma, 2)
    return None


def load_table(path: Path, shape: LutShape) -> Table:
    """Read a table from a file: text (values, or index and value a line), or 16-bit values, little-endian.

    Raises UsageError for a file that does not fit.
    """
    try:
        content = read_bounded(path, _MOST_BYTES, "look-up table")
        if path.suffix.lower() in (".csv", ".txt"):
            table = _from_text(content.decode("utf-8-sig", "replace"))
        elif len(content) % 2:
            raise ValueError(f"{len(content)} bytes are not 16-bit values")
        else:
            table = np.frombuffer(content, "<u2").astype(np.int64)
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror or error}") from error
    except ValueError as error:
        raise UsageError(f"{path} cannot be read as a look-up table: {error}") from error
    _require_fit(table, shape, str(path))
    return table


def save_table(path: Path, table: Table) -> None:
    """Write a table in the format of its suffix, as `load_table` reads it.

    Raises UsageError for values that do not fit into that format, and OSError.
    """
    if path.suffix.lower() in (".csv", ".txt"):
        lines = [f"{index},{value}" for index, value in enumerate(table.tolist())]
        write_whole(path, "index,value\n" + "\n".join(lines) + "\n")
    elif table.max(initial=0) > 0xFFFF:
        raise UsageError(f"values up to {table.max()} do not fit into 16 bits; save it as .csv")
    else:
        write_whole(path, table.astype("<u2").tobytes())


def _require_fit(table: Table, shape: LutShape, name: str) -> None:
    """Raise UsageError for a table that does not fit the camera's; `name` is used in the message."""
    if table.shape != (shape.entries,) or table.min() < 0 or table.max() > shape.maximum:
        ends = f" from {table.min()} to {table.max()}" if table.size else ""
        raise UsageError(
            f"the camera's look-up table has {shape.entries} entries from 0 to {shape.maximum}; {name} has"
            f" {table.size} values{ends}"
        )


def _from_text(text: str) -> Table:
    """Return the table of a text, a first line of which may name the columns. Raises ValueError."""
    rows = [
        (line, _SEPARATORS.split(content.strip(" ,;\t")))
        for line, content in enumerate(text.splitlines(), 1)
        if content.strip()
    ]
    if rows and all(_number(field) is None for field in rows[0][1]):
        rows = rows[1:]
    if len(rows) == 1 and len(rows[0][1]) > 2:
        line, fields = rows[0]
        rows = [(line, [field]) for field in fields]
    values = []
    for index, (line, fields) in enumerate(rows):
        *before, value = (_whole(field, line) for field in fields)
        if len(before) > 1:
            raise ValueError(f"line {line} has {len(fields)} columns; allowed: a value, or index and value")
        if before and before != [index]:
            raise ValueError(f"its indices do not count up from 0: line {line} has {before[0]}")
        values.append(value)
    return np.array(values, np.int64)


def _whole(field: str, line: int) -> int:
    number = _number(field)
    if number is None or not number.is_integer() or abs(number) >= 2**53:
        raise ValueError(f"'{field[:20]}' in line {line} is not a whole number")
    return int(number)


def _number(field: str) -> float | None:
    try:
        return float(field)
    except ValueError:
        return None


def _select(grabber: FeatureSource, selector: str) -> None:
    if selector and grabber.feature(_SELECTOR).value != selector:
        grabber.write_feature(_SELECTOR, selector)


def _entry(grabber: FeatureSource, index: int) -> int | None:
    """Return an entry; None if it cannot be read."""
    grabber.write_feature(_INDEX, index)
    value = grabber.feature(_VALUE).value
    return int(value) if isinstance(value, int | float) else None


def _register_length(grabber: RegisterSource) -> int:
    """Return the size of LUTValueAll in bytes; 0 without access to it."""
    try:
        return grabber.register_length(_ALL)
    except FeatureError:
        return 0


def _layouts(grabber: RegisterSource, shape: LutShape) -> list[_Dtype]:
    """Return the possible types of the register's values, as SFNC leaves their byte order to the vendor.

    There are two if every value reads the same in either order, such as 257 times its index.
    """
    size = _register_length(grabber) // shape.entries
    content = grabber.read_register(_ALL, size * shape.entries)
    dtypes: list[_Dtype] = [np.dtype(f"{order}u{size}") for order in "><"]
    tables = [np.frombuffer(content, dtype) for dtype in dtypes]
    indices = _probes(np.not_equal(*tables))
    values = [_entry(grabber, index) for index in indices]
    fitting = [each for each, table in zip(dtypes, tables, strict=True) if table[indices].tolist() == values]
    if not fitting:
        raise UsageError("LUTValueAll has other values than LUTIndex and LUTValue; its layout is not known")
    return fitting


def _probes(differs: NDArray[np.bool_]) -> list[int]:
    """Return the indices of the entries to compare, at least one that `differs` by byte order if any does."""
    spread = np.linspace(0, len(differs) - 1, _PROBES).astype(int)
    indices: list[int] = np.unique(np.concatenate((spread, differs.nonzero()[0][:1]))).tolist()
    return indices


def _write_whole(grabber: RegisterSource, table: Table, layouts: list[_Dtype]) -> None:
    """Write LUTValueAll and read it back. Raises CameraFileError."""
    for dtype in layouts:
        content = table.astype(dtype).tobytes()
        grabber.write_register(_ALL, content)
        if grabber.read_register(_ALL, len(content)) != content:
            break
        indices = _probes(table != table.astype(dtype).byteswap()) if len(layouts) > 1 else []
        if [_entry(grabber, index) for index in indices] == table[indices].tolist():
            return
    raise CameraFileError("the look-up table reads back differently; write it again", _ALL, "Read")


def _each(
    grabber: FeatureSource,
    selector: str,
    entries: int,
    act: Callable[[int], None],
    doing: str,
    progress: Progress,
    cancelled: threading.Event | None,
) -> None:
    """Call `act` with each index; other callers get their turn in between."""
    index = 0
    while index < entries:
        with grabber.exclusive(_RESTORED):
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
