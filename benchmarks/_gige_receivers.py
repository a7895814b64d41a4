"""The GigE Vision receivers to compare: this driver, Aravis and viva-genicam, each in a process."""

from __future__ import annotations

import contextlib
import functools
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from importlib.util import find_spec
from pathlib import Path

from benchmarks._gige_camera import ADDRESS, PAYLOAD
from grabbergui.core.errors import FrameTimeoutError

ARAVIS = "arv-camera-test-0.8"
SYSTEM_PYTHON = "/usr/bin/python3"
"The Python that has PyGObject and Aravis's bindings, if they are installed."
FRAME_TIMEOUT = 0.5
STOCK_RECEIVE_BUFFER = 212_992
"`net.core.rmem_max` as Linux has it."


class ReceiverError(Exception):
    """A receiver failed before it received anything."""


@dataclass(frozen=True)
class Run:
    """The frames, time and memory of one receiver."""

    complete: int
    incomplete: int
    "Frames that were incomplete or missing."
    seconds: float
    cpu: float
    "CPU seconds of the receiving process."
    memory: int = 0
    "Peak memory in bytes."
    arrivals: dict[str, float] = field(default_factory=dict)
    "Time at which the consumer got each frame (`time.monotonic`), by block id."
    resent: int = 0
    "Packets received after a resend request, if the receiver reports them."

    @property
    def frames_per_second(self) -> float:
        return self.complete / self.seconds

    @property
    def cpu_per_gb(self) -> float:
        return self.cpu / max(self.complete * PAYLOAD / 1e9, 1e-9)


Receiver = Callable[[int, float], Run]
"Takes the packet size in bytes and the duration in seconds."


def receive_ours(packet_size: int, seconds: float, options: str = "") -> Run:
    """Receive with this driver; count from the first frame on."""
    from grabbergui import sources

    camera = sources.create(f"gige:{ADDRESS}?packet_size={packet_size}{options}")
    camera.open()
    queue = camera.open_queue(4)
    camera.start()
    queue.get(10.0)
    arrivals: dict[str, float] = {}
    begun, cpu, before = time.monotonic(), time.process_time(), camera.statistics()
    while time.monotonic() < begun + seconds:
        with contextlib.suppress(FrameTimeoutError):
            frame = queue.get(FRAME_TIMEOUT)
            arrivals[str(frame.frame_id)] = time.monotonic()
    cpu, after = time.process_time() - cpu, camera.statistics()
    took = time.monotonic() - begun
    camera.close()
    lost = after.incomplete - before.incomplete + after.lost - before.lost
    resent = after.packets_resent - before.packets_resent
    return Run(after.frames - before.frames, lost, took, cpu, 0, arrivals, resent)


def receive_in_window(packet_size: int, seconds: float) -> Run:
    """Receive with this driver while the window paints, with the kernel's default buffer limit."""
    os.environ["QT_QPA_PLATFORM"] = "offscreen"
    from PyQt5.QtCore import QTimer

    from grabbergui.driver.gige.stream import sockets
    from grabbergui.ui.application import application
    from grabbergui.ui.preferences import Preferences
    from grabbergui.ui.run.program import Program
    from grabbergui.ui.views.main_window import MainWindow

    def grant_little(receiver: socket.socket, wanted: int) -> None:
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, min(wanted, STOCK_RECEIVE_BUFFER))

    sockets._grow_buffer = grant_little
    app = application()
    window = MainWindow()
    program = Program(window, Preferences(None))
    painted: list[float] = []
    window.image.painted.connect(lambda: painted.append(time.monotonic()))
    window.image.painted.connect(lambda: app.quit() if len(painted) == 30 else None)
    window.show()
    program.begin(f"gige:{ADDRESS}?packet_size={packet_size}")
    app.exec_()
    assert program.open_sources.current is not None and program.open_sources.current.grabber is not None
    camera = program.open_sources.current.grabber
    begun, cpu, before = time.monotonic(), time.process_time(), camera.statistics()
    QTimer.singleShot(round(1000 * seconds), app.quit)
    app.exec_()
    cpu, after = time.process_time() - cpu, camera.statistics()
    took = time.monotonic() - begun
    window.close()
    program.shut_down(10)
    lost = after.incomplete - before.incomplete + after.lost - before.lost
    shown = {str(index): at for index, at in enumerate(painted) if at >= begun}
    resent = after.packets_resent - before.packets_resent
    return Run(after.frames - before.frames, lost, took, cpu, 0, shown, resent)


