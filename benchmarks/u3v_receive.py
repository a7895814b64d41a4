"""Receiving a USB3 Vision stream: our host and Aravis, on the same simulated camera.

In the virtual machine of the tests (a real USB stack under software emulation) the hosts stream in turn from
the camera on vhci-hcd. The camera is a Python program in the same guest and limits all hosts, so compare
ratios only. Outside the guest, camera and host run in one process without the kernel, which shows the cost
of our receiver.

    python -m benchmarks.u3v_receive [--seconds 4] [--no-vm]
"""

from __future__ import annotations

import argparse
import contextlib
import json
import re
import resource
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks import _document
from benchmarks._results import Chart, Goal, Section, Table, machine
from grabbergui.core.errors import FrameTimeoutError
from grabbergui.core.pfnc import by_name
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import TestPattern
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.u3v.backend import SimulatedBus
from grabbergui.driver.sim.u3v.device import SimulatedU3vDevice
from grabbergui.driver.u3v.device import U3vDevice

REPOSITORY = Path(__file__).parents[1]
USBVM = REPOSITORY / "tests/support/usbvm"
ROUNDS = 5
FORMATS = (("Mono8", 640, 480), ("Mono8", 4096, 2160), ("RGB8", 1920, 1080))
IN_PROCESS = "in the process"
IN_GUEST = "in the virtual machine"
NO_GUEST = 77
"""Exit code of `usbvm` if no virtual machine can run."""
MARK = "@result "
"""Prefix of each result on the guest's standard output."""
METHOD = """The hosts take turns to stream from the simulated camera, which sends a still pattern as fast as
it can, for {seconds:g} seconds each; in the virtual machine in {rounds} rounds, of which each host's median
counts. *{guest}*: a real Linux USB stack under software emulation, the camera on vhci-hcd, Aravis by
`arv-camera-test-0.8` with both of its `--usb-mode` settings. The camera is Python in the same guest and
limits them all, so only the ratios mean something. The emulation slows Python down by a factor of 18 and
compiled code by 10, to the disadvantage of this driver. *{process}*: camera and host in one process, without
a kernel in between."""


@dataclass(frozen=True)
class Result:
    """The figures of one host with one camera."""

    where: str
    image: str
    host: str
    payload: int
    "Payload of a frame, bytes."
    frames: int
    seconds: float
    cpu: float
    "CPU seconds of the host; of camera and host together if they share a process."

    @property
    def rate(self) -> float:
        return self.frames / self.seconds

    @property
    def bytes_per_second(self) -> float:
        return self.payload * self.rate

    @property
    def cpu_per_gb(self) -> float:
        return self.cpu / (self.frames * self.payload / 1e9) if self.frames else float("nan")


def fast_camera(name: str, width: int, height: int) -> CameraModel:
    """Return a camera without a frame rate limit, with a still pattern."""
    return CameraModel(
        power_on={
            reg.WIDTH: width,
            reg.HEIGHT: height,
            reg.OFFSET_X: 0,
            reg.OFFSET_Y: 0,
            reg.PIXEL_FORMAT: by_name(name).code,
            reg.EXPOSURE_TIME: 10.0,
            reg.FRAME_RATE_ENABLE: 0,
            reg.TEST_PATTERN: TestPattern.GREY_HORIZONTAL_RAMP,
        }
    )


def stream(camera: DeviceGrabber, seconds: float) -> tuple[int, float, float]:
    """Return frames, seconds and CPU seconds of this process, after the first frame."""
    queue = camera.open_queue(4)
    camera.start()
    queue.get(20.0)
    begun, cpu, frames = time.monotonic(), time.process_time(), 0
    while time.monotonic() < begun + seconds:
        with contextlib.suppress(FrameTimeoutError):
            frames += queue.get(1.0).complete
    result = frames, time.monotonic() - begun, time.process_time() - cpu
    camera.stop()
    queue.close()
    return result


