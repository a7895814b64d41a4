"""Runs inside the virtual machine: the simulated camera, hosts that others wrote, and our own.

Prints one line `RESULT <json>` for the test outside: what was seen, by kind of camera.
Usage: in_guest.py vhci gadget webcam
"""

from __future__ import annotations

import json
import multiprocessing
import os
import re
import shutil
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, cast

from grabbergui import sources
from grabbergui.core import compiled_loops
from grabbergui.core.errors import AckTimeoutError, GrabberError
from grabbergui.core.grabber import ConnectionState, FrameGrabber
from grabbergui.core.uri import SourceUri
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import TestPattern
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.u3v import registers
from grabbergui.driver.sim.u3v.device import U3vFaults
from grabbergui.driver.sim.u3v.serve import serve
from grabbergui.driver.u3v import device as u3v
from grabbergui.driver.v4l2 import device as v4l2

try:
    from viva_genicam import _camctl as viva
except ImportError:
    viva = None

SOON = 120.0
"""Seconds for one step: the emulated machine is slow, and slower where others use the real one too."""
ATTEMPTS = 4
"""So often a program may fail because the emulated machine answered too late."""
WIDTH, HEIGHT = 320, 240
"""The size of the simulated camera's images: many packets and several transfers each, soon copied."""
FRAMES = 25
"""Frames that our host receives each time that it streams."""
ENOUGH_FRAMES = 5
"""Frames that show that a host of others streams."""
FORKING = multiprocessing.get_context("fork")
CAMERAS: list[SpareCamera] = []
FORGETFUL: list[SpareProgram] = []
VIVA: list[SpareProgram] = []
VIVA_SAID = Path("/run/viva.txt")
"""The output of the programs in `VIVA`."""
LEFT_OPEN: list[object] = []
"""Cameras that a program does not close, still there when Python ends."""


class SpareCamera:
    """A process that becomes a camera when it is plugged in.

    It is forked at the beginning, while this program has no threads: to start and import again takes the
    emulated machine half a minute.
    """

    def __init__(self) -> None:
        self.ready, self.stop = FORKING.Event(), FORKING.Event()
        self._orders, orders = FORKING.Pipe()
        self.process = FORKING.Process(target=self._run, args=(orders,), daemon=True)
        self.process.start()

    def plug_in(self, via: str, faults: dict[str, int]) -> None:
        self._orders.send((via, faults))

    def _run(self, orders: Connection) -> None:
        via, faults = orders.recv()
        registers.RESPONSE_TIME_MS = 5000  # the emulated machine may pause for longer than a camera does
        model = CameraModel(
            power_on={
                reg.WIDTH: WIDTH,
                reg.HEIGHT: HEIGHT,
                reg.TEST_PATTERN: TestPattern.GREY_HORIZONTAL_RAMP,
            }
        )
        serve(
            via,
            model=model,
            faults=U3vFaults(**faults),
            stop=cast(threading.Event, self.stop),
            ready=lambda _: self.ready.set(),
        )


class SpareProgram:
    """A process that does `work` on command, forked likewise.

    It ends as any program does, by the end of its main module.
    """

    def __init__(self, work: Callable[[], None]) -> None:
        reading, self._writing = os.pipe()
        self._process = os.fork()
        if not self._process:
            os.read(reading, 1)
            work()
            sys.exit()

    def status(self) -> int:
        """Run it and return its exit status, negative for a signal."""
        os.write(self._writing, b"!")
        ended: list[int] = []

        def has_ended() -> bool:
            process, status = os.waitpid(self._process, os.WNOHANG)
            if process:
                ended.append(os.waitstatus_to_exitcode(status))
            return bool(process)

        wait_until(has_ended, "a program does not end")
        return ended[0]


@contextmanager
def plugged_in(via: str, **faults: int) -> Iterator[None]:
    """With a camera on the bus."""
    camera = CAMERAS.pop()
    camera.plug_in(via, faults)
    try:
        assert camera.ready.wait(SOON), "the camera does not start"
        wait_until(lambda: len(u3v.discover(1.0)) == 1, "the camera does not appear on the bus")
        yield
    finally:  # whatever failed before it, the next way finds an empty bus, and this program ends
        camera.stop.set()
        camera.process.join(SOON)
        camera.process.kill()
    wait_until(lambda: not u3v.discover(1.0), "the camera does not go")


def wait_until(condition: Callable[[], bool], complaint: str, timeout: float = SOON) -> None:
    deadline = time.monotonic() + timeout
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(complaint)
        time.sleep(0.1)


