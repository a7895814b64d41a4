"""What was set on a camera since it was opened, so that it can be set again when it lost its power."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from grabbergui.core.errors import FeatureError
from grabbergui.core.features import FeatureValue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.selection import SettingKey, ValueChange
from grabbergui.core.settling import settle
from grabbergui.core.sfnc import AUTO_ONCE

LOAD_SET = "UserSetLoad"
"Replaces all settings by those of the set that UserSetSelector selects (SFNC, User Set Control)."


class SettingsMemory:
    """The last known value of each setting that was changed, in the order of the last change.

    It holds what was written for the user, what the driver wrote with it (a mode switched off, a switch
    turned on, a selector), and what the camera changed in consequence. One thread at a time.
    """

    def __init__(self) -> None:
        self._settings: dict[SettingKey, FeatureValue] = {}
        self._hidden: dict[str, ValueChange] = {}
        "Features that cannot be seen at the moment, and the write that hid them."
        self._loaded: SettingKey | None = None
        "The command that loaded the set all other settings stand on, with its selector."

    @property
    def settings(self) -> Mapping[SettingKey, FeatureValue]:
        """What is remembered."""
        return self._settings

    @property
    def regulated_once(self) -> list[str]:
        """Automatic modes that were told to regulate once, and are off again soon."""
        return [key.name for key, value in self._settings.items() if value == AUTO_ONCE]

    def note(self, key: SettingKey, value: FeatureValue) -> None:
        """Remember a value; the last change comes last when it is set again."""
        self._settings.pop(key, None)
        self._settings[key] = value

    def note_changes(self, changes: Iterable[ValueChange]) -> None:
        """Remember what a write changed."""
        for change in changes:
            if change.after is not None:
                self.note(change.key, change.after)

    def note_hidden(self, name: str, by: ValueChange) -> None:
        """Remember that a write hid a feature, as AcquisitionMode hides AcquisitionFrameCount."""
        self._hidden[name] = by

    def note_visible(self, names: Iterable[str]) -> None:
        """Remember that these features can be seen."""
        for name in names:
            self._hidden.pop(name, None)

    def note_loaded_set(self, command: SettingKey) -> None:
        """Remember that the camera loaded one of its own sets, which replaced all settings."""
        self._settings.clear()
        self._hidden.clear()
        self._loaded = command

    def restore(self, grabber: FrameGrabber) -> list[str]:
        """Set everything again and compare; return what is not as it was and why, a sentence each.

        Raises TransportError when the camera goes away again.
        """
        problems = []
        if self._loaded is not None:
            try:
                grabber.execute_setting(self._loaded)
            except FeatureError as error:
                problems.append(str(error))
        hidden = {key: value for key, value in self._settings.items() if key.name in self._hidden}
        for key, value in hidden.items():
            # What hides it is written again with all that can be seen.
            hider = self._hidden[key.name]
            if hider.before is not None:
                problems += settle(grabber, {hider.key: hider.before, key: value}).values()
        visible = {key: value for key, value in self._settings.items() if key not in hidden}
        return [*problems, *settle(grabber, visible).values()]
