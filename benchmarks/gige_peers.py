"""Receivers of GigE Vision side by side: this driver, Aravis and viva-genicam, on the same camera.

The simulated camera sends from a process of its own on the loopback; the receivers take turns, several short
runs each, of which the median counts. Compare figures within one table only.

    python -m benchmarks gige_peers [--seconds 4] [--runs 3] [--long 60]
"""

from __future__ import annotations

import argparse
import statistics
from collections.abc import Callable
from dataclasses import dataclass

from benchmarks import _document
from benchmarks._gige_camera import (
    GIGABIT,
    HEIGHT,
    PAYLOAD,
    PIXEL_FORMAT,
    WIDTH,
    Conditions,
    camera_process,
)
from benchmarks._gige_receivers import (
    Receiver,
    ReceiverError,
    Run,
    in_child,
    receivers,
    timed_receivers,
)
from benchmarks._results import Chart, Goal, Section, Table, machine

PACKET_SIZES = (1400, 8164)
LOSSES = (0.001, 0.01, 0.05)
REFERENCE = "Aravis"
METHOD = """The simulated camera sends {width}×{height} {format} over the loopback from a process of its own.
The receivers take turns, so that other load on the machine affects them all: this driver, Aravis 0.8
(`arv-camera-test-0.8 --no-packet-socket -a`, which sizes its socket buffer to the image) and viva-genicam,
{runs} runs of {seconds:g} seconds each. Figures are medians; CPU is that of the receiving process, kernel
included.

The camera lets the kernel cut packets out of large sends (UDP segmentation), and this driver lets the kernel
join consecutive packets (UDP_GRO): on the loopback they are never taken apart in between. A network card's
packets are joined if its driver supports that; if not, the rows *sent singly* apply."""
READING = [
    "*incomplete*: frames that began, or that are missing from the sequence of ids, and were not "
    "completed. At full speed the camera does not wait for a receiver.",
    "Resent packets are lost at the same rate as others.",
    "*latency*: from the moment the last payload packet leaves the camera to the frame in the consumer's "
    "hands; Aravis's through its Python binding. It is negative where the frame was there before the "
    "camera's program, which notes the moment, ran on. *memory*: the largest resident size; ours includes "
    "Python and NumPy.",
]


@dataclass(frozen=True)
class Case:
    """The conditions of one comparison."""

    packet_size: int
    conditions: Conditions

    @property
    def name(self) -> str:
        rate = "125 MB/s" if self.conditions.bandwidth else "full speed"
        if self.conditions.bandwidth > GIGABIT:
            rate = f"{self.conditions.bandwidth / 1e9:g} GB/s"
        return f"{self.packet_size} bytes, {rate}" + ("" if self.conditions.segmentation else ", sent singly")


SINGLY = Case(1400, Conditions(segmentation=False))
CASES = [
    *(Case(size, Conditions(bandwidth)) for bandwidth in (GIGABIT, 0.0) for size in PACKET_SIZES),
    SINGLY,
]
FAST = Case(8164, Conditions(3.1e9))
"A stream at the rate of 25 Gigabit Ethernet."
FAST_SECONDS, FAST_SHARE = 10.0, 0.95
"Duration in seconds, and the part of the rate that must arrive as frames; packets have headers."
MOST_COST, MOST_COST_FAST = 0.7, 0.15
"Goals in CPU seconds per GB: for packets sent singly, and for large ones at 3.1 GB/s."
Results = dict[str, list[Run]]
"The runs of each receiver, by its name."


def compare(case: Case, seconds: float, runs: int, found: dict[str, Receiver]) -> Results:
    """Run every receiver in turn, round after round."""
    results: Results = {}
    for _ in range(runs):
        for name, receive in found.items():
            try:
                run, _ = observe(case, seconds, receive)
            except ReceiverError as error:
                if name == "ours":
                    raise
                print(f"{case.name}: {error}", flush=True)
            else:
                results.setdefault(name, []).append(run)
    return results


def observe(case: Case, seconds: float, receive: Receiver) -> tuple[Run, list[float]]:
    """Return one run, and the seconds from each frame's last sent packet to its arrival."""
    with camera_process(case.conditions) as sent:
        run = receive(case.packet_size, seconds)
    delays = [at - sent[int(block)] for block, at in run.arrivals.items() if int(block) in sent]
    return run, delays


def median(runs: list[Run], figure: Callable[[Run], float]) -> float:
    return statistics.median(figure(run) for run in runs)


def rate(run: Run) -> float:
    return run.frames_per_second


def cost(run: Run) -> float:
    return run.cpu_per_gb


def ratio(results: Results, figure: Callable[[Run], float], name: str = "ours") -> float | None:
    """Return a figure of one receiver as a multiple of Aravis's; None without Aravis."""
    if REFERENCE not in results or name not in results:
        return None
    reference = median(results[REFERENCE], figure)
    return median(results[name], figure) / reference if reference else None


