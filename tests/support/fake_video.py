"""A webcam in memory: controls that lock each other, formats, buffers."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterable

import cv2
import numpy as np

from grabbergui.core.errors import DeviceLostError, DeviceStatusError
from grabbergui.driver.v4l2.video import Control, ControlKind, CurrentFormat, Filled, FrameSizes

EXPOSURE_AUTO, EXPOSURE, GAIN, POWER_LINE, MIRROR, RESET = (
    0x009A0901, 0x009A0902, 0x00980913, 0x00980918, 0x00980914, 0x00980D00,
)  # fmt: skip
CONTROLS = [
    Control(GAIN, "Gain", ControlKind.INTEGER, 0, 255),
    Control(
        POWER_LINE, "Power Line Frequency", ControlKind.MENU, 0, 2, 1, {0: "Disabled", 1: "50 Hz", 2: "60 Hz"}
    ),
    Control(MIRROR, "Horizontal Flip", ControlKind.BOOLEAN),
    Control(
        EXPOSURE_AUTO,
        "Auto Exposure",
        ControlKind.MENU,
        0,
        3,
        1,
        {1: "Manual Mode", 3: "Aperture Priority Mode"},
    ),
    Control(EXPOSURE, "Exposure Time, Absolute", ControlKind.INTEGER, 3, 2047),
    Control(RESET, "Pan, Reset", ControlKind.BUTTON),
    Control(0x0098F900, "Gain", ControlKind.INTEGER, -5, 5),
]
SIZES = ((640, 480), (320, 240))


class FakeVideo:
    """Frames at the rate that is set: a ramp that brightens with the exposure time."""

    def __init__(self, path: str = "/dev/video7") -> None:
        self.path = path
        self.values = {control.id: control.minimum for control in CONTROLS}
        self.values |= {EXPOSURE_AUTO: 1, EXPOSURE: 100}
        self.pressed = 0
        self.code, self.size, self.hz = "YUYV", SIZES[0], 30.0
        self.unplugged = False
        self.stamp = time.monotonic_ns
        self.streaming = False
        self._sequence = 0
        self._queued: list[int] = []
        self._filled: list[Filled] = []
        self._pipe = os.pipe()
        self._thread: threading.Thread | None = None

    def close(self) -> None:
        for end in self._pipe:
            os.close(end)
        self._pipe = (-1, -1)

    def fileno(self) -> int:
        return self._pipe[0]

    def controls(self) -> list[Control]:
        return CONTROLS

    def control(self, control_id: int) -> int:
        self._require_plugged()
        return self.values[control_id]

    def set_control(self, control_id: int, value: int) -> None:
        self._require_plugged()
        if self.locked(control_id):
            raise DeviceStatusError(f"{self.path}: the driver refuses a control", 13)
        self.pressed += control_id == RESET
        self.values[control_id] = value

    def locked(self, control_id: int) -> bool:
        return control_id == EXPOSURE and self.values[EXPOSURE_AUTO] != 1

    def formats(self) -> list[str]:
        return ["YUYV", "MJPG", "GREY", "XYZ9"]

    def sizes(self, fourcc: str) -> FrameSizes:
        assert fourcc != "XYZ9", "of a format that it does not know, linuxpy knows no sizes"
        return FrameSizes.listed(SIZES)

    def rates(self, fourcc: str, width: int, height: int) -> tuple[float, float]:
        return (5.0, 30.0 if width == 640 else 60.0)

    def format(self) -> CurrentFormat:
        self._require_plugged()
        width, height = self.size
        line = {"YUYV": 2 * width, "GREY": width}.get(self.code, 0)
        return CurrentFormat(self.code, width, height, line, line * height or width * height)

    def set_format(self, fourcc: str, width: int, height: int) -> None:
        assert not self.streaming
        self.code = fourcc
        self.size = min(SIZES, key=lambda size: abs(size[0] - width) + abs(size[1] - height))

    def rate(self) -> float:
        return self.hz

    def set_rate(self, rate: float) -> None:
        self.hz = min((5.0, 10.0, 15.0, 30.0, 60.0), key=lambda known: abs(known - rate))

    def begin(self, count: int) -> list[memoryview]:
        self._buffers = [memoryview(bytearray(640 * 480 * 2)) for _ in range(count)]
        self._queued, self.streaming = list(range(count)), True
        self._thread = threading.Thread(target=self._expose, daemon=True)
        self._thread.start()
        return self._buffers

    def end(self, maps: Iterable[memoryview]) -> None:
        self.streaming = False
        assert self._thread is not None
        self._thread.join()
        for each in maps:
            each.release()

    def queue(self, index: int) -> None:
        self._queued.append(index)

    def take(self) -> Filled | None:
        self._require_plugged()
        os.read(self._pipe[0], 1)
        return self._filled.pop(0)

    def _expose(self) -> None:
        while self.streaming:
            time.sleep(1 / self.hz)
            self._sequence += 1
            if self._queued or self.unplugged:
                if not self.unplugged:
                    self._fill(self._queued.pop(0))
                os.write(self._pipe[1], b"x")

    def _fill(self, index: int) -> None:
        content = self.image()
        self._buffers[index][: len(content)] = content
        stamp = self.stamp()
        self._filled.append(Filled(index, len(content), self._sequence, stamp, damaged=False))

    def image(self) -> bytes:
        width, height = self.size
        grey = np.tile(np.linspace(0, 200, width).astype(np.uint8), (height, 1)) + self.values[EXPOSURE] // 40
        if self.code == "GREY":
            return grey.tobytes()
        if self.code == "MJPG":
            return cv2.imencode(".jpg", cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR))[1].tobytes()
        yuyv = np.full((height, width, 2), 128, np.uint8)
        yuyv[..., 0] = grey
        return yuyv.tobytes()

    def _require_plugged(self) -> None:
        if self.unplugged:
            raise DeviceLostError(f"{self.path} was unplugged")
