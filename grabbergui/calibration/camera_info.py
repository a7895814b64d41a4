"""The calibration of each frame, and its file; the counterpart of ROS's camera_info_manager.

A `FittedCalibration` adapts the calibration of a file to the binning and region of each frame. A
`CalibrationChoice` can be exchanged while it is in use.

Files are camera_info YAML, as camera_info_manager and camera_calibration write it. PyYAML reads them,
restricted to mappings, lists, text, numbers as in YAML 1.2 (`1e-3` is a number, `on` is text), and the tag of
OpenCV's matrices. `camera_model` and `camera_serial`, which ROS ignores, name the camera.
"""

from __future__ import annotations

import itertools
import logging
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from grabbergui.calibration import ost_ini
from grabbergui.core.calibration import (
    DISTORTION_LENGTH,
    FISHEYE,
    NOMINAL_FIELD_OF_VIEW,
    Calibration,
    Matrix,
    given_projection,
    given_rectification,
)
from grabbergui.core.environment import write_whole
from grabbergui.core.errors import FeatureNotFoundError, GrabberError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.identity import DeviceInfo, describe
from grabbergui.core.regular_files import read_bounded
from grabbergui.core.sfnc import Role

log = logging.getLogger(__name__)

# -- the calibration of each frame ---------------------------------------------------------------
_FULL_SIZE = ("WidthMax", "HeightMax")
"""The largest image with the current binning (SFNC, Image Format Control)."""
_OFFSET = ("OffsetX", "OffsetY")

_NONE = "the camera has no calibration; serve it with --calibration FILE"

Pair = tuple[int, int]


class FittedCalibration:
    """A camera's calibration, shared by the networks that serve it. Any thread."""

    def __init__(self, grabber: FrameGrabber, file: Path | None = None) -> None:
        """Begin with the calibration of `file`, as `use` does."""
        self.calibration: Calibration | None = None
        "The calibration as it was made; None without one."
        self._grabber = grabber
        self._file: Path | None = None
        self._refused = ""
        "Why the file was not loaded; empty if it was, or if there is none yet."
        self._fitted: tuple[object, Calibration | None] = (None, None)
        "What the last calibration was fitted to, and that calibration; exchanged as one."
        self._changes = 0
        "Counts changes of the full size."
        self._listening = False
        if file is not None:
            self.use(file)

    @property
    def file(self) -> Path | None:
        """The file that `keep` writes; None if the calibration is only in memory."""
        return self._file

    def use(self, file: Path) -> None:
        """Load `file` if it exists; `keep` writes it from now on.

        A file that is refused stops no camera: there is a warning, images are sent without a calibration, and
        the file is left as it is.
        """
        self._file, self._refused = file, ""
        try:
            if file.exists():
                self.calibration = load_for(self._grabber.info, file)
        except (UsageError, OSError) as error:
            self._refused = str(error)
            log.warning("%s; images are sent without this calibration", error)

    def close(self) -> None:
        """Release the grabber. May be called twice."""
        self._grabber.features_changed.disconnect(self._on_features_changed, missing_ok=True)

    def keep(self, calibration: Calibration) -> Path | None:
        """Use another calibration, and save it if there is a file; return that file.

        Raises OSError, and UsageError rather than replace a file that was refused or write one that would be.
        """
        calibration = calibration.made_with(self._grabber.info)
        if self._file is not None:
            if self._refused and self._file.exists():
                raise UsageError(
                    f"{self._file} is kept, as it could not be loaded ({self._refused}); rename or remove it"
                )
            save(calibration, self._file)
        self.calibration = calibration
        return self._file

    def of(self, frame: Frame) -> Calibration | None:
        """Return the calibration of a frame; None, with one warning, if it cannot be determined.

        Without a calibration here, it is the one that the source reports.
        """
        size, offset = (frame.width, frame.height), (frame.offset_x, frame.offset_y)
        calibration = self.calibration
        if calibration is None:
            return self._own(size)
        if not self._listening:  # only now, as listening makes the camera poll its features
            self._listening = True
            self._grabber.features_changed.connect(self._on_features_changed, unique=True)
        key = (calibration, size, offset, self._changes)
        last_key, last = self._fitted
        if key == last_key:
            return last
        try:
            result = fitted(calibration, size, offset, self._full_size())
        except GrabberError as error:
            log.warning("images are sent without a calibration: %s", error)
            result = None
        self._fitted = key, result
        return result

    def now(self) -> Calibration:
        """Return the calibration of images with the camera's current settings.

        Raises FeatureNotFoundError without one, UsageError if it does not fit the region.
        """
        size = self._pair((self._grabber.role(Role.WIDTH), self._grabber.role(Role.HEIGHT)))
        if size is None:
            raise FeatureNotFoundError("the camera does not report the size of its images", "Width")
        calibration = self.calibration
        if calibration is None:
            own = self._own(size)
            if own is None:
                raise FeatureNotFoundError(_NONE, "calibration")
            return own
        return fitted(calibration, size, self._pair(_OFFSET) or (0, 0), self._full_size())

    def _own(self, size: Pair) -> Calibration | None:
        own = self._grabber.calibration()
        return own if own and (own.width, own.height) == size else None

    def _full_size(self) -> Pair | None:
        return self._pair(_FULL_SIZE)

    def _pair(self, names: tuple[str | None, str | None]) -> Pair | None:
        """Return the values of two integer features; None if either is missing."""
        has = self._grabber.has_feature
        values = [self._grabber.feature(name).value for name in names if name and has(name)]
        match values:
            case [int(first), int(second)]:
                return first, second
        return None

    def _on_features_changed(self, names: frozenset[str]) -> None:
        if not names.isdisjoint(_FULL_SIZE):
            self._changes += 1


