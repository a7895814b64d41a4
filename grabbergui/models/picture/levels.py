"""Levels: which values are shown as black and as white."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Levels:
    """Sensor values shown as black and as white, as fractions of the sensor's range."""

    black: float = 0.0
    white: float = 1.0

    @property
    def neutral(self) -> bool:
        """Whether the whole range is shown."""
        return self == Levels()
