"""Images of known scenes, by the simulated sensor itself."""

import numpy as np

from benchmarks._viewpoint import looking_at
from grabbergui.core.calibration import Calibration
from grabbergui.core.pfnc import by_name
from grabbergui.driver.sim.registers import SENSOR_HEIGHT, SENSOR_WIDTH
from grabbergui.driver.sim.rendered_scene import RenderedScene, Things, pinhole
from grabbergui.driver.sim.sensor import Sensor
from grabbergui.driver.sim.settings import FrameSettings, Optics


def settings(binning=4, pixel_format="Mono8", exposure=10_000.0, **optics):
    """The middle of the sensor, 2432×2048 of its pixels."""
    width, height = 2432 // binning, 2048 // binning
    return FrameSettings(
        width,
        height,
        (SENSOR_WIDTH // binning - width) // 2,
        (SENSOR_HEIGHT // binning - height) // 2,
        by_name(pixel_format),
        Optics(binning_horizontal=binning, binning_vertical=binning, **optics),
        exposure,
        0.0,
        2.0,
    )


def calibration(of):
    return Calibration(of.width, of.height, pinhole(of), np.zeros(5))


def image(of, camera=None, board=None, face=None, seconds=0.0):
    """Grey (rows, columns); board and face are poses, None where there is none."""
    things = Things(face=lambda _: face, board=lambda _: board)
    scene = RenderedScene(things)
    if camera is not None:
        scene.mount(lambda _: camera)
    out = np.empty(of.image_bytes, np.uint8)
    return Sensor(scene).render(of, 1, int(seconds * 1e9), out).copy()


def camera(x=0.0, y=0.0, z=0.5, towards=(1.0, 0.0, 0.5)):
    return looking_at((x, y, z), towards)
