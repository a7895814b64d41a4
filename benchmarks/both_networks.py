"""One camera on YARP and ROS 2 at once, and on each alone: delivery, latency, CPU and memory.

    python -m benchmarks.both_networks [--seconds 4] [--pixel-format BayerRG8] [--sizes 1080p]

The server is one process; every reader is another. Latency counts from the exposure's stamp until the
reader has the whole image. An image counts as delivered when the reader has received its stamp.
"""

from __future__ import annotations

import argparse
import importlib.util
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass

from benchmarks import _document
from benchmarks._network_ends import read_ros2, read_yarp, serve
from benchmarks._network_runs import Delivery, Run, Size, on_this_machine_only, process, rounds_text, watch
from benchmarks._results import Chart, Goal, Section, Table, machine

READERS = (1, 4)
NETWORKS = ("YARP", "ROS 2", "both")
METHOD = """One simulated camera ({pixel_format}, 10 ms exposure) and one serving process; each reader is a
process of its own that reads for {seconds:g} seconds{rounds}. YARP readers receive RGB over `fast_tcp`, ROS
2 readers `image_raw` over Fast DDS with our transport profile, best effort."""
READING = [
    "**delivered**: how many of the frames exposed in that time the *worst* reader received.",
    "**latency**: from the time stamp of the exposure to the whole image in the reader's hands, over all "
    "readers; the exposure accounts for 10 ms of it.",
    "**CPU**: of the serving process, in percent of one core; *sensor* is the part that simulating the "
    "camera takes. *Per frame* excludes the sensor; *per reader* is one reader's process, on YARP and on "
    "ROS 2. **Memory** is the resident size of the serving process.",
    "The readers share the machine with the server: four of each are nine processes, and a reader that "
    "gets no core in time loses images. Four readers of 8.8 MP on both networks require more than 3 GB/s "
    "to be copied out and in.",
    "Of the server's time for 8.8 MP on YARP, 3.3 ms are OpenCV's demosaicing (once, for any number of "
    "readers) and 3 ms per reader the kernel's copying of 26 MB of RGB.",
]
HEADER = [
    "image", "networks", "readers on each", "delivered YARP", "delivered ROS 2",
    "latency YARP, median / p99", "latency ROS 2, median / p99", "camera rate", "camera loss",
    "CPU", "CPU, sensor", "CPU per frame", "CPU per reader", "memory",
]  # fmt: skip


SIZES = (
    Size("640×480", 640, 480, 30.0),
    Size("1080p", 1920, 1080, 30.0),
    Size("8.8 MP", 4096, 2160, 21.0),
)


@dataclass(frozen=True)
class Row:
    """One measurement and its conditions."""

    size: Size
    networks: str
    readers: int
    run: Run

    def cells(self) -> list[str]:
        run = self.run
        return [
            self.size.name,
            self.networks,
            str(self.readers or ""),
            run.yarp.counts() if run.yarp else "",
            run.ros2.counts() if run.ros2 else "",
            run.yarp.latency() if run.yarp else "",
            run.ros2.latency() if run.ros2 else "",
            f"{run.rate:.1f} fps",
            f"{run.served.lost}",
            f"{run.cores:.0%}",
            f"{run.sensor_cores:.0%}",
            f"{run.milliseconds_per_frame:.1f} ms",
            " / ".join(f"{of.cores:.0%}" for of in (run.yarp, run.ros2) if of),
            f"{run.served.memory / 1e6:.0f} MB",
        ]


