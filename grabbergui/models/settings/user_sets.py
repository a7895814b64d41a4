"""Sets of settings that the camera itself keeps."""

from __future__ import annotations

import threading
from contextlib import suppress
from dataclasses import dataclass

from grabbergui.core.errors import FeatureError, FeatureNotFoundError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import FeatureKind
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.settings import SettingKey, ValueChange
from grabbergui.models.change_tracking import ChangeTrackingGrabber
from grabbergui.models.features.sensor_region import stream_paused
from grabbergui.models.settings.feature_set import Progress, capture, compare
from grabbergui.models.undo_steps import UndoStep

_SELECTOR = "UserSetSelector"
_LOAD = "UserSetLoad"
_SAVE = "UserSetSave"
_STARTS_WITH = ("UserSetDefault", "UserSetDefaultSelector", "DefaultStartupSet")
"Names of the feature for the set loaded at power-on: SFNC 2, SFNC 1, and older."
_FACTORY = ("Default", "Factory")
"Prefixes of the names of sets that cannot be overwritten."


@dataclass(frozen=True)
class UserSet:
    """One of the camera's user sets."""

    name: str
    "The selector's entry, e.g. `UserSet1`."
    title: str
    tooltip: str = ""
    savable: bool = False
    "Whether the present settings can be saved in it; false for factory sets."
    startable: bool = False
    "Whether the camera can start with it."
    starts: bool = False
    "Whether the camera starts with it."


def has_user_sets(grabber: FeatureSource) -> bool:
    """Return whether the camera has user sets that can be loaded."""
    return grabber.has_feature(_SELECTOR) and grabber.has_feature(_LOAD)


def user_sets(grabber: FrameGrabber) -> list[UserSet]:
    """Return the camera's user sets in its order; the selector is moved and restored.

    A streaming camera may refuse to save; then all sets but the factory's are assumed to be savable. Raises
    FeatureError, TransportError.
    """
    _require_user_sets(grabber)
    starting = _power_on_choice(grabber)
    default = grabber.feature(starting) if starting is not None else None
    can_start = {entry.name for entry in default.entries if entry.available} if default is not None else set()
    settable = default is not None and default.access.writable
    found: list[UserSet] = []
    with grabber.exclusive([_SELECTOR]):
        for entry in grabber.feature(_SELECTOR).entries:
            if not entry.available:
                continue
            savable = selected = False
            with suppress(FeatureError):
                save = grabber.read_setting(
                    _of_set(_SAVE if grabber.has_feature(_SAVE) else _LOAD, entry.name)
                )
                selected, savable = True, save.name == _SAVE and save.access.writable
            if not savable and selected and grabber.streaming:
                savable = not entry.name.startswith(_FACTORY)
            found.append(
                UserSet(
                    entry.name,
                    entry.title,
                    entry.tooltip,
                    savable,
                    settable and entry.name in can_start,
                    default is not None and default.value == entry.name,
                )
            )
    return found


def load_user_set(
    grabber: ChangeTrackingGrabber,
    name: str,
    *,
    progress: Progress = lambda done, of: None,
    cancelled: threading.Event | None = None,
) -> int:
    """Load one of the camera's user sets, and record the changes so that they can be undone.

    Returns the number of settings that changed; with `cancelled` set in time, loads nothing. Raises
    FeatureError, TransportError.
    """
    _require_user_sets(grabber)
    camera = grabber.plain
    with stream_paused(camera):
        before = capture(camera, progress=lambda done, of: progress(done, 2 * of), cancelled=cancelled)
        if cancelled is not None and cancelled.is_set():
            return 0
        grabber.execute_setting(_of_set(_LOAD, name))
        after = capture(camera, progress=lambda done, of: progress(of + done, 2 * of))
    changed = [ValueChange(d.key, d.first, d.second) for d in compare(before, after)]
    if changed:
        with grabber.journal.within(UndoStep(f"{_LOAD} {name}")):
            grabber.journal.wrote(changed)
    return len(changed)


def save_user_set(grabber: ChangeTrackingGrabber, name: str) -> None:
    """Save the present settings in one of the camera's user sets. Raises FeatureError, TransportError."""
    _require_user_sets(grabber)
    camera = grabber.plain
    # Some cameras refuse to save while they stream.
    with stream_paused(camera):
        grabber.execute_setting(_of_set(_SAVE, name))


def start_with_user_set(grabber: ChangeTrackingGrabber, name: str) -> None:
    """Let the camera load this set at power-on. Raises FeatureError, TransportError."""
    starting = _power_on_choice(grabber)
    if starting is None:
        raise FeatureNotFoundError(f"{grabber.info.title} always starts with the same set", _STARTS_WITH[0])
    grabber.write_feature(starting, name)


def _power_on_choice(grabber: FeatureSource) -> str | None:
    names = [name for name in _STARTS_WITH if grabber.has_feature(name)]
    return next((n for n in names if grabber.feature(n).kind is FeatureKind.ENUMERATION), None)


def _of_set(command: str, name: str) -> SettingKey:
    return SettingKey(command, ((_SELECTOR, name),))


def _require_user_sets(grabber: FeatureSource) -> None:
    if not has_user_sets(grabber):
        raise FeatureNotFoundError(f"{grabber.info.title} keeps no sets of settings", _SELECTOR)
