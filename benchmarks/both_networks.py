"""One camera on YARP and ROS 2 at once, and on each alone: delivery, latency, CPU and memory.

python -m benchmarks.both_networks [--seconds 2] [--rate 30] [--pixel-format BayerRG8]

The server is one process; every reader is another. Latency is from the exposure's stamp to the whole picture
in the reader's hands. A picture counts as delivered when the reader has the one with that stamp.
"""

from __future__ import annotations

import argparse
import bisect
import importlib.util
import multiprocessing
import os
import random
import statistics
from collections.abc import Callable
from contextlib import ExitStack
from multiprocessing.connection import Connection
from typing import Any

from benchmarks._network_ends import Arrivals, read_ros2, read_yarp, serve

SIZES = {"640×480": (640, 480), "1080p": (1920, 1080), "2448×2048": (2448, 2048)}
READERS = (1, 4)
CONTEXT = multiprocessing.get_context("spawn")
SAME_STAMP = 100_000
"""Nanoseconds: YARP's envelope keeps some ten microseconds of a stamp."""
IN_FLIGHT = 300_000_000
"""Nanoseconds at the end of a measurement whose frames may still be under way; they are not judged."""

HEADER = (
    "| picture | networks | readers on each | delivered YARP | delivered ROS 2 | latency YARP, median / p99 "
    "| latency ROS 2, median / p99 | camera | CPU, all | CPU, sensor | CPU per frame served | memory |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|---|"
)


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=2.0, help="how long each measurement takes")
    parser.add_argument("--rate", type=float, default=30.0, help="frames per second")
    parser.add_argument("--pixel-format", default="BayerRG8")
    options = parser.parse_args(arguments)
    # Nobody else's readers, and ours not beyond this machine.
    os.environ["ROS_DOMAIN_ID"] = str(random.randrange(1, 100))
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    missing = [name for name in ("rclpy", "grabber_interfaces") if importlib.util.find_spec(name) is None]
    if missing:
        print(f"Without ROS 2, since {' and '.join(missing)} cannot be imported (make setup-ros2).\n")
    uri = f"sim:?fps={options.rate:g}&pixel_format={options.pixel_format}"
    with ExitStack() as stack:
        server = _process(stack, serve, uri, not missing)
        address = server.recv()
        yarp = [_process(stack, read_yarp, number, address) for number in range(max(READERS))]
        numbers = range(0 if missing else max(READERS))
        ros2 = [_process(stack, read_ros2, number, address) for number in numbers]
        for reader in (*yarp, *ros2):
            reader.recv()
        print(HEADER)
        for name, size in SIZES.items():
            server.send(("size", *size))
            assert server.recv() == size
            _measure(server, [], [], options.seconds)  # what the first frames of a size cost is no matter
            print(_row(name, "none", 0, _measure(server, [], [], options.seconds)), flush=True)
            for count in READERS:
                for networks, ours, theirs in (
                    ("YARP", yarp[:count], []),
                    ("ROS 2", [], ros2[:count]),
                    ("both", yarp[:count], ros2[:count]),
                ):
                    if missing and networks != "YARP":
                        continue
                    result = _measure(server, ours, theirs, options.seconds)
                    print(_row(name, networks, count, result), flush=True)


class Result:
    """One measurement: what the server exposed and spent, what the readers have."""

    def __init__(self, answer: Any, seconds: float, yarp: list[Arrivals], ros2: list[Arrivals]) -> None:
        stamps, self.cpu, self.sensor_cpu, self.memory = answer
        self.seconds = seconds
        self.rate = (len(stamps) - 1) / (stamps[-1] - stamps[0]) * 1e9
        self.frames = len(stamps)
        self._judged = [stamp for stamp in stamps if stamp < stamps[-1] - IN_FLIGHT]
        self.yarp = self._delivery(yarp)
        self.ros2 = self._delivery(ros2)

    def _delivery(self, readers: list[Arrivals]) -> tuple[str, str]:
        """What arrived of what was exposed, the worst reader's; and the latency of all."""
        if not readers:
            return "", ""
        delivered, ages = len(self._judged), []
        for arrivals in readers:
            arrivals.sort()
            known = [stamp for stamp, _ in arrivals]
            delivered = min(delivered, sum(_has(known, stamp) for stamp in self._judged))
            ages += [(at - stamp) / 1e6 for stamp, at in arrivals if stamp >= self._judged[0]]
        if not ages:
            return f"0 of {len(self._judged)}", ""
        ages.sort()
        late = ages[int(len(ages) * 0.99)]
        return f"{delivered} of {len(self._judged)}", f"{statistics.median(ages):.1f} / {late:.1f} ms"


def _has(stamps: list[int], stamp: int) -> bool:
    place = bisect.bisect_left(stamps, stamp - SAME_STAMP)
    return place < len(stamps) and stamps[place] <= stamp + SAME_STAMP


def _measure(server: Connection, yarp: list[Connection], ros2: list[Connection], seconds: float) -> Result:
    """Let the readers join, watch for a while, and let them go."""
    for reader in (*yarp, *ros2):
        reader.send("join")
    for reader in (*yarp, *ros2):
        reader.recv()
    server.send("begin")
    server.recv()
    server.poll(seconds)  # nothing comes: this is the wait
    server.send("end")
    answer = server.recv()
    for reader in (*yarp, *ros2):
        reader.send("leave")
    return Result(answer, seconds, [reader.recv() for reader in yarp], [reader.recv() for reader in ros2])


def _row(size: str, networks: str, readers: int, result: Result) -> str:
    spent = result.cpu - result.sensor_cpu
    cells = [
        size,
        networks,
        str(readers or ""),
        result.yarp[0],
        result.ros2[0],
        result.yarp[1],
        result.ros2[1],
        f"{result.rate:.1f} fps",
        f"{result.cpu / result.seconds:.0%}",
        f"{result.sensor_cpu / result.seconds:.0%}",
        f"{spent / result.frames * 1e3:.1f} ms",
        f"{result.memory / 1e6:.0f} MB",
    ]
    return f"| {' | '.join(cells)} |"


def _process(stack: ExitStack, target: Callable[..., None], *arguments: Any) -> Connection:
    """A process of its own that obeys its pipe, and ends with the stack."""
    ours, theirs = CONTEXT.Pipe()
    process = CONTEXT.Process(target=target, args=(theirs, *arguments))
    process.start()
    theirs.close()

    def end() -> None:
        ours.send(None)
        process.join()

    stack.callback(end)
    return ours


if __name__ == "__main__":
    main()
