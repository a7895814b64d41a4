"""Receivers of GigE Vision on a wire that behaves like a network card's: this driver and its peers.

Two network namespaces and a veth pair, whose receiving end polls as a card with moderated interrupts does,
so that the kernel joins packets; the sending end sends each packet singly. Aravis's own fake camera sends,
except one stream, which is too fast for it: the simulated camera sends that. The receivers take turns, and
the median of their runs counts. Needs root, iproute2, ethtool and aravis-tools-cli; a second version of
Aravis takes part if --aravis-prefix or ARAVIS_PREFIX names the folder where it is installed.

    python -m benchmarks gige_wire [--seconds 3] [--runs 3] [--case NAME …] [--aravis-prefix DIR]
"""

from __future__ import annotations

import argparse
import os
import shutil
from contextlib import suppress
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from benchmarks._results import Chart, Goal, Section, Table, machine
from benchmarks._wire import FLUSH_NS, wire
from benchmarks._wire_cameras import ARAVIS_CAMERA, Case, camera
from benchmarks._wire_receivers import OURS, UNPRIVILEGED, Receiver, Run, receivers

USUAL = Case(2048, 1536, 33.4, 1400)
LARGE_PACKETS = Case(2048, 1536, 33.4, 8164)
SMALL = Case(1024, 1024, 80, 1400)
SLOW = Case(640, 480, 65, 1400)
TINY = Case(64, 48, 65, 1400)
FAST = Case(4096, 256, 40, 8164, fast=True)
CASES = {
    "usual": USUAL,
    "large-packets": LARGE_PACKETS,
    "small": SMALL,
    "slow": SLOW,
    "tiny": TINY,
    "fast": FAST,
}
LOSSLESS = tuple(case for case in CASES.values() if not case.fast)
METHOD = """Two network namespaces are joined by a pair of virtual interfaces. The receiving one polls in a
thread of the kernel and gathers packets for {flush:g} µs, as a network card with moderated interrupts does;
the sending one has no segmentation offload. Aravis's fake camera sends Mono8, each packet singly. The last
stream is faster than Gigabit Ethernet, 168 MB/s with each frame in one burst; the simulated camera sends it.
More is not measured: sender, kernel and receiver share two cores. Without a limit the camera reaches about
3 Gbit/s beside a receiver, not 10, and every receiver then loses a third of the frames or more.

The receivers take turns of {seconds:g} s each; the median of {runs} counts.
viva-genicam, pyGigEVision and the older Aravis without privilege take one turn.

Each is at its best: this driver as root, with real-time priority, and without any capability; Aravis as root
with its packet socket, which costs it least, and without any capability, with a socket buffer as large as an
image (`-a`) unless the default is larger. Real-time or high priority (`--realtime`, `--high-priority`) do not
lower Aravis's cost. viva-genicam {viva} has no such options. pyGigEVision takes images of at most two bytes
a pixel, so it has no part in the last stream."""
READING = [
    "*process*: CPU milliseconds of the receiving process for each complete frame, start-up apart. "
    "*network*: those of the kernel's thread that receives the packets. The sender's are not counted.",
    "*lost*: frames that the receiver counted as incomplete or missing.",
    "*× Aravis*: times the cheapest run of an Aravis, which has its packet socket.",
    "Compare figures within one table only.",
]
Found = dict[Case, dict[str, Run]]


