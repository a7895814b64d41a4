"""ROS 2 camera drivers side by side: our server and camera_aravis2, on the same simulated GigE camera.

    python -m benchmarks ros2_drivers [--seconds 5] [--rounds 3]

The path of camera_aravis2's `camera_driver_gv` is taken from the variable CAMERA_ARAVIS2 or from the PATH.
Without it only our server is measured, and the page says so.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from benchmarks import _document
from benchmarks._network_ends import cpu_seconds_of
from benchmarks._network_runs import Size, on_this_machine_only, process
from benchmarks._results import Chart, Goal, Section, Table, machine
from benchmarks._ros2_driver_ends import (
    ADDRESS,
    PACKET_SIZE,
    PATIENCE,
    Seen,
    Watched,
    be_camera,
    operate,
    read,
)

OURS, PEER, PEER_WITH_PROFILE = "ours", "camera_aravis2", "camera_aravis2, our DDS profile"
PEER_PROGRAM = "camera_driver_gv"
SIZES = (Size("1080p", 1920, 1080, 30.0), Size("8.8 MP", 4096, 2160, 10.0))
READERS = (1, 4)
PROFILE = Path(__file__).parents[1] / "resources/ros2/fastdds.xml"
ARRIVE = 2.0
"Seconds that the last images have to arrive."
WRITES = 20
"Writes of Gain per round."
TOPIC = "/camera/image_raw"
CALIBRATION = """image_width: 1920
image_height: 1080
camera_name: camera
distortion_model: plumb_bob
camera_matrix: {rows: 3, cols: 3, data: [1500, 0, 960, 0, 1500, 540, 0, 0, 1]}
distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
projection_matrix: {rows: 3, cols: 4, data: [1500, 0, 960, 0, 0, 1500, 540, 0, 0, 0, 1, 0]}
"""
METHOD = """One simulated GigE Vision camera (Mono8, packets of {packet} bytes, each sent singly, 10 ms
exposure; 30 frames per second at 1080p, 10 at 8.8 MP, which is what Gigabit Ethernet carries) runs in a
process of its own on the loopback. One driver at a time receives from it, in turn, in {rounds} rounds of
{seconds:g} seconds each: `grabbergui serve gige:… --ros2 /camera`, and Fraunhofer IOSB's `camera_aravis2` (a
C++ node over Aravis 0.8). Readers and operator are plain rclpy processes with the default quality of service
(reliable, depth 10), the same for both drivers. Both drivers run without capabilities, like an ordinary
user's programs.

