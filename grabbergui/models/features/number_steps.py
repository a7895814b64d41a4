"""Steps of numbers by arrow keys. Pure functions."""

from __future__ import annotations

import math
from enum import Enum

from grabbergui.core.features import Feature, FeatureKind
from grabbergui.models.features.slider_scale import (
    TINY,
    SliderScale,
    increment_of,
    nearest_allowed,
    significant,
)

KEY_STEP = 0.01
"""One step of an arrow key, as a fraction of the range or the number."""


class StepSize(Enum):
    """Size of one step: Shift makes it fine, Ctrl coarse."""

    FINE = 0.1
    USUAL = 1.0
    COARSE = 10.0


def natural_step(feature: Feature, pace: StepSize = StepSize.USUAL) -> int | float:
    """Return what one press of an arrow key adds: the increment, or about 1 %.

    That is 1 % of the range, or of the value if the scale is logarithmic or unlimited. A tenth of it with
    Pace.FINE, ten times as much with Pace.COARSE, and never less than the increment.
    """
    integer = feature.kind is FeatureKind.INTEGER
    scale = SliderScale.of(feature)
    linear = scale is not None and not scale.logarithmic
    least = increment_of(feature)
    if linear and scale is not None:
        size = scale.maximum - scale.minimum
    else:
        size = abs(feature.value) if isinstance(feature.value, int | float) else 0
    step: int | float = significant(size * KEY_STEP, 1) if TINY < size < 1 / TINY else 1.0
    # With a very small increment (1e-6 dB) a step of one increment would take thousands of presses.
    if least and not feature.logarithmic and (integer or not linear or least * 1000 >= size):
        step = least
    step *= pace.value
    if least:
        step = max(1, round(step / least)) * least
    return int(step) if integer else step


def stepped(feature: Feature, steps: int, pace: StepSize = StepSize.USUAL) -> int | float:
    """Return the value after some presses of an arrow key; 64-bit integers exact, fractions rounded."""
    step = natural_step(feature, pace)
    value = feature.value if isinstance(feature.value, int | float) else feature.minimum or 0
    number = value + steps * step
    if isinstance(number, float) and not feature.increment:
        number = round(number, max(0, -math.floor(math.log10(step))))
    return nearest_allowed(feature, number)
