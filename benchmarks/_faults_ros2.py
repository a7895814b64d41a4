"""Faults of other programs on ROS 2: a reliable reader that is frozen, and programs that are killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from benchmarks._faults import Outcome, fault
from benchmarks._network_runs import on_this_machine_only
from grabbergui import sources
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.shared_folder import MEMORY
from grabbergui.net.ros2.shared_memory import clear, leftovers

CHAPTER = "Other programs on ROS 2"
FPS = 25
CAMERA = f"sim:?width=1280&height=720&fps={FPS}"
NAME = "/fault/camera"
FROZEN_SECONDS = 10.0
QUEUED = 10
"Depth of a subscription's queue, images."
KILLED = 5
"Number of programs that are killed."
LONGEST = 60.0
"Seconds within which the resources of killed programs must be free again."
_READER = f"""
import sys
from grabbergui.net.ros2.runtime import Ros2Node
from sensor_msgs.msg import Image

received = 0

def take(image):
    global received
    received += 1
    if received == 1:
        print("receives", flush=True)

ros = Ros2Node(f"reader{{sys.argv[1]}}")
ros.node.create_subscription(Image, "{NAME}/image_raw", take, {QUEUED})
ros.start()
for _ in sys.stdin:
    print(received, flush=True)
"""


class Reader:
    """A program with a plain, reliable subscription; its constructor waits for the first image."""

    def __init__(self, number: int) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-c", _READER, str(number)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        if self._line() != "receives":
            raise RuntimeError("the reader ended")

    def received(self) -> int:
        """Return the number of images so far."""
        assert self.process.stdin is not None
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        return int(self._line())

    def close(self) -> None:
        self.process.kill()
        self.process.communicate()

    def _line(self) -> str:
        assert self.process.stdout is not None
        return self.process.stdout.readline().strip()


@contextmanager
def served() -> Iterator[FrameGrabber]:
    """Serve a camera on ROS 2 in this process."""
    from grabbergui.net.ros2.server import Ros2GrabberServer

    with ExitStack() as stack:
        grabber = sources.create(CAMERA)
        grabber.open()
        stack.callback(grabber.close)
        stack.enter_context(Ros2GrabberServer(grabber, NAME))
        yield grabber


@fault(CHAPTER)
def frozen_reliable_reader() -> Outcome:
    on_this_machine_only()
    with ExitStack() as stack:
        grabber = stack.enter_context(served())
        readers = [Reader(number) for number in range(2)]
        for reader in readers:
            stack.callback(reader.close)
        reader, frozen = readers

        def lost_of() -> tuple[int, int]:
            """Return the frames that the other reader misses in a period, and those that the camera sends."""
            sent, received = grabber.statistics().frames, reader.received()
            time.sleep(FROZEN_SECONDS)
            received, sent = reader.received() - received, grabber.statistics().frames - sent
            return max(0, sent - received), sent

        undisturbed, _ = lost_of()
        frozen.process.send_signal(signal.SIGSTOP)
        lost, sent = lost_of()
        frozen.process.send_signal(signal.SIGCONT)
        begun, before = time.monotonic(), frozen.received()
        while frozen.received() <= before + QUEUED:
            time.sleep(0.01)
        again = time.monotonic() - begun
    return Outcome(
        "one of two reliable readers of 720p images gets SIGSTOP",
        f"for {FROZEN_SECONDS:g} s",
        f"{lost} of {sent} frames at the other reader; {undisturbed} in as long before",
        f"{again:.1f} s after SIGCONT: the frozen one receives new images",
        lost <= undisturbed + 0.05 * sent,
    )


@fault(CHAPTER)
def killed_programs_memory() -> Outcome:
    on_this_machine_only()
    freed: dict[str, int] = {}
    with served():
        ours = used_by(os.getpid())
        readers = [Reader(number) for number in range(KILLED)]
        left = set().union(*(used_by(reader.process.pid) for reader in readers)) - ours
        for reader in readers:
            reader.close()
        begun = time.monotonic()
        # The server maps some of them, too, until it notices that the programs have ended.
        while _since(begun) < LONGEST:
            found = [one for one in leftovers(MEMORY, youngest=0) if one.name in left]
            freed |= {one.name: one.size for one in clear(found)}
            here = {one.name for one in found} | (left & used_by(os.getpid()))
            if not here:
                break
            time.sleep(0.2)
        seconds = _since(begun)
        Reader(KILLED).close()  # receives an image
        missing = [name for name in ours if "port" not in name and not (MEMORY / name).exists()]
    return Outcome(
        "readers of images get SIGKILL, then `doctor --clear-shared-memory`",
        f"{KILLED} programs",
        f"nothing: {sum(freed.values()) / 1e6:.1f} MB in {len(freed)} segments and ports are free again; the "
        "living server keeps its own, and a new reader receives",
        f"{seconds:.1f} s",
        bool(freed) and not missing and not here,
    )


def _since(begun: float) -> float:
    return time.monotonic() - begun


def used_by(pid: int) -> set[str]:
    """Return the names of the Fast DDS segments and ports that a process has mapped."""
    lines = Path(f"/proc/{pid}/maps").read_text().splitlines()
    return {Path(line.split()[-1]).name for line in lines if f"{MEMORY}/fastdds_" in line}
