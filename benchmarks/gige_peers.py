"""Lost packets, latency and a long run: this driver, Aravis and viva-genicam receive from the same camera.

The simulated camera sends from a process of its own on the loopback; the receivers take turns, several short
runs each. What they cost is measured where packets arrive as from a network card: `gige_wire`.

    python -m benchmarks gige_peers [--seconds 4] [--runs 3] [--long 60]
"""

from __future__ import annotations

import argparse
import statistics
from collections.abc import Callable
from dataclasses import dataclass

from benchmarks import _document
from benchmarks._gige_camera import (
    HEIGHT,
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
from benchmarks._results import Goal, Section, Table, machine

PACKET_SIZES = (1400, 8164)
LOSSES = (0.001, 0.01, 0.05)
REFERENCE = "Aravis"
METHOD = """The simulated camera sends {width}×{height} {format} at 125 MB/s over the loopback from a process
of its own. The receivers take turns, so that other load on the machine affects them all: this driver,
Aravis 0.8 (`arv-camera-test-0.8 --no-packet-socket -a`, which sizes its socket buffer to the image and loses
least here) and viva-genicam, {runs} runs of {seconds:g} seconds each. The loopback neither cuts nor joins
packets: it says nothing about the cost of receiving, which is in the section above."""
READING = [
    "*incomplete*: frames that began, or that are missing from the sequence of ids, and were not completed.",
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
                print(f"{name}: {error}", flush=True)
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


def share(runs: list[Run]) -> float:
    """Return the percentage of complete frames."""
    complete, incomplete = sum(run.complete for run in runs), sum(run.incomplete for run in runs)
    return 100 * complete / max(complete + incomplete, 1)


def loss_table(found: dict[float, Results]) -> Table:
    rows = []
    for loss, results in found.items():
        for name, runs in results.items():
            counts = [f"{median(runs, rate):.1f}", str(sum(run.incomplete for run in runs))]
            rows.append([f"{100 * loss:g} %", name, *counts, f"{share(runs):.2f} %"])
    header = ["loss", "receiver", "frames/s", "incomplete, all runs", "complete"]
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


def loss_goals(losses: dict[float, Results]) -> list[Goal]:
    """Judge how many frames were complete."""
    made = []
    for loss, results in losses.items():
        if loss <= 0.01:
            complete = share(results["ours"])
            asked = f"99.9 % of frames complete at {100 * loss:g} % loss"
            made.append(Goal(asked, f"{complete:.2f} %", complete >= 99.9))
    return made


def _megabytes(run: Run) -> str:
    return f"{run.memory / 1e6:.0f} MB"


def measure(arguments: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=4.0, help="of each run")
    parser.add_argument("--runs", type=int, default=3, help="of each receiver")
    parser.add_argument("--long", type=float, default=60.0, help="seconds of the long runs; 0: none")
    options = parser.parse_args(arguments)
    before = machine()
    losses = {}
    for loss in LOSSES:
        case = Case(1400, Conditions(loss=loss))
        losses[loss] = compare(case, options.seconds, options.runs, receivers())
        print(_document.table(loss_table({loss: losses[loss]})), flush=True)
    latencies, latency_goals = latency_table(options.seconds, options.runs)
    tables = [loss_table(losses), latencies]
    asked = loss_goals(losses) + latency_goals
    if options.long:
        table, more = long_runs(options.long)
        tables.append(table)
        asked += more
    # Latencies are judged by Aravis's only; without its Python binding there is no goal.
    compared = latency_goals and all(REFERENCE in results for results in losses.values())
    return Section(
        "GigE Vision, losses and latency",
        "python -m benchmarks gige_peers          # six minutes",
        METHOD.format(
            width=WIDTH,
            height=HEIGHT,
            format=PIXEL_FORMAT.name,
            runs=options.runs,
            seconds=options.seconds,
        ),
        tables,
        [],
        asked,
        READING,
        before,
        lacking="" if compared else REFERENCE,
    )


if __name__ == "__main__":
    print(_document.markdown(measure()))
