"""Calibrations as camera_info files, the YAML of ROS's camera_info_manager and camera_calibration.

The little of YAML that these files are made of: mappings by indentation, one or two levels deep; plain and
quoted scalars; lists of numbers in brackets, which may go on over several lines, or in lines that begin with
a dash. Anything else is refused.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from grabbergui.core.calibration import (
    DISTORTION_LENGTH,
    Calibration,
    Matrix,
    given_projection,
    given_rectification,
)
from grabbergui.core.errors import UsageError

MAX_FILE_BYTES = 64 * 1024

_ENTRY = re.compile(r"( *)([A-Za-z_][\w.-]*) *:(?: +(.*))?")
_INTEGER = re.compile(r"[-+]?\d{1,18}", re.ASCII)
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", re.ASCII)
_QUOTED = re.compile(r"""'((?:[^']|'')*)'|"((?:[^"\\]|\\.)*)\"""")
_ESCAPED = re.compile(r"\\(.)")
_ESCAPES = {"n": "\n", "t": "\t"}
"What an escaped letter stands for; other signs stand for themselves."
_PLAIN = re.compile(r"(?!(?:y|n|yes|no|on|off|true|false|null)$)[A-Za-z_][\w./-]*", re.ASCII | re.IGNORECASE)
"Text that needs no quotes: YAML 1.1 takes the words left out for truth values or nothing."


def load(path: Path) -> Calibration:
    """Read a camera_info file. Raises UsageError, OSError."""
    if path.stat().st_size > MAX_FILE_BYTES:
        raise UsageError(f"{path} is too long for a calibration")
    return parse(path.read_text("utf-8", "replace"), str(path))


def save(calibration: Calibration, path: Path) -> None:
    """Write a file that camera_info_manager reads. Raises OSError."""
    path.write_text(dump(calibration), "utf-8")


def dump(calibration: Calibration) -> str:
    """Return the text of a camera_info file."""
    return write(
        {
            "image_width": calibration.width,
            "image_height": calibration.height,
            "camera_name": calibration.camera_name,
            "camera_matrix": _matrix(calibration.matrix),
            "distortion_model": calibration.distortion_model,
            "distortion_coefficients": _matrix(calibration.distortion[None]),
            "rectification_matrix": _matrix(calibration.rectification),
            "projection_matrix": _matrix(calibration.projection),
        }
    )


def parse(text: str, where: str = "calibration") -> Calibration:
    """Read a camera_info file's text. Raises UsageError naming `where` and what is wrong."""
    values = read(text, where)
    model = str(values.get("distortion_model", "plumb_bob"))
    if model not in DISTORTION_LENGTH:
        raise UsageError(
            f"{where}: distortion model '{model}' is not known; there are {', '.join(DISTORTION_LENGTH)}"
        )
    coefficients = _numbers(values, "distortion_coefficients", where).reshape(-1)
    # Older files leave out zeros at the end.
    padding = DISTORTION_LENGTH[model] - coefficients.size
    if padding < 0:
        raise UsageError(f"{where}: {coefficients.size} coefficients are too many for {model}")
    matrix = _numbers(values, "camera_matrix", where)
    if matrix.shape != (3, 3):
        raise UsageError(f"{where}: camera_matrix is {matrix.shape}, not 3×3")
    try:
        return Calibration(
            _size(values, "image_width", where),
            _size(values, "image_height", where),
            matrix,
            np.pad(coefficients, (0, padding)),
            str(values.get("camera_name", "camera")),
            rectification=given_rectification(_optional(values, "rectification_matrix", where)),
            rectified=given_projection(_optional(values, "projection_matrix", where)),
        )
    except UsageError as error:
        raise UsageError(f"{where}: {error}") from None