def run(*command: str, timeout: float = 40.0) -> str:
    """Another host's output. One that hangs is ended, and what it said so far counts.

    (Aravis 0.8.26 now and then waits for ever for its cancelled transfers on a gadget of dummy_hcd.)
    """
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as host:
        try:
            return host.communicate(timeout=timeout)[0]
        except subprocess.TimeoutExpired:
            host.kill()
            return host.communicate()[0]


def opened(uri: str) -> FrameGrabber:
    """Our own host's camera; opened again where the emulated machine answered too late."""
    for tries_left in reversed(range(8)):
        camera = u3v.create(SourceUri.parse(uri))
        try:
            camera.open()
            break
        except AckTimeoutError as error:
            camera.close()
            if not tries_left:
                raise
            print(f"opened again, because {error}", flush=True)
    return camera


def our_host(result: dict[str, Any]) -> None:
    """List, read, set, stream."""
    result["listed"] = [info.as_dict() for info in u3v.discover(1.0)]
    camera = opened("u3v:SIM001")
    try:
        result["exposure_set_by_aravis"] = camera.feature("ExposureTime").value
        camera.write_feature("ExposureTime", 4000.0)
        for _ in range(2):  # the stream is started a second time on what the first left
            queue = camera.open_queue(4)
            camera.start()
            good = 0
            for _ in range(FRAMES):
                frame = queue.get(60.0)
                good += frame.complete and bool((frame.raw() == frame.raw()[0]).all())
            camera.stop()
            queue.close()
            result.setdefault("good_frames", []).append(good)
            result["statistics"] = camera.statistics().as_dict()
    finally:
        camera.close()


def stream_and_close_nothing() -> None:
    """What a forgetful program does."""
    camera = u3v.create(SourceUri.parse("u3v:"))
    camera.open()
    queue = camera.open_queue()
    camera.start()
    queue.get(60.0)
    LEFT_OPEN.extend((camera, queue))


def forgetful_program() -> int:
    """The exit status of a program that ends while it streams, without closing anything.

    An exception, e.g. of an answer that came too late, is 1, a crash is not.
    """
    for _ in range(ATTEMPTS):
        status = FORGETFUL.pop().status()
        if status != 1:
            break
    return status


def aravis(*command: str) -> str:
    """Return the output of a program of Aravis; run again where the emulated machine answered too late."""
    for _ in range(8):
        text = run(*command)
        if "Failed to bootstrap" not in text:
            break
    return text


def aravis_streams(mode: str) -> dict[str, int]:
    """Return Aravis's counters of a stream without failures, or with the first failures that it counts.

    It streams once more, and for longer, where the emulated machine was too slow for a few frames, or where
    it hung before it said its counters (see `run`).
    """
    counters: dict[str, int] = {}
    for seconds in ("1", "4"):
        text = aravis("arv-camera-test-0.8", f"--usb-mode={mode}", "--duration", seconds)
        counters = {name: int(count) for name, count in re.findall(r"(n_\w+)\s*=\s*(\d+)", text)}
        failed = counters.get("n_failures") or counters.get("n_ignored_bytes")
        if failed or counters.get("n_completed_buffers", 0) >= ENOUGH_FRAMES:
            break
    return counters