def in_process(seconds: float) -> Iterator[Result]:
    """Run camera and host in one process, which measures both costs together."""
    for name, width, height in FORMATS:
        simulated = SimulatedU3vDevice(fast_camera(name, width, height))
        simulated.start()
        camera = DeviceGrabber(U3vDevice(backend=SimulatedBus(simulated)))
        camera.open()
        try:
            payload = simulated.model.memory.integer(reg.PAYLOAD_SIZE)
            yield Result(IN_PROCESS, f"{name} {width}×{height}", "ours", payload, *stream(camera, seconds))
        finally:
            camera.close()
            simulated.stop()


@contextlib.contextmanager
def camera_process(name: str, width: int, height: int) -> Iterator[None]:
    """Run the camera on the guest's virtual bus."""
    code = (
        "import sys, threading\n"
        "from benchmarks.u3v_receive import fast_camera\n"
        "from grabbergui.driver.sim.u3v.serve import serve\n"
        "stop = threading.Event()\n"
        "threading.Thread(target=lambda: (sys.stdin.read(), stop.set()), daemon=True).start()\n"
        f"serve('vhci', model=fast_camera({name!r}, {width}, {height}), stop=stop,\n"
        "      ready=lambda text: print(text, flush=True))\n"
    )
    command = [sys.executable, "-c", code]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(3)  # the kernel reads its descriptors
        yield
        assert process.stdin is not None
        process.stdin.close()


def aravis(mode: str, seconds: float) -> tuple[int, float, float]:
    """Return frames, seconds and CPU seconds of arv-camera-test, without the opening."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(["arv-tool-0.8", "control", "Width"], capture_output=True, check=False)
    opened = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = ["arv-camera-test-0.8", f"--usb-mode={mode}", "--duration", str(int(seconds))]
    text = subprocess.run(command, capture_output=True, text=True, check=False, errors="replace").stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)

    def cpu(usage: resource.struct_rusage) -> float:
        return usage.ru_utime + usage.ru_stime

    # It counts whole seconds from the start of its main loop; the first one includes the start-up.
    per_second = [int(count) for count in re.findall(r"(\d+) frames?/s", text)][1:]
    total = re.search(r"n_completed_buffers\s*=\s*(\d+)", text)
    spent = cpu(after) - cpu(opened) - (cpu(opened) - cpu(before))
    share = sum(per_second) / max(int(total.group(1)) if total else 1, 1)
    return sum(per_second), float(max(len(per_second), 1)), spent * share


def in_guest(seconds: float) -> Iterator[Result]:
    """Run every host on every format, inside the virtual machine."""
    for name, width, height in FORMATS:
        payload = by_name(name).image_bytes(width, height)
        image = f"{name} {width}×{height}"
        with camera_process(name, width, height):
            for _ in range(ROUNDS):
                if shutil.which("arv-camera-test-0.8"):
                    for mode in ("async", "sync"):
                        label = f"Aravis, {mode}"
                        yield Result(IN_GUEST, image, label, payload, *aravis(mode, seconds + 1))
                for label, transfers in (("ours, 64 in flight", 64), ("ours, synchronous", 1)):
                    camera = DeviceGrabber(U3vDevice(transfers_in_flight=transfers))
                    camera.open()
                    yield Result(IN_GUEST, image, label, payload, *stream(camera, seconds))
                    camera.close()


def from_guest(seconds: float) -> Iterator[Result]:
    """Run `in_guest` in the virtual machine; return nothing if none can run."""
    guest = [sys.executable, "-m", "benchmarks.u3v_receive", "--guest", "--seconds", str(seconds)]
    limit = str(int(120 + len(FORMATS) * ROUNDS * (30 + 8 * seconds)))
    command = [str(USBVM), "-t", limit, "--", *guest]
    with subprocess.Popen(command, cwd=REPOSITORY, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith(MARK):
                yield Result(**json.loads(line.removeprefix(MARK)))
            else:
                print(line, end="", flush=True)
    if process.returncode not in (0, NO_GUEST):
        raise SystemExit("not every host in the virtual machine was measured; let less else run here")


def measure(arguments: list[str] | None = None) -> Section:
    options = _options(arguments)
    before = machine()
    results = []
    for result in in_process(options.seconds):
        results.append(result)
        print(result, flush=True)
    for result in () if options.no_vm else from_guest(options.seconds):
        results.append(result)
        print(result, flush=True)
    results = typical(results)
    guest = [result for result in results if result.where == IN_GUEST]
    return Section(
        "USB3 Vision",
        "python -m benchmarks u3v_receive          # ten minutes; 15 seconds with --no-vm",
        METHOD.format(
            seconds=options.seconds,
            rounds=ROUNDS,
            guest=IN_GUEST.capitalize(),
            process=IN_PROCESS.capitalize(),
        ),
        [_table(results)],
        [_chart(guest)] if guest else [],
        _goals(guest),
        machine=before,
        lacking="" if guest else "the virtual machine",
    )


def typical(results: list[Result]) -> list[Result]:
    """Return the round of median rate, for each host and image.

    The median is fairer than the best round, as the load of the machine changes within minutes.
    """
    rounds: dict[tuple[str, str, str], list[Result]] = {}
    for result in results:
        rounds.setdefault((result.where, result.image, result.host), []).append(result)
    return [sorted(several, key=lambda one: one.rate)[len(several) // 2] for several in rounds.values()]


def _reference(results: list[Result], image: str) -> Result | None:
    """Return the result of Aravis's faster setting."""
    theirs = [result for result in results if result.host.startswith("Aravis") and result.image == image]
    return max(theirs, key=lambda result: result.rate, default=None)


