"""A long stream: checks that memory does not grow and that every frame arrives.

The simulated camera, in a process of its own, sends 30 frames a second over the loopback and loses some
packets; this process receives them as the window does. The resident memory of both is sampled.

    python -m benchmarks.soak [--minutes 1] [--loss 0.1%] [--address 127.0.0.40]

One minute checks the program; a real soak test takes an hour.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path

import numpy as np

from grabbergui import sources
from grabbergui.core.errors import FrameTimeoutError
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import FrameGrabber

SAMPLE_PERIOD = 10.0
WARM_UP = 60.0
"Seconds in which pools and caches fill; they do not count in the slope."
PAGE = os.sysconf("SC_PAGE_SIZE")
CAMERA = "sim:?width=640&height=480&fps=30"


def resident_bytes(pid: int) -> int:
    """Return the resident memory of a process (Linux)."""
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * PAGE


def slope(seconds: Sequence[float], sizes: Sequence[int]) -> float:
    """Return the slope of a linear fit, bytes per second."""
    if len(seconds) < 2:
        return 0.0
    return float(np.polyfit(seconds, sizes, 1)[0])


@contextmanager
def simulated(address: str, loss: str) -> Iterator[int]:
    """Run the camera at an address, in a process of its own; yield its process id."""
    command = [sys.executable, "-m", "grabbergui", "simulate", "--gige", address, "--camera", CAMERA]
    process = subprocess.Popen([*command, "--loss", loss], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    try:
        if address not in process.stdout.readline():
            sys.exit(f"no camera came up at {address}")
        yield process.pid
    finally:
        process.terminate()
        process.wait(10)
        process.stdout.close()


class Consumer:
    """Receives frames as a viewer does, and reads the first and last byte of each."""

    def __init__(self, queue: FrameQueue) -> None:
        self.frames = 0
        self.longest_gap = 0.0
        "Longest time between two frames, seconds."
        self._queue = queue
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="consumer")
        self._thread.start()

    def close(self) -> None:
        self._stopping.set()
        self._thread.join()

    def _run(self) -> None:
        last = None
        while not self._stopping.is_set():
            try:
                frame = self._queue.get(0.5)
            except FrameTimeoutError:
                continue
            now = time.monotonic()
            if last is not None:
                self.longest_gap = max(self.longest_gap, now - last)
            last = now
            int(frame.payload[0]) + int(frame.payload[-1])
            self.frames += 1


def watch(grabber: FrameGrabber, consumer: Consumer, camera: int, minutes: float) -> None:
    """Sample until the time is over, then print the result."""
    pids = {"receiver": os.getpid(), "simulated camera": camera}
    samples: dict[str, list[int]] = {name: [] for name in pids}
    times: list[float] = []
    begun = time.monotonic()
    while (elapsed := time.monotonic() - begun) < minutes * 60:
        if elapsed >= WARM_UP or minutes * 60 <= 2 * WARM_UP:
            times.append(elapsed)
            for name, pid in pids.items():
                samples[name].append(resident_bytes(pid))
        if int(elapsed / SAMPLE_PERIOD) % 6 == 0:
            statistics = grabber.statistics()
            sizes = ", ".join(f"{name} {resident_bytes(pid) / 1e6:.1f} MB" for name, pid in pids.items())
            print(
                f"{elapsed / 60:5.1f} min: {statistics.frames} frames, {statistics.incomplete} incomplete,"
                f" {statistics.packets_resent} packets resent; {sizes}",
                flush=True,
            )
        time.sleep(SAMPLE_PERIOD - (time.monotonic() - begun) % SAMPLE_PERIOD)
    statistics = grabber.statistics()
    print(f"\n{minutes:g} minutes, {statistics.frames / (minutes * 60):.2f} frames/s")
    for name, counter in statistics.as_dict().items():
        if isinstance(counter, int):
            print(f"  {name}: {counter}")
    print(f"  taken by the consumer: {consumer.frames}; longest gap {consumer.longest_gap * 1000:.0f} ms")
    for name, sizes_seen in samples.items():
        first, last = sizes_seen[0] / 1e6, sizes_seen[-1] / 1e6
        half = len(times) // 2
        grown, lately = (slope(times[n:], sizes_seen[n:]) * 3600 / 1e6 for n in (0, half))
        print(
            f"  memory of the {name}: {first:.1f} MB behind the first minute, {last:.1f} MB at the end,"
            f" most {max(sizes_seen) / 1e6:.1f} MB; slope {grown:+.2f} MB/hour, lately {lately:+.2f}"
        )


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.soak", description=__doc__)
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--loss", default="0.1%")
    parser.add_argument("--address", default="127.0.0.40")
    options = parser.parse_args(arguments)
    with simulated(options.address, options.loss) as camera:
        grabber = sources.create(f"gige:{options.address}?packet_size=1500")
        with closing(grabber):
            grabber.open()
            consumer = Consumer(grabber.open_queue(4))
            with closing(consumer):
                grabber.start()
                watch(grabber, consumer, camera, options.minutes)
                grabber.stop()


if __name__ == "__main__":
    main()
