"""One change of a feature's value, and who made it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from grabbergui.core.features import FeatureValue, format_value
from grabbergui.core.selection import SettingKey


class Origin(Enum):
    """Who changed something."""

    OPERATOR = "operator"
    "A person at this window, or what they started here."
    CAMERA = "camera"
    "The camera by itself: an automatic mode, or the consequence of another change."
    NETWORK = "network"
    "Somebody else who uses the same camera over a network."


@dataclass(frozen=True)
class Change:
    """What one feature was and became; a command that was run has neither value."""

    number: int
    "Counts up from 1. A change that goes on, as while a slider is dragged, keeps its number."
    time: float
    "Seconds since the epoch when it began."
    key: SettingKey
    before: FeatureValue | None
    after: FeatureValue | None
    origin: Origin
    cause: str = ""
    "What it was part of, for people: `Loaded settings.yaml`; empty for a control that was moved."
    command: bool = False

    @property
    def effective(self) -> bool:
        """Whether anything is other than before."""
        return self.command or self.before != self.after

    def __str__(self) -> str:
        """`Gain 0 → 6`, `TriggerSoftware run`."""
        if self.command:
            return f"{self.key} run"
        return f"{self.key} {format_value(self.before)} → {format_value(self.after)}"
