"""A simulated GigE Vision camera in a process of its own, which records when each frame left."""

from __future__ import annotations

import argparse
import contextlib
import json
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from grabbergui.core.pfnc import by_name
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import TestPattern

ADDRESS = "127.0.79.9"
WIDTH, HEIGHT = 4096, 256
PIXEL_FORMAT = by_name("BGRa8")
"Few lines of many bytes, so that the sensor's readout does not bound the rate: 1,630 frames/s, 6.8 GB/s."
PAYLOAD = PIXEL_FORMAT.image_bytes(WIDTH, HEIGHT)
_FEW_LINES = {
    reg.WIDTH: WIDTH,
    reg.HEIGHT: HEIGHT,
    reg.PIXEL_FORMAT: PIXEL_FORMAT.code,
    reg.TEST_PATTERN: int(TestPattern.GREY_HORIZONTAL_RAMP),
}
COUNTED_WIDTH, COUNTED_HEIGHT, COUNTED_RATE = 2048, 2160, 25.0
"The whole sensor, binned across: AravisCamera sets the largest region, whatever was set before."
_COUNTED = {
    reg.BINNING_HORIZONTAL: 2,
    reg.WIDTH: COUNTED_WIDTH,
    reg.HEIGHT: COUNTED_HEIGHT,
    reg.FRAME_RATE_ENABLE: 1,
    reg.FRAME_RATE: COUNTED_RATE,
    reg.TEST_PATTERN: int(TestPattern.GREY_HORIZONTAL_RAMP_MOVING),
}
GIGABIT = 125e6
"Bandwidth of the link, bytes per second."


@dataclass(frozen=True)
class Conditions:
    """How the camera sends."""

    bandwidth: float = GIGABIT
    "Bytes per second; 0 for no limit."
    loss: float = 0.0
    counted: bool = False
    "Mono8 images at a constant rate, whose first pixel counts them, instead of the few lines."


def serve(conditions: Conditions, address: str) -> None:
    """Run the camera until standard input ends, then print when each block's last packet left."""
    from grabbergui.driver.sim.gige.faults import GigeFaults
    from grabbergui.driver.sim.gige.server import GigeCamera

    sent: dict[int, float] = {}
    camera = GigeCamera(
        address,
        bandwidth=conditions.bandwidth,
        faults=GigeFaults(loss=conditions.loss),
        segmentation=True,  # the kernel cuts packets out of large sends, fast as a camera's hardware
        on_sent=lambda block_id: sent.__setitem__(block_id, time.monotonic()),
        power_on={
            reg.FRAME_RATE_ENABLE: 0,
            reg.EXPOSURE_TIME: 1000.0,
            **(_COUNTED if conditions.counted else _FEW_LINES),
        },
    )
    print("ready", flush=True)
    sys.stdin.read()
    camera.close()
    print(json.dumps(sent), flush=True)


@contextlib.contextmanager
def camera_process(
    conditions: Conditions, address: str = ADDRESS, enter: Sequence[str] = ()
) -> Iterator[dict[int, float]]:
    """Run a new camera process for a receiver; `enter` is put before its command.

    Yields when each block's last payload packet left (monotonic seconds, by block id), filled at the end.
    """
    command = [*enter, sys.executable, "-m", "benchmarks._gige_camera", address, str(conditions.bandwidth)]
    command += [str(conditions.loss), str(int(conditions.counted))]
    sent: dict[int, float] = {}
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stdin is not None
        if process.stdout.readline().strip() != "ready":
            raise SystemExit(f"the camera did not come up at {address}; is another one there?")
        try:
            yield sent
        finally:
            process.stdin.close()
            sent |= {int(block_id): at for block_id, at in json.loads(process.stdout.read()).items()}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("address")
    parser.add_argument("bandwidth", type=float)
    parser.add_argument("loss", type=float)
    parser.add_argument("counted", type=int)
    chosen = parser.parse_args()
    serve(Conditions(chosen.bandwidth, chosen.loss, bool(chosen.counted)), chosen.address)
