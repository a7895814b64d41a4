"""Simulates TEO and the camera on its head in a process of its own.

The robot has YARP ports; the camera is a GigE Vision device. The process prints one line with the name
server's address and the time at which the camera's clock was zero. It ends with its standard input.
"""

from __future__ import annotations

import contextlib
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass

from grabbergui.calibration.geometry import Pose
from grabbergui.core.pfnc import by_name
from grabbergui.core.scheduling import run_first, single_threaded
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.server import GigeCamera
from grabbergui.driver.sim.rendered_scene import RenderedScene, Things
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import NameServer
from grabbergui.servo import closed_loop
from grabbergui.servo.config import Config
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.robots.teo_ports import TeoPorts

ADDRESS = "127.14.79.10"
EXPOSURE_US = 4000.0


def serve(fps: float, board: bool) -> None:
    """Run robot and camera until standard input ends."""
    single_threaded()
    robot = SimRobot(teo.MODEL)
    things = Things() if board else Things(board=lambda seconds: None)
    scene = RenderedScene(closed_loop.things_for(Config().marker, things))
    chosen = closed_loop.settings()
    camera = GigeCamera(
        ADDRESS,
        scene=scene,
        segmentation=True,
        power_on={
            reg.BINNING_HORIZONTAL: closed_loop.BINNING,
            reg.BINNING_VERTICAL: closed_loop.BINNING,
            reg.OFFSET_X: chosen.offset_x,
            reg.OFFSET_Y: chosen.offset_y,
            reg.WIDTH: chosen.width,
            reg.HEIGHT: chosen.height,
            reg.PIXEL_FORMAT: by_name("Mono8").code,
            reg.FRAME_RATE: fps,
            reg.EXPOSURE_TIME: EXPOSURE_US,
        },
    )

    def pose(device_ns: int) -> Pose:
        age = (camera.model.timestamp() - device_ns) * 1e-9
        return robot.camera_at(time.monotonic() - age + EXPOSURE_US * 0.5e-6)

    scene.mount(pose, closed_loop.DRAWN_AHEAD_S)
    server = NameServer("127.14.79.1", 0)
    server.open()
    ports = TeoPorts(robot, NameClient(server.contact))
    run_first()
    ports.open()
    zero = time.monotonic() - 1e-9 * camera.model.timestamp()
    print(f"{server.contact.host}:{server.contact.port} {zero}", flush=True)
    sys.stdin.read()
    ports.close()
    camera.close()
    server.close()


@dataclass(frozen=True)
class Stand:
    """The addresses of the process."""

    name_server: str
    camera: str
    "URI of the camera."
    zero: float
    "`time.monotonic` at which the camera's clock was zero; stamps of frames do not give it exactly."


@contextlib.contextmanager
def stand(fps: float, *, board: bool = True) -> Iterator[Stand]:
    """Start the process; end it with the block."""
    command = [sys.executable, "-m", "benchmarks.servo._servo_stand", str(fps), str(int(board))]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stdin is not None
        place, zero = process.stdout.readline().split()
        try:
            yield Stand(place, f"gige:{ADDRESS}", float(zero))
        finally:
            process.stdin.close()
            process.wait(10)


if __name__ == "__main__":
    serve(float(sys.argv[1]), bool(int(sys.argv[2])))