def share(runs: list[Run]) -> float:
    """Return the percentage of complete frames."""
    complete, incomplete = sum(run.complete for run in runs), sum(run.incomplete for run in runs)
    return 100 * complete / max(complete + incomplete, 1)


# -- tables ------------------------------------------------------------------------------------------
def rates_table(found: dict[Case, Results]) -> Table:
    header = [
        "case",
        "receiver",
        "frames/s",
        "range of the runs",
        "× Aravis",
        "incomplete",
        "CPU s/GB",
        "× Aravis",
    ]
    rows = []
    for case, results in found.items():
        for name, runs in results.items():
            speeds = [run.frames_per_second for run in runs]
            rows.append(
                [
                    case.name,
                    name,
                    f"{median(runs, rate):.1f}",
                    f"{min(speeds):.1f} … {max(speeds):.1f}",
                    _times(ratio(results, rate, name)),
                    str(sum(run.incomplete for run in runs)),
                    f"{median(runs, cost):.2f}",
                    _times(ratio(results, cost, name)),
                ]
            )
    return Table(header, rows, "Rate and cost:")


def loss_table(found: dict[float, Results]) -> Table:
    rows = []
    for loss, results in found.items():
        for name, runs in results.items():
            counts = [f"{median(runs, rate):.1f}", str(sum(run.incomplete for run in runs))]
            cells = [f"{share(runs):.2f} %", f"{median(runs, cost):.2f}"]
            rows.append([f"{100 * loss:g} %", name, *counts, *cells])
    header = ["loss", "receiver", "frames/s", "incomplete, all runs", "complete", "CPU s/GB"]
    return Table(header, rows, "With simulated packet loss, 1400 bytes at 125 MB/s:")


def latency_table(seconds: float, runs: int) -> tuple[Table, list[Goal]]:
    """Run the receivers in turn, round after round; the figures cover the frames of all rounds."""
    rows, goals = [], []
    for size in PACKET_SIZES:
        delays: dict[str, list[float]] = {}
        memory: dict[str, str] = {}
        refused: dict[str, ReceiverError] = {}
        for _ in range(runs):
            for name, receive in timed_receivers().items():
                try:
                    run, late = observe(Case(size, Conditions()), seconds, receive)
                except ReceiverError as error:
                    refused[name] = error
                else:
                    delays.setdefault(name, []).extend(late)
                    memory[name] = _megabytes(run)
        figures: dict[str, tuple[float, float]] = {}
        for name, found in delays.items():
            if len(found) > 1:
                figures[name] = 1e3 * statistics.median(found), 1e3 * statistics.quantiles(found, n=100)[98]
                middle, late_one = figures[name]
                rows.append([str(size), name, f"{middle:.2f} ms", f"{late_one:.2f} ms", memory[name]])
        rows += [
            [str(size), name, f"not measured: {error}", "–", "–"]
            for name, error in refused.items()
            if name not in figures
        ]
        if {"ours", REFERENCE} <= figures.keys():
            ours, theirs = figures["ours"], figures[REFERENCE]
            for what, mine, reference in zip(("median", "99 %"), ours, theirs, strict=True):
                asked = f"latency, {what}, no more than Aravis's: {size} bytes"
                goals.append(Goal(asked, f"{mine:.2f} and {reference:.2f} ms", mine <= reference))
    header = ["packet", "receiver", "latency, median", "99 % within", "memory"]
    return Table(header, rows, "Latency and memory at 125 MB/s:"), goals


def long_runs(seconds: float) -> tuple[Table, list[Goal]]:
    """Run our driver for a long time, alone and with the window painting."""
    rows, goals = [], []
    case = Case(1400, Conditions())
    for label, name in (("alone", "ours"), ("window painting, the kernel's own buffer limit", "window")):
        run, _ = observe(case, seconds, lambda *a, name=name: in_child(name, *a))
        shown = f"{len(run.arrivals) / run.seconds:.1f}" if name == "window" else "–"
        counts = [str(run.complete), str(run.incomplete), str(run.resent), shown]
        rows.append([label, f"{run.seconds:.0f} s", *counts, f"{run.cpu / run.seconds:.2f}"])
        asked = f"no frame lost in {seconds:g} s at 125 MB/s with 1400-byte packets, {label}"
        goals.append(Goal(asked, f"{run.incomplete} of {run.complete + run.incomplete}", not run.incomplete))
    header = ["this driver", "duration", "frames", "lost", "packets resent", "images painted/s", "cores"]
    return Table(header, rows, "A long run, 1400 bytes at 125 MB/s:"), goals


