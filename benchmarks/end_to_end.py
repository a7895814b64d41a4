"""From a GigE camera to a reader on YARP: `grabbergui serve` beside AravisCamera, the C++ device of YARP.

    python -m benchmarks end_to_end [--seconds 5] [--rounds 3]

AravisCamera (github.com/roboticslab-uc3m/aravis-yarp-devices) takes part if `yarpdev` is on the PATH and
finds it.
"""

from __future__ import annotations

import argparse
import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection

from benchmarks import _document
from benchmarks._gige_camera import (
    ADDRESS,
    COUNTED_HEIGHT,
    COUNTED_RATE,
    COUNTED_WIDTH,
    GIGABIT,
    Conditions,
    camera_process,
)
from benchmarks._network_ends import cpu_seconds_of
from benchmarks._results import Goal, Section, Table, machine
from benchmarks.yarp_ports import CONTEXT, name_server, real_version
from grabbergui.core.errors import FrameTimeoutError, GrabberError
from grabbergui.net.yarp import image
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.ports import InputPort

PORT = "/benchmark/camera"
PACKET_SIZE = 1400
OURS, THEIRS = "grabbergui serve", "AravisCamera"
RAW = ("--capabilities", "RAW")
SOURCE = f"gige:{ADDRESS}?packet_size={PACKET_SIZE}"
SERVE = (sys.executable, "-m", "grabbergui", "serve", "--yarp", PORT, *RAW)
COMMANDS = {
    OURS: [*SERVE, SOURCE],
    THEIRS: [
        *("yarpdev", "--device", "deviceBundler", "--wrapper_device", "frameGrabber_nws_yarp"),
        *("--attached_device", THEIRS, "--name", PORT, "--period", "0.005", *RAW),
    ],
}
CAMERA = Conditions(GIGABIT, segmentation=False, counted=True)
PATIENCE = 20.0
"Seconds that a server has to start."
SETTLING = 2.0
"Seconds of streaming before anything counts."
HEADER = ["server", "frames/s", "latency, median", "95 %", "CPU", "CPU per frame"]
METHOD = """The simulated camera sends {width}×{height} Mono8 at {rate:g} frames/s, paced as by Gigabit
Ethernet, in packets of {packet} bytes, each sent singly. A server receives them and sends the images over
`fast_tcp` to a reader in a process of its own. The servers take turns of {seconds:g} seconds in {rounds}
rounds, of which the median counts; ratios compare runs of the same round. {peer}CPU is that of the server
alone, kernel included."""
READING = [
    "*latency*: from the moment the last payload packet leaves the camera to the image in the reader's "
    "hands.",
    "AravisCamera receives through the ring of a packet socket if it may (CAP_NET_RAW): the kernel then "
    "copies packets in the sender's time, which does not count as the server's.",
]


@dataclass(frozen=True)
class Run:
    """The results of one server's run."""

    frames: int
    seconds: float
    cpu: float
    "CPU seconds of the server's process."
    latencies: list[float]
    "Latencies in milliseconds, sorted."

    @property
    def median(self) -> float:
        return statistics.median(self.latencies) if self.latencies else float("nan")

    @property
    def late(self) -> float:
        return self.latencies[int(0.95 * len(self.latencies))] if self.latencies else float("nan")

    @property
    def cpu_per_frame(self) -> float:
        return 1000 * self.cpu / max(self.frames, 1)


