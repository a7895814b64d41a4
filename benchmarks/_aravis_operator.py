"""Drives Aravis as an operator would: open, start, stop, change format and region, write the gain.

The format and the region are as before when it ends. Runs in the system's Python, which has PyGObject:
/usr/bin/python3 _aravis_operator.py ADDRESS WRITES PAUSE
Prints seconds as JSON: one number an action, a list for the writes.
"""

import json
import sys
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import gi

gi.require_version("Aravis", "0.8")
from gi.repository import Aravis  # noqa: E402 - only after the version is chosen

BUFFERS = 8
PATIENCE_US = 5_000_000


class Operator:
    def __init__(self, address: str) -> None:
        began = time.monotonic()
        self.camera = Aravis.Camera.new(address)
        self.camera.gv_set_stream_options(Aravis.GvStreamOption.PACKET_SOCKET_DISABLED)
        self.device = self.camera.get_device()
        self.took = {"open": time.monotonic() - began}
        self.stream: Any = None

    def start(self) -> None:
        self.stream = self.camera.create_stream(None, None)
        self.stream.set_property("socket-buffer", Aravis.GvStreamSocketBuffer.AUTO)
        for _ in range(BUFFERS):
            self.stream.push_buffer(Aravis.Buffer.new_allocate(self.camera.get_payload()))
        self.camera.start_acquisition()

    def frame(self) -> None:
        while True:
            buffer = self.stream.timeout_pop_buffer(PATIENCE_US)
            if buffer is None:
                raise SystemExit("Aravis got no frame")
            complete = buffer.get_status() == Aravis.BufferStatus.SUCCESS
            self.stream.push_buffer(buffer)
            if complete:
                return

    def stop(self) -> None:
        self.camera.stop_acquisition()
        self.stream = None  # its thread ends with it

    def timed(self, name: str, *actions: Callable[[], object]) -> None:
        began = time.monotonic()
        for action in actions:
            action()
        self.took[name] = time.monotonic() - began

    def change(self, name: str, write: Callable[[], object]) -> None:
        """Change settings as a viewer does, until the first frame with the new ones."""
        self.timed(name, partial(self.write_stopped, write), self.frame)

    def write_stopped(self, write: Callable[[], object]) -> None:
        """Stop, write and start again."""
        self.stop()
        write()
        self.start()


def main(address: str, writes: int, pause: float) -> None:
    operator = Operator(address)
    operator.timed("start", operator.start, operator.frame)
    gains = []
    for number in range(writes):
        end = time.monotonic() + pause
        while time.monotonic() < end:
            operator.frame()
        began = time.monotonic()
        operator.device.set_float_feature_value("Gain", float(number % 2))
        gains.append(time.monotonic() - began)
    device = operator.device
    operator.change("pixel format", lambda: device.set_string_feature_value("PixelFormat", "Mono16"))
    operator.write_stopped(lambda: device.set_string_feature_value("PixelFormat", "Mono8"))
    operator.change("region", lambda: device.set_integer_feature_value("Height", 768))
    operator.write_stopped(lambda: device.set_integer_feature_value("Height", 1536))
    operator.timed("stop", operator.stop)
    operator.timed("start and stop", operator.start, operator.stop)
    print(json.dumps({**operator.took, "writes": gains}))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]))
