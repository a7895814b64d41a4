"""Receivers of GigE Vision side by side: this driver, Aravis and viva-genicam, on the same camera.

The simulated camera sends from a process of its own on the loopback; the receivers take turns, several short
runs each, of which the median counts. Only ratios within one table mean something.

    python -m benchmarks.gige_peers [--seconds 3] [--runs 3]
"""

from __future__ import annotations

import argparse
import contextlib
import json
import re
import resource
import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from importlib.util import find_spec

from grabbergui.core.errors import FrameTimeoutError

ADDRESS = "127.0.79.9"
WIDTH, HEIGHT = 4096, 1024
PAYLOAD = WIDTH * HEIGHT
GIGABIT = 125e6
LOSSES = (0.001, 0.01, 0.05)
ARAVIS = "arv-camera-test-0.8"


@dataclass(frozen=True)
class Run:
    """What one receiver got."""

    complete: int
    incomplete: int
    seconds: float
    cpu: float
    "Seconds of the receiving process."

    @property
    def frames_per_second(self) -> float:
        return self.complete / self.seconds

    @property
    def cpu_per_gb(self) -> float:
        return self.cpu / max(self.complete * PAYLOAD / 1e9, 1e-9)

    @property
    def share(self) -> float:
        """Complete frames of all that were begun, in percent."""
        return 100 * self.complete / max(self.complete + self.incomplete, 1)


NOTHING = Run(0, 0, 1.0, 0.0)


# -- the camera, in a process of its own -------------------------------------------------------------
def serve(bandwidth: float, loss: float) -> None:
    """Be the camera until standard input ends."""
    from grabbergui.driver.sim import registers as reg
    from grabbergui.driver.sim.gige.faults import Faults
    from grabbergui.driver.sim.gige.server import GigeCamera

    camera = GigeCamera(
        ADDRESS,
        bandwidth=bandwidth,
        faults=Faults(loss=loss),
        power_on={
            reg.WIDTH: WIDTH,
            reg.HEIGHT: HEIGHT,
            reg.FRAME_RATE_ENABLE: 0,
            reg.EXPOSURE_TIME: 1000.0,
            reg.TEST_PATTERN: int(reg.TestPattern.GREY_HORIZONTAL_RAMP),
        },
    )
    print("ready", flush=True)
    sys.stdin.read()
    camera.close()


