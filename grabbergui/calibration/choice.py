"""The calibration in use, which may be exchanged while pictures come."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from grabbergui.calibration import camera_info
from grabbergui.core.calibration import NOMINAL_FIELD_OF_VIEW, Calibration

CalibrationFor = Callable[[int, int], Calibration]
"Width and height of pictures to their calibration. Raises UsageError for a size that it does not fit."


class CalibrationChoice:
    """Is called as a CalibrationFor. Any thread."""

    def __init__(self, chosen: CalibrationFor) -> None:
        self._chosen = chosen

    @classmethod
    def file(cls, path: Path) -> CalibrationChoice:
        """That of a camera_info file. Raises UsageError, OSError."""
        return cls(camera_info.load(path).scaled_to)

    @classmethod
    def nominal(cls, degrees: float = NOMINAL_FIELD_OF_VIEW) -> CalibrationChoice:
        """An ideal camera that sees so much from left to right."""
        return cls(partial(Calibration.from_field_of_view, degrees=degrees))

    def __call__(self, width: int, height: int) -> Calibration:
        """The calibration for pictures of a size."""
        return self._chosen(width, height)

    def exchange(self, other: CalibrationChoice) -> None:
        """Be like another from now on."""
        self._chosen = other._chosen
