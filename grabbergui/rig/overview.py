"""How a rig is doing, as rows of text: its sets, the clocks of its cameras, the budget of its link."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from grabbergui.core.features import FeatureValue
from grabbergui.core.settings import SettingKey
from grabbergui.rig import rig_file
from grabbergui.rig.budget_settings import WRITTEN, budgets_of, with_budget, without_budget
from grabbergui.rig.camera_clock import ClockState
from grabbergui.rig.camera_features import prefixed
from grabbergui.rig.grabber import RigGrabber
from grabbergui.rig.set_statistics import SetCounts

SKEWS = 300
"Recent sets whose skew is shown."


@dataclass(frozen=True)
class CameraLine:
    """One camera of a rig."""

    name: str
    frames: int
    missing: int
    "Sets without its frame."
    clock: ClockState


@dataclass(frozen=True)
class RigOverview:
    """The state of a rig."""

    counts: SetCounts
    skews_us: tuple[float, ...]
    "Skews of the recent complete sets in microseconds, oldest first."
    cameras: tuple[CameraLine, ...]
    leader: str = ""
    "The camera that the others follow; empty if each has its own settings."


@dataclass(frozen=True)
class BudgetOverview:
    """The budget of a rig's links."""

    rows: tuple[tuple[str, ...], ...]
    "A header, then a line for each camera and each link."
    problems: tuple[str, ...]
    settings: Mapping[str, Mapping[str, FeatureValue]]
    "By camera, what the budget sets."

    def keys(self) -> dict[SettingKey, FeatureValue]:
        """Return the settings by the rig's names: `left.GevSCPD`."""
        return {
            SettingKey(prefixed(camera, name)): value
            for camera, settings in self.settings.items()
            for name, value in settings.items()
        }


def overview(rig: RigGrabber) -> RigOverview:
    """Return how a rig is doing. Reads the clocks if the stream is off; raises GrabberError."""
    counts, clocks = rig.counts(), rig.clock_states()
    cameras = tuple(
        CameraLine(name, camera.statistics().frames, counts.missing.get(name, 0), clocks[name])
        for name, camera in rig.cameras.items()
    )
    skews = tuple(skew / 1000 for skew in rig.recent_skews_ns()[-SKEWS:])
    return RigOverview(counts, skews, cameras, rig.leader)


def budget(rig: RigGrabber) -> BudgetOverview:
    """Return the budget of a rig's links, from its cameras as they are set now. Raises GrabberError."""
    budgets = budgets_of(rig.entry, rig.cameras)
    rows: list[tuple[str, ...]] = []
    for each in budgets:
        header, *lines = each.table()
        rows += [tuple(line) for line in (lines if rows else [header, *lines])]
    problems = tuple(problem for each in budgets for problem in each.problems)
    planned = with_budget(rig.entry, budgets).cameras
    settings = {
        name: {feature: value for feature, value in camera.settings.items() if feature in WRITTEN}
        for name, camera in planned.items()
    }
    return BudgetOverview(tuple(rows), problems, settings)


def write_budget(path: Path, planned: BudgetOverview) -> None:
    """Write the settings of a budget into a rig's file. Raises UsageError, MissingFileError."""
    entry = without_budget(rig_file.read(path))
    cameras = {
        name: replace(camera, settings={**camera.settings, **planned.settings.get(name, {})})
        for name, camera in entry.cameras.items()
    }
    rig_file.write(path, replace(entry, cameras=cameras))


def remove_budget(path: Path) -> None:
    """Take the settings of a budget out of a rig's file. Raises UsageError, MissingFileError."""
    rig_file.write(path, without_budget(rig_file.read(path)))