def receive_viva(packet_size: int, seconds: float) -> Run:
    """Receive with viva-genicam; count from the first frame on."""
    import viva_genicam

    found = {str(info.ip): info for _ in range(3) for info in viva_genicam.discover(all=True)}
    with (
        viva_genicam.connect_gige(found[ADDRESS]) as camera,
        camera.stream(packet_size=packet_size, deliver_incomplete=True) as frames,
    ):
        frames.next_frame()
        arrivals: dict[str, float] = {}
        incomplete = 0
        begun, cpu = time.monotonic(), time.process_time()
        while time.monotonic() < begun + seconds:
            frame = frames.next_frame(timeout_ms=round(1000 * FRAME_TIMEOUT))
            if frame is None:
                continue
            if frame.is_complete:
                arrivals[str(frame.block_id)] = time.monotonic()
            else:
                incomplete += 1
        took, cpu = time.monotonic() - begun, time.process_time() - cpu
        return Run(len(arrivals), incomplete, took, cpu, 0, arrivals)


IN_CHILD: dict[str, Receiver] = {
    "ours": receive_ours,
    "window": receive_in_window,
    "viva-genicam": receive_viva,
}


def in_child(name: str, packet_size: int, seconds: float) -> Run:
    """Run one of the functions above in a process of its own."""
    command = [sys.executable, "-m", "benchmarks._gige_receivers", name, str(packet_size), str(seconds)]
    text, _, memory = _measured(command)
    return Run(**{**json.loads(text.splitlines()[-1]), "memory": memory})


def run_aravis(packet_size: int, seconds: float) -> Run:
    """Run arv-camera-test; subtract the CPU time of opening, which is measured separately."""
    _, opening, _ = _measured(["arv-tool-0.8", "-a", ADDRESS, "control", "Width"])
    command = [ARAVIS, "-n", ADDRESS, "--no-packet-socket", "-a", "-i", str(packet_size)]
    text, cpu, memory = _measured([*command, "--duration", str(int(seconds) + 1)])
    rates = re.findall(r"(\d+) frames?/s", text)
    counts = {
        name: int(count) for name, count in re.findall(r"n_(completed_buffers|failures)\s*=\s*(\d+)", text)
    }
    complete, incomplete = counts.get("completed_buffers", 0), counts.get("failures", 0)
    return Run(complete, incomplete, max(len(rates), 1), max(cpu - opening, 0.0), memory)


def time_aravis(packet_size: int, seconds: float) -> Run:
    """Receive with Aravis's Python binding, which times each frame; without it, raise ReceiverError."""
    check = [SYSTEM_PYTHON, "-c", "import gi; gi.require_version('Aravis', '0.8')"]
    if not Path(SYSTEM_PYTHON).exists() or subprocess.run(check, capture_output=True).returncode:
        raise ReceiverError("python3-gi and gir1.2-aravis-0.8 are not installed")
    script = str(Path(__file__).with_name("_aravis_receiver.py"))
    text, cpu, memory = _measured([SYSTEM_PYTHON, script, ADDRESS, str(packet_size), str(seconds)])
    arrivals = json.loads(text.splitlines()[-1])
    return Run(len(arrivals), 0, seconds, cpu, memory, arrivals)


def _measured(command: list[str]) -> tuple[str, float, int]:
    """Return a command's standard output, its CPU seconds and its peak memory in bytes."""
    with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as errors:
        process = subprocess.Popen(command, stdout=output, stderr=errors)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        errors.seek(0)
        if process.returncode and command[0] == sys.executable:
            last = errors.read().decode(errors="replace").strip().splitlines()[-1:]
            raise ReceiverError(f"{' '.join(command[2:4])} failed: {last}")
        output.seek(0)
        text = output.read().decode(errors="replace")
    return text, usage.ru_utime + usage.ru_stime, usage.ru_maxrss << 10


def receivers() -> dict[str, Receiver]:
    """Return the receivers for rates and costs."""
    found: dict[str, Receiver] = {"ours": functools.partial(in_child, "ours")}
    if shutil.which(ARAVIS):
        found["Aravis"] = run_aravis
    if find_spec("viva_genicam"):
        found["viva-genicam"] = functools.partial(in_child, "viva-genicam")
    return found


def timed_receivers() -> dict[str, Receiver]:
    """Return the receivers for latencies, which give the time of each frame."""
    found = receivers()
    if "Aravis" in found:
        found["Aravis"] = time_aravis
    return found


if __name__ == "__main__":
    print(json.dumps(asdict(IN_CHILD[sys.argv[1]](int(sys.argv[2]), float(sys.argv[3])))))