def read(text: str, where: str) -> dict[str, Any]:
    """Keys to numbers, text, lists of scalars, or one more such mapping. Raises UsageError with the line."""
    values: dict[str, Any] = {}
    inner: dict[str, Any] | None = None
    lines = enumerate(text.splitlines(), 1)
    target, key = values, ""
    for number, raw in lines:
        line = raw.rstrip()
        if not line or line.lstrip().startswith("#") or line.split(" #")[0].rstrip() in ("---", "..."):
            continue
        if line.startswith("%YAML"):
            continue
        if line.lstrip().startswith("- ") and key:
            if not isinstance(target.get(key), list):
                target[key] = []
            target[key].append(_scalar(_uncommented(line.lstrip()[2:])))
            continue
        match = _ENTRY.fullmatch(line)
        if not match:
            raise UsageError(f"{where}, line {number}: '{line.strip()[:60]}' is not 'key: value'")
        indentation, key, value = match[1], match[2], _uncommented(match[3] or "")
        if indentation and inner is None:
            raise UsageError(f"{where}, line {number}: '{key}' is indented below nothing")
        target = inner if indentation and inner is not None else values
        if not value or value.startswith("!!"):
            if indentation:
                target[key] = []  # a list in dashes follows, or nothing
            else:
                inner = values[key] = {}
            continue
        while value.startswith("[") and "]" not in value:
            try:
                value += " " + _uncommented(next(lines)[1])
            except StopIteration:
                raise UsageError(f"{where}, line {number}: the list of '{key}' has no end") from None
        target[key] = _list(value) if value.startswith("[") else _scalar(value)
    return values


def write(values: dict[str, Any]) -> str:
    """The text of such a mapping."""
    lines = []
    for key, value in values.items():
        if isinstance(value, dict):
            lines.append(f"{key}:")
            lines += [f"  {name}: {_text(inner)}" for name, inner in value.items()]
        else:
            lines.append(f"{key}: {_text(value)}")
    return "\n".join(lines) + "\n"


def _uncommented(text: str) -> str:
    """A value without the comment behind it; within quotes there is none."""
    text = text.strip()
    quoted = _QUOTED.match(text)
    if quoted is not None:
        return quoted[0] if text[quoted.end() :].lstrip()[:1] in ("", "#") else text
    return "" if text.startswith("#") else text.split(" #")[0].rstrip()


def _list(text: str) -> list[Any]:
    inside = text[1 : text.index("]")].strip()
    return [_scalar(part.strip()) for part in inside.split(",") if part.strip()]


def _scalar(text: str) -> int | float | str:
    text = text.strip()
    quoted = _QUOTED.fullmatch(text)
    if quoted is not None and quoted[1] is not None:
        return quoted[1].replace("''", "'")
    if quoted is not None:
        return _ESCAPED.sub(lambda sign: _ESCAPES.get(sign[1], sign[1]), quoted[2])
    if _INTEGER.fullmatch(text):
        return int(text)
    if _NUMBER.fullmatch(text):
        return float(text)
    return {".nan": float("nan"), ".inf": float("inf"), "-.inf": -float("inf")}.get(text.lower(), text)


def _text(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_text, value))}]"
    if isinstance(value, float):
        # YAML 1.1 takes 1e-05 for text: a number needs its point.
        text = repr(value)
        return text.replace("e", ".0e") if "e" in text and "." not in text else text
    if isinstance(value, str) and not _PLAIN.fullmatch(value):
        # In single quotes nothing but they themselves means anything; a line's end would end the value.
        return "'" + " ".join(value.splitlines()).replace("'", "''") + "'"
    return str(value)


def _matrix(values: Matrix) -> dict[str, Any]:
    return {"rows": values.shape[0], "cols": values.shape[1], "data": [float(v) for v in values.flat]}


def _numbers(values: dict[str, Any], key: str, where: str) -> Matrix:
    """A matrix entry, checked: rows × cols finite numbers."""
    entry = values.get(key)
    if not isinstance(entry, dict) or not isinstance(entry.get("data"), list):
        raise UsageError(f"{where}: {key} is missing, or has no list 'data'")
    data, rows, columns = entry["data"], entry.get("rows"), entry.get("cols")
    if not all(isinstance(value, (int, float)) for value in data):
        raise UsageError(f"{where}: {key} holds something that is no number")
    if not isinstance(rows, int) or not isinstance(columns, int) or rows * columns != len(data) or rows < 1:
        raise UsageError(f"{where}: {key} has {len(data)} numbers for {rows} rows and {columns} columns")
    return np.array(data, np.float64).reshape(rows, columns)


def _optional(values: dict[str, Any], key: str, where: str) -> Matrix | None:
    return _numbers(values, key, where) if key in values else None


def _size(values: dict[str, Any], key: str, where: str) -> int:
    value = values.get(key)
    if not isinstance(value, int) or not 0 < value < 1 << 16:
        raise UsageError(f"{where}: {key} is {value}, not a number of pixels")
    return value
