"""Receivers of GigE Vision on a wire that behaves like a network card: this driver and Aravis at its best.

Two network namespaces and a veth pair, whose receiving end polls as a card with moderated interrupts does, so
that the kernel joins packets; the sending end sends each packet singly. Aravis's own fake camera sends. The
receivers take turns, and the median of their runs counts. Needs root, iproute2, ethtool and aravis-tools-cli.

    python -m benchmarks gige_wire [--seconds 6] [--runs 3]
"""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import shutil
import statistics
import subprocess
import sys
import time
from contextlib import closing, suppress
from dataclasses import asdict, dataclass

from benchmarks._results import Chart, Goal, Section, Table, machine
from benchmarks._wire import CAMERA, FLUSH_NS, inside, network_seconds, wire
from grabbergui.core.errors import FeatureError, FrameTimeoutError

ARAVIS, ARAVIS_CAMERA = "arv-camera-test-0.8", "arv-fake-gv-camera-0.8"
OURS, UNPRIVILEGED, THEIRS, PLAIN = "ours", "ours, no privilege", "Aravis", "Aravis, no packet socket"
WITHOUT_PRIVILEGE = ("setpriv", "--bounding-set=-all", "--inh-caps=-all")


@dataclass(frozen=True)
class Case:
    """A stream that the camera sends."""

    width: int
    height: int
    rate: float
    "Frames per second that are asked for; the fake camera may not reach it."
    packet_size: int

    @property
    def name(self) -> str:
        size = f"{self.width}×{self.height}"
        return f"{size} at {self.rate:g} Hz, {self.packet_size} bytes"

    @property
    def payload(self) -> int:
        return self.width * self.height


USUAL = Case(2048, 1536, 33.4, 1400)
SMALL = Case(1024, 1024, 80, 1400)
SLOW = Case(640, 480, 65, 1400)
TINY = Case(64, 48, 65, 1400)
LARGE_PACKETS = Case(2048, 1536, 33.4, 8164)
CASES = (USUAL, LARGE_PACKETS, SMALL, SLOW, TINY)
METHOD = """Two network namespaces are joined by a pair of virtual interfaces. The receiving one polls in a
thread of the kernel and gathers packets for {flush:g} µs, as a network card with moderated interrupts does;
the sending one has no segmentation offload. Aravis's fake camera sends Mono8, each packet singly. The
receivers take turns, {runs} runs of {seconds:g} s each, and the median counts: this driver as root and
without any capability, Aravis 0.8 as it comes (as root, with its packet socket, which is its best), and with
`--no-packet-socket -a`."""
READING = [
    "*process*: CPU milliseconds of the receiving process for each complete frame, start-up apart. "
    "*network*: those of the kernel's thread that receives the packets.",
    "*lost*: frames that the receiver counted as incomplete or missing.",
    "Compare figures within one table only.",
]


@dataclass(frozen=True)
class Run:
    """The result of one receiver."""

    frames: int
    lost: int
    process: float
    "CPU seconds of the receiving process."
    network: float = 0.0
    "CPU seconds of the kernel's thread."