def list_and_read_by_viva() -> None:
    """Do what two calls of viva-camctl do, whose start takes the emulated machine longer than the work."""
    said = os.open(VIVA_SAID, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(said, 1)
    os.dup2(said, 2)
    viva.main(["list-usb"])
    viva.main(["get", "--usb", "0", "--name", "PayloadSize"])


def other_hosts(result: dict[str, Any]) -> None:
    """Aravis and viva-genicam, where they are installed."""
    if VIVA:
        VIVA.pop().status()
        result["viva"] = VIVA_SAID.read_text()
    if shutil.which("arv-tool-0.8"):
        result["aravis_list"] = aravis("arv-tool-0.8")
        result["aravis_set"] = aravis("arv-tool-0.8", "control", "ExposureTime=3000", "Width")
        result["aravis"] = {mode: aravis_streams(mode) for mode in ("sync", "async")}


def unplugged_while_streaming(via: str) -> dict[str, Any]:
    """The camera is unplugged after ten frames; the host reports it, and opens the next one."""
    reported: list[str] = []
    with plugged_in(via, unplug_after_frames=10):
        camera = opened("u3v:")

        def on_change(state: ConnectionState, reason: str) -> None:
            if state is ConnectionState.LOST:
                reported.append(reason)

        camera.connection_changed.connect(on_change)
        camera.start()
        wait_until(lambda: bool(reported), "the unplugging is not noticed")
        try:
            camera.feature("Width")
            refused = ""
        except GrabberError as error:
            refused = type(error).__name__
        camera.close()
    return {"reported": reported, "refused": refused}


def replaced_after_a_kill(via: str) -> bool:
    """What a killed camera leaves in configfs, which Linux takes from the bus, makes room for the next."""
    camera = CAMERAS.pop()
    camera.plug_in(via, {})
    assert camera.ready.wait(SOON), "the camera does not start"
    wait_until(lambda: len(u3v.discover(1.0)) == 1, "the camera does not appear on the bus")
    camera.process.kill()
    wait_until(lambda: not u3v.discover(1.0), "the killed camera does not go")
    with plugged_in(via):
        return True


def prove(via: str) -> dict[str, Any]:
    """One way of being a USB device, before all hosts."""
    result: dict[str, Any] = {}
    try:
        with plugged_in(via):
            other_hosts(result)
            our_host(result)
            result["forgetful_exit"] = forgetful_program()
            if shutil.which("arv-tool-0.8"):
                result["aravis_reads"] = aravis("arv-tool-0.8", "control", "ExposureTime")
        if via == "vhci":
            result["unplugged"] = unplugged_while_streaming(via)
        if via == "gadget":
            result["replaced"] = replaced_after_a_kill(via)
    except Exception as error:
        result["failure"] = f"{type(error).__name__}: {error}"
    return result


def prove_webcam() -> dict[str, Any]:
    """Return our host's view of the kernel's virtual video device (vivid), beside v4l2-ctl's."""
    try:
        return try_webcam()
    except Exception:
        return {"failure": traceback.format_exc()}


def try_webcam() -> dict[str, Any]:
    (info,) = v4l2.discover(1.0)
    result: dict[str, Any] = {"info": info.as_dict(), "formats": {}}
    camera = sources.create("v4l2:")
    camera.open()
    try:
        for name in ("YUV422_8", "BGR8", "Mono8", "Mono16"):
            camera.write_feature("PixelFormat", name)
            result["formats"][name] = grabbed(camera)
        camera.write_feature("Brightness", 77)
        result["brightness by v4l2-ctl"] = v4l2_ctl("--get-ctrl", "brightness")
        v4l2_ctl("--set-ctrl", "brightness=99")
        result["brightness by us"] = camera.feature("Brightness").value
        camera.write_feature("Resolution", "R320x180")
        camera.write_feature("AcquisitionFrameRate", 5.0)
        result["format by v4l2-ctl"] = v4l2_ctl("--get-fmt-video", "--get-parm")
        camera.start()
        result["another program"] = refusal()
        lost: list[str] = []
        camera.connection_changed.connect(lambda state, why: lost.append(f"{state.value}: {why}"))
        with suppress(GrabberError):  # vivid's own: the device is gone, also for the answer
            camera.execute("Disconnect")
        wait_until(lambda: bool(lost), "the loss is not noticed")
        result["lost"] = lost[0]
    finally:
        camera.close()
    return result


def grabbed(camera: FrameGrabber) -> dict[str, Any]:
    """Three frames of a format."""
    queue = camera.open_queue()
    camera.start()
    frames = [queue.get(SOON) for _ in range(3)]
    camera.stop()
    queue.close()
    last = frames[-1]
    return {
        "ids": [frame.frame_id for frame in frames],
        "shape": last.raw().shape,
        "brightness": float(last.rgb().mean()),
        "contrast": float(last.rgb().std()),
    }


def v4l2_ctl(*arguments: str) -> str | None:
    """Return the output of v4l2-ctl; None without it."""
    program = shutil.which("v4l2-ctl")
    return run(program, "-d", "/dev/video0", *arguments) if program else None


def refusal() -> str:
    """The error that a second program gets when it wants to stream as well."""
    second = sources.create("v4l2:/dev/video0")
    second.open()
    try:
        second.start()
    except GrabberError as error:
        return f"{type(error).__name__}: {error}"
    finally:
        second.close()
    return ""


if __name__ == "__main__":
    compiled_loops.disable(True)  # emulated, numba's compiler takes longer than all tests here
    FORGETFUL = [SpareProgram(stream_and_close_nothing) for _ in range(ATTEMPTS * 2)]
    if viva is not None:
        VIVA = [SpareProgram(list_and_read_by_viva) for _ in range(2)]
    CAMERAS = [SpareCamera() for _ in range(5)]
    results = {via: prove_webcam() if via == "webcam" else prove(via) for via in sys.argv[1:]}
    print("RESULT " + json.dumps(results), flush=True)