@contextlib.contextmanager
def camera_process(bandwidth: float, loss: float = 0.0) -> Iterator[None]:
    """The camera, started anew so that every receiver meets it fresh."""
    command = [sys.executable, "-m", "benchmarks.gige_peers", "--serve", str(bandwidth), str(loss)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stdin is not None
        if process.stdout.readline().strip() != "ready":
            raise SystemExit(f"the camera did not come up at {ADDRESS}; is another one there?")
        yield
        process.stdin.close()


# -- receivers ---------------------------------------------------------------------------------------
def receive_ours(packet_size: int, seconds: float) -> Run:
    """In this process, counted from the first frame on."""
    from grabbergui import sources

    camera = sources.create(f"gige:{ADDRESS}?packet_size={packet_size}")
    camera.open()
    queue = camera.open_queue(4)
    camera.start()
    queue.get(10.0)
    begun, cpu, before = time.monotonic(), time.process_time(), camera.statistics()
    while time.monotonic() < begun + seconds:
        with contextlib.suppress(FrameTimeoutError):
            queue.get(0.5)
    cpu, after = time.process_time() - cpu, camera.statistics()
    took = time.monotonic() - begun
    camera.close()
    lost = after.incomplete - before.incomplete + after.lost - before.lost
    return Run(after.frames - before.frames, lost, took, cpu)


def receive_viva(packet_size: int, seconds: float) -> Run:
    """viva-genicam in this process, counted from the first frame on."""
    import viva_genicam

    (info,) = [info for info in viva_genicam.discover(all=True) if str(info.ip) == ADDRESS]
    with (
        viva_genicam.connect_gige(info) as camera,
        camera.stream(packet_size=packet_size, deliver_incomplete=True) as frames,
    ):
        frames.next_frame()
        begun, cpu, counts = time.monotonic(), time.process_time(), [0, 0]
        while time.monotonic() < begun + seconds:
            frame = frames.next_frame(timeout_ms=500)
            if frame is not None:
                counts[bool(frame.is_complete)] += 1
        return Run(counts[1], counts[0], time.monotonic() - begun, time.process_time() - cpu)


def run_in_child(name: str, packet_size: int, seconds: float) -> Run:
    """One of the above in a process of its own."""
    command = [
        sys.executable,
        "-m",
        "benchmarks.gige_peers",
        "--receive",
        name,
        str(packet_size),
        str(seconds),
    ]
    child = subprocess.run(command, capture_output=True, text=True, check=False)
    if child.returncode:
        raise SystemExit(f"{name} failed: {child.stderr.strip().splitlines()[-1:]}")
    return Run(**json.loads(child.stdout.splitlines()[-1]))


def run_aravis(packet_size: int, seconds: float) -> Run:
    """arv-camera-test; its opening, measured apart, is subtracted."""
    before = children_cpu()
    subprocess.run(["arv-tool-0.8", "-a", ADDRESS, "control", "Width"], capture_output=True, check=False)
    opened = children_cpu()
    command = [ARAVIS, "-n", ADDRESS, "--no-packet-socket", "-a", "-i", str(packet_size)]
    command += ["--duration", str(int(seconds) + 1)]
    text = subprocess.run(command, capture_output=True, text=True, check=False, errors="replace").stdout
    spent = children_cpu() - opened - (opened - before)
    rates = [int(count) for count in re.findall(r"(\d+) frames?/s", text)]
    counts = {
        name: int(count) for name, count in re.findall(r"n_(completed_buffers|failures)\s*=\s*(\d+)", text)
    }
    complete, incomplete = counts.get("completed_buffers", 0), counts.get("failures", 0)
    return Run(complete, incomplete, max(len(rates), 1), spent)


def children_cpu() -> float:
    """Seconds of CPU that ended child processes took."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def receivers() -> dict[str, Callable[[int, float], Run]]:
    """Those that this machine has."""
    found: dict[str, Callable[[int, float], Run]] = {"ours": lambda *a: run_in_child("ours", *a)}
    if shutil.which(ARAVIS):
        found["Aravis"] = run_aravis
    if find_spec("viva_genicam"):
        found["viva-genicam"] = lambda *a: run_in_child("viva", *a)
    return found


# -- tables ------------------------------------------------------------------------------------------
def median_run(runs: list[Run]) -> Run:
    """The medians of everything."""
    fields = zip(*(asdict(run).values() for run in runs), strict=True)
    return Run(*(statistics.median(values) for values in fields))


def compare(
    bandwidth: float, loss: float, packet_size: int, seconds: float, runs: int
) -> dict[str, list[Run]]:
    """Every receiver in turn, round after round, so that a busy moment meets all of them."""
    results: dict[str, list[Run]] = {}
    for _ in range(runs):
        for name, receive in receivers().items():
            with camera_process(bandwidth, loss):
                results.setdefault(name, []).append(receive(packet_size, seconds))
    return results


def spread(values: list[float]) -> str:
    """The lowest and the highest: medians hide runs that went wrong."""
    return f"{min(values):.1f} … {max(values):.1f}"


def ratio(value: float, reference: float) -> str:
    """A value as a multiple of Aravis's, or a dash."""
    return f"{value / reference:.2f}" if reference else "–"


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=3.0, help="of each run")
    parser.add_argument("--runs", type=int, default=3, help="of each receiver; the median counts")
    parser.add_argument("--serve", nargs=2, type=float, help=argparse.SUPPRESS)
    parser.add_argument("--receive", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.serve:
        serve(*options.serve)
        return
    if options.receive:
        name, packet_size, seconds = options.receive
        receive = {"ours": receive_ours, "viva": receive_viva}[name]
        print(json.dumps(asdict(receive(int(packet_size), float(seconds)))))
        return
    print(f"pictures of {WIDTH}x{HEIGHT} Mono8; medians of {options.runs} runs of {options.seconds:g} s\n")
    print(
        "| packet | rate | receiver | frames/s | × Aravis | of the runs | incomplete | CPU s/GB | × Aravis |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for bandwidth in (GIGABIT, 0.0):
        for packet_size in (1400, 8164):
            found = compare(bandwidth, 0.0, packet_size, options.seconds, options.runs)
            reference = median_run(found.get("Aravis", [NOTHING]))
            for name, measured in found.items():
                run = median_run(measured)
                cells = (
                    packet_size,
                    "125 MB/s" if bandwidth else "full speed",
                    name,
                    f"{run.frames_per_second:.1f}",
                    ratio(run.frames_per_second, reference.frames_per_second),
                    spread([one.frames_per_second for one in measured]),
                    f"{run.incomplete:g}",
                    f"{run.cpu_per_gb:.2f}",
                    ratio(run.cpu_per_gb, reference.cpu_per_gb),
                )
                print("|", " | ".join(map(str, cells)), "|", flush=True)
    print("\n| loss | receiver | frames/s | incomplete, all runs | complete, of all |")
    print("|---|---|---|---|---|")
    for loss in LOSSES:
        for name, measured in compare(GIGABIT, loss, 1400, options.seconds, options.runs).items():
            columns = zip(*(asdict(run).values() for run in measured), strict=True)
            total = Run(*(sum(column) for column in columns))
            rate = f"{total.frames_per_second:.1f}"
            print(
                f"| {100 * loss:g} % | {name} | {rate} | {total.incomplete} | {total.share:.2f} % |",
                flush=True,
            )


if __name__ == "__main__":
    main()
