"""The sets of settings that a camera keeps itself (SFNC, UserSetControl)."""

from __future__ import annotations

import threading
from contextlib import suppress
from dataclasses import dataclass

from grabbergui.core.errors import FeatureError, FeatureNotFoundError
from grabbergui.core.features import FeatureKind
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.selection import SettingKey, ValueChange
from grabbergui.models.changes.history import Step
from grabbergui.models.changes.tracking import ChangeTrackingGrabber
from grabbergui.models.features.sensor_region import stream_paused
from grabbergui.models.settings.feature_set import Progress, capture, compare

SELECTOR = "UserSetSelector"
LOAD = "UserSetLoad"
SAVE = "UserSetSave"
STARTS_WITH = ("UserSetDefault", "UserSetDefaultSelector", "DefaultStartupSet")
"Feature for the set loaded at power-on: SFNC 2's name, SFNC 1's, and an older one."

FACTORY = ("Default", "Factory")
"Prefixes of the names of sets that cannot be overwritten."


@dataclass(frozen=True)
class UserSet:
    """One of the camera's sets."""

    name: str
    "The selector's entry, e.g. `UserSet1`."
    title: str
    tooltip: str = ""
    savable: bool = False
    "Whether the present settings can be saved in it; false for the factory's."
    startable: bool = False
    "Whether the camera can start with it."
    starts: bool = False
    "Whether the camera starts with it."


def has_user_sets(grabber: FrameGrabber) -> bool:
    """Return whether the camera keeps sets that can be loaded."""
    return grabber.has_feature(SELECTOR) and grabber.has_feature(LOAD)


def user_sets(grabber: FrameGrabber) -> list[UserSet]:
    """Return the camera's sets in its order; the selector is moved and restored.

    While it streams a camera may refuse to save; then any set but the factory's is taken for savable.
    Raises FeatureError, TransportError.
    """
    _require(grabber)
    starting = _starting(grabber)
    default = grabber.feature(starting) if starting is not None else None
    can_start = {entry.name for entry in default.entries if entry.available} if default is not None else set()
    settable = default is not None and default.access.writable
    found: list[UserSet] = []
    with grabber.exclusive([SELECTOR]):
        for entry in grabber.feature(SELECTOR).entries:
            if not entry.available:
                continue
            savable = selected = False
            with suppress(FeatureError):
                save = grabber.read_setting(_of_set(SAVE if grabber.has_feature(SAVE) else LOAD, entry.name))
                selected, savable = True, save.name == SAVE and save.access.writable
            if not savable and selected and grabber.streaming:
                savable = not entry.name.startswith(FACTORY)
            found.append(
                UserSet(
                    entry.name,
                    entry.display_name or entry.name,
                    entry.tooltip,
                    savable,
                    settable and entry.name in can_start,
                    default is not None and default.value == entry.name,
                )
            )
    return found


def load(
    grabber: ChangeTrackingGrabber,
    name: str,
    *,
    progress: Progress = lambda done, of: None,
    cancelled: threading.Event | None = None,
) -> int:
    """Let the camera load one of its sets, and record the changes, so that they can be undone.

    Returns how many settings are other than before; with `cancelled` set in time, nothing is loaded.
    Raises FeatureError, TransportError.
    """
    _require(grabber)
    camera = grabber.plain
    with stream_paused(camera):
        before = capture(camera, progress=lambda done, of: progress(done, 2 * of), cancelled=cancelled)
        if cancelled is not None and cancelled.is_set():
            return 0
        grabber.execute_setting(_of_set(LOAD, name))
        after = capture(camera, progress=lambda done, of: progress(of + done, 2 * of))
    changed = [ValueChange(d.key, d.first, d.second) for d in compare(before, after)]
    if changed:
        with grabber.journal.within(Step(f"{LOAD} {name}")):
            grabber.journal.wrote(changed)
    return len(changed)


def save(grabber: ChangeTrackingGrabber, name: str) -> None:
    """Save the present settings in one of the camera's sets. Raises FeatureError, TransportError."""
    _require(grabber)
    camera = grabber.plain
    # Not every camera saves while it streams.
    with stream_paused(camera):
        grabber.execute_setting(_of_set(SAVE, name))


def start_with(grabber: ChangeTrackingGrabber, name: str) -> None:
    """Let the camera start with this set from its next power-on. Raises FeatureError, TransportError."""
    starting = _starting(grabber)
    if starting is None:
        raise FeatureNotFoundError(f"{grabber.info.title} always starts with the same set", STARTS_WITH[0])
    grabber.write_feature(starting, name)


def _starting(grabber: FrameGrabber) -> str | None:
    names = [name for name in STARTS_WITH if grabber.has_feature(name)]
    return next((n for n in names if grabber.feature(n).kind is FeatureKind.ENUMERATION), None)


def _of_set(command: str, name: str) -> SettingKey:
    return SettingKey(command, ((SELECTOR, name),))


def _require(grabber: FrameGrabber) -> None:
    if not has_user_sets(grabber):
        raise FeatureNotFoundError(f"{grabber.info.title} keeps no sets of settings", SELECTOR)