def measure(arguments: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks gige_wire", description=__doc__)
    parser.add_argument("--seconds", type=float, default=3.0)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument(
        "--case", action="append", choices=CASES, help="only this one; the page stays as it is"
    )
    prefix = os.environ.get("ARAVIS_PREFIX")
    parser.add_argument("--aravis-prefix", type=Path, default=Path(prefix) if prefix else None)
    options = parser.parse_args(arguments)
    for program in (ARAVIS_CAMERA, "arv-camera-test-0.8", "ip", "ethtool", "setpriv", "stdbuf"):
        if shutil.which(program) is None:
            raise SystemExit(f"{program} is not installed")
    before = machine()
    peers = receivers(options.aravis_prefix)
    found: Found = {}
    with wire() as ends:
        for name in options.case or CASES:
            case = CASES[name]
            found[case] = observe(ends, case, peers, options.runs, options.seconds)
            print(case.name, {name: rounded(run, case) for name, run in found[case].items()}, flush=True)
    complete = len(found) == len(CASES)
    lacking = "" if options.aravis_prefix else "a second version of Aravis"
    return Section(
        "GigE Vision",
        "python -m benchmarks gige_wire --aravis-prefix DIR          # as root; nine minutes",
        METHOD.format(flush=FLUSH_NS / 1000, runs=options.runs, seconds=options.seconds, viva=viva_version()),
        [cost_table(found)],
        [cost_chart(found)],
        goals(found) if complete else [],
        READING,
        before,
        lacking if complete else "the other streams",
    )


def viva_version() -> str:
    with suppress(PackageNotFoundError):
        return version("viva-genicam")
    return ""


def observe(
    ends: tuple[str, str], case: Case, peers: list[Receiver], runs: int, seconds: float
) -> dict[str, Run]:
    """Let the receivers take turns at what a fresh camera sends."""
    chosen = [receiver for receiver in peers if receiver.takes(case)]
    done: dict[str, list[Run]] = {receiver.name: [] for receiver in chosen}
    for turn in range(runs):
        for receiver in chosen:
            if turn == 0 or receiver.compared:
                with camera(ends[0], case):
                    done[receiver.name].append(receiver.receive(ends[1], case, seconds))
    return {name: middle(turns) for name, turns in done.items()}


def middle(runs: list[Run]) -> Run:
    """Return the run with the median cost, with the sum of all losses."""
    chosen = sorted(runs, key=cost)[len(runs) // 2]
    return replace(chosen, lost=sum(run.lost for run in runs))


def cost(run: Run) -> float:
    """Return the CPU seconds of process and network for each frame."""
    return (run.process + run.network) / max(run.frames, 1)


def per_gb(run: Run, case: Case) -> float:
    return cost(run) / case.payload * 1e9


def rounded(run: Run, case: Case) -> list[float]:
    return [
        run.frames,
        run.lost,
        round(1e3 * run.process / max(run.frames, 1), 2),
        round(per_gb(run, case), 2),
    ]


def best_aravis(runs: dict[str, Run], *, privileged: bool = True) -> float:
    """Return the cost of the cheapest Aravis; without privilege, of those that have none."""
    names = [
        name for name in runs if name.startswith("Aravis") and (privileged or name.endswith("no privilege"))
    ]
    return min(cost(runs[name]) for name in names)


def cost_table(found: Found) -> Table:
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
                    f"{cost(run) / best_aravis(runs):.2f}",
                ]
            )
    return Table(header, rows)


def cost_chart(found: Found) -> Chart:
    names = dict.fromkeys(name for runs in found.values() for name in runs)
    series: dict[str, list[float | None]] = {
        name: [1e3 * cost(runs[name]) if name in runs else None for runs in found.values()]
        for name in names
        if not (name.startswith("Aravis") and name.endswith("no privilege"))
    }
    title = "CPU milliseconds per frame, process and network, less is better"
    return Chart("gige-wire", title, "ms", [case.name for case in found], series)


def goals(found: Found) -> list[Goal]:
    made = []
    for case, most in ((USUAL, 0.8), (SLOW, 1.0)):
        for name, peer, privileged in (
            (OURS, "Aravis at its best", True),
            (UNPRIVILEGED, "Aravis at its best", True),
            (UNPRIVILEGED, "Aravis without privilege", False),
        ):
            times = cost(found[case][name]) / best_aravis(found[case], privileged=privileged)
            made.append(
                Goal(f"{name}: at most {most:g} × {peer}: {case.name}", f"{times:.2f} ×", times <= most)
            )
    times = per_gb(found[SMALL][OURS], SMALL) / per_gb(found[USUAL][OURS], USUAL)
    made.append(
        Goal("small frames: at most 1.2 × the cost per GB of large ones", f"{times:.2f} ×", times <= 1.2)
    )
    own = 1e3 * found[TINY][OURS].process / max(found[TINY][OURS].frames, 1)
    made.append(Goal("a frame of four packets: at most 0.5 ms of the process", f"{own:.2f} ms", own <= 0.5))
    lost = sum(found[case][name].lost for case in LOSSLESS for name in (OURS, UNPRIVILEGED))
    made.append(Goal("no frame lost, up to 105 MB/s", f"{lost} lost", lost == 0))
    return made