camera_aravis2 1.2 was built from source with rclcpp 29.3 over the Fast DDS 3.2 of rclpy's wheels. Of
image_transport it has only the raw transport."""
WITHOUT = "\n\n**`camera_driver_gv` was not found here (CAMERA_ARAVIS2, PATH), so ours is measured alone.**"
READING = [
    "**delivered**: how many of the frames exposed in that time, over all rounds, the *worst* reader "
    "received; frames are identified by their first pixel. *None in N rounds*: a reader received no image "
    "within 30 s.",
    "On a busy machine the camera exposes fewer frames than requested, and latency and CPU per image rise "
    "for the driver that is measured at that moment.",
    "**latency**: from the start of the exposure, by the camera's own clock, to the whole image in a "
    "reader's hands, over all readers; the exposure takes 10 ms of it, the wire 17 ms at 1080p and 71 ms "
    "at 8.8 MP.",
    "**CPU per image**: of the driver's process, kernel included; *CPU per reader* is the share of a core "
    "that one reader's process takes.",
    "*our DDS profile*: `FASTDDS_DEFAULT_PROFILES_FILE=resources/ros2/fastdds.xml`, which our server sets "
    "by itself.",
    "**Gain**: from the operator's `set_parameters` to the write of the camera's register, and to the "
    "answer.",
]


@dataclass
class Runs:
    """All rounds of one driver with one image size and number of readers."""

    delivered: list[tuple[int, int]] = field(default_factory=list)
    "Images that the worst reader received, and images exposed, for each round."
    ages: list[list[float]] = field(default_factory=list)
    "Latencies of all readers in milliseconds, sorted, for each round."
    cpu_an_image: list[float] = field(default_factory=list)
    "CPU milliseconds per image of the driver's process, for each round."
    reader_cores: list[float] = field(default_factory=list)
    failed: int = 0
    "Rounds in which a reader received nothing."

    def add(self, watched: Watched, seen: list[Seen], cpu: float) -> None:
        judged = {began for _, began in watched.exposures}
        first = min(judged, default=0)
        ages: list[float] = []
        worst = len(judged)
        for one in seen:
            arrived = _exposed(watched.exposures, one.arrivals)
            worst = min(worst, len(judged & arrived.keys()))
            ages += [(at - began) / 1e6 for began, at in arrived.items() if began >= first]
        self.delivered.append((worst, len(judged)))
        self.ages.append(sorted(ages))
        self.cpu_an_image.append(1e3 * cpu / max(len(judged), 1))
        self.reader_cores.append(statistics.median(one.cores for one in seen))

    @property
    def share(self) -> float:
        """Percentage of the images of all rounds that the worst reader received."""
        worst, of = self._sums()
        return 100 * worst / of if of and not self.failed else 0.0

    @property
    def counts(self) -> str:
        worst, of = self._sums()
        return f"{worst} of {of}" + (f", none in {self.failed} rounds" if self.failed else "")

    def _sums(self) -> tuple[int, int]:
        return sum(worst for worst, _ in self.delivered), sum(of for _, of in self.delivered)

    def age(self, share: float) -> float | None:
        """Return the latency that a share of images does not exceed, the median of the rounds, or None."""
        rounds = [ages[min(int(len(ages) * share), len(ages) - 1)] for ages in self.ages if ages]
        return statistics.median(rounds) if rounds else None

    @property
    def cpu(self) -> float:
        """CPU milliseconds per image, the median of the rounds."""
        return statistics.median(self.cpu_an_image or [float("nan")])


@dataclass
class Gains:
    """Milliseconds from the request, of all rounds."""

    written: list[float] = field(default_factory=list)
    answered: list[float] = field(default_factory=list)


Key = tuple[str, str, int]
"Image size, driver, number of readers."


def _exposed(exposures: Sequence[tuple[int, int]], arrivals: Sequence[tuple[int, int]]) -> dict[int, int]:
    """Map the exposure of each image to its arrival, matching the latest one with the same first pixel."""
    by_pixel: dict[int, list[int]] = defaultdict(list)
    for pixel, began in exposures:
        by_pixel[pixel].append(began)
    found: dict[int, int] = {}
    for pixel, at in arrivals:
        earlier = [began for began in by_pixel[pixel] if began <= at]
        if earlier:
            found.setdefault(earlier[-1], at)
    return found


def peer() -> str | None:
    """Return the path of camera_aravis2's program, or None if it is not installed."""
    named = os.environ.get("CAMERA_ARAVIS2")
    return shutil.which(named or PEER_PROGRAM)


def as_ordinary_user(command: list[str]) -> list[str]:
    """Return the command, run without root's capabilities such as packet sockets and larger buffers."""
    if os.geteuid() != 0:
        return command
    return ["setpriv", "--bounding-set=-all", "--inh-caps=-all", *command]


def command_of(driver: str, folder: Path) -> list[str]:
    if driver == OURS:
        source = f"gige:{ADDRESS}?packet_size={PACKET_SIZE}"
        return [sys.executable, "-m", "grabbergui", "serve", source, "--ros2", "/camera"]
    program = peer()
    assert program is not None
    features = folder / "features.yaml"
    features.write_text("- FeatureName: Gain\n  Type: float\n  Description: Gain.\n")
    calibration = folder / "calibration.yaml"  # camera_aravis2 ends without one
    calibration.write_text(CALIBRATION)
    parameters = folder / "parameters.yaml"
    parameters.write_text(
        f"""/**:
  ros__parameters:
    guid: "{ADDRESS}"
    frame_id: camera
    camera_info_urls: ["{calibration}"]
    dynamic_parameters_yaml_url: "{features}"
    TransportLayerControl: {{GevSCPSPacketSize: {PACKET_SIZE}}}
"""
    )
    return [program, "--ros-args", "-r", "__node:=camera", "--params-file", str(parameters)]


