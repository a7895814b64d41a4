"""From a GigE camera to a reader on YARP: `grabbergui serve` beside AravisCamera, the C++ device of YARP.

    python -m benchmarks end_to_end [--seconds 5] [--rounds 3]

AravisCamera (github.com/roboticslab-uc3m/aravis-yarp-devices) takes part if `yarpdev` is on the PATH and
finds it. Needs root, iproute2 and ethtool.
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
    COUNTED_HEIGHT,
    COUNTED_RATE,
    COUNTED_WIDTH,
    GIGABIT,
    Conditions,
    camera_process,
)
from benchmarks._network_ends import cpu_seconds_of
from benchmarks._results import Goal, Section, Table, machine
from benchmarks._wire import CAMERA, FLUSH_NS, inside, moved_into, network_seconds, wire
from benchmarks.yarp_ports import CONTEXT, name_server, real_version
from grabbergui.core.errors import FrameTimeoutError, GrabberError
from grabbergui.net.yarp import image
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.ports import InputPort

PORT = "/benchmark/camera"
PACKET_SIZE = 1400
OURS, THEIRS = "grabbergui serve", "AravisCamera"
RAW = ("--capabilities", "RAW")
SOURCE = f"gige:{CAMERA}?packet_size={PACKET_SIZE}"
SERVE = (sys.executable, "-m", "grabbergui", "serve", "--yarp", PORT, *RAW)
COMMANDS = {
    OURS: [*SERVE, SOURCE],
    THEIRS: [
        *("yarpdev", "--device", "deviceBundler", "--wrapper_device", "frameGrabber_nws_yarp"),
        *("--attached_device", THEIRS, "--name", PORT, "--period", "0.005", *RAW),
    ],
}
SENT = Conditions(GIGABIT, counted=True)
LIKE_HARDWARE = ("nice", "-n", "-15")
"A camera keeps its rate, whatever else the computer does."
PATIENCE = 20.0
"Seconds that a server has to start."
SETTLING = 2.0
"Seconds of streaming before anything counts."
HEADER = ["server", "frames/s", "latency, median", "95 %", "server, CPU", "network, CPU", "both"]
METHOD = """The simulated camera sends {width}×{height} Mono8 at {rate:g} frames/s, paced as by Gigabit
Ethernet, in packets of {packet} bytes, over the wire between two network namespaces of the section on GigE
Vision: its end polls in a thread of the kernel and gathers packets for {flush:g} µs, as a network card does.
A server receives them and sends the images over `fast_tcp` to a reader in a process of its own. The servers
take turns of {seconds:g} seconds in {rounds} rounds, of which the median counts; ratios compare runs of the
same round. {peer}"""
READING = [
    "*latency*: from the moment the last payload packet leaves the camera to the image in the reader's "
    "hands.",
    "*server*, *network*: CPU milliseconds for each image that the reader gets, of the server's process and "
    "of the kernel's thread that receives the packets. AravisCamera receives through the ring of a packet "
    "socket, into which that thread copies them; for us it joins them. Camera and reader are the same for "
    "both, and not counted.",
]


@dataclass(frozen=True)
class Run:
    """The results of one server's run."""

    frames: int
    seconds: float
    server: float
    "CPU seconds of the server's process."
    network: float
    "CPU seconds of the kernel's thread that receives packets."
    latencies: list[float]
    "Latencies in milliseconds, sorted."

    @property
    def median(self) -> float:
        return statistics.median(self.latencies) if self.latencies else float("nan")

    @property
    def late(self) -> float:
        return self.latencies[int(0.95 * len(self.latencies))] if self.latencies else float("nan")

    @property
    def server_per_frame(self) -> float:
        return 1000 * self.server / max(self.frames, 1)

    @property
    def network_per_frame(self) -> float:
        return 1000 * self.network / max(self.frames, 1)

    @property
    def cpu_per_frame(self) -> float:
        return self.server_per_frame + self.network_per_frame


def measure(arguments: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks end_to_end", description=__doc__)
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args(arguments)
    before = machine()
    servers = [OURS, *([THEIRS] if has_aravis_camera() else [])]
    runs: dict[str, list[Run]] = {server: [] for server in servers}
    with wire() as (camera, host), moved_into(host), name_server() as names:
        for _ in range(options.rounds):
            for server in servers:
                run = observe(server, names, camera, options.seconds)
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
        flush=FLUSH_NS / 1000,
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


def observe(server: str, names: str, camera: str, seconds: float) -> Run:
    """Measure one server between the camera, in the namespace of that name, and the reader."""
    with (
        camera_process(SENT, CAMERA, [*inside(camera), *LIKE_HARDWARE]) as sent,
        running(server, names) as pid,
        ExitStack() as stack,
    ):
        pipe, theirs = CONTEXT.Pipe()
        reader = CONTEXT.Process(target=read, args=(theirs, names, SETTLING + seconds), daemon=True)
        reader.start()
        theirs.close()  # so that a reader without an image ends the wait for it
        stack.callback(reader.join, PATIENCE)
        pipe.recv()
        time.sleep(SETTLING)
        begun, cpu, network = time.monotonic(), cpu_seconds_of(pid), network_seconds()
        time.sleep(seconds)
        took, cpu = time.monotonic() - begun, cpu_seconds_of(pid) - cpu
        network = network_seconds() - network
        arrivals: list[tuple[float, int]] = pipe.recv()
    counted = [(at, count) for at, count in arrivals if begun <= at < begun + took]
    found = (latency(at, count, sent) for at, count in counted)
    return Run(len(counted), took, cpu, network, sorted(1000 * late for late in found if late is not None))


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
    """Report the first image, then the arrival time of each image and the number in its first pixel."""
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
        port.read(PATIENCE)
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
            f"{middle(server, lambda run: run.server_per_frame):.1f} ms",
            f"{middle(server, lambda run: run.network_per_frame):.1f} ms",
            f"{middle(server, cpu_per_frame):.1f} ms",
        ]
        for server in runs
    ]


def goals(runs: dict[str, list[Run]]) -> list[Goal]:
    """Judge our figures as multiples of AravisCamera's, round by round; no goals without it."""
    if THEIRS not in runs:
        return []

    def goal(what: str, most: float, figure: Figure) -> Goal:
        rounds = zip(runs[OURS], runs[THEIRS], strict=True)
        ratio = statistics.median(figure(ours) / figure(theirs) for ours, theirs in rounds)
        return Goal(f"{what} at most {most:g} × AravisCamera's", f"{ratio:.2f} ×", ratio <= most)

    return [goal("CPU per frame", 1.0, cpu_per_frame), goal("latency", 0.3, median)]


if __name__ == "__main__":
    print(_document.markdown(measure()))