def fitted(calibration: Calibration, size: Pair, offset: Pair, full_size: Pair | None) -> Calibration:
    """Fit a calibration to images of `size`, cut out at `offset` from binned ones of `full_size`.

    A calibration of exactly that size is returned unchanged. Without `full_size` the image counts as whole.
    Raises UsageError if the aspect ratios show that the calibration is of another region.
    """
    if size == (calibration.width, calibration.height):
        return calibration
    return calibration.scaled_to(*(full_size or size)).cut_out(*offset, *size)


# -- an exchangeable calibration -----------------------------------------------------------------
CalibrationFor = Callable[[int, int], Calibration]
"Returns the calibration of images by width and height. Raises UsageError for a size that it does not fit."


class CalibrationChoice:
    """A CalibrationFor that can be exchanged. Any thread."""

    def __init__(self, chosen: CalibrationFor) -> None:
        self._chosen = chosen

    @classmethod
    def file(cls, path: Path, info: DeviceInfo) -> CalibrationChoice:
        """Choose the calibration of a camera from a camera_info file, for poses and servoing.

        Raises UsageError, also for a fisheye lens, OSError.
        """
        calibration = load_for(info, path)
        try:
            _ = calibration.pinhole_distortion
        except UsageError as error:
            raise UsageError(f"{path}: {error}") from None
        return cls(calibration.scaled_to)

    @classmethod
    def nominal(cls, degrees: float = NOMINAL_FIELD_OF_VIEW) -> CalibrationChoice:
        """Choose an ideal camera with a horizontal field of view of `degrees`."""
        return cls(partial(Calibration.from_field_of_view, degrees=degrees))

    def __call__(self, width: int, height: int) -> Calibration:
        """Return the calibration of images by size."""
        return self._chosen(width, height)

    def exchange(self, other: CalibrationChoice) -> None:
        """Choose the same as `other` from now on."""
        self._chosen = other._chosen


# -- files ---------------------------------------------------------------------------------------
_KEYS = ("image_width", "image_height", "camera_matrix", "distortion_coefficients")


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
    if len(text.encode()) > _MAX_FILE_BYTES:
        raise UsageError(f"{path}: a calibration of {len(text)} characters is too long")
    parse(text, str(path))
    write_whole(path, text)


