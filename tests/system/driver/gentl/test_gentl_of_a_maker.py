"""A GigE Vision camera through a camera maker's GenTL producer."""

from __future__ import annotations

import json
import statistics

from makers_producer import needs_producer, producer
from namespaces import Network, network
from patience import PATIENCE

__all__ = ["network"]

FRAMES = 10
PERIOD_NS = 50_000_000
PROGRAM = f"""
import json, sys, time
import grabbergui

def report(**what):
    print(json.dumps(what), flush=True)

with grabbergui.open("gentl:" + sys.argv[1]) as camera:
    camera["ExposureTime"] = 12345
    camera["PixelFormat"] = "Mono12"
    frames = list(camera.frames({FRAMES}))
    report(
        model=camera.info.model,
        exposure=camera["ExposureTime"],
        sizes=[frame.raw().shape for frame in frames],
        dtype=str(frames[0].raw().dtype),
        times=[frame.timestamp_ns for frame in frames],
        lost=camera.statistics.lost,
    )
    sys.stdin.readline()
    try:
        while True:
            camera.grab(timeout={PATIENCE})
    except grabbergui.GrabberError as error:
        report(error=type(error).__name__)
"""


@needs_producer
def test_it_streams_and_its_loss_is_noticed(network: Network) -> None:
    """Baumer's producer does not let the order of registers be set, and delivers ticks, not nanoseconds."""
    network.join()
    camera = network.start_camera("sim:?width=320&height=240&fps=20")
    host = network.programs.start(network.host, "-c", PROGRAM, str(producer()))
    assert host.stdout is not None and host.stdin is not None
    seen = json.loads(next(line for line in host.stdout if line.startswith("{")))
    assert seen["model"] == "Simulated camera"
    assert seen["exposure"] == 12345
    assert seen["sizes"] == FRAMES * [[240, 320]] and seen["dtype"] == "uint16"
    steps = [(b - a) / PERIOD_NS for a, b in zip(seen["times"], seen["times"][1:], strict=False)]
    assert min(steps) > 0.9 and abs(statistics.median(steps) - 1) < 0.001, steps
    camera.kill()
    host.stdin.write("\n")
    host.stdin.flush()
    assert (
        json.loads(next(line for line in host.stdout if line.startswith("{")))["error"] == "DeviceLostError"
    )
