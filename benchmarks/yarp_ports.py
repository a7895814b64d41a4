"""YARP streams and requests between two processes, ours and real YARP's in all four pairs.

    python -m benchmarks.yarp_ports [--seconds 2] [--rounds 3] [--carriers tcp fast_tcp udp mjpeg]

Real YARP is used if its Python bindings can be imported (`import yarp`); without them only our ports are
measured, and the page says so.
"""

from __future__ import annotations

import argparse
import importlib.util
import multiprocessing
import os
import re
import shutil
import statistics
import subprocess
import tempfile
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from benchmarks import _document, _yarp_ends
from benchmarks._results import Chart, Goal, Section, Table, machine
from benchmarks._yarp_ends import Order, Received
from grabbergui.core.errors import GrabberError
from grabbergui.net.yarp.os.name_server import NameServer

SIZES = {"640×480": (640, 480), "1080p": (1920, 1080), "8.8 MP": (4096, 2160)}
CARRIERS = ("tcp", "fast_tcp", "udp", "mjpeg")
WITH_REAL = ("tcp", "fast_tcp")
"""Carriers on which all pairs and sizes are measured; the others lose images or compress them."""
OURS, REAL = "ours", "YARP"
PAIRS = ((REAL, REAL), (REAL, OURS), (OURS, REAL), (OURS, OURS))
SENDERS = {OURS: _yarp_ends.send_ours, REAL: _yarp_ends.send_real}
READERS = {OURS: _yarp_ends.read_ours, REAL: _yarp_ends.read_real}
ASKERS = {OURS: _yarp_ends.ask_ours, REAL: _yarp_ends.ask_real}
ANSWERERS = {OURS: _yarp_ends.answer_ours, REAL: _yarp_ends.answer_real}
PACE = 30.0
"""Images per second when their age is measured."""
CONTEXT = multiprocessing.get_context("spawn")
METHOD = """RGB images from one process to another on the loopback, each as soon as the previous one is
sent, for {seconds:g} seconds, in {rounds} rounds. Rates are those of the best round. *× YARP* compares runs
of the same round, which follow each other within seconds, so that other load on the machine affects both;
the median of the rounds counts. *YARP* is {version}; its ports are C++, controlled from Python. {without}CPU
is that of both processes."""
WITHOUT = "**It could not be imported here (`import yarp`), so ours is only compared with ours.** "


@dataclass(frozen=True)
class Stream:
    """One round of a pair on one carrier with one size."""

    sent: int
    received: Received
    payload: int
    cpu: float
    "CPU seconds of both processes."

    @property
    def rate(self) -> float:
        ages = self.received.ages
        return (len(ages) - 1) / self.received.seconds if len(ages) > 1 else 0.0

    @property
    def cpu_per_gb(self) -> float:
        return self.cpu / (max(len(self.received.ages), 1) * self.payload / 1e9)

    def late(self, share: float) -> float:
        """Return the age that a share of images does not exceed, milliseconds."""
        ages = sorted(self.received.ages) or [float("nan")]
        return ages[min(int(len(ages) * share), len(ages) - 1)]


@dataclass
class Streams:
    """All rounds of one pair on one carrier with one size."""

    runs: list[Stream] = field(default_factory=list)

    @property
    def best(self) -> Stream:
        return max(self.runs, key=lambda run: run.rate)

    def times(self, reference: Streams, quantity: Callable[[Stream], float]) -> float:
        """Return `quantity` as a multiple of the reference's, the median of the rounds."""
        rounds = zip(self.runs, reference.runs, strict=True)
        ratios = [quantity(run) / quantity(other) for run, other in rounds if quantity(other)]
        return statistics.median(ratios) if ratios else float("nan")


Measured = dict[tuple[str, str, str, str], Streams]
"""Streams by size, carrier, sender and reader."""


