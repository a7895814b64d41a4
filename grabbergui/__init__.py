"""Open, tune and read GenICam cameras from Python.

```python
import grabbergui

with grabbergui.open("gige:192.168.0.10") as camera:
    camera.exposure_time = 20_000
    image = camera.grab().rgb()
```

Only the names in `__all__` are the public interface. Within a minor version (0.2.x) they keep their meaning.
Before a name is removed, it is deprecated for a minor version, with a `DeprecationWarning`.

Importing this module loads neither Qt nor any transport, as each name is imported on its first use.
"""

from __future__ import annotations

import importlib
import os
from typing import TYPE_CHECKING

# OpenCV reads this variable when it is loaded. By default its threads spin for a while after each call, in
# case of another; between frames this costs more than the conversion of a small one.
os.environ.setdefault("OPENCV_THREAD_POOL_ACTIVE_WAIT_WORKER", "0")

if TYPE_CHECKING:
    from grabbergui.core.component import Component, ComponentKind, PayloadType
    from grabbergui.core.errors import (
        AccessDeniedError,
        AckTimeoutError,
        CameraFileError,
        ClosedError,
        DeviceLostError,
        DeviceStatusError,
        ExistingFileError,
        FeatureAccessError,
        FeatureError,
        FeatureNotFoundError,
        FeatureValueError,
        FrameTimeoutError,
        GrabberError,
        LocalFileError,
        MissingFileError,
        MissingFrameError,
        OtherCameraError,
        PixelFormatError,
        ProtocolError,
        RemoteProtocolError,
        ResourceExhaustedError,
        SourceNotFoundError,
        SourceUnavailableError,
        TransferCancelledError,
        TransportError,
        UsageError,
    )
    from grabbergui.core.features import (
        AccessCondition,
        AccessMode,
        EnumEntry,
        Feature,
        FeatureKind,
        Representation,
        Visibility,
    )
    from grabbergui.core.file_access import CameraFile, Written
    from grabbergui.core.frame import Frame, FrameStatus
    from grabbergui.core.frame_queue import StreamStatistics
    from grabbergui.core.grabber import DeviceEvent
    from grabbergui.core.identity import DeviceInfo
    from grabbergui.core.pfnc import PixelFormat
    from grabbergui.core.point_cloud import PointCloud
    from grabbergui.core.settings import SettingKey
    from grabbergui.library import discover, open, open_all  # noqa: A004
    from grabbergui.library.camera import Camera
    from grabbergui.library.features import CameraFiles, SettingValue
    from grabbergui.library.group import CameraGroup, GroupFrames
    from grabbergui.library.live_view import NotebookPanel, live_view
    from grabbergui.library.rig import Rig, open_rig
    from grabbergui.library.streaming import AsyncFrames, FrameLoop, Frames, Recording
    from grabbergui.models.settings.loading import LoadReport, SettingOutcome, SettingReport
    from grabbergui.recording.errors import RecordingError
    from grabbergui.recording.recorder import RecordingProgress
    from grabbergui.rig.camera_clock import ClockState
    from grabbergui.rig.frame_sets import FrameSet, FrameStamp, SetState
    from grabbergui.rig.set_statistics import SetCounts

__version__ = "0.3.0.dev0"