def dump(calibration: Calibration) -> str:
    """Return the text of a camera_info file."""
    camera = {"camera_model": calibration.camera_model, "camera_serial": calibration.camera_serial}
    return write_yaml(
        {
            "image_width": calibration.width,
            "image_height": calibration.height,
            "camera_name": calibration.camera_name,
            **{key: value for key, value in camera.items() if value},
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


_MAX_FILE_BYTES = 64 * 1024


def text_of(path: Path) -> str:
    """Return the text of a file of any kind of calibration. Raises UsageError, OSError."""
    return read_bounded(path, _MAX_FILE_BYTES, "calibration").decode("utf-8", "replace")


# -- YAML of calibrations ------------------------------------------------------------------------
_TAG = "tag:yaml.org,2002:"
_OPENCV_DIRECTIVE = re.compile(r"\A\ufeff?%YAML:[\d.]+[ \t]*\r?\n")
"The first line of OpenCV's files, which in YAML would have a space instead of the colon."


class _Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]  # PyYAML has no types
    """Accepts the tags below, and resolves plain text to numbers as YAML 1.2 does.

    Some PyYAML come without libyaml, which is ten times as fast.
    """

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012, PyYAML's own name
    yaml_constructors = {  # noqa: RUF012
        tag: construct
        for tag, construct in yaml.SafeLoader.yaml_constructors.items()
        if tag is None or tag.removeprefix(_TAG) in ("map", "seq", "str", "int", "float", "null")
    }


class _Dumper(yaml.SafeDumper):  # type: ignore[misc]
    """Quotes text that YAML 1.1 or 1.2 would resolve to another type; writes lists in brackets."""


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


_BRACKETS = {"[": 1, "{": 1, "]": -1, "}": -1}
_DEEPEST = 20
"Brackets within brackets that a file may have. PyYAML takes seconds for thousands, or recurses that deep."
_DASHES = re.compile(rf"^[ \t]*(?:[-?:][ \t]+){{{_DEEPEST}}}", re.MULTILINE)
"Lists within lists, begun on one line."


def read_yaml(text: str, where: str) -> dict[str, Any]:
    """Return the mapping in a text, or an empty one. Raises UsageError with the line."""
    documents = read_documents(text, where)
    if len(documents) > 1:
        raise UsageError(f"{where} has {len(documents)} YAML documents; one is expected")
    return documents[0] if documents else {}


MOST_DOCUMENTS = 100


def read_documents(text: str, where: str) -> list[dict[str, Any]]:
    """Return the mappings of a text's YAML documents that are not empty. Raises UsageError with the line."""
    depth = max(itertools.accumulate(_BRACKETS.get(sign, 0) for sign in text), default=0)
    if depth > _DEEPEST or _DASHES.search(text):
        raise UsageError(f"{where} is no YAML of a calibration: lists or brackets are nested too deeply")
    try:
        loaded = list(
            itertools.islice(yaml.load_all(_OPENCV_DIRECTIVE.sub("", text), _Loader), MOST_DOCUMENTS)
        )
    except yaml.MarkedYAMLError as error:
        mark, last = error.problem_mark, text.count("\n")  # libyaml marks the end after the last line
        line = f", line {min(mark.line, last) + 1}" if mark is not None else ""
        problem = ", ".join(filter(None, (error.context, error.problem)))
        raise UsageError(f"{where}{line}: {problem}") from None
    except (yaml.YAMLError, ValueError, OverflowError, RecursionError) as error:
        raise UsageError(f"{where} is no YAML of a calibration: {str(error).splitlines()[0]}") from None
    documents = [each for each in loaded if each is not None]
    if not all(isinstance(each, dict) for each in documents):
        raise UsageError(f"{where} has no entries 'key: value'")
    return documents


def write_yaml(values: dict[str, Any]) -> str:
    """Return the text of a mapping, with lists in brackets."""
    text: str = yaml.dump(values, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=100)
    return text
