"""The handle by which networks use a camera that the window shares."""

from __future__ import annotations

from psygnal import Signal
from typing_extensions import override

from grabbergui.core.features import Feature, FeatureValue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.settings import SettingKey, WriteResult
from grabbergui.core.shared import SharedGrabber


class PeerGrabber(SharedGrabber):
    """Passes requests on to the camera and reports what they changed.

    The stream is left to the window, whose operator starts and stops it. Any thread.
    """

    written = Signal(WriteResult)
    """A peer wrote a setting. Emitted on the thread of the peer's connection."""
    executed = Signal(SettingKey)
    """A peer ran a command. Emitted on the same thread."""

    def __init__(self, grabber: FrameGrabber) -> None:
        super().__init__(grabber)
        super().open()

    @override
    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        return self.write_setting(SettingKey(name), value).feature

    @override
    def write_setting(self, key: SettingKey, value: FeatureValue) -> WriteResult:
        result = super().write_setting(key, value)
        self.written.emit(result)
        return result

    @override
    def execute(self, name: str) -> None:
        self.execute_setting(SettingKey(name))

    @override
    def execute_setting(self, key: SettingKey) -> None:
        super().execute_setting(key if key.selected else self.setting(key.name))
        self.executed.emit(key)

    @override
    def start(self, *, keep_trigger: bool = False) -> None:
        """Do nothing: the window starts the stream."""

    @override
    def stop(self) -> None:
        """Do nothing: others need the stream."""
