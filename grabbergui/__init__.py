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
    from grabbergui.core.errors import (
        AccessDeniedError,
        CameraFileError,
        ClosedError,
        DeviceLostError,
        FeatureAccessError,
        FeatureError,
        FeatureNotFoundError,
        FeatureValueError,
        FrameTimeoutError,
        GrabberError,
        PixelFormatError,
        SourceNotFoundError,
        TransportError,
        UsageError,
    )
    from grabbergui.core.features import Feature
    from grabbergui.core.frame import Frame
    from grabbergui.core.frame_queue import StreamStatistics
    from grabbergui.core.grabber import DeviceEvent
    from grabbergui.core.identity import DeviceInfo
    from grabbergui.library import discover, open, open_all  # noqa: A004
    from grabbergui.library.camera import Camera
    from grabbergui.library.group import CameraGroup
    from grabbergui.library.live_view import live_view
    from grabbergui.library.streaming import AsyncFrames, Frames, Recording

__version__ = "0.2.0"

_HOMES = {
    "open": "library",
    "open_all": "library",
    "discover": "library",
    "live_view": "library.live_view",
    "Camera": "library.camera",
    "CameraGroup": "library.group",
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
    "PixelFormatError": "core.errors",
    "CameraFileError": "core.errors",
}
"""The module below `grabbergui` that defines each public name."""

__all__ = [
    "AccessDeniedError",
    "AsyncFrames",
    "Camera",
    "CameraFileError",
    "CameraGroup",
    "ClosedError",
    "DeviceEvent",
    "DeviceInfo",
    "DeviceLostError",
    "Feature",
    "FeatureAccessError",
    "FeatureError",
    "FeatureNotFoundError",
    "FeatureValueError",
    "Frame",
    "FrameTimeoutError",
    "Frames",
    "GrabberError",
    "PixelFormatError",
    "Recording",
    "SourceNotFoundError",
    "StreamStatistics",
    "TransportError",
    "UsageError",
    "__version__",
    "discover",
    "live_view",
    "open",
    "open_all",
]


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'grabbergui' has no attribute '{name}'")
    value: object = getattr(importlib.import_module(f"grabbergui.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
