"""The cameras of a rig for network servers: each a grabber of its own, with equal stamps within a set."""

from __future__ import annotations

from collections.abc import Mapping

from typing_extensions import override

from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameQueue, FrameSink
from grabbergui.core.shared import SharedGrabber
from grabbergui.rig.grabber import RigGrabber


class ServedCamera(SharedGrabber):
    """A handle on one camera of a rig, whose frames are those of the sets, with the sets' times."""

    def put(self, frame: Frame) -> None:
        """Pass a frame to the server."""
        self._fanout.put(frame)

    @override
    def open_queue(self, depth: int = 2) -> FrameQueue:
        return self._fanout.open_queue(depth)

    @override
    def close(self) -> None:
        super().close()
        self._fanout.close()


class ServedCameras:
    """Distributes the sets of a rig to a handle for each camera, on a thread of its own."""

    def __init__(self, rig: RigGrabber) -> None:
        self.cameras: Mapping[str, ServedCamera] = {
            name: ServedCamera(grabber) for name, grabber in rig.cameras.items()
        }
        self._sink = FrameSink(rig, self._distribute, name="rig cameras", depth=4)

    def start(self) -> None:
        """Open the handles and begin to distribute."""
        for camera in self.cameras.values():
            camera.open()
        self._sink.start()

    def close(self) -> None:
        """End the thread and close the handles."""
        self._sink.stop()
        for camera in self.cameras.values():
            camera.close()

    def _distribute(self, frame: Frame) -> None:
        for name, member in frame.members().items():
            self.cameras[name].put(member)