_HOMES = {
    "open": "library",
    "open_all": "library",
    "open_rig": "library.rig",
    "discover": "library",
    "live_view": "library.live_view",
    "Camera": "library.camera",
    "CameraGroup": "library.group",
    "Rig": "library.rig",
    "FrameSet": "rig.frame_sets",
    "SetState": "rig.frame_sets",
    "FrameStamp": "rig.frame_sets",
    "SetCounts": "rig.set_statistics",
    "ClockState": "rig.camera_clock",
    "Frames": "library.streaming",
    "AsyncFrames": "library.streaming",
    "Recording": "library.streaming",
    "Frame": "core.frame",
    "Feature": "core.features",
    "DeviceInfo": "core.identity",
    "DeviceEvent": "core.grabber",
    "StreamStatistics": "core.frame_queue",
    "GrabberError": "core.errors",
    "UsageError": "core.errors",
    "SourceNotFoundError": "core.errors",
    "AccessDeniedError": "core.errors",
    "TransportError": "core.errors",
    "DeviceLostError": "core.errors",
    "ClosedError": "core.errors",
    "FeatureError": "core.errors",
    "FeatureNotFoundError": "core.errors",
    "FeatureAccessError": "core.errors",
    "FeatureValueError": "core.errors",
    "FrameTimeoutError": "core.errors",
    "MissingFrameError": "core.errors",
    "PixelFormatError": "core.errors",
    "CameraFileError": "core.errors",
    "AccessCondition": "core.features",
    "AccessMode": "core.features",
    "EnumEntry": "core.features",
    "FeatureKind": "core.features",
    "Representation": "core.features",
    "Visibility": "core.features",
    "CameraFiles": "library.features",
    "SettingValue": "library.features",
    "Component": "core.component",
    "ComponentKind": "core.component",
    "PayloadType": "core.component",
    "FrameLoop": "library.streaming",
    "GroupFrames": "library.group",
    "FrameStatus": "core.frame",
    "LoadReport": "models.settings.loading",
    "PixelFormat": "core.pfnc",
    "PointCloud": "core.point_cloud",
    "RecordingProgress": "recording.recorder",
    "CameraFile": "core.file_access",
    "Written": "core.file_access",
    "NotebookPanel": "library.live_view",
    "AckTimeoutError": "core.errors",
    "DeviceStatusError": "core.errors",
    "ExistingFileError": "core.errors",
    "LocalFileError": "core.errors",
    "MissingFileError": "core.errors",
    "OtherCameraError": "core.errors",
    "ProtocolError": "core.errors",
    "RemoteProtocolError": "core.errors",
    "ResourceExhaustedError": "core.errors",
    "SourceUnavailableError": "core.errors",
    "TransferCancelledError": "core.errors",
    "RecordingError": "recording.errors",
    "SettingOutcome": "models.settings.loading",
    "SettingReport": "models.settings.loading",
    "SettingKey": "core.settings",
}
"""The module below `grabbergui` that defines each public name."""

__all__ = [
    "AccessCondition",
    "AccessDeniedError",
    "AccessMode",
    "AckTimeoutError",
    "AsyncFrames",
    "Camera",
    "CameraFile",
    "CameraFileError",
    "CameraFiles",
    "CameraGroup",
    "ClockState",
    "ClosedError",
    "Component",
    "ComponentKind",
    "DeviceEvent",
    "DeviceInfo",
    "DeviceLostError",
    "DeviceStatusError",
    "EnumEntry",
    "ExistingFileError",
    "Feature",
    "FeatureAccessError",
    "FeatureError",
    "FeatureKind",
    "FeatureNotFoundError",
    "FeatureValueError",
    "Frame",
    "FrameLoop",
    "FrameSet",
    "FrameStamp",
    "FrameStatus",
    "FrameTimeoutError",
    "Frames",
    "GrabberError",
    "GroupFrames",
    "LoadReport",
    "LocalFileError",
    "MissingFileError",
    "MissingFrameError",
    "NotebookPanel",
    "OtherCameraError",
    "PayloadType",
    "PixelFormat",
    "PixelFormatError",
    "PointCloud",
    "ProtocolError",
    "Recording",
    "RecordingError",
    "RecordingProgress",
    "RemoteProtocolError",
    "Representation",
    "ResourceExhaustedError",
    "Rig",
    "SetCounts",
    "SetState",
    "SettingKey",
    "SettingOutcome",
    "SettingReport",
    "SettingValue",
    "SourceNotFoundError",
    "SourceUnavailableError",
    "StreamStatistics",
    "TransferCancelledError",
    "TransportError",
    "UsageError",
    "Visibility",
    "Written",
    "__version__",
    "discover",
    "live_view",
    "open",
    "open_all",
    "open_rig",
]


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'grabbergui' has no attribute '{name}'")
    try:
        value: object = getattr(importlib.import_module(f"grabbergui.{_HOMES[name]}"), name)
    except ImportError as error:
        from grabbergui.core.missing_packages import explained

        raise ImportError(f"grabbergui.{name}: {explained(error)}", name=error.name) from error
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