def measure(arguments: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks yarp_ports", description=__doc__)
    parser.add_argument("--seconds", type=float, default=1.5, help="how long each stream runs")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--carriers", nargs="+", choices=CARRIERS, default=CARRIERS)
    parser.add_argument("--sizes", nargs="+", choices=list(SIZES), default=list(SIZES))
    options = parser.parse_args(arguments)
    before = machine()
    bindings = importlib.util.find_spec("yarp")
    with_real = bindings is not None and bindings.origin is not None  # any folder of that name can be found
    pairs = [pair for pair in PAIRS if with_real or REAL not in pair]
    streams: Measured = defaultdict(Streams)
    trips: dict[tuple[str, str], list[float]] = {}
    with name_server() as names:
        for name, size in SIZES.items():
            if name not in options.sizes:
                continue
            for carrier in options.carriers:
                if carrier not in WITH_REAL and name != "1080p":
                    continue
                order = Order(names, carrier, size, options.seconds)
                for _ in range(options.rounds):
                    for sender, reader in pairs if carrier in WITH_REAL else [(OURS, OURS)]:
                        found = stream(sender, reader, order)
                        key = name, carrier, sender, reader
                        streams[key].runs.append(found)
                        print(*key, f"{found.rate:.1f} fps", flush=True)
        paced = Order(names, "fast_tcp", SIZES["1080p"], options.seconds, PACE)
        ages = {(sender, reader): stream(sender, reader, paced) for sender, reader in pairs}
        for asker, answerer in pairs:
            trips[asker, answerer] = round_trips(asker, answerer, names, options.seconds)
    method = METHOD.format(
        seconds=options.seconds,
        rounds=options.rounds,
        version=real_version() if with_real else "the original",
        without="" if with_real else WITHOUT,
    )
    return Section(
        "YARP ports",
        "python -m benchmarks yarp_ports          # two minutes; PYTHONPATH with real YARP's bindings",
        method,
        [_stream_table(streams), _age_table(ages), _trip_table(trips)],
        [_chart(streams, "fast_tcp")] if "fast_tcp" in options.carriers else [],
        _goals(streams) if with_real else [],
        machine=before,
        lacking="" if with_real else "real YARP's Python bindings",
    )


@contextmanager
def name_server() -> Iterator[str]:
    """Run our name server, which all processes of the block find, also real YARP's; yield its address."""
    before = {name: os.environ.get(name) for name in ("YARP_CONFIG_HOME", "YARP_FORWARD_LOG_ENABLE")}
    server = NameServer("127.0.0.1", 0)
    with ExitStack() as stack:
        server.open()
        stack.callback(server.close)
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        (Path(folder) / "yarp.conf").write_text(f"127.0.0.1 {server.port_number} yarp\n")
        os.environ |= {"YARP_CONFIG_HOME": folder, "YARP_FORWARD_LOG_ENABLE": "0"}
        try:
            yield f"127.0.0.1:{server.port_number}"
        finally:
            for name, value in before.items():
                os.environ.pop(name) if value is None else os.environ.__setitem__(name, value)


def stream(sender: str, reader: str, order: Order) -> Stream:
    """Measure a stream between two processes."""
    with ExitStack() as stack:
        source = _process(stack, SENDERS[sender], order)
        source.recv()
        sink = _process(stack, READERS[reader], order)
        sink.recv()
        source.send("begin")
        sent, cpu = source.recv()
        received = sink.recv()
        source.send("enough")
    return Stream(sent, received, order.size[0] * order.size[1] * 3, cpu + received.cpu)


def round_trips(asker: str, answerer: str, names: str, seconds: float) -> list[float]:
    """Measure requests of a few words, one after the other; return milliseconds, sorted."""
    with ExitStack() as stack:
        name = f"/benchmark/{asker}-asks-{answerer}"
        server = _process(stack, ANSWERERS[answerer], names, name, ends=False)
        server.recv()
        return sorted(_process(stack, ASKERS[asker], names, name, seconds).recv())


def _process(stack: ExitStack, target: Callable[..., None], *arguments: Any, ends: bool = True) -> Connection:
    """Start a process that ends by itself or with the stack."""
    ours, theirs = CONTEXT.Pipe()
    process = CONTEXT.Process(target=target, args=(theirs, *arguments))
    process.start()
    theirs.close()

    def end() -> None:
        if not ends:
            process.terminate()
        process.join(20)
        if process.is_alive():
            process.kill()

    stack.callback(end)
    return ours


def real_version() -> str:
    """Return the version that the program `yarp` reports, if it is on the PATH."""
    if shutil.which("yarp") is None:
        return "the original"
    done = subprocess.run(["yarp", "version"], capture_output=True, text=True, check=False)
    found = re.search(r"[Vv]ersion (\d[\w.]*)", done.stdout)
    return f"the original, {found[1]}" if found else "the original"


def _stream_table(streams: Measured) -> Table:
    rows = []
    for (name, carrier, sender, reader), rounds in streams.items():
        run, reference = rounds.best, streams.get((name, carrier, REAL, REAL))
        rows.append(
            [
                name,
                carrier,
                f"{sender} → {reader}",
                f"{run.rate:.0f}",
                f"{rounds.times(reference, _rate):.2f}" if reference else "",
                f"{run.rate * run.payload / 1e9:.2f} GB/s",
                f"{run.cpu_per_gb:.2f}",
                f"{rounds.times(reference, _cpu_per_gb):.2f}" if reference else "",
                f"{run.sent - len(run.received.ages)} of {run.sent}",
            ]
        )
    header = ["image", "carrier", "from → to", "frames/s", "× YARP", "throughput"]
    return Table([*header, "CPU s/GB", "× YARP", "not delivered"], rows)


def _rate(run: Stream) -> float:
    return run.rate


def _cpu_per_gb(run: Stream) -> float:
    return run.cpu_per_gb


def _age_table(ages: dict[tuple[str, str], Stream]) -> Table:
    rows = [
        [f"{sender} → {reader}", f"{run.late(0.5):.2f} ms", f"{run.late(0.99):.2f} ms"]
        for (sender, reader), run in ages.items()
    ]
    title = f"Latency of 1080p RGB over fast_tcp at {PACE:g} images per second, from stamp to reader:"
    return Table(["from → to", "median", "p99"], rows, title)


def _trip_table(trips: dict[tuple[str, str], list[float]]) -> Table:
    rows = []
    for (asker, answerer), times in trips.items():
        median, late = statistics.median(times), times[int(len(times) * 0.99)]
        rows.append([f"{asker} asks {answerer}", f"{median:.3f} ms", f"{late:.3f} ms"])
    return Table(["requests", "median", "p99"], rows, "Consecutive requests of a few words:")


def _chart(streams: Measured, carrier: str) -> Chart:
    keys = [key for key in streams if key[1] == carrier]
    sizes = list(dict.fromkeys(name for name, *_ in keys))
    pairs = dict.fromkeys((sender, reader) for _, _, sender, reader in keys)

    def throughput(name: str, pair: tuple[str, str]) -> float | None:
        rounds = streams.get((name, carrier, *pair))
        return rounds.best.rate * rounds.best.payload / 1e9 if rounds else None

    return Chart(
        "yarp-throughput",
        f"RGB over {carrier} between two processes",
        "GB/s",
        sizes,
        {f"{pair[0]} → {pair[1]}": [throughput(name, pair) for name in sizes] for pair in pairs},
    )


def _goals(streams: Measured) -> list[Goal]:
    """Judge our figures by real YARP's, at 1080p over fast_tcp."""
    goals = []
    reference = streams.get(("1080p", "fast_tcp", REAL, REAL))
    for sender, reader in PAIRS[1:]:
        rounds = streams.get(("1080p", "fast_tcp", sender, reader))
        if rounds and reference:
            ratio = rounds.times(reference, _rate)
            asked = f"1080p RGB over fast_tcp, {sender} → {reader}: as many frames as YARP → YARP"
            goals.append(Goal(asked, f"{ratio:.2f} ×", ratio >= 1))
    return goals


if __name__ == "__main__":
    try:
        print(_document.markdown(measure()))
    except GrabberError as error:
        raise SystemExit(str(error)) from error
