"""Settings that a rig writes to its cameras, and their return to what they were."""

from __future__ import annotations

import logging

from grabbergui.core.errors import FeatureError, GrabberError
from grabbergui.core.features import FeatureValue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.settings import SettingKey, same_value

log = logging.getLogger(__name__)


class UndoableSettings:
    """Writes settings and remembers the values before. One thread at a time."""

    def __init__(self) -> None:
        self._before: list[tuple[FrameGrabber, SettingKey, FeatureValue]] = []

    @property
    def before(self) -> list[tuple[FrameGrabber, SettingKey, FeatureValue]]:
        """Camera, setting and value before each write, in the order of writing."""
        return list(self._before)

    def write(self, grabber: FrameGrabber, key: SettingKey, value: FeatureValue) -> None:
        """Write a setting unless it has the value. Raises GrabberError."""
        present = grabber.read_setting(key).value
        if present is not None and same_value(present, value):
            return
        for change in grabber.write_setting(key, value).written:  # what is switched with it, too
            if change.before is not None:
                self._before.append((grabber, change.key, change.before))

    def write_if_offered(self, grabber: FrameGrabber, key: SettingKey, value: FeatureValue) -> bool:
        """Write a setting that the camera has and accepts; return whether it did."""
        if not grabber.has_feature(key.name):
            return False
        try:
            self.write(grabber, key, value)
        except FeatureError as error:
            log.info("%s: %s", grabber.info.title, error)
            return False
        return True

    def undo(self) -> list[str]:
        """Write all values from before, the last first; return what a camera refused, a sentence each."""
        problems = []
        while self._before:
            grabber, key, value = self._before.pop()
            try:
                grabber.write_setting(key, value)
            except GrabberError as error:
                problems.append(f"{grabber.info.title}: {key} is not {value} again: {error}")
        return problems