def _table(results: list[Result]) -> Table:
    rows = []
    for result in results:
        reference = _reference(results, result.image) if result.where == IN_GUEST else None
        speed = f"{result.bytes_per_second / reference.bytes_per_second:.2f}" if reference else ""
        cost = f"{result.cpu_per_gb / reference.cpu_per_gb:.2f}" if reference else ""
        figures = [f"{result.rate:.1f}", f"{result.bytes_per_second / 1e6:.0f}", speed]
        figures += [f"{result.cpu_per_gb:.2f}", cost]
        rows.append([result.where, result.image, result.host, *figures])
    header = ["where", "image", "host", "frames/s", "MB/s", "× Aravis", "CPU s/GB", "× Aravis"]
    return Table(header, rows)


def _chart(results: list[Result]) -> Chart:
    images = list(dict.fromkeys(result.image for result in results))
    hosts = dict.fromkeys(result.host for result in results)
    by_key = {(result.host, result.image): result.bytes_per_second / 1e6 for result in results}
    return Chart(
        "u3v-throughput",
        "USB3 Vision through vhci-hcd in the virtual machine",
        "MB/s (the simulated camera limits them all)",
        images,
        {host: [by_key.get((host, image)) for image in images] for host in hosts},
    )


def _goals(results: list[Result]) -> list[Goal]:
    goals = []
    for image in dict.fromkeys(result.image for result in results):
        reference = _reference(results, image)
        ours = [result for result in results if result.host.startswith("ours") and result.image == image]
        if reference and ours:
            ratio = ours[0].bytes_per_second / reference.bytes_per_second
            asked = f"{image}: at least the throughput of Aravis's better setting"
            goals.append(Goal(asked, f"{ratio:.2f} ×", ratio >= 1))
    return goals


def _options(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=3.0, help="of each run")
    parser.add_argument("--no-vm", action="store_true", help="only what needs no virtual machine")
    parser.add_argument("--guest", action="store_true", help=argparse.SUPPRESS)
    return parser.parse_args(arguments)


def main() -> None:
    options = _options(None)
    if not options.guest:
        print(_document.markdown(measure()))
        return
    for result in in_guest(options.seconds):
        print(MARK + json.dumps(asdict(result)), flush=True)


if __name__ == "__main__":
    main()
