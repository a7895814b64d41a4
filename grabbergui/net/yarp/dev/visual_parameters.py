"""Calibrations as YARP's visual parameters (`yarp::dev::IRgbVisualParams`, `yarp::sig::IntrinsicParams`)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from grabbergui.core.calibration import Calibration
from grabbergui.net.yarp.os.values import Item

_COEFFICIENTS: Final = ("k1", "k2", "t1", "t2", "k3", "k4", "k5", "k6")
"""YARP's names in OpenCV's order. YARP itself knows `plumb_bob` only, the first five."""


def intrinsics(calibration: Calibration, seconds: float) -> Mapping[str, Item]:
    """Return the properties of `getRgbIntrinsicParam`; lengths in pixels, `seconds` since 1970 as the stamp.

    The physical focal length is 0, as YARP writes one that is not known: a calibration cannot tell it.
    """
    (focal_x, _, x), (_, focal_y, y), _ = calibration.matrix.tolist()
    lens = zip(_COEFFICIENTS, calibration.distortion.tolist(), strict=False)
    return {
        "physFocalLength": 0.0,
        "focalLengthX": focal_x,
        "focalLengthY": focal_y,
        "principalPointX": x,
        "principalPointY": y,
        "stamp": seconds,
        "distortionModel": calibration.distortion_model,
        **dict(lens),
    }
