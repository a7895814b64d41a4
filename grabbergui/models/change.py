"""A change of a feature, with its author."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from grabbergui.core.features import FeatureValue, format_value
from grabbergui.core.settings import SettingKey


class Origin(Enum):
    """Author of a change."""

    OPERATOR = "operator"
    "A person at this window, or what they started here."
    CAMERA = "camera"
    "The camera by itself: an automatic mode, or the consequence of another change."
    NETWORK = "network"
    "Another user of the same camera over a network."


@dataclass(frozen=True)
class Change:
    """The values of a feature before and after a change; a command has neither."""

    number: int
    "Counts up from 1. A change that continues, as while a slider is dragged, keeps its number."
    time: float
    "Start of the change in seconds since the epoch."
    key: SettingKey
    before: FeatureValue | None
    after: FeatureValue | None
    origin: Origin
    cause: str = ""
    """The operation it was part of, as display text: `Loaded settings.yaml`; empty for a single control.

    Of a change over a network, the program that made it, if it is known.
    """
    command: bool = False

    @property
    def effective(self) -> bool:
        """Whether anything differs from before."""
        return self.command or self.before != self.after

    def __str__(self) -> str:
        """`Gain 0 → 6`, `TriggerSoftware run`, `UserSetLoad[UserSetSelector=UserSet1] run`."""
        if self.command:
            return f"{self.key} run"
        return f"{self.key} {format_value(self.before)} → {format_value(self.after)}"
