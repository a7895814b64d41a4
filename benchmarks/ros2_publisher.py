"""What our ROS 2 server costs beside the least that a driver can do: a C program that only publishes.

    python -m benchmarks ros2_publisher [--seconds 4] [--rounds 3]

Needs a C compiler, and the headers that come with rclpy.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import resource
import shutil
import statistics
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from multiprocessing.connection import Connection
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks import _document
from benchmarks._network_ends import ROS2_NAME, Served, read_ros2, serve
from benchmarks._network_runs import Run, Size, on_this_machine_only, process, watch
from benchmarks._results import Chart, Goal, Section, Table, machine

OURS, THEIRS = "ours", "C publisher"
SIZES = (Size("1080p", 1920, 1080, 30.0), Size("8.8 MP", 4096, 2160, 10.0))
READERS = (1, 4)
LIMIT = 1.2
"CPU time of ours, of that of the C publisher."
DELIVERED = 0.9
"Share of the images that must be delivered, or their cost decides nothing."
SOURCE = Path(__file__).with_name("rcl_publisher.c")
PROFILE = Path(__file__).parents[1] / "resources/ros2/fastdds.xml"
LIBRARIES = (
    "rcl",
    "rcutils",
    "rosidl_runtime_c",
    "sensor_msgs__rosidl_typesupport_c",
    "sensor_msgs__rosidl_generator_c",
)
START = """
import ctypes, sys
words = [word.encode() for word in sys.argv[1:]]
ctypes.CDLL(sys.argv[1]).main(len(words), (ctypes.c_char_p * len(words))(*words))
"""
"""Runs the C program in a process that has Python's symbols: rcl of rclpy's wheels does not load without."""
METHOD = """Mono8 images at 30 (1080p) and 10 (8.8 MP) frames per second from one process to rclpy readers
on the same machine, best effort, each a process of its own: from our server of a simulated camera, and
from a C program (`benchmarks/rcl_publisher.c`) that publishes what lies in its memory with rcl alone,
without camera, controls, `camera_info` and diagnostics. Both have `resources/ros2/fastdds.xml` and the
same quality of service (reliable, volatile, depth 5). They take turns, in {rounds} rounds of {seconds:g}
seconds each; the figures are medians."""
READING = [
    "**CPU per image**: of the publishing process, kernel included, without the simulation of the sensor. "
    "*For publishing*: what it takes more than without a reader, when ours only receives images from its "
    "camera; the C program has none.",
    "*With readers*: of all processes. Shared memory has no other costs.",
    "Rows of which less than nine tenths were delivered have no goal: a busy machine loses most images "
    "of 8.8 MP.",
    "**latency**: from the stamp to the whole image in the reader's hands. Ours is stamped at the start of "
    "the exposure and includes the simulation of the image; the C program's directly before publishing.",
]

Key = tuple[str, int, str]
"Image size, number of readers, publisher."


def measure(arguments: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks ros2_publisher", description=__doc__)
    parser.add_argument("--seconds", type=float, default=4.0, help="how long each measurement takes")
    parser.add_argument("--rounds", type=int, default=3)
    names = [size.name for size in SIZES]
    parser.add_argument("--sizes", nargs="+", choices=names, default=names)
    parser.add_argument("--readers", nargs="+", type=int, default=list(READERS))
    options = parser.parse_args(arguments)
    if importlib.util.find_spec("rclpy") is None:
        raise SystemExit("rclpy cannot be imported (make setup-ros2)")
    before = machine()
    on_this_machine_only()
    sizes = [size for size in SIZES if size.name in options.sizes]
    with TemporaryDirectory() as folder:
        program = compiled(Path(folder))
        runs: dict[Key, list[Run]] = {}
        with ExitStack() as stack:
            readers = [process(stack, read_ros2, number, "") for number in range(max(options.readers))]
            for reader in readers:
                reader.recv()
            for size in sizes:
                for _ in range(options.rounds):
                    for key, run in measured(program, size, readers, options.readers, options.seconds):
                        runs.setdefault(key, []).append(run)
    return Section(
        "Compared with a C publisher",
        "python -m benchmarks ros2_publisher          # three minutes; needs a C compiler",
        METHOD.format(rounds=options.rounds, seconds=options.seconds),
        [table(runs)],
        [chart(runs)],
        goals(runs),
        READING,
        before,
    )


def compiled(folder: Path) -> Path:
    """Compile the C program against the headers and libraries of rclpy's wheels; return its path."""
    compiler = shutil.which("cc")
    if compiler is None:
        raise SystemExit("no C compiler (`cc`) is installed")
    program, prefix = folder / "rcl_publisher.so", Path(sys.prefix)
    includes = [f"-I{each}" for each in (prefix / "include").iterdir()]
    libraries = [f"-L{prefix}/lib", f"-Wl,-rpath,{prefix}/lib"]
    libraries += [f"-l{name}" for name in LIBRARIES]
    done = subprocess.run(
        [compiler, "-O2", "-shared", "-fPIC", *includes, str(SOURCE), "-o", str(program), *libraries],
        capture_output=True,
        text=True,
    )
    if done.returncode:
        raise SystemExit(f"{SOURCE.name} cannot be compiled: {done.stderr[-600:]}")
    return program


