"""The errors of hand and head that a cycle measured, as all networks publish them."""

from __future__ import annotations

import math

from grabbergui.servo.loop import ControlCycle


def errors(cycle: ControlCycle) -> dict[str, float]:
    """Return the known errors of hand and head in a cycle, by their published names."""
    measured = {
        "distance_mm": 1e3 * cycle.error[0],
        "angle_degrees": math.degrees(cycle.error[1]),
        "right_degrees": math.degrees(cycle.off_centre[0]),
        "down_degrees": math.degrees(cycle.off_centre[1]),
    }
    return {name: float(value) for name, value in measured.items() if math.isfinite(value)}
