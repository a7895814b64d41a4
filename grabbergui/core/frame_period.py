"""The frame period by a camera's features, which decides how long a working stream may be silent."""

from __future__ import annotations

from contextlib import suppress
from typing import Protocol

from grabbergui.core.errors import GrabberError
from grabbergui.core.features import Feature
from grabbergui.core.sfnc import Role

_MICROSECONDS = {
    "": 1.0, "us": 1.0, "usec": 1.0, "\N{MICRO SIGN}s": 1.0, "\N{GREEK SMALL LETTER MU}s": 1.0,
    "ns": 1e-3, "ms": 1e3, "msec": 1e3, "s": 1e6, "sec": 1e6,
}  # fmt: skip
"Units of times; older cameras report none for microseconds."
_RATES = ("AcquisitionResultingFrameRate", "ResultingFrameRateAbs", "ResultingFrameRate")
"Frame rates that the other settings allow; vendors have them beside SFNC's."
FRAME_WAIT = 5.0
"Seconds without a frame, besides two frame periods, after which a stream counts as silent."


class _Camera(Protocol):
    """A grabber, as far as its features are concerned."""

    def has_feature(self, name: str) -> bool:
        """Return whether it has this feature."""
        ...

    def role(self, role: Role) -> str | None:
        """Return the feature that has a role."""
        ...

    def feature(self, name: str) -> Feature:
        """Read a feature."""
        ...


def microseconds(unit: str) -> float | None:
    """Return the microseconds in a unit of time, in which SFNC has all exposure times; None for others."""
    return _MICROSECONDS.get(unit.strip().lower())


def frame_rate(camera: _Camera) -> float:
    """Return the frames per second by the camera's settings; 0 if they do not tell.

    A line-scan camera's are its lines per second over the lines of a frame. Reads up to two features.
    """
    name = next(filter(camera.has_feature, _RATES), None) or camera.role(Role.FRAME_RATE)
    if name is None or name.endswith("Raw"):
        return 0.0
    hertz, _ = _number(camera, name)
    if "linerate" in name.lower() and (height := camera.role(Role.HEIGHT)) is not None:
        lines, _ = _number(camera, height)
        return hertz / lines if lines > 0 else 0.0
    return max(hertz, 0.0)


def frame_period(camera: _Camera) -> float:
    """Return the seconds from one frame to the next by the camera's settings; 0 if they do not tell.

    It is the longer of the frame rate's period and the exposure time. Reads up to three features.
    """
    hertz = frame_rate(camera)
    period = 1 / hertz if hertz > 0 else 0.0
    if (name := camera.role(Role.EXPOSURE)) is not None:
        exposure, unit = _number(camera, name)
        period = max(period, exposure * (microseconds(unit) or 0.0) / 1e6)
    return period


def frame_wait(camera: _Camera, least: float = FRAME_WAIT) -> float:
    """Return the seconds to wait for a frame: `least`, and two frame periods.

    A frame that is being exposed already may have to end first.
    """
    return least + 2 * frame_period(camera)


def _number(camera: _Camera, name: str) -> tuple[float, str]:
    """Return a feature's value and unit; 0 if it cannot be read."""
    with suppress(GrabberError):
        feature = camera.feature(name)
        if isinstance(feature.value, int | float) and not isinstance(feature.value, bool):
            return float(feature.value), feature.unit
    return 0.0, ""