def measured(
    program: Path, size: Size, readers: list[Connection], counts: list[int], seconds: float
) -> Iterator[tuple[Key, Run]]:
    """Measure both publishers in turn, each in a new process, with so many of the readers."""
    for publisher in (OURS, THEIRS):
        with ExitStack() as stack:
            if publisher == OURS:
                uri = f"sim:?width={size.width}&height={size.height}&fps={size.rate:g}&pixel_format=Mono8"
                server = process(stack, serve, uri, True, False)
            else:
                server = process(stack, publish, program, size)
            server.recv()
            watch(server, [], readers[:1], 1.0)
            for count in (0, *counts) if publisher == OURS else counts:
                run = watch(server, [], readers[:count], seconds)
                print(size.name, count, publisher, f"{run.milliseconds_per_frame:.2f} ms", flush=True)
                yield (size.name, count, publisher), run


def publish(pipe: Connection, program: Path, size: Size) -> None:
    """Run the C program; obey as `_network_ends.serve` does."""
    words = [f"{ROS2_NAME}/image_raw", str(size.width), str(size.height), f"{size.rate:g}"]
    environment = {**os.environ, "FASTDDS_DEFAULT_PROFILES_FILE": str(PROFILE)}
    with subprocess.Popen(
        [sys.executable, "-c", START, program, *words],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=environment,
    ) as child:
        assert child.stdin is not None and child.stdout is not None
        pipe.send("")
        while (order := pipe.recv()) is not None:
            child.stdin.write(f"{order}\n")
            child.stdin.flush()
            answer = child.stdout.readline()
            if not answer:
                raise RuntimeError(f"{program.name} has ended with exit code {child.wait()}")
            if order == "begin":
                pipe.send(None)
            else:
                cpu_ns, pages, *stamps = map(int, answer.split())
                pipe.send(Served(stamps, 0, cpu_ns / 1e9, 0.0, pages * resource.getpagesize()))


def cost(runs: list[Run]) -> float:
    """Return the CPU time per image of the publishing process, milliseconds."""
    return statistics.median(run.milliseconds_per_frame for run in runs)


def publishing_cost(runs: dict[Key, list[Run]], key: Key) -> float:
    """Return the CPU time per image that the publishing process takes for its readers, milliseconds."""
    size, _, publisher = key
    return cost(runs[key]) - (cost(runs[size, 0, OURS]) if publisher == OURS else 0.0)


def whole_cost(runs: list[Run], readers: int) -> float:
    """Return the CPU time per image of all processes, milliseconds."""
    return statistics.median(
        1e3 * (run.cores - run.sensor_cores + readers * (run.ros2.cores if run.ros2 else 0.0)) / run.rate
        for run in runs
        if run.rate
    )


def table(runs: dict[Key, list[Run]]) -> Table:
    rows = []
    for key, rounds in runs.items():
        size, count, publisher = key
        base = size, count, THEIRS
        row = [size, str(count), publisher]
        if count:
            judged = [run.ros2 for run in rounds if run.ros2]
            row.append(f"{sum(one.worst for one in judged)} of {sum(one.judged for one in judged)}")
            row.append(max(judged, key=lambda one: (one.share, -(one.median or 0))).latency())
        else:
            row += ["", ""]
        row.append(f"{cost(rounds):.2f} ms")
        if count:
            row.append(f"{cost(rounds) / cost(runs[base]):.2f}")
            published, whole = publishing_cost(runs, key), whole_cost(rounds, count)
            row += [f"{published:.2f} ms", f"{published / publishing_cost(runs, base):.2f}"]
            row += [f"{whole:.2f} ms", f"{whole / whole_cost(runs[base], count):.2f}"]
        else:
            row += [""] * 5
        rows.append(row)
    header = ["image", "readers", "publisher", "delivered", "latency, median / p99"]
    for what in ("CPU per image", "for publishing", "with readers"):
        header += [what, f"× {THEIRS}"]
    return Table(header, rows)


def compared(runs: dict[Key, list[Run]]) -> list[tuple[str, int]]:
    """Return the sizes and numbers of readers that were measured."""
    return [(size, count) for size, count, publisher in runs if publisher == OURS and count]


def chart(runs: dict[Key, list[Run]]) -> Chart:
    return Chart(
        "ros2-publisher-cpu",
        "CPU of the publishing process per image",
        "milliseconds",
        [f"{size}, {count} reader{'s' * (count > 1)}" for size, count in compared(runs)],
        {name: [cost(runs[size, count, name]) for size, count in compared(runs)] for name in (OURS, THEIRS)},
    )


def delivered(runs: list[Run]) -> float:
    """Return the share of the images that came to the reader that got the fewest."""
    judged = [run.ros2 for run in runs if run.ros2]
    return sum(one.worst for one in judged) / max(1, sum(one.judged for one in judged))


def goals(runs: dict[Key, list[Run]]) -> list[Goal]:
    found = []
    for size, count in compared(runs):
        if min(delivered(runs[size, count, name]) for name in (OURS, THEIRS)) < DELIVERED:
            continue
        who = f"{size}, {count} reader{'s' * (count > 1)}: at most {LIMIT} × the C publisher's CPU"
        costs = {
            "": [cost(runs[size, count, name]) for name in (OURS, THEIRS)],
            " with the readers": [whole_cost(runs[size, count, name], count) for name in (OURS, THEIRS)],
        }
        for what, (ours, theirs) in costs.items():
            met = ours <= LIMIT * theirs
            found.append(Goal(f"{who}{what}", f"{ours:.2f} and {theirs:.2f} ms per image", met))
    return found


if __name__ == "__main__":
    print(_document.markdown(measure()))
