"""Simulated cameras with drifting clocks, the first one wired to the others, for a network namespace.

`python wired_cameras.py RATE WIDTH HEIGHT ADDRESS…` starts a camera at each address and prints a JSON object
with the epoch and drift of each clock: a camera's time is (monotonic - epoch) · (1 + drift), in nanoseconds.
The monotonic clock is that of all processes of the machine. Ends when its input is closed.
"""

from __future__ import annotations

import json
import random
import sys

from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.server import GigeCamera

WORST_DRIFT = 50e-6


def main(rate: float, width: int, height: int, addresses: list[str]) -> None:
    drifts = [WORST_DRIFT, -WORST_DRIFT]
    drifts += [random.Random(n).uniform(-WORST_DRIFT, WORST_DRIFT) for n in range(2, len(addresses))]
    settings = {reg.WIDTH: width, reg.HEIGHT: height, reg.EXPOSURE_TIME: 3000.0, reg.FRAME_RATE: rate}
    cameras = [
        GigeCamera(address, power_on=settings, drift=drift)
        for address, drift in zip(addresses, drifts, strict=True)
    ]
    for other in cameras[1:]:
        cameras[0].wire_to(other)
    clocks = {
        camera.address: (camera.model.device_clock.to_monotonic(0), drift)
        for camera, drift in zip(cameras, drifts, strict=True)
    }
    print(json.dumps(clocks), flush=True)
    sys.stdin.read()
    for camera in cameras:
        camera.close()


if __name__ == "__main__":
    main(float(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), sys.argv[4:])
