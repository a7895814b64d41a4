"""Receiving a USB3 Vision stream: our host and Aravis, on the same simulated camera.

In the virtual machine of the tests (a real USB stack under software emulation) each host streams in turn
from the camera on vhci-hcd. The camera is Python in the same guest and bounds them all, so only the ratios
mean something. Here, without a kernel between, the camera's bus within the process shows what our receiver
costs.

    python -m benchmarks.u3v_receive [--seconds 4] [--no-vm]
"""

from __future__ import annotations

import argparse
import contextlib
import re
import resource
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from grabbergui.core.errors import FrameTimeoutError
from grabbergui.core.pfnc import by_name
from grabbergui.driver.camera import Camera
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.u3v.backend import SimulatedBus
from grabbergui.driver.sim.u3v.device import SimulatedU3vDevice
from grabbergui.driver.u3v.device import U3vDevice

REPOSITORY = Path(__file__).parents[1]
USBVM = REPOSITORY / "tests/driver/u3v/usbvm"
FORMATS = (("Mono8", 640, 480), ("Mono8", 2448, 2048), ("RGB8", 2448, 2048))


def fast_camera(name: str, width: int, height: int) -> CameraModel:
    """A camera as fast as it can: a still pattern, no frame rate asked for."""
    return CameraModel(
        power_on={
            reg.WIDTH: width,
            reg.HEIGHT: height,
            reg.OFFSET_X: 0,
            reg.OFFSET_Y: 0,
            reg.PIXEL_FORMAT: by_name(name).code,
            reg.EXPOSURE_TIME: 10.0,
            reg.FRAME_RATE_ENABLE: 0,
            reg.TEST_PATTERN: reg.TestPattern.GREY_HORIZONTAL_RAMP,
        }
    )


def stream(camera: Camera, seconds: float) -> tuple[int, float, float]:
    """Frames, seconds and seconds of this process's CPU, after the first frame."""
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


def row(
    label: str, frames: int, payload: int, seconds: float, cpu: float, best: float | None = None
) -> float:
    """Print a result; gives its bytes a second."""
    rate = frames * payload / seconds
    each = cpu / (frames * payload / 1e9) if frames else float("nan")
    ratio = f"{rate / best:6.2f} × Aravis async" if best else ""
    print(
        f"  {label:24} {frames / seconds:7.1f} fps {rate / 1e6:8.1f} MB/s {each:7.2f} CPU s/GB {ratio}",
        flush=True,
    )
    return rate


def in_process(seconds: float) -> None:
    """Camera and host in one process: both costs together."""
    print("on a bus within the process (CPU of camera and host)")
    for name, width, height in FORMATS:
        simulated = SimulatedU3vDevice(fast_camera(name, width, height))
        simulated.start()
        camera = Camera(U3vDevice(backend=SimulatedBus(simulated)))
        camera.open()
        try:
            payload = simulated.model.memory.integer(reg.PAYLOAD_SIZE)
            row(f"{name} {width}x{height}", *_with_payload(stream(camera, seconds), payload))
        finally:
            camera.close()
            simulated.stop()


def _with_payload(result: tuple[int, float, float], payload: int) -> tuple[int, int, float, float]:
    frames, took, cpu = result
    return frames, payload, took, cpu


# -- in the guest ------------------------------------------------------------------------------------
@contextlib.contextmanager
def camera_process(name: str, width: int, height: int) -> Iterator[None]:
    """The camera on the guest's virtual bus."""
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
    """Frames, seconds, CPU seconds of a run of arv-camera-test, its opening subtracted."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(["arv-tool-0.8", "control", "Width"], capture_output=True, check=False)
    opened = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = ["arv-camera-test-0.8", f"--usb-mode={mode}", "--duration", str(int(seconds))]
    text = subprocess.run(command, capture_output=True, text=True, check=False, errors="replace").stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)

    def cpu(usage: resource.struct_rusage) -> float:
        return usage.ru_utime + usage.ru_stime

    # It counts from the start of its main loop, whole seconds; the first has the start-up in it.
    per_second = [int(count) for count in re.findall(r"(\d+) frames?/s", text)][1:]
    total = re.search(r"n_completed_buffers\s*=\s*(\d+)", text)
    spent = cpu(after) - cpu(opened) - (cpu(opened) - cpu(before))
    share = sum(per_second) / max(int(total.group(1)) if total else 1, 1)
    return sum(per_second), float(max(len(per_second), 1)), spent * share


def in_guest(seconds: float) -> None:
    """Every host on every format; only called inside the virtual machine."""
    for name, width, height in FORMATS:
        payload = by_name(name).image_bytes(width, height)
        print(f"{name} {width}x{height} through vhci-hcd, in the virtual machine", flush=True)
        with camera_process(name, width, height):
            best = None
            if shutil.which("arv-camera-test-0.8"):
                best = row("Aravis async", *_with_payload(aravis("async", seconds + 1), payload))
                row("Aravis sync", *_with_payload(aravis("sync", seconds + 1), payload), best)
            for label, transfers in (("ours, 64 in flight", 64), ("ours, synchronous", 1)):
                camera = Camera(U3vDevice(transfers_in_flight=transfers))
                camera.open()
                row(label, *_with_payload(stream(camera, seconds), payload), best)
                camera.close()


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=4.0, help="of each run")
    parser.add_argument("--no-vm", action="store_true", help="only what needs no virtual machine")
    parser.add_argument("--guest", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.guest:
        in_guest(options.seconds)
        return
    in_process(options.seconds)
    if not options.no_vm:
        guest = [sys.executable, "-m", "benchmarks.u3v_receive", "--guest", "--seconds", str(options.seconds)]
        limit = str(int(90 + len(FORMATS) * (30 + 6 * options.seconds)))
        subprocess.run([str(USBVM), "-t", limit, "--", *guest], cwd=REPOSITORY, check=False)


if __name__ == "__main__":
    main()
