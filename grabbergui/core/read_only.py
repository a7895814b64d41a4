"""A grabber that can be looked at and not changed, for networks whose peers are not trusted."""

from __future__ import annotations

from dataclasses import replace

from grabbergui.core.errors import AccessDeniedError, FeatureAccessError
from grabbergui.core.features import AccessMode, Feature, FeatureValue
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.selection import SettingKey, WriteResult
from grabbergui.core.shared import SharedGrabber

_REASON = "the camera is served read-only"


class ReadOnlyGrabber(SharedGrabber):
    """A handle on an open grabber through which images and values come, and nothing is written."""

    @property
    def access(self) -> Access:
        """Monitor, whatever access this process has itself."""
        return Access.MONITOR

    def feature(self, name: str) -> Feature:
        """Return the feature as it is now, writable by nobody. Raises FeatureNotFoundError."""
        feature = super().feature(name)
        if not feature.access.writable:
            return feature
        if feature.access.readable:
            return replace(feature, access=AccessMode.READ_ONLY)
        return replace(feature, access=AccessMode.NOT_AVAILABLE, problem=_REASON)

    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        """Raise FeatureAccessError, or FeatureNotFoundError."""
        raise FeatureAccessError(f"{super().feature(name).name} cannot be written: {_REASON}", name)

    def read_setting(self, key: SettingKey) -> Feature:
        """Read a feature under its selectors. Raises FeatureAccessError where they stand otherwise."""
        return FrameGrabber.read_setting(self, key)  # which selects by `write_feature` of this class

    def write_setting(self, key: SettingKey, value: FeatureValue) -> WriteResult:
        """Raise FeatureAccessError, or FeatureNotFoundError."""
        return WriteResult(self.write_feature(key.name, value), ())

    def pauses_for(self, name: str) -> bool:
        """Return False: no write gets as far as to pause the stream."""
        return False

    def offered(self, feature: Feature) -> Feature:
        """Return the feature as nobody may write it."""
        return FrameGrabber.offered(self, feature)  # which asks for the access of this class

    def execute(self, name: str) -> None:
        """Raise FeatureAccessError, or FeatureNotFoundError."""
        raise FeatureAccessError(f"{super().feature(name).name} cannot be run: {_REASON}", name)

    def execute_setting(self, key: SettingKey) -> None:
        """Raise FeatureAccessError, or FeatureNotFoundError."""
        self.execute(key.name)

    def write_register(self, name: str, content: bytes) -> None:
        """Raise FeatureAccessError."""
        raise FeatureAccessError(f"{name} cannot be written: {_REASON}", name)

    def start(self, *, keep_trigger: bool = False) -> None:
        """Do nothing if the stream is on. Raises AccessDeniedError otherwise."""
        if not self.streaming:
            raise AccessDeniedError(f"the stream cannot be started: {_REASON}")

    def stop(self) -> None:
        """Raise AccessDeniedError: the stream belongs to everybody."""
        raise AccessDeniedError(f"the stream cannot be stopped: {_REASON}")
