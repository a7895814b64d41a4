"""The processes of `yarp_ports`: senders, readers, clients and servers, ours and real YARP's.

Real YARP is used through its Python bindings, in which the port's threads and all copying are C++. Both use
our name server; real YARP finds it by its configuration folder (YARP_CONFIG_HOME).
"""

from __future__ import annotations

import resource
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from grabbergui.core.errors import FrameTimeoutError
from grabbergui.net.yarp import image
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.ports import InputPort, OutputPort, RpcServer
from grabbergui.net.yarp.os.rpc_client import RpcClient
from grabbergui.net.yarp.os.stamp import Stamp
from grabbergui.net.yarp.os.target import Target

SENDER, READER = "/benchmark/out", "/benchmark/in"
LAST = 2**31 - 1
"""Number of the image that ends a stream."""
QUESTION = ("fgc", "get", "feat", 8)
PATIENCE = 20.0


@dataclass(frozen=True)
class Received:
    """The frames of a stream that a reader received."""

    ages: list[float]
    "Age of each image on arrival, milliseconds from its stamp."
    seconds: float
    "Seconds from the first image to the last."
    cpu: float
    "CPU seconds of the process."


@dataclass(frozen=True)
class Order:
    """The parameters of a stream."""

    names: str
    "Address of the name server."
    carrier: str
    size: tuple[int, int]
    seconds: float
    rate: float = 0.0
    "Images per second; 0: each as soon as the one before is sent."


def gradient(width: int, height: int) -> np.ndarray[Any, Any]:
    return np.tile(np.arange(width * 3, dtype=np.uint8).reshape(1, -1, 3), (height, 1, 1))


def _send(pipe: Connection, order: Order, send: Callable[[int], object]) -> None:
    """Send for a while; report count and CPU seconds; then repeat the last image until a message arrives."""
    cpu, began, count = _cpu(), time.monotonic(), 0
    while (now := time.monotonic()) < began + order.seconds:
        if order.rate and now < began + count / order.rate:
            time.sleep(began + count / order.rate - now)
        send(count)
        count += 1
    pipe.send((count, _cpu() - cpu))
    while not pipe.poll(0.05):
        send(LAST)


def send_ours(pipe: Connection, order: Order) -> None:
    """Report that the port is ready; after the command to begin, see `_send`."""
    header, body = image.encode(gradient(*order.size), "rgb")
    port = OutputPort(SENDER, NameClient.find(order.names))
    with port:
        pipe.send(None)
        pipe.recv()
        if order.carrier != "mjpeg":
            port.add(Target(READER, order.carrier))
        while not port.connections:
            time.sleep(0.01)

        def send(number: int) -> None:
            port.write(header, body, Stamp(number, time.time()).encode())
            port.wait_sent(5.0)

        _send(pipe, order, send)


def read_ours(pipe: Connection, order: Order) -> None:
    """Report that the port is ready, then, at the end of the stream, a `Received`."""
    ages: list[float] = []
    first = last = cpu = 0.0
    port = InputPort(READER, NameClient.find(order.names), depth=2)
    with port:
        pipe.send(None)
        if order.carrier == "mjpeg":
            port.connect(SENDER, order.carrier)
        until = time.monotonic() + order.seconds + PATIENCE
        while time.monotonic() < until:
            try:
                _, envelope = port.read(0.5)
            except FrameTimeoutError:
                continue
            stamp = Stamp.decode(envelope)
            assert stamp is not None
            if stamp.count == LAST:
                break
            last = time.monotonic()
            if not ages:
                first, cpu = last, _cpu()
            ages.append((time.time() - stamp.time) * 1000)
        pipe.send(Received(ages, last - first, _cpu() - cpu))


def ask_ours(pipe: Connection, names: str, name: str, seconds: float) -> None:
    """Measure round trips in milliseconds."""
    times = []
    with RpcClient(name, NameClient.find(names)) as client:
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            began = time.perf_counter()
            client.call(Bottle(QUESTION))
            times.append((time.perf_counter() - began) * 1000)
    pipe.send(times)


def answer_ours(pipe: Connection, names: str, name: str) -> None:
    with RpcServer(name, lambda request: Bottle(["fgc", "feat", "is", 5.0]), NameClient.find(names)):
        pipe.send(None)
        with suppress(EOFError):
            pipe.recv()


def _yarp() -> Any:
    import yarp  # type: ignore[import-not-found]

    yarp.Network.init()
    yarp.Log.setMinimumPrintLevel(yarp.Log.WarningType)
    return yarp


def _open(port: Any, name: str) -> None:
    """Open a port of real YARP; retry if another program took the offered port number meanwhile."""
    for _ in range(5):
        if port.open(name):
            return
    raise SystemExit(f"real YARP could not open {name}")


def send_real(pipe: Connection, order: Order) -> None:
    """Do as `send_ours`, with real YARP."""
    yarp, pixels = _yarp(), gradient(*order.size)
    port = yarp.BufferedPortImageRgb()
    _open(port, SENDER)
    pipe.send(None)
    pipe.recv()
    yarp.Network.connect(SENDER, READER, order.carrier)

    def send(number: int) -> None:
        prepared = port.prepare()
        prepared.setExternal(pixels.data, *order.size)
        port.setEnvelope(yarp.Stamp(number, time.time()))
        port.write()
        port.waitForWrite()

    _send(pipe, order, send)
    port.close()


def read_real(pipe: Connection, order: Order) -> None:
    """Do as `read_ours`, with real YARP."""
    yarp = _yarp()
    ages: list[float] = []
    first = last = cpu = 0.0
    port = yarp.BufferedPortImageRgb()
    _open(port, READER)
    pipe.send(None)
    stamp = yarp.Stamp()
    while port.read(True) is not None:
        port.getEnvelope(stamp)
        if stamp.getCount() == LAST:
            break
        last = time.monotonic()
        if not ages:
            first, cpu = last, _cpu()
        ages.append((time.time() - stamp.getTime()) * 1000)
    pipe.send(Received(ages, last - first, _cpu() - cpu))
    port.close()


def ask_real(pipe: Connection, names: str, name: str, seconds: float) -> None:
    """Do as `ask_ours`, with real YARP."""
    yarp = _yarp()
    port = yarp.RpcClient()
    _open(port, f"{name}/asker")
    yarp.Network.connect(f"{name}/asker", name)
    question, reply, times = yarp.Bottle(), yarp.Bottle(), []
    question.fromString(" ".join(map(str, QUESTION)))
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        began = time.perf_counter()
        port.write(question, reply)
        times.append((time.perf_counter() - began) * 1000)
    pipe.send(times)
    port.close()


def answer_real(pipe: Connection, names: str, name: str) -> None:
    """Do as `answer_ours`, with real YARP, until the process ends."""
    yarp = _yarp()
    port = yarp.RpcServer()
    _open(port, name)
    pipe.send(None)
    question, answer = yarp.Bottle(), yarp.Bottle()
    answer.fromString("fgc feat is 5.0")
    while port.read(question, True):
        port.reply(answer)


def _cpu() -> float:
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime
