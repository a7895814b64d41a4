"""Files of a camera's calibration; the counterpart of ROS's camera_info_manager.

Files are camera_info YAML, as camera_info_manager and camera_calibration write it. PyYAML reads them,
restricted to mappings, lists, text, numbers as in YAML 1.2 (`1e-3` is a number, `on` is text), and the tag of
OpenCV's matrices. ROS ignores `camera_model` and `camera_serial`, which name the camera, and
`image_geometry`, which says where its images lie on the sensor.
"""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import numpy as np

from grabbergui.calibration import ost_ini
from grabbergui.calibration.opencv_yaml import MAX_FILE_BYTES, read_documents, text_of, write_yaml
from grabbergui.core.calibration import (
    DISTORTION_LENGTH,
    FISHEYE,
    Calibration,
    Matrix,
    given_projection,
    given_rectification,
)
from grabbergui.core.environment import write_whole
from grabbergui.core.errors import UsageError
from grabbergui.core.identity import DeviceInfo, describe
from grabbergui.core.image_geometry import ImageGeometry

log = logging.getLogger(__name__)

_KEYS = ("image_width", "image_height", "camera_matrix", "distortion_coefficients")


_GEOMETRY = "image_geometry"
_GEOMETRY_KEYS = (
    "width_max",
    "height_max",
    "offset_x",
    "offset_y",
    "binning_x",
    "binning_y",
    "reverse_x",
    "reverse_y",
)

_MODELS = {"fisheye": FISHEYE}
"Distortion models by other names than ROS's."


def load(path: Path) -> Calibration:
    """Read a camera_info file. Raises UsageError, OSError."""
    return parse(text_of(path), str(path))


def load_for(info: DeviceInfo, path: Path) -> Calibration:
    """Read a camera's file; log a warning if it was made with another one. Raises UsageError, OSError."""
    calibration = load(path)
    if calibration.is_of_another(info):
        log.warning(
            "%s was made with another camera, %s %s; this one is %s: calibrate it as well",
            path,
            calibration.camera_model,
            calibration.camera_serial,
            describe(info),
        )
    return calibration


def save(calibration: Calibration, path: Path) -> None:
    """Write a camera_info file. Raises OSError, and UsageError for one that `load` would refuse."""
    text = dump(calibration)
    if len(text.encode()) > MAX_FILE_BYTES:
        raise UsageError(f"{path}: a calibration of {len(text)} characters is too long")
    parse(text, str(path))
    write_whole(path, text)


def dump(calibration: Calibration) -> str:
    """Return the text of a camera_info file."""
    camera = {"camera_model": calibration.camera_model, "camera_serial": calibration.camera_serial}
    geometry = calibration.geometry
    return write_yaml(
        {
            "image_width": calibration.width,
            "image_height": calibration.height,
            "camera_name": calibration.camera_name,
            **{key: value for key, value in camera.items() if value},
            **({} if geometry is None else {_GEOMETRY: _geometry_entry(geometry)}),
            "camera_matrix": _matrix(calibration.matrix),
            "distortion_model": calibration.distortion_model,
            "distortion_coefficients": _matrix(calibration.distortion[None]),
            "rectification_matrix": _matrix(calibration.rectification),
            "projection_matrix": _matrix(calibration.projection),
        }
    )


def parse(text: str, where: str = "calibration") -> Calibration:
    """Read the text of a camera_info file. Raises UsageError naming `where` and the fault."""
    values = ost_ini.mapping(text, where) if ost_ini.is_ini(text) else _only_calibration(text, where)
    if not any(key in values for key in _KEYS):
        found = f" but has {', '.join(str(key)[:20] for key in list(values)[:6])}" if values else ""
        raise UsageError(
            f"{where} is no camera_info file: it lacks {', '.join(_KEYS)}{found}; "
            "Kalibr and others use other names for these numbers, so rename them"
        )
    coefficients = _numbers(values, "distortion_coefficients", where).reshape(-1)
    # OpenCV names no model.
    short = coefficients.size <= DISTORTION_LENGTH["plumb_bob"]
    model = _text(values, "distortion_model", "plumb_bob" if short else "rational_polynomial")
    model = _MODELS.get(model, model)
    if model not in DISTORTION_LENGTH:
        raise UsageError(
            f"{where}: distortion model '{model[:60]}' is not known; there are {', '.join(DISTORTION_LENGTH)}"
        )
    # Older files omit zeros at the end; OpenCV adds those of thin prisms and tilted sensors.
    length = DISTORTION_LENGTH[model]
    if coefficients[length:].any():
        raise UsageError(f"{where}: {coefficients.size} coefficients are too many for {model}")
    coefficients = np.pad(coefficients[:length], (0, max(0, length - coefficients.size)))
    matrix = _numbers(values, "camera_matrix", where)
    if matrix.shape != (3, 3):
        raise UsageError(f"{where}: camera_matrix is {matrix.shape}, not 3×3")
    width, height = (_size(values, key, where) for key in ("image_width", "image_height"))
    rectification, projection = (
        _optional(values, key, where) for key in ("rectification_matrix", "projection_matrix")
    )
    try:
        return Calibration(
            width,
            height,
            matrix,
            coefficients,
            _text(values, "camera_name", "camera"),
            rectification=given_rectification(rectification),
            rectified=given_projection(projection),
            camera_model=_text(values, "camera_model", ""),
            camera_serial=_text(values, "camera_serial", ""),
            geometry=_geometry(values),
        )
    except UsageError as error:
        raise UsageError(f"{where}: {error}") from None


def _only_calibration(text: str, where: str) -> dict[str, Any]:
    """Return the YAML document that is a calibration, or the first one. Raises UsageError for several."""
    documents = read_documents(text, where)
    calibrations = [each for each in documents if any(key in each for key in _KEYS)]
    if len(calibrations) > 1:
        names = ", ".join(_text(each, "camera_name", "camera")[:40] for each in calibrations[:8])
        raise UsageError(
            f"{where} has {len(calibrations)} calibrations ({names}); save the camera's in a file of its own"
        )
    return (calibrations or documents or [{}])[0]


def _geometry_entry(geometry: ImageGeometry) -> dict[str, float]:
    numbers = (*geometry.whole, *geometry.offset, *geometry.binning, *map(int, geometry.reversed))
    return dict(zip(_GEOMETRY_KEYS, numbers, strict=True))


def _geometry(values: dict[str, Any]) -> ImageGeometry | None:
    """Return the geometry of the images; None if the file has none. Raises UsageError."""
    if _GEOMETRY not in values:
        return None
    entry = values[_GEOMETRY]
    numbers = [entry.get(key) for key in _GEOMETRY_KEYS] if isinstance(entry, dict) else [None]
    match numbers:
        case [
            int(width), int(height), int(x), int(y),
            int() | float() as across, int() | float() as down,
            int(reverse_x), int(reverse_y),
        ]:  # fmt: skip
            mirrored = bool(reverse_x), bool(reverse_y)
            return ImageGeometry((width, height), (x, y), (across, down), mirrored)
    raise UsageError(f"{_GEOMETRY} needs numbers for {', '.join(_GEOMETRY_KEYS)}; remove it if unknown")


def _matrix(values: Matrix) -> dict[str, Any]:
    return {"rows": values.shape[0], "cols": values.shape[1], "data": [float(v) for v in values.flat]}


def _numbers(values: dict[str, Any], key: str, where: str) -> Matrix:
    """Return a matrix entry of rows × cols numbers. Raises UsageError for any other entry."""
    entry = values.get(key)
    if not isinstance(entry, dict) or not isinstance(entry.get("data"), list):
        raise UsageError(f"{where}: {key} is missing, or has no list 'data'")
    data, rows, columns = entry["data"], entry.get("rows"), entry.get("cols")
    if not all(isinstance(value, (int, float)) for value in data):
        raise UsageError(f"{where}: {key} contains something other than numbers")
    if not isinstance(rows, int) or not isinstance(columns, int) or rows * columns != len(data) or rows < 1:
        lengths = f"{_text(entry, 'rows', 'no')[:60]} rows and {_text(entry, 'cols', 'no')[:60]} columns"
        raise UsageError(f"{where}: {key} has {len(data)} numbers for {lengths}")
    return np.array(data, np.float64).reshape(rows, columns)


def _optional(values: dict[str, Any], key: str, where: str) -> Matrix | None:
    return _numbers(values, key, where) if key in values else None


def _text(values: dict[str, Any], key: str, default: str) -> str:
    """Return a text or number as text, and other values by their type, as aliases can make them huge."""
    value = values.get(key, default)
    return str(value) if isinstance(value, str | int | float) else f"a {type(value).__name__}"


def _size(values: dict[str, Any], key: str, where: str) -> int:
    value = values.get(key)
    if not isinstance(value, int):
        raise UsageError(f"{where}: {key} is {_text(values, key, '')[:60]}, not a number of pixels")
    return value
