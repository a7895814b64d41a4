"""Quantities computed from sensor data: millimetres of 3D coordinates, polarisation from mosaics."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray


def millimetres(
    raw: NDArray[Any], scale: float, offset: float = 0.0, invalid: float | None = None
) -> NDArray[np.float32]:
    """Return coordinates in millimetres: raw × scale + offset, NaN where nothing was measured.

    `raw` is as `Frame.raw` gives it, or one of its components. Scale, offset and invalid value are the
    features Scan3dCoordinateScale, Scan3dCoordinateOffset and Scan3dInvalidDataValue (SFNC, 3D Scan Control).
    """
    values = np.asarray(raw, np.float64) * scale + offset
    if invalid is not None:
        values[raw == invalid] = np.nan
    return values.astype(np.float32)


class Polarisation(NamedTuple):
    """Linear polarisation, each (height // 2, width // 2) float32."""

    intensity: NDArray[np.float32]
    "The mean of the four angles' values, in the sensor's."
    degree: NDArray[np.float32]
    "0 (none) to 1; more than 1 only by noise."
    angle: NDArray[np.float32]
    "Degrees, 0 up to 180; of no meaning where the degree is 0."


def polarisation(mosaic: NDArray[Any]) -> Polarisation:
    """Compute linear polarisation from a mosaic of 90°, 45° over 135°, 0°: Sony's polarised sensors.

    `mosaic` is (height, width) of at least 2×2; a last line or column that is no whole cell is left out.
    """
    height, width = mosaic.shape[0] & ~1, mosaic.shape[1] & ~1
    values = mosaic[:height, :width].astype(np.float32)
    at_90, at_45 = values[0::2, 0::2], values[0::2, 1::2]
    at_135, at_0 = values[1::2, 0::2], values[1::2, 1::2]
    total = (at_0 + at_45 + at_90 + at_135) / 2  # Stokes' S0, S1, S2
    across, diagonal = at_0 - at_90, at_45 - at_135
    degree = np.hypot(across, diagonal) / np.maximum(total, np.finfo(np.float32).tiny)
    angle = np.degrees(np.arctan2(diagonal, across)) / 2 % 180
    return Polarisation(*(np.asarray(found, np.float32) for found in (total / 2, degree, angle)))
