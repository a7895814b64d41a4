"""A measurement of a served camera: its readers, its duration and its results.

Linux only, as the processes of `_network_ends` are.
"""

from __future__ import annotations

import bisect
import multiprocessing
import os
import random
import statistics
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

from benchmarks._network_ends import Read, Served

CONTEXT = multiprocessing.get_context("spawn")
SAME_STAMP = 100_000
"""Nanoseconds: YARP's envelope keeps some ten microseconds of a stamp."""
IN_FLIGHT = 300_000_000
"""Nanoseconds at the end of a measurement whose frames may still be in transit; they are not judged."""


@dataclass(frozen=True)
class Size:
    """Size and rate of the images to stream."""

    name: str
    width: int
    height: int
    rate: float
    "Frames per second."


def on_this_machine_only() -> None:
    """Keep ROS discovery on this machine. Call before any process is started."""
    os.environ["ROS_DOMAIN_ID"] = str(random.randrange(1, 100))
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"


def rounds_text(rounds: int) -> str:
    """Explain that each row shows its best round."""
    return f", in {rounds} rounds, of which each row's best counts" if rounds > 1 else ""


def process(stack: ExitStack, target: Callable[..., None], *arguments: Any) -> Connection:
    """Run a process that obeys its pipe and ends with the stack."""
    ours, theirs = CONTEXT.Pipe()
    child = CONTEXT.Process(target=target, args=(theirs, *arguments))
    child.start()
    theirs.close()

    def end() -> None:
        ours.send(None)
        child.join()

    stack.callback(end)
    return ours


class Delivery:
    """The frames that the readers of one network received, of those that were judged."""

    def __init__(self, judged: list[int], readers: list[Read]) -> None:
        self.judged = len(judged)
        self.worst = self.judged
        "Number of frames that the worst reader received."
        ages: list[float] = []
        for reader in readers:
            arrivals = sorted(reader.arrivals)
            known = [stamp for stamp, _ in arrivals]
            self.worst = min(self.worst, sum(_has(known, stamp) for stamp in judged))
            ages += [(at - stamp) / 1e6 for stamp, at in arrivals if judged and stamp >= judged[0]]
        ages.sort()
        self.median = statistics.median(ages) if ages else None
        "Median latency of all readers, milliseconds."
        self.late = ages[int(len(ages) * 0.99)] if ages else None
        "99th percentile of the latency, milliseconds."
        self.cores = statistics.median(reader.cores for reader in readers)
        "Cores used by one reader."

    @property
    def share(self) -> float:
        """Return the received part of the judged frames, percent; 0 if there were none."""
        return 100 * self.worst / self.judged if self.judged else 0.0

    def counts(self) -> str:
        return f"{self.worst} of {self.judged}"

    def latency(self) -> str:
        return "–" if self.median is None or self.late is None else f"{self.median:.1f} / {self.late:.1f} ms"


def _has(stamps: list[int], stamp: int) -> bool:
    place = bisect.bisect_left(stamps, stamp - SAME_STAMP)
    return place < len(stamps) and stamps[place] <= stamp + SAME_STAMP


class Run:
    """The frames and CPU time of the server, and the frames of its readers."""

    def __init__(self, served: Served, seconds: float, yarp: list[Read], ros2: list[Read]) -> None:
        stamps = served.stamps
        self.served = served
        self.frames = len(stamps)
        self.rate = (len(stamps) - 1) / (stamps[-1] - stamps[0]) * 1e9 if len(stamps) > 1 else 0.0
        judged = [stamp for stamp in stamps if stamp < stamps[-1] - IN_FLIGHT]
        self.yarp = Delivery(judged, yarp) if yarp else None
        self.ros2 = Delivery(judged, ros2) if ros2 else None
        self.cores = served.cpu / seconds
        "Cores used by the server."
        self.sensor_cores = served.sensor_cpu / seconds
        self.milliseconds_per_frame = (served.cpu - served.sensor_cpu) / max(self.frames, 1) * 1e3
        "CPU time for serving a frame, without the simulated sensor."

    @property
    def quality(self) -> tuple[float, float]:
        """Return a sort key, larger is better: the worst reader's share, then the shorter latency."""
        deliveries = [delivery for delivery in (self.yarp, self.ros2) if delivery]
        return (
            min((delivery.share for delivery in deliveries), default=100.0),
            -max((delivery.median or 0.0 for delivery in deliveries), default=0.0),
        )


def watch(server: Connection, yarp: list[Connection], ros2: list[Connection], seconds: float) -> Run:
    """Let the readers join, measure for a while, and let them leave."""
    for reader in (*yarp, *ros2):
        reader.send("join")
    for reader in (*yarp, *ros2):
        reader.recv()
    server.send("begin")
    server.recv()
    server.poll(seconds)  # waits; nothing arrives
    server.send("end")
    served = server.recv()
    for reader in (*yarp, *ros2):
        reader.send("leave")
    return Run(served, seconds, [reader.recv() for reader in yarp], [reader.recv() for reader in ros2])