def measure(arguments: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks end_to_end", description=__doc__)
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args(arguments)
    before = machine()
    servers = [OURS, *([THEIRS] if has_aravis_camera() else [])]
    runs: dict[str, list[Run]] = {server: [] for server in servers}
    with name_server() as names:
        for _ in range(options.rounds):
            for server in servers:
                run = observe(server, names, options.seconds)
                runs[server].append(run)
                print(
                    f"{server}: {run.cpu_per_frame:.1f} ms of CPU per frame, {run.median:.1f} ms", flush=True
                )
    there = THEIRS in servers
    peer = f"AravisCamera's YARP is {real_version()}. " if there else "**AravisCamera was not there.** "
    method = METHOD.format(
        width=COUNTED_WIDTH,
        height=COUNTED_HEIGHT,
        rate=COUNTED_RATE,
        packet=PACKET_SIZE,
        seconds=options.seconds,
        rounds=options.rounds,
        peer=peer,
    )
    return Section(
        "From the camera to a reader on YARP",
        "python -m benchmarks end_to_end          # a minute; yarpdev and AravisCamera on the PATH",
        method,
        [Table(HEADER, rows(runs))],
        goals=goals(runs),
        reading=READING,
        machine=before,
        lacking="" if there else "AravisCamera",
    )


def observe(server: str, names: str, seconds: float) -> Run:
    """Measure one server between the camera and the reader."""
    with camera_process(CAMERA) as sent, running(server, names) as pid, ExitStack() as stack:
        pipe, theirs = CONTEXT.Pipe()
        reader = CONTEXT.Process(target=read, args=(theirs, names, SETTLING + seconds), daemon=True)
        reader.start()
        stack.callback(reader.join, PATIENCE)
        pipe.recv()
        time.sleep(SETTLING)
        begun, cpu = time.monotonic(), cpu_seconds_of(pid)
        time.sleep(seconds)
        took, cpu = time.monotonic() - begun, cpu_seconds_of(pid) - cpu
        arrivals: list[tuple[float, int]] = pipe.recv()
    counted = [(at, count) for at, count in arrivals if begun <= at < begun + took]
    found = (latency(at, count, sent) for at, count in counted)
    return Run(len(counted), took, cpu, sorted(1000 * late for late in found if late is not None))


@contextmanager
def running(server: str, names: str) -> Iterator[int]:
    """Run a server; yield its process id."""
    command = COMMANDS[server] + ([] if server == THEIRS else ["--nameserver", names])
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        try:
            yield process.pid
        finally:
            process.terminate()
            with suppress(subprocess.TimeoutExpired):
                process.wait(PATIENCE)
            process.kill()


def read(pipe: Connection, names: str, seconds: float) -> None:
    """Report the connection, then the arrival time of each image and the number in its first pixel."""
    port = InputPort("/benchmark/reader", NameClient.find(names), depth=4)
    with port:
        until = time.monotonic() + PATIENCE
        while True:
            try:
                port.connect(PORT)
                break
            except GrabberError:
                if time.monotonic() > until:
                    raise
                time.sleep(0.2)
        pipe.send(None)
        arrivals = []
        until = time.monotonic() + seconds + 1.0
        while time.monotonic() < until:
            with suppress(FrameTimeoutError):
                message, _ = port.read(0.5)
                at = time.monotonic()
                pixels = image.decode(message)[1]
                if pixels.shape[:2] != (COUNTED_HEIGHT, COUNTED_WIDTH):
                    raise SystemExit(f"an image of {pixels.shape}: the servers would not do the same work")
                arrivals.append((at, int(pixels[0, 0])))
        pipe.send(arrivals)


def latency(at: float, count: int, sent: dict[int, float]) -> float | None:
    """Return the seconds since the last frame with the number `count` modulo 256 left, or None."""
    left = [when for block, when in sent.items() if block % 256 == count and when <= at]
    return at - max(left) if left else None


def has_aravis_camera() -> bool:
    if not shutil.which("yarpdev"):
        return False
    listed = subprocess.run(["yarpdev", "--list"], capture_output=True, text=True, check=False)
    return f'"{THEIRS}"' in listed.stdout + listed.stderr


Figure = Callable[[Run], float]


def median(run: Run) -> float:
    return run.median


def cpu_per_frame(run: Run) -> float:
    return run.cpu_per_frame


def rows(runs: dict[str, list[Run]]) -> list[list[str]]:
    def middle(server: str, figure: Figure) -> float:
        return statistics.median(map(figure, runs[server]))

    return [
        [
            server,
            f"{middle(server, lambda run: run.frames / run.seconds):.1f}",
            f"{middle(server, median):.1f} ms",
            f"{middle(server, lambda run: run.late):.1f} ms",
            f"{middle(server, lambda run: run.cpu / run.seconds):.0%}",
            f"{middle(server, cpu_per_frame):.1f} ms",
        ]
        for server in runs
    ]


def goals(runs: dict[str, list[Run]]) -> list[Goal]:
    """Judge our figures as multiples of AravisCamera's, round by round; no goals without it."""
    if THEIRS not in runs:
        return []

    def goal(server: str, what: str, figure: Figure) -> Goal:
        rounds = zip(runs[server], runs[THEIRS], strict=True)
        ratio = statistics.median(figure(ours) / figure(theirs) for ours, theirs in rounds)
        return Goal(f"{server}: no more {what} than AravisCamera", f"{ratio:.2f} times", ratio <= 1)

    return [goal(OURS, "CPU per frame", cpu_per_frame), goal(OURS, "latency", median)]


if __name__ == "__main__":
    print(_document.markdown(measure()))
