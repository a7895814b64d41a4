"""The receivers of `gige_wire`, each in a process of its own at the receiving end of the wire.

Costs are counted from the first frame or the first report on, without the start-up.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import closing, suppress
from dataclasses import asdict, dataclass
from functools import partial
from importlib.util import find_spec
from pathlib import Path

from benchmarks._wire import CAMERA, HOST, inside, network_seconds, process_seconds
from benchmarks._wire_cameras import Case
from grabbergui.core.errors import FeatureError, FrameTimeoutError

OURS, UNPRIVILEGED = "ours", "ours, no privilege"
WITHOUT_PRIVILEGE = ("setpriv", "--bounding-set=-all", "--inh-caps=-all")
STOCK_RECEIVE_BUFFER = 212_992
"`net.core.rmem_max` as Linux has it, bytes: the buffer of a socket that asks for nothing."
FAKE_WIDTH, FAKE_HEIGHT, FAKE_PERIOD, FAKE_ACQUISITION = 0x100, 0x104, 0x138, 0x124
"Registers of Aravis's fake camera, for a receiver that knows no features; the period in µs."
STREAM_PORT, STREAM_PACKET_SIZE, STREAM_ADDRESS = 0xD00, 0xD04, 0xD18
"GigE Vision 2.2, section 28: SCP0, SCPS0 and SCDA0."
DO_NOT_FRAGMENT = 1 << 30


@dataclass(frozen=True)
class Run:
    """What one receiver did."""

    frames: int
    lost: int
    process: float
    "CPU seconds of the receiving process."
    network: float
    "CPU seconds of the kernel's thread that receives packets."


@dataclass(frozen=True)
class Receiver:
    """A program that receives a stream."""

    name: str
    receive: Callable[[str, Case, float], Run]
    "Takes the namespace of the receiving end, the stream and the seconds to receive."
    compared: bool = True
    "Whether goals name it; the others take one turn."
    takes: Callable[[Case], bool] = lambda case: True


def receivers(aravis_prefix: Path | None) -> list[Receiver]:
    """Return this driver with and without privilege, and the peers that are installed."""
    found = [
        Receiver(OURS, partial(in_child, "ours")),
        Receiver(UNPRIVILEGED, partial(in_child, "ours", privilege=WITHOUT_PRIVILEGE)),
    ]
    versions = installed_aravis(aravis_prefix)
    for aravis in versions:
        for privileged in (True, False):
            name = aravis.name if privileged else f"{aravis.name}, no privilege"
            receive = partial(aravis.receive, privileged=privileged)
            found.append(Receiver(name, receive, compared=privileged or aravis is versions[-1]))
    if find_spec("viva_genicam"):
        viva = partial(in_child, "viva-genicam", privilege=WITHOUT_PRIVILEGE)
        found.append(Receiver("viva-genicam", viva, compared=False))
    if find_spec("pyGigEVision"):
        pure = partial(in_child, "pyGigEVision", privilege=WITHOUT_PRIVILEGE)
        # It knows formats of one and two bytes a pixel only.
        found.append(Receiver("pyGigEVision", pure, compared=False, takes=lambda case: not case.fast))
    return found


@dataclass(frozen=True)
class InstalledAravis:
    """Aravis's test program and where its libraries are."""

    program: str
    environment: dict[str, str]

    @property
    def name(self) -> str:
        done = subprocess.run(
            [self.program, "--version"], env=self.environment, capture_output=True, text=True
        )
        return f"Aravis {done.stdout.strip()}"

    def receive(self, host: str, case: Case, seconds: float, *, privileged: bool) -> Run:
        """Receive; count from the first report to the last, which the program gives every second.

        Its packet socket, which needs a privilege, is the default. Of the options beside it, real-time or
        high priority make the stream cost no less, and `-a` (a socket buffer as large as an image) concerns
        only plain sockets and is too small for images smaller than the default.
        """
        size = ["-w", str(case.width), "-h", str(case.height), "-f", str(case.rate)]
        packets = ["--gv-packet-size", str(case.packet_size), "--packet-size-adjustment=never"]
        automatic = ["-a"] if case.payload > STOCK_RECEIVE_BUFFER else []
        options = [] if privileged else ["--no-packet-socket", *automatic]
        command = [
            *inside(host),
            *(() if privileged else WITHOUT_PRIVILEGE),
            "stdbuf",
            "-oL",
            self.program,
        ]
        command += [*size, *packets, *options, "--duration", str(round(seconds) + 1)]
        used: list[tuple[float, float]] = []
        rates: list[int] = []
        counts: dict[str, int] = {}
        with subprocess.Popen(
            command, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        ) as process:
            assert process.stdout is not None
            for line in process.stdout:
                if report := re.match(r"\s*(\d+) frames?/s", line):
                    with suppress(OSError):  # the program may have ended
                        used.append((process_seconds(process.pid), network_seconds()))
                        rates.append(int(report[1]))
                elif count := re.search(r"n_(\w+)\s*=\s*(\d+)", line):
                    counts[count[1]] = int(count[2])
        if len(used) < 2:
            raise SystemExit(f"{self.program} received nothing")
        (process_before, network_before), (process_after, network_after) = used[0], used[-1]
        lost = counts.get("failures", 0) + counts.get("missing_frames", 0)
        return Run(sum(rates[1:]), lost, process_after - process_before, network_after - network_before)


