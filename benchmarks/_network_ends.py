"""The processes of `both_networks`: a server of a camera, and independent readers.

Each end obeys messages on its pipe, so that one set of processes serves every measurement. Times are
nanoseconds of the system's clock, which all of them share.
"""

from __future__ import annotations

import os
import resource
import threading
import time
from contextlib import ExitStack
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from grabbergui import sources
from grabbergui.core.errors import FrameTimeoutError
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import NameServer
from grabbergui.net.yarp.os.ports import InputPort
from grabbergui.net.yarp.os.stamp import Stamp
from grabbergui.net.yarp.server import YarpGrabberServer

YARP_NAME, ROS2_NAME = "/benchmark", "/benchmark"
SENSOR_THREAD = "simulated camera"


@dataclass(frozen=True)
class Served:
    """Frames and CPU time of the serving process between `"begin"` and `"end"`."""

    stamps: list[int]
    "Stamps of all exposed frames."
    lost: int
    "Frames lost between the camera and the server."
    cpu: float
    "CPU seconds of the process."
    sensor_cpu: float
    "CPU seconds of the simulated camera, a part of `cpu`."
    memory: int
    "Resident memory in bytes."


def serve(pipe: Connection, uri: str, with_ros2: bool, with_yarp: bool = True) -> None:
    """Share a camera on the networks until None arrives.

    Answers `("size", width, height, rate)` with the resulting size, `"begin"` with None, and `"end"` with
    a `Served`.
    """
    with ExitStack() as stack:
        names = NameServer("127.0.0.1", 0)
        names.open()
        stack.callback(names.close)
        address = f"127.0.0.1:{names.port_number}"
        grabber = sources.create(uri)
        grabber.open()
        stack.callback(grabber.close)
        grabber.start()
        if with_yarp:
            stack.enter_context(YarpGrabberServer(grabber, YARP_NAME, names=NameClient.find(address)))
        if with_ros2:
            from grabbergui.net.ros2.server import Ros2GrabberServer

            stack.enter_context(Ros2GrabberServer(grabber, ROS2_NAME))
        pipe.send(address)
        stamps = _Stamps(grabber.open_queue(16))
        stack.callback(stamps.stop)
        while (order := pipe.recv()) is not None:
            if order == "begin":
                stamps.clear()
                cpu, sensor_cpu = cpu_seconds(), thread_cpu_seconds(SENSOR_THREAD)
                lost = frames_lost(grabber)
                pipe.send(None)
            elif order == "end":
                used = cpu_seconds() - cpu, thread_cpu_seconds(SENSOR_THREAD) - sensor_cpu
                pipe.send(Served(stamps.taken(), frames_lost(grabber) - lost, *used, resident_bytes()))
            else:
                grabber.stop()
                for name, value in zip(("Width", "Height", "AcquisitionFrameRate"), order[1:], strict=True):
                    grabber.write_feature(name, value)
                grabber.start()
                pipe.send(tuple(int(str(grabber.feature(name).value)) for name in ("Width", "Height")))


class _Stamps:
    """Records when each frame was exposed."""

    def __init__(self, queue: FrameQueue) -> None:
        self._queue = queue
        self._stamps: list[int] = []
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def clear(self) -> None:
        self._stamps = []

    def taken(self) -> list[int]:
        return list(self._stamps)

    def stop(self) -> None:
        self._queue.close()
        self._thread.join()

    def _run(self) -> None:
        while not self._queue.closed:
            try:
                self._stamps.append(self._queue.get(0.5).received_ns)
            except FrameTimeoutError:
                continue


Arrivals = list[tuple[int, int]]
"""Stamp and arrival time of each image, nanoseconds."""


@dataclass(frozen=True)
class Read:
    """Frames of one reader between `"join"` and `"leave"`."""

    arrivals: Arrivals
    cores: float
    "CPU seconds per second."


def read_yarp(pipe: Connection, number: int, nameserver: str) -> None:
    """Read images as any YARP program does; see `_obey`."""
    arrivals: Arrivals = []
    names = NameClient.find(nameserver)
    ended = threading.Event()
    port = InputPort(f"/benchmark/reader{number}", names, depth=2)
    with port:

        def take() -> None:
            while not ended.is_set():
                try:
                    _, envelope = port.read(0.2)
                except FrameTimeoutError:
                    continue
                stamp = Stamp.decode(envelope)
                assert stamp is not None
                arrivals.append((round(stamp.time * 1e9), time.time_ns()))

        thread = threading.Thread(target=take)
        thread.start()
        _obey(pipe, arrivals, lambda: port.connect(YARP_NAME), lambda: port.disconnect(YARP_NAME))
        ended.set()
        thread.join()


def read_ros2(pipe: Connection, number: int, nameserver: str) -> None:
    """Read images as any rclpy program does, with the transport's profile; see `_obey`."""
    from sensor_msgs.msg import Image

    from grabbergui.net.ros2.runtime import Ros2Node, quality_of_service

    arrivals: Arrivals = []
    ros = Ros2Node(f"benchmark_reader{number}")
    quality = quality_of_service("sensor_data")
    subscriptions: list[Any] = []

    def take(message: Image) -> None:
        stamp = message.header.stamp
        arrivals.append((stamp.sec * 1_000_000_000 + stamp.nanosec, time.time_ns()))

    ros.start()
    _obey(
        pipe,
        arrivals,
        lambda: subscriptions.append(
            ros.node.create_subscription(Image, f"{ROS2_NAME}/image_raw", take, quality)
        ),
        lambda: ros.node.destroy_subscription(subscriptions.pop()),
    )
    ros.close()


def _obey(pipe: Connection, arrivals: Arrivals, join: Any, leave: Any) -> None:
    """Answer `"join"` after the first image and `"leave"` with a `Read`; return on None."""
    pipe.send(None)
    cpu, since = 0.0, time.monotonic()
    while (order := pipe.recv()) is not None:
        if order == "join":
            arrivals.clear()
            join()
            deadline = time.monotonic() + 20
            while not arrivals and time.monotonic() < deadline:
                time.sleep(0.005)
            cpu, since = cpu_seconds(), time.monotonic()
            pipe.send(None)
        else:
            leave()
            cores = (cpu_seconds() - cpu) / (time.monotonic() - since)
            pipe.send(Read(list(arrivals), cores))


def frames_lost(grabber: FrameGrabber) -> int:
    """Return the frames that the camera's stream lost, regardless of later losses."""
    statistics = grabber.statistics()
    return statistics.incomplete + statistics.lost + statistics.underruns


def cpu_seconds() -> float:
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def cpu_seconds_of(pid: int) -> float:
    """Return the CPU seconds that another process has used, all its threads (Linux, proc(5))."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def thread_cpu_seconds(name: str) -> float:
    """Return the CPU seconds of the running threads whose names have this prefix."""
    used = 0.0
    for thread in threading.enumerate():
        if thread.name.startswith(name) and thread.native_id is not None:
            used += time.clock_gettime(_thread_clock(thread.native_id))
    return used


def _thread_clock(native_id: int) -> int:
    """Return Linux's CPU clock id of a thread of this process (MAKE_THREAD_CPUCLOCK, CPUCLOCK_SCHED)."""
    return (~native_id << 3) | 6


def resident_bytes() -> int:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize()
