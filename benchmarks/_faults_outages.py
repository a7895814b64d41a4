"""Faults of outages: a camera's cable or power, packets, a server, a reader, disk space."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress

from benchmarks._faults import Outcome, fault
from benchmarks._faults_strangers import CAMERA, FPS, served, streamed_through, watched
from grabbergui import sources
from grabbergui.core.errors import FrameTimeoutError
from grabbergui.core.features import FeatureValue
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import ConnectionState, FrameGrabber
from grabbergui.models.settings.feature_set import capture, compare
from grabbergui.net.yarp.os.name_client import NameClient

CHAPTER = "What goes away and comes back"
CABLE_CAMERA, POWER_CAMERA, LOSSY_CAMERA = "127.15.2.1", "127.15.2.2", "127.15.2.3"
TIMES = 5
AWAY_SECONDS = 3.0
LONG_AWAY_SECONDS = 15.0
"Longer than any wait that ends by itself within the program."
SLOW_SECONDS = 8.0
PATIENCE = 60.0
DISK_MEGABYTES = 400
SETTINGS: dict[str, FeatureValue] = {
    "ExposureTime": 5000.0,
    "Gain": 6.0,
    "GainAuto": "Off",
    "BinningVertical": 2,
    "Width": 320,
}
"Beside these the camera starts as it comes from its factory."


def simulate(address: str, *options: str) -> subprocess.Popen[str]:
    """Run a simulated GigE Vision camera in a process of its own."""
    command = [
        sys.executable,
        "-m",
        "grabbergui",
        "simulate",
        "--gige",
        address,
        "--camera",
        CAMERA,
        *options,
    ]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert address in process.stdout.readline(), f"no camera at {address}"
    return process


def end(process: subprocess.Popen[str]) -> None:
    process.kill()
    process.wait()
    if process.stdout is not None:
        process.stdout.close()


@contextmanager
def streaming(uri: str) -> Iterator[tuple[FrameGrabber, FrameQueue]]:
    """Open and start a camera, and receive its first second."""
    with closing(sources.create(uri)) as grabber:
        grabber.open()
        queue = grabber.open_queue(8)
        grabber.start()
        for _ in range(FPS):
            queue.get(PATIENCE)
        yield grabber, queue


def seconds_until_frame(queue: FrameQueue) -> float:
    """Return how long the next new frame takes to arrive."""
    begun = time.monotonic()
    while True:
        with suppress(FrameTimeoutError):
            queue.get(0)
            continue
        queue.get(PATIENCE)
        return time.monotonic() - begun


def until(condition: Callable[[], bool], what: str) -> None:
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline, f"{what} did not happen within {PATIENCE:.0f} s"
        time.sleep(0.05)


class Returns:
    """Collects the connection states that a grabber reports."""

    def __init__(self, grabber: FrameGrabber) -> None:
        self.lost = 0
        self.back: list[str] = []
        grabber.connection_changed.connect(self._take)

    def _take(self, state: ConnectionState, why: str) -> None:
        self.lost += state is ConnectionState.LOST
        if state is ConnectionState.OPEN:
            self.back.append(why)


@fault(CHAPTER)
def cable_pulled() -> Outcome:
    """Pause the camera's process, as if its cable were pulled and plugged in again."""
    waits = []
    with ExitStack() as stack:
        camera = simulate(CABLE_CAMERA)
        stack.callback(end, camera)
        grabber, queue = stack.enter_context(streaming(f"gige:{CABLE_CAMERA}"))
        returns = Returns(grabber)
        for pull in range(1, TIMES + 1):
            camera.send_signal(signal.SIGSTOP)
            until(lambda: returns.lost >= pull, "the loss")  # noqa: B023 - used at once
            time.sleep(AWAY_SECONDS)
            camera.send_signal(signal.SIGCONT)
            waits.append(seconds_until_frame(queue))
            until(lambda: len(returns.back) >= pull, "the return")  # noqa: B023
    return Outcome(
        f"a GigE Vision camera's cable is pulled for {AWAY_SECONDS:.0f} s (its process gets SIGSTOP)",
        f"{TIMES} times",
        "the frames during the outage",
        f"{max(waits):.1f} s at most, with images",
        set(returns.back) == {"set as before"},
    )


@fault(CHAPTER)
def power_lost() -> Outcome:
    """Replace the camera by another process at its address, with factory settings."""
    waits, unlike = [], []
    with ExitStack() as stack:
        running = [simulate(POWER_CAMERA)]
        stack.callback(lambda: end(running[0]))
        grabber, queue = stack.enter_context(streaming(f"gige:{POWER_CAMERA}"))
        for name, value in SETTINGS.items():
            grabber.write_feature(name, value)
        returns = Returns(grabber)
        before = capture(grabber)
        chosen = {name: grabber.feature(name).value for name in SETTINGS}  # the stream locks some of them
        for loss in range(1, TIMES + 1):
            end(running[0])
            until(lambda: returns.lost >= loss, "the loss")  # noqa: B023
            running[0] = simulate(POWER_CAMERA)
            waits.append(seconds_until_frame(queue))
            until(lambda: len(returns.back) >= loss, "the return")  # noqa: B023
            unlike += [str(difference) for difference in compare(before, capture(grabber))]
            unlike += [name for name, value in chosen.items() if grabber.feature(name).value != value]
    return Outcome(
        f"a GigE Vision camera with {len(SETTINGS)} settings loses its power (its process gets SIGKILL)",
        f"{TIMES} times",
        f"the frames during the outage; {len(unlike)} settings other than before",
        f"{max(waits):.1f} s at most from its power to images",
        not unlike and set(returns.back) == {"set as before"},
    )


