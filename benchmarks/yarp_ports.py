"""YARP streams between two processes: frames per second, latency and CPU; round trips of requests.

python -m benchmarks.yarp_ports [--seconds 2] [--carriers tcp fast_tcp udp mjpeg]
"""

from __future__ import annotations

import argparse
import multiprocessing
import resource
import statistics
import time
from multiprocessing.connection import Connection

import numpy as np

from grabbergui.core.errors import FrameTimeoutError
from grabbergui.net.yarp import image
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.envelope import Stamp
from grabbergui.net.yarp.os.names import Target
from grabbergui.net.yarp.os.ports import InputPort, OutputPort, RpcServer
from grabbergui.net.yarp.os.rpc_client import RpcClient

SIZES = {"640×480": (480, 640), "1080p": (1080, 1920), "8.8 MP": (2448, 3600)}
CARRIERS = ("tcp", "fast_tcp", "udp", "mjpeg")
CONTEXT = multiprocessing.get_context("spawn")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=2.0, help="how long each stream runs")
    parser.add_argument("--carriers", nargs="+", choices=CARRIERS, default=CARRIERS)
    options = parser.parse_args()
    for name, shape in SIZES.items():
        for carrier in options.carriers:
            print(f"{name:>8} {carrier:>9} {stream(carrier, shape, options.seconds)}", flush=True)
    print(round_trips(options.seconds))


def stream(carrier: str, shape: tuple[int, int], seconds: float) -> str:
    """Keep one link full for a while; the figures as a line."""
    pixels = np.tile(np.arange(shape[1] * 3, dtype=np.uint8).reshape(1, -1, 3), (shape[0], 1, 1))
    header, body = image.encode(pixels, "rgb")
    ours, theirs = CONTEXT.Pipe()
    with OutputPort("/benchmark/out") as output:
        process = CONTEXT.Process(target=read, args=(theirs, carrier, output.place(), seconds))
        process.start()
        number = ours.recv()
        if carrier != "mjpeg":
            output.add(Target.parse(f"tcp://127.0.0.1:{number}/", carrier))
        while not output.connections:
            time.sleep(0.01)
        cpu, until, count = cpu_seconds(), time.monotonic() + seconds, 0
        while time.monotonic() < until:
            output.write(header, body, Stamp(count, time.time()).encode())
            output.wait_sent(5.0)
            count += 1
        cpu = cpu_seconds() - cpu
        ours.send("enough")
        ages, size, elapsed, reader_cpu = ours.recv()
        process.join()
    if len(ages) < 2:
        return "nothing arrived whole"
    ages.sort()
    return (
        f"{(len(ages) - 1) / elapsed:7.1f} fps {size / elapsed / 1e9:5.2f} GB/s   "
        f"latency {statistics.median(ages):6.2f} ms, p99 {ages[int(len(ages) * 0.99)]:6.2f} ms   "
        f"CPU {(cpu + reader_cpu) / size * 1e9:5.2f} s/GB   lost {count - len(ages)} of {count}"
    )


def read(pipe: Connection, carrier: str, source: str, seconds: float) -> None:
    """The reading process: ages in ms, bytes, seconds from first to last frame, CPU seconds."""
    ages: list[float] = []
    size, first, last = 0, 0.0, 1.0
    with InputPort("/benchmark/in", depth=2) as reader:
        pipe.send(reader.port_number)
        if carrier == "mjpeg":
            reader.connect(source, carrier)
        cpu, until = cpu_seconds(), time.monotonic() + seconds + 20
        while time.monotonic() < until and not pipe.poll():
            try:
                payload, envelope = reader.read(0.2)
            except FrameTimeoutError:
                continue
            last = time.monotonic()
            first = first or last
            stamp = Stamp.decode(envelope)
            assert stamp is not None
            ages.append((time.time() - stamp.time) * 1000)
            size += len(payload)
        pipe.send((ages, size, last - first, cpu_seconds() - cpu))


def round_trips(seconds: float) -> str:
    """Requests of a few words, one after the other."""
    ours, theirs = CONTEXT.Pipe()
    process = CONTEXT.Process(target=answer, args=(theirs,))
    process.start()
    times = []
    with RpcClient(ours.recv()) as client:
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            start = time.perf_counter()
            client.call(Bottle(["fgc", "get", "feat", 8]))
            times.append((time.perf_counter() - start) * 1000)
    ours.send("enough")
    process.join()
    times.sort()
    median, late = statistics.median(times), times[int(len(times) * 0.99)]
    return f"requests: {len(times) / seconds:.0f} a second, median {median:.3f} ms, p99 {late:.3f} ms"


def answer(pipe: Connection) -> None:
    with RpcServer("/benchmark/rpc", lambda request: Bottle(["fgc", "feat", "is", 5.0])) as server:
        pipe.send(server.place())
        pipe.recv()


def cpu_seconds() -> float:
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


if __name__ == "__main__":
    main()