def measure(arguments: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks gige_wire", description=__doc__)
    parser.add_argument("--seconds", type=float, default=6.0)
    parser.add_argument("--runs", type=int, default=3)
    options = parser.parse_args(arguments)
    for program in (ARAVIS, ARAVIS_CAMERA, "ip", "ethtool"):
        if shutil.which(program) is None:
            raise SystemExit(f"{program} is not installed")
    before = machine()
    found: dict[Case, dict[str, Run]] = {}
    with wire() as (camera, host):
        for case in CASES:
            runs: dict[str, list[Run]] = {name: [] for name in (OURS, UNPRIVILEGED, THEIRS, PLAIN)}
            for _ in range(options.runs):
                for name, done in runs.items():
                    done.append(observe(camera, host, case, name, options.seconds))
            found[case] = {name: middle(done) for name, done in runs.items()}
            print(case.name, {name: rounded(run, case) for name, run in found[case].items()}, flush=True)
    return Section(
        "GigE Vision",
        "python -m benchmarks gige_wire          # as root; five minutes",
        METHOD.format(flush=FLUSH_NS / 1000, runs=options.runs, seconds=options.seconds),
        [cost_table(found)],
        [cost_chart(found)],
        goals(found),
        READING,
        before,
    )


def observe(camera: str, host: str, case: Case, receiver: str, seconds: float) -> Run:
    """Let a receiver take what a fresh camera sends."""
    command = [*inside(camera), ARAVIS_CAMERA, "-i", CAMERA, "-s", f"WIRE{os.getpid()}"]
    sender = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        time.sleep(0.5)  # it prints nothing when it is ready
        before = network_seconds()
        enter = inside(host)
        if receiver in (OURS, UNPRIVILEGED):
            privilege = WITHOUT_PRIVILEGE if receiver == UNPRIVILEGED else ()
            child = [sys.executable, "-m", "benchmarks.gige_wire", json.dumps(asdict(case)), str(seconds)]
            done = subprocess.run([*enter, *privilege, *child], capture_output=True, text=True, check=True)
            values = json.loads(done.stdout.splitlines()[-1])
        else:
            values = receive_with_aravis(enter, case, seconds, packet_socket=receiver == THEIRS)
        return Run(**values, network=network_seconds() - before)
    finally:
        sender.terminate()
        sender.wait()


def receive_with_aravis(
    enter: list[str], case: Case, seconds: float, *, packet_socket: bool
) -> dict[str, float]:
    """Receive with Aravis's own test program."""
    size = ["-w", str(case.width), "-h", str(case.height), "-f", str(case.rate)]
    packets = ["--gv-packet-size", str(case.packet_size), "--packet-size-adjustment=never"]
    plain = [] if packet_socket else ["--no-packet-socket", "-a"]
    command = [*enter, ARAVIS, *size, *packets, *plain, "--duration", str(round(seconds))]
    before = children_seconds()
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    counts = {name: int(count) for name, count in re.findall(r"n_(\w+)\s*=\s*(\d+)", printed)}
    lost = counts.get("failures", 0) + counts.get("aborted", 0)
    return {
        "frames": counts["completed_buffers"],
        "lost": lost,
        "process": children_seconds() - before,
    }


def children_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def receive(case: Case, seconds: float) -> dict[str, float]:
    """Receive with this driver; count from the first frame on."""
    from grabbergui import sources

    with closing(sources.create(f"gige:{CAMERA}?packet_size={case.packet_size}")) as camera:
        camera.open()
        for name, value in (("Width", case.width), ("Height", case.height)):
            camera.write_feature(name, value)
        for name in ("AcquisitionFrameRate", "AcquisitionFrameRateAbs"):
            with suppress(FeatureError):
                camera.write_feature(name, case.rate)
        queue = camera.open_queue(4)
        camera.start()
        queue.get(10.0)
        before, cpu, end = camera.statistics(), time.process_time(), time.monotonic() + seconds
        while time.monotonic() < end:
            with suppress(FrameTimeoutError):
                queue.get(0.5)
        cpu, after = time.process_time() - cpu, camera.statistics()
    lost = after.incomplete - before.incomplete + after.lost - before.lost
    return {"frames": after.frames - before.frames, "lost": lost, "process": cpu}


def middle(runs: list[Run]) -> Run:
    """Return the run with the median cost, with the sum of all losses."""
    ordered = sorted(runs, key=cost)
    chosen = ordered[len(ordered) // 2]
    return Run(chosen.frames, sum(run.lost for run in runs), chosen.process, chosen.network)


def cost(run: Run) -> float:
    """Return the CPU seconds of process and network for each frame."""
    return (run.process + run.network) / max(run.frames, 1)


def rounded(run: Run, case: Case) -> list[float]:
    return [
        run.frames,
        run.lost,
        round(1e3 * run.process / max(run.frames, 1), 2),
        round(per_gb(run, case), 2),
    ]


def per_gb(run: Run, case: Case) -> float:
    return cost(run) / case.payload * 1e9


def cost_table(found: dict[Case, dict[str, Run]]) -> Table:
    header = ["stream", "receiver", "frames", "lost", "process", "network", "both, CPU s/GB", "× Aravis"]
    rows = []
    for case, runs in found.items():
        for name, run in runs.items():
            each = max(run.frames, 1)
            rows.append(
                [
                    case.name,
                    name,
                    str(run.frames),
                    str(run.lost),
                    f"{1e3 * run.process / each:.2f} ms",
                    f"{1e3 * run.network / each:.2f} ms",
                    f"{per_gb(run, case):.2f}",
                    f"{cost(run) / cost(runs[THEIRS]):.2f}",
                ]
            )
    return Table(header, rows)


def cost_chart(found: dict[Case, dict[str, Run]]) -> Chart:
    names = (OURS, UNPRIVILEGED, THEIRS)
    series: dict[str, list[float | None]] = {
        name: [1e3 * cost(runs[name]) for runs in found.values()] for name in names
    }
    title = "CPU milliseconds per frame, process and network, less is better"
    return Chart("gige-wire", title, "ms", [case.name for case in found], series)


def goals(found: dict[Case, dict[str, Run]]) -> list[Goal]:
    made = []
    for case, most in ((USUAL, 0.8), (SLOW, 1.0)):
        for name in (OURS, UNPRIVILEGED):
            times = cost(found[case][name]) / cost(found[case][THEIRS])
            asked = f"{name}: at most {most:g} × Aravis at its best: {case.name}"
            made.append(Goal(asked, f"{times:.2f} ×", times <= most))
    times = statistics.mean(
        per_gb(found[SMALL][name], SMALL) / per_gb(found[USUAL][name], USUAL) for name in (OURS,)
    )
    made.append(
        Goal("small frames: at most 1.2 × the cost per GB of large ones", f"{times:.2f} ×", times <= 1.2)
    )
    own = 1e3 * found[TINY][OURS].process / max(found[TINY][OURS].frames, 1)
    made.append(Goal("a frame of four packets: at most 0.5 ms of the process", f"{own:.2f} ms", own <= 0.5))
    lost = sum(runs[name].lost for runs in found.values() for name in (OURS, UNPRIVILEGED))
    made.append(Goal("no frame lost", f"{lost} lost", lost == 0))
    return made


if __name__ == "__main__":
    print(json.dumps(receive(Case(**json.loads(sys.argv[1])), float(sys.argv[2]))))
