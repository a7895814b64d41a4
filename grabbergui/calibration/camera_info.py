"""Calibrations as camera_info files, the YAML of ROS's camera_info_manager and camera_calibration.

PyYAML reads them, restricted to what such a file needs: mappings, lists, text and numbers as YAML 1.2 has
them (`1e-3` is a number, `on` is text), and the tag of OpenCV's matrices.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from grabbergui.core.calibration import (
    DISTORTION_LENGTH,
    Calibration,
    Matrix,
    given_projection,
    given_rectification,
)
from grabbergui.core.errors import UsageError

MAX_FILE_BYTES = 64 * 1024
_TAG = "tag:yaml.org,2002:"
_OPENCV_DIRECTIVE = re.compile(r"\A\ufeff?%YAML:[\d.]+[ \t]*\r?\n")
"The first line of OpenCV's files, which YAML would write with a blank."


class _Loader(yaml.SafeLoader):  # type: ignore[misc]  # PyYAML has no types
    """Knows the tags below, and takes plain text for a number where YAML 1.2 does."""

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012, PyYAML's own name
    yaml_constructors = {  # noqa: RUF012
        tag: construct
        for tag, construct in yaml.SafeLoader.yaml_constructors.items()
        if tag is None or tag.removeprefix(_TAG) in ("map", "seq", "str", "int", "float", "null")
    }


class _Dumper(yaml.SafeDumper):  # type: ignore[misc]
    """Quotes text that a reader of YAML 1.1 or 1.2 takes for something else; lists go in brackets."""


def _in_brackets(dumper: yaml.SafeDumper, values: list[Any]) -> yaml.Node:
    return dumper.represent_sequence(f"{_TAG}seq", values, flow_style=True)


for _name, _pattern, _first in (
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("int", r"[-+]?(0|[1-9][0-9]{0,17})", list("-+0123456789")),
    ("float", r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?", list("-+.0123456789")),
    ("float", r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)", list("-+.")),
):
    _Loader.add_implicit_resolver(f"{_TAG}{_name}", re.compile(rf"({_pattern})\Z"), _first)
    _Dumper.add_implicit_resolver(f"{_TAG}{_name}", re.compile(rf"({_pattern})\Z"), _first)
_Dumper.add_representer(list, _in_brackets)
_Loader.add_constructor(f"{_TAG}opencv-matrix", yaml.SafeLoader.construct_yaml_map)


def load(path: Path) -> Calibration:
    """Read a camera_info file. Raises UsageError, OSError."""
    return parse(text_of(path), str(path))


def text_of(path: Path) -> str:
    """Return the text of a calibration's file, of any kind of calibration. Raises UsageError, OSError."""
    with path.open("rb") as file:
        content = file.read(MAX_FILE_BYTES + 1)
    if len(content) > MAX_FILE_BYTES:
        raise UsageError(f"{path} is too long for a calibration")
    return content.decode("utf-8", "replace")


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
    """Read a camera_info file's text. Raises UsageError naming `where` and the fault."""
    values = read(text, where)
    model = _text(values, "distortion_model", "plumb_bob")
    if model not in DISTORTION_LENGTH:
        raise UsageError(
            f"{where}: distortion model '{model[:60]}' is not known; there are {', '.join(DISTORTION_LENGTH)}"
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
            _text(values, "camera_name", "camera"),
            rectification=given_rectification(_optional(values, "rectification_matrix", where)),
            rectified=given_projection(_optional(values, "projection_matrix", where)),
        )
    except UsageError as error:
        raise UsageError(f"{where}: {error}") from None


def read(text: str, where: str) -> dict[str, Any]:
    """Return the mapping that a text contains; empty if there is none. Raises UsageError with the line."""
    try:
        values = yaml.load(_OPENCV_DIRECTIVE.sub("", text), _Loader)
    except yaml.MarkedYAMLError as error:
        line = f", line {error.problem_mark.line + 1}" if error.problem_mark is not None else ""
        raise UsageError(f"{where}{line}: {error.problem}") from None
    except (yaml.YAMLError, ValueError, OverflowError, RecursionError) as error:
        raise UsageError(f"{where} is no YAML of a calibration: {error}") from None
    if not isinstance(values, dict | None):
        raise UsageError(f"{where} has no entries 'key: value'")
    return values or {}


def write(values: dict[str, Any]) -> str:
    """Return the text of a mapping; lists of numbers go in brackets."""
    text: str = yaml.dump(values, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=100)
    return text


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
        lengths = f"{_text(entry, 'rows', 'no')[:60]} rows and {_text(entry, 'cols', 'no')[:60]} columns"
        raise UsageError(f"{where}: {key} has {len(data)} numbers for {lengths}")
    return np.array(data, np.float64).reshape(rows, columns)


def _optional(values: dict[str, Any], key: str, where: str) -> Matrix | None:
    return _numbers(values, key, where) if key in values else None


def _text(values: dict[str, Any], key: str, default: str) -> str:
    """Return a text or a number as text, and other things by their kind: aliases can make them huge."""
    value = values.get(key, default)
    return str(value) if isinstance(value, str | int | float) else f"a {type(value).__name__}"


def _size(values: dict[str, Any], key: str, where: str) -> int:
    value = values.get(key)
    if not isinstance(value, int) or not 0 < value < 1 << 16:
        raise UsageError(f"{where}: {key} is {_text(values, key, '')[:60]}, not a number of pixels")
    return value