def measure(arguments: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks both_networks", description=__doc__)
    parser.add_argument("--seconds", type=float, default=4.0, help="how long each measurement takes")
    parser.add_argument("--rounds", type=int, default=1, help="of all rows, of which the best counts")
    parser.add_argument("--pixel-format", default="BayerRG8")
    names = [size.name for size in SIZES]
    parser.add_argument("--sizes", nargs="+", choices=names, default=names)
    options = parser.parse_args(arguments)
    on_this_machine_only()
    before = machine()
    missing = [name for name in ("rclpy", "grabber_interfaces") if importlib.util.find_spec(name) is None]
    if missing:
        print(f"Without ROS 2, since {' and '.join(missing)} cannot be imported (make setup-ros2).")
    sizes = [size for size in SIZES if size.name in options.sizes]
    uri = f"sim:?pixel_format={options.pixel_format}"
    rows = measured(uri, sizes, options.seconds, options.rounds, not missing)
    return Section(
        "Both networks at once",
        "python -m benchmarks both_networks          # about two minutes; without ROS 2 it measures YARP",
        METHOD.format(
            pixel_format=options.pixel_format,
            seconds=options.seconds,
            rounds=rounds_text(options.rounds),
        ),
        [Table(HEADER, [row.cells() for row in rows])],
        charts(rows),
        goals(rows),
        READING,
        before,
        lacking="ROS 2" if missing else "",
    )


def measured(uri: str, sizes: list[Size], seconds: float, rounds: int, with_ros2: bool) -> list[Row]:
    rows: dict[tuple[str, str, int], Row] = {}

    def keep(size: Size, networks: str, readers: int, run: Run) -> None:
        row, key = Row(size, networks, readers, run), (size.name, networks, readers)
        rows[key] = max(rows.get(key, row), row, key=lambda one: one.run.quality)
        print(" ".join(row.cells()), flush=True)

    with ExitStack() as stack:
        server = process(stack, serve, uri, with_ros2)
        address = server.recv()
        yarp = [process(stack, read_yarp, number, address) for number in range(max(READERS))]
        numbers = range(max(READERS) if with_ros2 else 0)
        ros2 = [process(stack, read_ros2, number, address) for number in numbers]
        for reader in (*yarp, *ros2):
            reader.recv()
        for size in sizes * rounds:
            server.send(("size", size.width, size.height, size.rate))
            assert server.recv() == (size.width, size.height)
            watch(server, [], [], 1.0)  # the first frames of a size do not count
            keep(size, "none", 0, watch(server, [], [], seconds))
            for count in READERS:
                joining = {"YARP": (yarp[:count], []), "ROS 2": ([], ros2[:count])}
                joining["both"] = (yarp[:count], ros2[:count])
                for networks in NETWORKS if with_ros2 else ("YARP",):
                    keep(size, networks, count, watch(server, *joining[networks], seconds))
    return list(rows.values())


def charts(rows: list[Row]) -> list[Chart]:
    served = [row for row in rows if row.readers]
    groups = list(dict.fromkeys((row.size.name, row.readers) for row in served))
    labels = [f"{size}, {count} reader{'s' * (count > 1)}" for size, count in groups]
    by_key = {(row.networks, row.size.name, row.readers): row.run for row in served}

    def series(networks: str, value: str) -> list[float | None]:
        """Return one value per group."""
        runs = [by_key.get((networks, *group)) for group in groups]
        return [None if run is None else _VALUES[value](run) for run in runs]

    chosen = [networks for networks in NETWORKS if any(row.networks == networks for row in served)]
    ways = {"YARP alone": ("YARP", "yarp"), "ROS 2 alone": ("ROS 2", "ros2")}
    if "both" in chosen:
        ways |= {"YARP, both": ("both", "yarp"), "ROS 2, both": ("both", "ros2")}
    else:
        del ways["ROS 2 alone"]
    return [
        Chart(
            "networks-cpu",
            "CPU of the serving process, the simulated sensor included",
            "percent of one core",
            labels,
            {networks: series(networks, "cpu") for networks in chosen},
            100.0,
            "one core",
        ),
        Chart(
            "networks-latency",
            "Latency from the exposure to the reader, median",
            "milliseconds",
            labels,
            {way: series(networks, f"{kind} median") for way, (networks, kind) in ways.items()},
            logarithmic=True,
        ),
        Chart(
            "networks-delivered",
            "Frames received by the worst reader",
            "percent",
            labels,
            {way: series(networks, f"{kind} share") for way, (networks, kind) in ways.items()},
        ),
    ]


def _of(delivery: Delivery | None, name: str) -> float | None:
    return None if delivery is None else getattr(delivery, name)


_VALUES: dict[str, Callable[[Run], float | None]] = {
    "cpu": lambda run: 100 * run.cores,
    "yarp median": lambda run: _of(run.yarp, "median"),
    "ros2 median": lambda run: _of(run.ros2, "median"),
    "yarp share": lambda run: _of(run.yarp, "share"),
    "ros2 share": lambda run: _of(run.ros2, "share"),
}


def goals(rows: list[Row]) -> list[Goal]:
    """Judge the rows by the goals that apply to them."""
    found = []
    for row in rows:
        run = row.run
        if (row.size.name, row.networks) != ("1080p", "both") or run.yarp is None or run.ros2 is None:
            continue
        who = f"1080p at 30 fps on both at once, {row.readers} reader{'s' * (row.readers > 1)} on each"
        deliveries = f"YARP {run.yarp.counts()}, ROS 2 {run.ros2.counts()}"
        every = run.yarp.worst == run.ros2.worst == run.yarp.judged > 0
        found.append(Goal(f"{who}: every frame delivered", deliveries, every))
        found.append(Goal(f"{who}: less than one core", f"{run.cores:.0%}", run.cores < 1))
    lost = {name: sum(row.run.served.lost for row in rows if row.networks == name) for name in NETWORKS}
    if any(row.networks == "both" for row in rows):
        text = f"{lost['YARP']} frames on YARP alone, {lost['both']} on both"
        asked = "adding ROS 2 to YARP costs the camera no frames"
        found.append(Goal(asked, text, lost["both"] <= lost["YARP"]))
    return found


if __name__ == "__main__":
    print(_document.markdown(measure()))
