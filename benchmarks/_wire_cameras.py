"""The streams of `gige_wire`, and the cameras that send them.

Run as a program, this is the fast camera: the simulated one, without a limit on its bandwidth, until standard
input ends. The sending interface cuts its large sends into packets, so each packet arrives singly.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass

from benchmarks._wire import CAMERA, inside

ARAVIS_CAMERA = "arv-fake-gv-camera-0.8"


@dataclass(frozen=True)
class Case:
    """A stream to receive."""

    width: int
    height: int
    rate: float
    "Frames per second that are asked for; the fake camera may not reach it."
    packet_size: int
    fast: bool = False
    "Whether the simulated camera sends, in BGRa8: Aravis's fake camera does not reach more than 110 MB/s."

    @property
    def name(self) -> str:
        pixels = ", BGRa8" if self.fast else ""
        return f"{self.width}×{self.height}{pixels} at {self.rate:g} Hz, {self.packet_size} bytes"

    @property
    def payload(self) -> int:
        return self.width * self.height * (4 if self.fast else 1)


@contextmanager
def camera(namespace: str, case: Case) -> Iterator[None]:
    """Run a new camera for a receiver."""
    if case.fast:
        command = [
            *inside(namespace),
            sys.executable,
            "-m",
            "benchmarks._wire_cameras",
            json.dumps(asdict(case)),
        ]
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as sender:
            assert sender.stdout is not None and sender.stdin is not None
            if sender.stdout.readline().strip() != "ready":
                raise SystemExit("the simulated camera did not start")
            try:
                yield
            finally:
                sender.stdin.close()
    else:
        command = [*inside(namespace), ARAVIS_CAMERA, "-i", CAMERA, "-s", f"WIRE{os.getpid()}"]
        fake = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            time.sleep(0.5)  # it prints nothing when it is ready
            yield
        finally:
            fake.terminate()
            fake.wait()


def serve(case: Case) -> None:
    """Run the fast camera until standard input ends."""
    from grabbergui.core.pfnc import by_name
    from grabbergui.driver.sim import registers as reg
    from grabbergui.driver.sim.enumerations import TestPattern
    from grabbergui.driver.sim.gige.server import GigeCamera

    power_on = {
        reg.WIDTH: case.width,
        reg.HEIGHT: case.height,
        reg.PIXEL_FORMAT: by_name("BGRa8").code,
        reg.TEST_PATTERN: int(TestPattern.GREY_HORIZONTAL_RAMP),
        reg.EXPOSURE_TIME: 1000.0,
        reg.FRAME_RATE_ENABLE: 1,
        reg.FRAME_RATE: case.rate,
    }
    with closing(GigeCamera(CAMERA, bandwidth=0, segmentation=True, power_on=power_on)):
        print("ready", flush=True)
        sys.stdin.read()


if __name__ == "__main__":
    serve(Case(**json.loads(sys.argv[1])))
