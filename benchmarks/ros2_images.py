"""The effect of our DDS profile on images between processes: with it, without it, and at the reader only.

    python -m benchmarks.ros2_images [--seconds 4] [--readers 1 4]

Fast DDS's default shared memory holds half a megabyte, less than one image; with our profile it holds 64.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks import _document
from benchmarks._network_ends import read_ros2, serve
from benchmarks._network_runs import Run, on_this_machine_only, process, rounds_text, watch
from benchmarks._results import Chart, Section, Table, machine

PLAIN = (
    '<dds xmlns="http://www.eprosima.com"><profiles><participant profile_name="plain">'
    "<rtps><name>plain</name></rtps></participant></profiles></dds>"
)
"A profile that changes nothing, as Fast DDS reports a missing one as an error."
PROFILES = "FASTDDS_DEFAULT_PROFILES_FILE"
WIDTH, HEIGHT, RATE = 1920, 1080, 30.0
CASES = {
    "none": (False, False),
    "camera's side": (True, False),
    "both sides": (True, True),
}
"Whether the server and the readers have the profile."
METHOD = """1080p BayerRG8 at 30 frames per second from `serve` to rclpy readers on the same machine, best
effort, each a process of its own, for {seconds:g} seconds{rounds}: with Fast DDS's defaults, with
`resources/ros2/fastdds.xml` on the camera's side only (our server sets it by itself), and on the readers'
side too (`FASTDDS_DEFAULT_PROFILES_FILE=…/fastdds.xml`)."""


def measure(arguments: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks ros2_images", description=__doc__)
    parser.add_argument("--seconds", type=float, default=4.0, help="how long each measurement takes")
    parser.add_argument("--rounds", type=int, default=1, help="of all rows, of which the best counts")
    parser.add_argument("--readers", nargs="+", type=int, default=[1, 4])
    options = parser.parse_args(arguments)
    if importlib.util.find_spec("rclpy") is None:
        raise SystemExit("rclpy cannot be imported (make setup-ros2)")
    before = machine()
    runs: dict[tuple[str, int], Run] = {}
    for name, (server_has, readers_have) in list(CASES.items()) * options.rounds:
        for count, run in delivered(server_has, readers_have, options.readers, options.seconds).items():
            runs[name, count] = max(runs.get((name, count), run), run, key=lambda one: one.quality)
            print(name, count, run.ros2 and (run.ros2.counts(), run.ros2.latency()), flush=True)
    rows = []
    for (name, count), run in runs.items():
        assert run.ros2
        rate = f"{run.rate * run.ros2.share / 100:.1f} fps"
        cells = [run.ros2.counts(), rate, run.ros2.latency(), f"{run.cores:.0%}", f"{run.ros2.cores:.0%}"]
        rows.append([name, str(count), *cells])
    header = ["profile on", "readers", "delivered", "rate", "latency, median / p99", "CPU", "CPU per reader"]
    chart = Chart(
        "ros2-profile",
        "1080p frames received by the worst ROS 2 reader, by use of the DDS profile",
        "percent of the frames",
        [f"{count} reader{'s' * (count > 1)}" for count in options.readers],
        {
            f"profile: {case}": [run.ros2.share for key, run in runs.items() if run.ros2 and key[0] == case]
            for case in CASES
        },
    )
    return Section(
        "The DDS profile",
        "python -m benchmarks ros2_images          # half a minute",
        METHOD.format(seconds=options.seconds, rounds=rounds_text(options.rounds)),
        [Table(header, rows)],
        [chart],
        machine=before,
    )


def delivered(server_has: bool, readers_have: bool, readers: list[int], seconds: float) -> dict[int, Run]:
    """Return the runs by number of readers. Processes read their profile when they start."""
    on_this_machine_only()
    with ExitStack() as stack:
        stack.callback(os.environ.pop, PROFILES, None)
        nothing = Path(stack.enter_context(TemporaryDirectory())) / "nothing.xml"
        nothing.write_text(PLAIN)

        def profile(wanted: bool) -> None:
            """Choose our profile, which is the default, or the empty one."""
            if wanted:
                os.environ.pop(PROFILES, None)
            else:
                os.environ[PROFILES] = str(nothing)

        profile(server_has)
        uri = f"sim:?width={WIDTH}&height={HEIGHT}&fps={RATE:g}&pixel_format=BayerRG8"
        server = process(stack, serve, uri, True)
        address = server.recv()
        profile(readers_have)
        ros2 = [process(stack, read_ros2, number, address) for number in range(max(readers))]
        for reader in ros2:
            reader.recv()
        watch(server, [], [], 1.0)
        return {count: watch(server, [], ros2[:count], seconds) for count in readers}


if __name__ == "__main__":
    print(_document.markdown(measure()))