@contextmanager
def running(driver: str) -> Iterator[int]:
    """Run the driver for the block; yield its process id."""
    with tempfile.TemporaryDirectory() as name, tempfile.TemporaryFile("w+") as log:
        environment = {key: value for key, value in os.environ.items() if not key.startswith("FASTDDS_")}
        if driver == PEER_WITH_PROFILE:
            environment["FASTDDS_DEFAULT_PROFILES_FILE"] = str(PROFILE)
        command = as_ordinary_user(command_of(driver, Path(name)))
        child = subprocess.Popen(command, env=environment, stdout=log, stderr=log)
        try:
            yield child.pid
        finally:
            ended = child.poll()
            child.terminate()
            try:
                child.wait(20)
            except subprocess.TimeoutExpired:
                child.kill()
                child.wait()
            if ended is not None:
                log.seek(0)
                print(f"{driver} ended by itself ({ended}):\n{log.read()[-2000:]}", flush=True)


def measured(
    drivers: Sequence[str], sizes: Sequence[Size], seconds: float, rounds: int
) -> tuple[dict[Key, Runs], dict[str, Gains]]:
    runs: dict[Key, Runs] = defaultdict(Runs)
    gains: dict[str, Gains] = defaultdict(Gains)
    for size in sizes:
        for _ in range(rounds):
            for count in READERS:
                for driver in drivers:
                    with ExitStack() as stack:
                        camera = process(stack, be_camera, size)
                        camera.recv()
                        pid = stack.enter_context(running(driver))
                        readers = [process(stack, read, number, TOPIC) for number in range(count)]
                        for end in readers:
                            end.recv()
                        found = watch(camera, readers, pid, seconds, runs[size.name, driver, count])
                        print(size.name, driver, count, *found, flush=True)
                        if size is sizes[0] and count == READERS[0]:
                            operator = process(stack, operate, "/camera/set_parameters", WRITES)
                            operator.recv()
                            set_gain(camera, operator, gains[driver])
    return dict(runs), dict(gains)


def watch(
    camera: Connection, readers: list[Connection], pid: int, seconds: float, runs: Runs
) -> tuple[str, ...]:
    """Let the readers join and measure for a while; they continue to read."""
    for reader in readers:
        reader.send("join")
    came = [reader.recv() for reader in readers]
    if not all(came):
        runs.failed += 1
        return (f"{came.count(False)} of {len(came)} readers got no image within {PATIENCE:g} s",)
    _ask(camera, "begin")
    cpu = cpu_seconds_of(pid)
    camera.poll(seconds)  # waits; nothing arrives
    watched, cpu = _ask(camera, "end"), cpu_seconds_of(pid) - cpu
    camera.poll(ARRIVE)
    runs.add(watched, [_ask(reader, "seen") for reader in readers], cpu)
    worst, of = runs.delivered[-1]
    ages = runs.ages[-1] or [float("nan")]
    return f"{worst} of {of}", f"{statistics.median(ages):.1f} ms", f"{runs.cpu_an_image[-1]:.1f} ms"


def set_gain(camera: Connection, operator: Connection, gains: Gains) -> None:
    """Set Gain repeatedly while one reader receives."""
    _ask(camera, "begin")
    done = _ask(operator, "set")
    watched = _ask(camera, "end")
    for one in done:
        written = [at for at in watched.gains if one.began <= at <= one.answered]
        gains.written += [(at - one.began) / 1e6 for at in written[:1]]
        gains.answered.append((one.answered - one.began) / 1e6)


def _ask(end: Connection, order: str) -> Any:
    end.send(order)
    return end.recv()


def stream_table(runs: dict[Key, Runs]) -> Table:
    rows = []
    for (size, driver, count), run in runs.items():
        reference = runs.get((size, PEER, count))
        rows.append(
            [
                size,
                str(count),
                driver,
                run.counts,
                f"{_text(run.age(0.5))} / {_text(run.age(0.99))} ms",
                _times(run.age(0.5), reference.age(0.5) if reference else None),
                f"{run.cpu:.1f} ms",
                _times(run.cpu, reference.cpu if reference else None),
                f"{statistics.median(run.reader_cores or [float('nan')]):.0%}",
            ]
        )
    header = ["image", "readers", "driver", "delivered", "latency, median / p99", f"× {PEER}"]
    return Table([*header, "CPU per image", f"× {PEER}", "CPU per reader"], rows)