@fault(CHAPTER)
def packets_lost() -> Outcome:
    with ExitStack() as stack:
        stack.callback(end, simulate(LOSSY_CAMERA, "--loss", "5%"))
        grabber, queue = stack.enter_context(streaming(f"gige:{LOSSY_CAMERA}"))
        before = grabber.statistics()
        time.sleep(10)
        after = grabber.statistics()
        waited = seconds_until_frame(queue)
    frames = after.frames - before.frames
    lost = after.lost + after.incomplete - before.lost - before.incomplete
    resent = after.packets_resent - before.packets_resent
    return Outcome(
        "every twentieth packet of a GigE Vision camera is lost",
        "for 10 s",
        f"{lost} of {frames + lost} frames; {resent} packets were sent again",
        f"{waited:.1f} s",
        resent > 0 and lost <= 0.02 * frames and frames > 0.9 * 10 * FPS,
    )


_READER = """
import sys, time
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.ports import InputPort
with InputPort("/slow", NameClient.find(sys.argv[1])) as port:
    port.connect("/cam", "fast_tcp")
    port.read(30)
    print("reads", flush=True)
    time.sleep(600)
"""


@fault(CHAPTER)
def frozen_reader() -> Outcome:
    with served() as names, watched(names) as watch:
        where = f"{names.server.host}:{names.server.port}"
        reader = subprocess.Popen([sys.executable, "-c", _READER, where], stdout=subprocess.PIPE, text=True)
        try:
            assert reader.stdout is not None
            assert "reads" in reader.stdout.readline()
            time.sleep(1)
            reader.send_signal(signal.SIGSTOP)
            begin = time.monotonic()
            time.sleep(SLOW_SECONDS)
            lost, well, held = streamed_through(watch, begin, time.monotonic())
        finally:
            end(reader)
    return Outcome(
        "a reader of the images freezes on YARP (SIGSTOP), while another reads on",
        f"for {SLOW_SECONDS:.0f} s",
        f"for the other reader {lost}",
        well,
        held,
    )


@fault(CHAPTER)
def server_away() -> Outcome:
    """Kill and restart the camera's server; the name server keeps running."""
    with ExitStack() as stack:
        names = stack.enter_context(served())
        process = serve_again(names)
        running = [process]
        stack.callback(lambda: end(running[0]))
        uri = f"yarp:/away?nameserver={names.server.host}:{names.server.port}"
        grabber, queue = stack.enter_context(streaming(uri))
        returns = Returns(grabber)
        end(running[0])
        until(lambda: returns.lost >= 1, "the loss")
        time.sleep(LONG_AWAY_SECONDS)
        running[0] = serve_again(names)
        waited = seconds_until_frame(queue)
        until(lambda: len(returns.back) >= 1, "the return")
    return Outcome(
        f"the server of a camera on YARP gets SIGKILL and is started again after {LONG_AWAY_SECONDS:.0f} s",
        "once",
        "the frames during the outage",
        f"{waited:.1f} s after it serves again, with images",
    )


def serve_again(names: NameClient) -> subprocess.Popen[str]:
    where = f"{names.server.host}:{names.server.port}"
    command = [sys.executable, "-m", "grabbergui", "serve", CAMERA, "--yarp", "/away", "--nameserver", where]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    assert process.stdout is not None
    assert any("serving" in line for line in iter(process.stdout.readline, ""))
    return process


_RECORD_ON_FULL_DISK = """
mount -t tmpfs -o size={size}m none {disk} && cd {disk} || exit
(sleep {seconds}; dd if=/dev/zero of=other bs=1M) &
timeout 60 {python} -m grabbergui record {camera} --out {name} --json
echo ended $?
timeout 60 {python} -m grabbergui grab file:{name} -n 25 --json
"""


@fault(CHAPTER)
def full_disk() -> Outcome:
    """Fill a disk in memory, in a mount namespace of its own. Needs root."""
    kept = []
    for name in ("movie.mp4", "messages.mcap", "images"):
        with tempfile.TemporaryDirectory() as disk:
            script = _RECORD_ON_FULL_DISK.format(
                size=DISK_MEGABYTES,
                disk=disk,
                seconds=SLOW_SECONDS,
                python=sys.executable,
                camera=f"'{CAMERA}'",
                name=name,
            )
            command = ["unshare", "--mount", "sh", "-c", script]
            done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        recorded, ended, *read = done.stdout.splitlines()
        assert ended == "ended 1", f"{name}: {done.stdout}"
        kept.append((name, json.loads(recorded)["frames"], bool(read)))
    return Outcome(
        "another program fills the disk while a movie, an MCAP file and a folder are recorded",
        "once each",
        "the frames after that; "
        + ", ".join(
            f"{name} {f'keeps {frames} frames' if read else 'cannot be read'}" for name, frames, read in kept
        ),
        "the recording ends and says why",
        all(frames and read for _, frames, read in kept),
    )