def installed_aravis(prefix: Path | None) -> list[InstalledAravis]:
    """Return the system's Aravis, and the one below the prefix."""
    found = []
    if system := shutil.which("arv-camera-test-0.8"):
        found.append(InstalledAravis(system, dict(os.environ)))
    if prefix:
        programs = sorted((prefix / "bin").glob("arv-camera-test-*"))
        libraries = sorted(prefix.glob("lib*/**/libaravis-*.so"))
        if not programs or not libraries:
            raise SystemExit(f"{prefix} has no bin/arv-camera-test-* with its library")
        environment = {**os.environ, "LD_LIBRARY_PATH": str(libraries[-1].parent)}
        found.append(InstalledAravis(str(programs[-1]), environment))
    return found


def in_child(name: str, host: str, case: Case, seconds: float, *, privilege: tuple[str, ...] = ()) -> Run:
    """Run one of the functions of `IN_CHILD` at the receiving end."""
    arguments = [json.dumps(asdict(case)), str(seconds)]
    child = [sys.executable, "-m", "benchmarks._wire_receivers", name, *arguments]
    done = subprocess.run([*inside(host), *privilege, *child], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{name} failed: {done.stderr.strip().splitlines()[-1:]}")
    return Run(**json.loads(done.stdout.splitlines()[-1]))


def receive_ours(case: Case, seconds: float) -> Run:
    """Receive with this driver; count from the first frame on."""
    from grabbergui import sources

    with closing(sources.create(f"gige:{CAMERA}?packet_size={case.packet_size}")) as camera:
        camera.open()
        for name, value in (("Width", case.width), ("Height", case.height)):
            camera.write_feature(name, value)
        for name in ("AcquisitionFrameRate", "AcquisitionFrameRateAbs"):
            with suppress(FeatureError):
                camera.write_feature(name, case.rate)
        queue = camera.open_queue(4)
        camera.start()
        queue.get(10.0)
        before, cpu, network = camera.statistics(), time.process_time(), network_seconds(os.getppid())
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            with suppress(FrameTimeoutError):
                queue.get(0.5)
        cpu, network, after = (
            time.process_time() - cpu,
            network_seconds(os.getppid()) - network,
            camera.statistics(),
        )
    lost = after.incomplete - before.incomplete + after.lost - before.lost
    return Run(after.frames - before.frames, lost, cpu, network)


def receive_viva(case: Case, seconds: float) -> Run:
    """Receive with viva-genicam; count from the first frame on."""
    import viva_genicam

    found = {str(info.ip): info for _ in range(3) for info in viva_genicam.discover(iface=HOST)}
    with viva_genicam.connect_gige(found[CAMERA]) as camera:
        for name, value in (
            ("Width", case.width),
            ("Height", case.height),
            ("AcquisitionFrameRate", case.rate),
        ):
            camera.set(name, str(value))
        with camera.stream(packet_size=case.packet_size, deliver_incomplete=True) as frames:
            frames.next_frame()
            cpu, network, end = time.process_time(), network_seconds(os.getppid()), time.monotonic() + seconds
            complete = incomplete = 0
            while time.monotonic() < end:
                frame = frames.next_frame(timeout_ms=500)
                if frame is not None:
                    complete += frame.is_complete
                    incomplete += not frame.is_complete
            return Run(
                complete, incomplete, time.process_time() - cpu, network_seconds(os.getppid()) - network
            )


def receive_pygigevision(case: Case, seconds: float) -> Run:
    """Receive from Aravis's fake camera with pyGigEVision, by registers; count from the first frame on."""
    from pyGigEVision import GVCPClient, GVSPReceiver

    with GVCPClient(CAMERA) as camera:
        receiver = GVSPReceiver(HOST, gvcp_client=camera, packet_size=case.packet_size - 28)
        for register, value in (
            (FAKE_WIDTH, case.width),
            (FAKE_HEIGHT, case.height),
            (FAKE_PERIOD, round(1e6 / case.rate)),
            (STREAM_ADDRESS, int.from_bytes(bytes(map(int, HOST.split("."))), "big")),
            (STREAM_PORT, receiver.port),
            (STREAM_PACKET_SIZE, DO_NOT_FRAGMENT | case.packet_size),
        ):
            camera.write_reg(register, value)
        receiver.start()
        camera.write_reg(FAKE_ACQUISITION, 1)
        receiver.get_frame(10.0)
        cpu, network, end = time.process_time(), network_seconds(os.getppid()), time.monotonic() + seconds
        complete = incomplete = 0
        while time.monotonic() < end:
            taken = receiver.get_frame_with_info(0.5)
            if taken is not None:
                complete += taken[1]["complete"]
                incomplete += not taken[1]["complete"]
        run = Run(complete, incomplete, time.process_time() - cpu, network_seconds(os.getppid()) - network)
        camera.write_reg(FAKE_ACQUISITION, 0)
        receiver.close()
        return run


IN_CHILD: dict[str, Callable[[Case, float], Run]] = {
    "ours": receive_ours,
    "viva-genicam": receive_viva,
    "pyGigEVision": receive_pygigevision,
}


def main(name: str, case: str, seconds: str) -> None:
    done = IN_CHILD[name](Case(**json.loads(case)), float(seconds))
    print(json.dumps(asdict(done)))


if __name__ == "__main__":
    main(*sys.argv[1:])