def goals(found: dict[Case, Results], losses: dict[float, Results]) -> list[Goal]:
    """Judge the results; there are no goals without Aravis."""
    made = []
    for case, results in found.items():
        times_cost, times_rate = ratio(results, cost), ratio(results, rate)
        if times_cost is None or times_rate is None:
            continue
        if case.conditions.bandwidth:
            asked = f"CPU per GB no more than Aravis's: {case.name}"
            made.append(Goal(asked, f"{times_cost:.2f} times", times_cost <= 1))
        else:
            asked = f"complete frames, at least 1.5 times Aravis's: {case.name}"
            made.append(Goal(asked, f"{times_rate:.2f} times", times_rate >= 1.5))
    for loss, results in losses.items():
        if loss <= 0.01:
            complete = share(results["ours"])
            asked = f"99.9 % of frames complete at {100 * loss:g} % loss"
            made.append(Goal(asked, f"{complete:.2f} %", complete >= 99.9))
            if (times := ratio(results, cost)) is not None:
                asked = f"CPU per GB no more than Aravis's at {100 * loss:g} % loss"
                made.append(Goal(asked, f"{times:.2f} times", times <= 1))
    return made


def singly_goal(results: Results) -> list[Goal]:
    """Judge the cost of packets sent singly."""
    asked = f"at most {MOST_COST} CPU s/GB: packets of 1400 bytes, sent singly"
    spent = median(results["ours"], cost)
    return [Goal(asked, f"{spent:.2f} s/GB", spent <= MOST_COST)]


def fast_run() -> tuple[Table, list[Goal]]:
    """Run our driver at the rate of 25 Gigabit Ethernet."""
    run, _ = observe(FAST, FAST_SECONDS, lambda *a: in_child("ours", *a))
    speed, lost = run.frames_per_second * PAYLOAD / 1e9, run.incomplete
    row = [FAST.name, f"{run.seconds:.0f} s", f"{speed:.2f} GB/s", str(lost), f"{run.cpu_per_gb:.2f}"]
    goals = [
        Goal(
            f"all frames of {FAST_SECONDS:g} s complete: {FAST.name}",
            f"{lost} lost, at {speed:.2f} GB/s",
            not lost and speed >= FAST_SHARE * FAST.conditions.bandwidth / 1e9,
        ),
        Goal(
            f"at most {MOST_COST_FAST} CPU s/GB: {FAST.name}",
            f"{run.cpu_per_gb:.2f} s/GB",
            run.cpu_per_gb <= MOST_COST_FAST,
        ),
    ]
    header = ["this driver", "duration", "complete frames", "lost", "CPU s/GB"]
    return Table(header, [row], "At the rate of 25 Gigabit Ethernet:"), goals


def _charts(found: dict[Case, Results]) -> list[Chart]:
    groups = [case.name for case in found]
    names = list(dict.fromkeys(name for results in found.values() for name in results))

    def series(figure: Callable[[Run], float]) -> dict[str, list[float | None]]:
        return {
            name: [median(results[name], figure) if name in results else None for results in found.values()]
            for name in names
        }

    return [
        Chart("gige-cost", "CPU seconds per GB, less is better", "s/GB", groups, series(cost)),
        Chart("gige-rate", "Complete frames per second", "frames/s", groups, series(rate)),
    ]


def _times(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f}"


def _megabytes(run: Run) -> str:
    return f"{run.memory / 1e6:.0f} MB"


# -- the section -------------------------------------------------------------------------------------
def measure(arguments: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=4.0, help="of each run")
    parser.add_argument("--runs", type=int, default=3, help="of each receiver")
    parser.add_argument("--long", type=float, default=60.0, help="seconds of the long runs; 0: none")
    options = parser.parse_args(arguments)
    before = machine()
    found = {}
    for case in CASES:
        found[case] = compare(case, options.seconds, options.runs, receivers())
        print(_document.table(rates_table({case: found[case]})), flush=True)
    losses = {}
    for loss in LOSSES:
        case = Case(1400, Conditions(loss=loss))
        losses[loss] = compare(case, options.seconds, options.runs, receivers())
        print(_document.table(loss_table({loss: losses[loss]})), flush=True)
    latencies, latency_goals = latency_table(options.seconds, options.runs)
    fast, fast_goals = fast_run()
    tables = [rates_table(found), loss_table(losses), latencies, fast]
    asked = goals(found, losses) + singly_goal(found[SINGLY]) + latency_goals + fast_goals
    if options.long:
        table, more = long_runs(options.long)
        tables.append(table)
        asked += more
    # Latencies are judged by Aravis's only; without its Python binding there is no goal.
    compared = latency_goals and all(REFERENCE in results for results in found.values())
    return Section(
        "GigE Vision",
        "python -m benchmarks gige_peers          # ten minutes",
        METHOD.format(
            width=WIDTH,
            height=HEIGHT,
            format=PIXEL_FORMAT.name,
            runs=options.runs,
            seconds=options.seconds,
        ),
        tables,
        _charts(found),
        asked,
        READING,
        before,
        lacking="" if compared else REFERENCE,
    )


if __name__ == "__main__":
    print(_document.markdown(measure()))