def gain_table(gains: dict[str, Gains]) -> Table:
    rows = [
        [driver, *(f"{_middle(times)} / {_late(times)} ms" for times in (one.written, one.answered))]
        for driver, one in gains.items()
    ]
    header = ["driver", "register written, median / p99", "answered, median / p99"]
    return Table(header, rows, f"Gain, set {WRITES} times per round while one reader receives 1080p:")


def _middle(times: list[float]) -> str:
    return f"{statistics.median(times):.2f}" if times else "–"


def _late(times: list[float]) -> str:
    return f"{sorted(times)[int(len(times) * 0.99)]:.2f}" if times else "–"


def _text(value: float | None) -> str:
    return "–" if value is None else f"{value:.1f}"


def _times(value: float | None, reference: float | None) -> str:
    return f"{value / reference:.2f}" if value is not None and reference else "–"


def charts(runs: dict[Key, Runs]) -> list[Chart]:
    groups = list(dict.fromkeys((size, count) for size, _, count in runs))
    labels = [f"{size}, {count} reader{'s' * (count > 1)}" for size, count in groups]
    drivers = list(dict.fromkeys(driver for _, driver, _ in runs))

    def series(figure: Callable[[Runs], float | None]) -> dict[str, list[float | None]]:
        return {driver: [figure(runs[size, driver, count]) for size, count in groups] for driver in drivers}

    return [
        Chart(
            "ros2-drivers-latency",
            "Latency from the exposure to the reader, median",
            "milliseconds",
            labels,
            series(lambda run: run.age(0.5)),
            logarithmic=True,
        ),
        Chart(
            "ros2-drivers-cpu",
            "CPU of the driver per image",
            "milliseconds",
            labels,
            series(lambda run: run.cpu),
        ),
    ]


def goals(runs: dict[Key, Runs], gains: dict[str, Gains]) -> list[Goal]:
    """Judge our figures by those of camera_aravis2; no goals without it."""
    found = []
    for size, driver, count in runs:
        theirs = runs.get((size, PEER, count))
        if driver != OURS or theirs is None:
            continue
        ours = runs[size, OURS, count]
        who = f"{size}, {count} reader{'s' * (count > 1)}"
        counts = f"{ours.counts}, {PEER} {theirs.counts}"
        found.append(Goal(f"{who}: as many frames delivered", counts, ours.share >= theirs.share))
        mine, other = ours.age(0.5), theirs.age(0.5)
        latency = f"{_text(mine)} and {_text(other)} ms"
        soon = mine is not None and (other is None or mine <= other)
        found.append(Goal(f"{who}: latency no higher", latency, soon))
        found.append(
            Goal(
                f"{who}: no more CPU",
                f"{ours.cpu:.1f} and {theirs.cpu:.1f} ms per image",
                ours.cpu <= theirs.cpu,
            )
        )
    if OURS in gains and PEER in gains:
        asked = "Gain written to the register no later"
        mine, other = (statistics.median(gains[driver].written or [float("inf")]) for driver in (OURS, PEER))
        found.append(Goal(asked, f"{mine:.2f} and {other:.2f} ms", mine <= other))
    return found


def measure(arguments: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks ros2_drivers", description=__doc__)
    parser.add_argument("--seconds", type=float, default=5.0, help="how long each measurement takes")
    parser.add_argument("--rounds", type=int, default=3)
    names = [size.name for size in SIZES]
    parser.add_argument("--sizes", nargs="+", choices=names, default=names)
    options = parser.parse_args(arguments)
    if importlib.util.find_spec("rclpy") is None:
        raise SystemExit("rclpy cannot be imported (make setup-ros2)")
    before = machine()
    on_this_machine_only()
    drivers = [OURS, PEER, PEER_WITH_PROFILE] if peer() else [OURS]
    sizes = [size for size in SIZES if size.name in options.sizes]
    runs, gains = measured(drivers, sizes, options.seconds, options.rounds)
    method = METHOD.format(packet=PACKET_SIZE, rounds=options.rounds, seconds=options.seconds)
    return Section(
        "Compared with camera_aravis2",
        "python -m benchmarks ros2_drivers          # nine minutes; CAMERA_ARAVIS2=…/camera_driver_gv",
        method + ("" if peer() else WITHOUT),
        [stream_table(runs), gain_table(gains)],
        charts(runs),
        goals(runs, gains),
        READING,
        before,
        lacking="" if peer() else PEER,
    )


if __name__ == "__main__":
    print(_document.markdown(measure()))
