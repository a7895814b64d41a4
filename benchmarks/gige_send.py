"""Rate and CPU time of the simulated GigE Vision camera, sending on the loopback.

    python -m benchmarks.gige_send [--seconds 5]

The receiver is another process that only counts. The images are full-size test patterns (2448×2048 Mono8),
which need no rendering.
"""

from __future__ import annotations

import argparse
import multiprocessing
import socket
import time
from multiprocessing.connection import Connection

from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import TestPattern
from grabbergui.driver.sim.gige.server import GigeCamera

ADDRESS = "127.79.0.1"
TRAILER = 2


def receive(port_out: Connection, result_out: Connection) -> None:
    """Count datagrams until none arrives for a second."""
    receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    receiver.setsockopt(socket.SOL_SOCKET, 33, 64 << 20)  # SO_RCVBUFFORCE
    receiver.bind(("127.0.0.1", 0))
    port_out.send(receiver.getsockname()[1])
    receiver.settimeout(5)
    buffer = bytearray(65536)
    bytes_in = frames = 0
    start = end = 0.0
    try:
        while True:
            count = receiver.recv_into(buffer)
            end = time.monotonic()
            if not start:
                start = end
                receiver.settimeout(1)
            bytes_in += count
            frames += buffer[4] == TRAILER
    except TimeoutError:
        result_out.send((bytes_in, frames, end - start))


def send(packet_size: int, seconds: float) -> None:
    """Send without a limit and print the rate."""
    port_in, port_out = multiprocessing.Pipe(False)
    result_in, result_out = multiprocessing.Pipe(False)
    receiver = multiprocessing.Process(target=receive, args=(port_out, result_out))
    receiver.start()
    camera = GigeCamera(
        ADDRESS,
        bandwidth=0,
        segmentation=True,
        power_on={
            reg.WIDTH: reg.SENSOR_WIDTH,
            reg.HEIGHT: reg.SENSOR_HEIGHT,
            reg.FRAME_RATE_ENABLE: 0,
            reg.EXPOSURE_TIME: 1000.0,
            reg.TEST_PATTERN: int(TestPattern.GREY_HORIZONTAL_RAMP),
        },
    )
    try:
        camera.stream_to("127.0.0.1", port_in.recv(), packet_size)
        cpu = time.process_time()
        camera.model.write(reg.ACQUISITION_START.address, bytes((0, 0, 0, 1)))
        time.sleep(seconds)
        cpu = time.process_time() - cpu
        camera.model.stop()
        sent = camera.stream_bytes
    finally:
        camera.close()
    received, frames, span = result_in.recv()
    receiver.join()
    print(
        f"packets of {packet_size:5} bytes: sent {sent / seconds / 1e6:5.0f} MB/s"
        f" at {cpu / sent * 1e9:.2f} s of CPU a GB;"
        f" a counting receiver got {received / span / 1e6:5.0f} MB/s, {frames} frames"
    )


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=5.0, help="of each packet size")
    options = parser.parse_args(arguments)
    for packet_size in (8164, 1400):
        send(packet_size, options.seconds)


if __name__ == "__main__":
    main()
