"""Writes to a camera with everything that belongs to them: companions before, consequences after, memory.

The memory holds what was set since the camera was opened, so that it can be set again after a power loss.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

from grabbergui.core.errors import FeatureError
from grabbergui.core.feature_instances import instances_of
from grabbergui.core.features import AccessMode, Feature, FeatureValue, format_value
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.settings import SettingKey, ValueChange, WriteResult, same_value, setting_names
from grabbergui.core.settle import settle
from grabbergui.core.sfnc import (
    AUTO_OFF,
    AUTO_ONCE,
    FILE_ACCESS,
    TIMED,
    Companions,
    is_on,
    regulated_by_mode,
    switched_off,
    switched_on,
    switched_to,
)
from grabbergui.driver.acquisition import NOT_SETTINGS
from grabbergui.driver.genapi.node_map import CameraNodeMap

log = logging.getLogger(__name__)

LOAD_SET = "UserSetLoad"
"Replaces all settings by those of the set that UserSetSelector selects (SFNC, User Set Control)."
COMPARE_SECONDS = 2.0
"Longest comparison of settings that others may have changed; everybody else waits for it."


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
        """The remembered values."""
        return self._settings

    @property
    def regulated_once(self) -> list[SettingKey]:
        """Automatic modes and the like that were set to Once, and will switch themselves off."""
        return [key for key, value in self._settings.items() if value == AUTO_ONCE]

    def note(self, key: SettingKey, value: FeatureValue) -> None:
        """Remember a value, unless it is of a file's transfer; the last change is set again last."""
        if key.name in FILE_ACCESS:
            return
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
        """Set everything again and compare; return the differences and their reasons, a sentence each.

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
            # The feature that hides it is written again with all that are visible.
            hider = self._hidden[key.name]
            if hider.before is not None:
                problems += settle(grabber, {hider.key: hider.before, key: value}).values()
        visible = {key: value for key, value in self._settings.items() if key not in hidden}
        return [*problems, *settle(grabber, visible).values()]


def validated(feature: Feature, value: FeatureValue) -> tuple[Feature, FeatureValue]:
    """Check a value before a companion is switched or the stream paused for it. Raises FeatureError.

    A lock is ignored, as the write may open it. A feature without a value is checked after that.
    """
    if feature.value is None:
        return feature, value
    ready = feature if feature.access.writable else replace(feature, access=AccessMode.READ_WRITE)
    return feature, ready.validated(value)


class _Target(NamedTuple):
    """A feature to be written, as far as the description fixes it."""

    companions: Companions
    beforehand: tuple[str, ...]
    "The feature and its companions, whose values are read before the write."
    key: SettingKey | None
    "None where selectors decide which setting it is."


class SettingWriter:
    """Writes features of one open camera, and keeps its memory true. The caller holds the camera's lock."""

    def __init__(self, grabber: FrameGrabber, nodes: CameraNodeMap, memory: SettingsMemory) -> None:
        self.memory = memory
        self._grabber = grabber
        self._nodes = nodes
        names = (description.name for description in nodes.root.descriptions())
        self._regulated_by = regulated_by_mode(names, nodes.has)
        "Each automatic mode, and the features it regulates."
        self._noting: set[str] = set()
        "Modes whose values are being noted."
        self._targets: dict[str, _Target] = {}
        self._followers_of: dict[tuple[str, ...], tuple[str, ...]] = {}
        "Both are fixed by the description; kept because a slider asks for them sixty times a second."

    def write(self, feature: Feature, value: FeatureValue) -> WriteResult:
        """Write a feature, and before it what makes it writable.

        All that was written and what followed is remembered. A refusal leaves the companions as they were,
        and raises what the node map raises. Where `feature` is writable and has a value, `value` was
        validated by it.
        """
        nodes, name = self._nodes, feature.name
        target = self._target(name)
        stood = nodes.values(target.beforehand)
        switched = list(self._to_switch(target.companions, stood))
        names = (*(change.key.name for change in switched), name) if switched else (name,)
        candidates = self._may_follow(names)
        before = nodes.values(candidates)
        try:
            for change in switched:
                assert change.after is not None
                nodes.write(change.key.name, change.after)
            if switched or feature.value is None or not feature.access.writable:
                value = nodes.explained(name).validated(value)  # a switch or a stream was on until now
            written = nodes.write_and_read(name, value)
        except FeatureError:
            self._switch_back(switched)
            raise
        became = value if written.value is None else written.value
        changes = (*switched, ValueChange(self._key(name), stood.get(name), became))
        moved: tuple[ValueChange, ...] = ()
        if candidates:
            after = nodes.values(candidates)
            moved = tuple(self._moved(before, after))
            self._note_visibility(before, after, changes[-1])
        self.memory.note_changes((*moved, *changes))
        for change in changes:
            if change.key.name in self._regulated_by and is_on(change.before) and not is_on(change.after):
                self._note_regulated(change.key.name)
        if not (switched or moved):
            return WriteResult(written, changes)
        consequences = tuple(change for change in moved if change.before is not None)
        others = tuple(nodes.feature(change.key.name) for change in (*switched, *consequences))
        return WriteResult(written, changes, consequences, others)

    def known_settings(self) -> dict[SettingKey, FeatureValue]:
        """Return settings that are not in the memory, as far as they are known without asking the camera.

        Without those that an automatic mode moves.
        """
        values, selectors = self._nodes.cached_values(), self._grabber.selectors
        moving = {n for mode, names in self._regulated_by.items() if is_on(values.get(mode)) for n in names}
        known = {}
        for name in setting_names(selectors):
            path = selectors.of(name)
            if {name, *path} <= values.keys() and name not in moving and values[name] != AUTO_ONCE:
                selected = tuple((selector, format_value(values[selector])) for selector in path)
                known[SettingKey(name, selected)] = values[name]
        return {key: value for key, value in known.items() if key not in self.memory.settings}

    def changed_since(self, known: Mapping[SettingKey, FeatureValue]) -> list[str]:
        """Return which of these settings have another value now, a sentence each. Reads them all at most."""
        moving = {name for mode, names in self._regulated_by.items() if self._is_on(mode) for name in names}
        deadline = time.monotonic() + COMPARE_SECONDS
        changed = []
        for key, before in known.items():
            if key.name in moving or time.monotonic() > deadline:
                continue
            try:
                feature = self._grabber.read_setting(key)
            except FeatureError:
                continue
            value = feature.value
            if value is not None and feature.access.writable and not same_value(value, before):
                changed.append(f"{key} is {format_value(value)} instead of {format_value(before)}")
        return changed

    def _is_on(self, mode: str) -> bool:
        return is_on(self._nodes.value(mode))

    def regulated_now(self) -> Iterator[str]:
        """Give the automatic modes that are on, and the features they regulate: these move by themselves."""
        for mode, names in self._regulated_by.items():
            if self._is_on(mode):
                yield mode  # Once falls back to Off by itself
                yield from names

    def notice_regulated_once(self) -> None:
        """Remember the values that a mode found which was set to Once and has switched itself off.

        One that its selectors do not show at the moment is noticed once they do.
        """
        for key in self.memory.regulated_once:
            self._nodes.invalidate(frozenset({key.name}))
            if self._nodes.value(key.name) == AUTO_OFF and self._key(key.name) == key:
                self.memory.note(key, AUTO_OFF)
                if key.name in self._regulated_by:  # EventNotification regulates nothing
                    self._note_regulated(key.name)

    def _key(self, name: str) -> SettingKey:
        return self._target(name).key or self._grabber.setting(name)

    def _to_switch(self, companions: Companions, stood: Mapping[str, FeatureValue]) -> Iterator[ValueChange]:
        """Give what must be written so that a feature can be written and has an effect."""
        mode, enabler = companions.mode, companions.enabler
        if mode and is_on(stood.get(mode)):
            yield from self._switch(switched_off(self._nodes.feature(mode)))
        if enabler and stood.get(enabler) is False:
            yield from self._switch(switched_on(self._nodes.feature(enabler)))
        operation = companions.operation
        if operation and companions.impedes(operation, stood.get(operation)):
            yield from self._switch(switched_to(self._nodes.feature(operation), TIMED))

    def _switch(self, write: tuple[str, FeatureValue] | None) -> Iterator[ValueChange]:
        if write is not None:
            name, wanted = write
            yield ValueChange(self._key(name), self._nodes.value(name), wanted)

    def _switch_back(self, switched: Iterable[ValueChange]) -> None:
        """Undo changes after a refused write. What the camera refuses now, too, is only logged."""
        for change in switched:
            if change.before is not None:
                try:
                    self._nodes.write(change.key.name, change.before)
                except FeatureError as error:
                    log.warning("%s stays %s: %s", change.key, format_value(change.after), error)

    def _target(self, name: str) -> _Target:
        target = self._targets.get(name)
        if target is None:
            companions = Companions.of(name, self._nodes.has)
            key = None if self._grabber.selectors.of(name) else SettingKey(name)
            target = self._targets[name] = _Target(companions, (name, *companions.names), key)
        return target

    def _may_follow(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """Return the features that the camera may change when these are written."""
        if names not in self._followers_of:
            selectors = self._grabber.selectors
            found: set[str] = set()
            for name in names:
                # Under a selector other instances appear; nothing has changed.
                dependents = self._nodes.dependents(name)
                found.update(other for other in dependents if name not in selectors.of(other))
            self._followers_of[names] = tuple(sorted(found.difference(names, NOT_SETTINGS)))
        return self._followers_of[names]

    def _moved(
        self, before: dict[str, FeatureValue], after: dict[str, FeatureValue]
    ) -> Iterator[ValueChange]:
        """Give the settings that a write changed in the camera, other than by an automatic mode."""
        for name, value in after.items():
            if before.get(name) == value:
                continue
            key = self._key(name)
            remembered = key in self.memory.settings  # perhaps it is only locked at the moment
            if (remembered or self._nodes.feature(name).access.writable) and not self._is_regulated(name):
                yield ValueChange(key, before.get(name), value)

    def _is_regulated(self, name: str) -> bool:
        mode = self._target(name).companions.mode
        return mode is not None and self._is_on(mode)

    def _note_visibility(self, before: Iterable[str], after: Iterable[str], by: ValueChange) -> None:
        self.memory.note_visible(after)
        for name in set(before).difference(after):
            self.memory.note_hidden(name, by)

    def _note_regulated(self, mode: str) -> None:
        """Remember the values that an automatic mode found, which stay when it goes off."""
        if mode in self._noting:
            return  # the selectors that are written below may switch the mode itself
        self._noting.add(mode)
        try:
            self._remember_regulated(mode)
        finally:
            self._noting.discard(mode)

    def _remember_regulated(self, mode: str) -> None:
        self._nodes.invalidate(frozenset(self._regulated_by[mode]))
        for name in self._regulated_by[mode]:
            for key in instances_of(self._grabber, name):
                if (value := self._grabber.read_setting(key).value) is not None:
                    self.memory.note(key, value)
