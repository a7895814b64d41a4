"""Receiving a GigE Vision stream at the line rate of Gigabit Ethernet, and without a limit.

Another process sends prebuilt packets over the loopback with `sendmmsg`, paced; this one receives them in
batches (`recvmmsg`) and one datagram at a time. The figures depend on the machine; compare the rows.

    python -m benchmarks.gige_receive [--seconds 5]
"""

from __future__ import annotations

import argparse
import ctypes
import logging
import multiprocessing
import socket
import time
from dataclasses import dataclass
from multiprocessing.connection import Connection

import numpy as np

from grabbergui.core.frame import Frame
from grabbergui.driver.gige import gvsp
from grabbergui.driver.gige.gvsp import Leader, Trailer
from grabbergui.driver.gige.packet_header import PacketFormat, PacketHeader
from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.batch_source import BatchSource
from grabbergui.driver.gige.stream.channel import make_pool
from grabbergui.driver.gige.stream.datagram_source import PlainSource
from grabbergui.driver.gige.stream.frame_builder import FrameBuilder
from grabbergui.driver.gige.stream.packet_origin import PacketOrigin
from grabbergui.driver.gige.stream.receiver import StreamReceiver
from grabbergui.driver.gige.stream.recvmmsg import IOVEC, MMSGHDR
from grabbergui.driver.gige.stream.resend import ResendPolicy
from grabbergui.driver.gige.stream.sockets import buffer_bytes, open_stream_socket

WIDTH, HEIGHT = 2048, 2048
PAYLOAD = WIDTH * HEIGHT
LINE_RATE = 117_500_000
"Payload of Gigabit Ethernet, bytes per second."
BURST = 32
DEVICE, HOST = "127.0.0.9", "127.0.0.1"


@dataclass(frozen=True)
class Result:
    """The figures of one run."""

    sent: int
    frames: int
    incomplete: int
    packets_missing: int
    seconds: float
    cpu: float
    "CPU seconds of this process."

    @property
    def megabytes_per_second(self) -> float:
        return self.frames * PAYLOAD / self.seconds / 1e6


class Sender:
    """Sends the prebuilt packets of an image; only the block id changes between images."""

    def __init__(self, port: int, packet_size: int) -> None:
        stride = gvsp.payload_stride(packet_size)
        pixels = np.arange(PAYLOAD, dtype=np.uint32).astype(np.uint8).tobytes()
        bodies = [Leader(1, 1, 0x01080001, WIDTH, HEIGHT).encode()]
        bodies += [pixels[at : at + stride] for at in range(0, PAYLOAD, stride)]
        bodies += [Trailer(1, HEIGHT).encode()]
        kinds = [PacketFormat.LEADER] + [PacketFormat.PAYLOAD] * (len(bodies) - 2) + [PacketFormat.TRAILER]
        self.packets = [
            np.frombuffer(bytearray(PacketHeader(kind, 1, index).encode() + body), np.uint8)
            for index, (kind, body) in enumerate(zip(kinds, bodies, strict=True))
        ]
        self._iov = np.zeros(len(bodies), IOVEC)
        self._iov["base"] = [packet.ctypes.data for packet in self.packets]
        self._iov["length"] = [packet.nbytes for packet in self.packets]
        self._messages = np.zeros(len(bodies), MMSGHDR)
        self._messages["iov"] = self._iov.ctypes.data + 16 * np.arange(len(bodies), dtype=np.uint64)
        self._messages["iov_length"] = 1
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((DEVICE, 0))
        self._socket.connect((HOST, port))
        self._call = ctypes.CDLL(None, use_errno=True).sendmmsg

    def send(self, block_id: int, began: float, rate: float) -> None:
        """Send one image at no more than `rate` bytes per second (0: without a limit)."""
        identity = block_id.to_bytes(2, "big")
        for packet in self.packets:
            packet[2], packet[3] = identity
        step = int(self._iov["length"][1])
        done = 0
        while done < len(self.packets):
            if rate:
                while time.monotonic() < began + done * step / rate:
                    time.sleep(0.0002)
            count = min(BURST, len(self.packets) - done)
            address = ctypes.c_void_p(self._messages.ctypes.data + done * MMSGHDR.itemsize)
            done += max(0, self._call(self._socket.fileno(), address, count, 0))


def send_images(port: int, packet_size: int, rate: float, seconds: float, result: Connection) -> None:
    """Send images for a while; the target of the sending process."""
    sender = Sender(port, packet_size)
    began = time.monotonic()
    sent = 0
    while time.monotonic() - began < seconds:
        sender.send(sent % 0xFFFF + 1, began + sent * PAYLOAD / rate if rate else 0.0, rate)
        sent += 1
    result.send(sent)


def measure(packet_size: int, rate: float, seconds: float, *, batched: bool) -> Result:
    """Receive for a while."""
    receiver = open_stream_socket(HOST, PAYLOAD)
    port = receiver.getsockname()[1]
    assembler = BlockAssembler(
        gvsp.payload_stride(packet_size), PAYLOAD, make_pool(PAYLOAD).take, ResendPolicy(enabled=False)
    )
    origin = PacketOrigin(DEVICE)
    source = BatchSource(receiver, origin) if batched else PlainSource(receiver, origin)
    frames: list[int] = []

    def take(frame: Frame) -> None:
        frames.append(frame.frame_id)

    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(
        target=send_images, args=(port, packet_size, rate, seconds, theirs), daemon=True
    )
    stream = StreamReceiver(receiver, DEVICE, assembler, FrameBuilder(1_000_000_000), take, source)
    try:
        process.start()
        while not frames and process.is_alive():
            time.sleep(0.001)
        began, cpu = time.monotonic(), time.process_time()
        sent = ours.recv()
        elapsed, used = time.monotonic() - began, time.process_time() - cpu
        process.join()
        time.sleep(0.3)
        statistics = stream.statistics()
    finally:
        stream.stop()
    return Result(sent, statistics.frames, statistics.incomplete, statistics.packets_missing, elapsed, used)


def main(argv: list[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=5.0, help="of each run")
    seconds = parser.parse_args(argv).seconds
    logging.basicConfig(level=logging.WARNING)
    probe = open_stream_socket(HOST, PAYLOAD)
    print(f"images of {WIDTH}x{HEIGHT} Mono8; socket buffer {buffer_bytes(probe) >> 10} KiB")
    probe.close()
    print("| packet | rate | way | frames/s | MB/s | lost frames | CPU per second | CPU s per GB | ratio |")
    print("|---|---|---|---|---|---|---|---|---|")
    for rate in (LINE_RATE, 0):
        for packet_size in (1400, 8164):
            plain = 0.0
            for batched in (False, True):
                run = measure(packet_size, rate, seconds, batched=batched)
                per_gb = run.cpu / max(run.frames * PAYLOAD / 1e9, 1e-9)
                plain = plain or per_gb
                row = (
                    packet_size,
                    "1 GbE" if rate else "full",
                    "recvmmsg" if batched else "plain",
                    f"{run.frames / run.seconds:.1f}",
                    f"{run.megabytes_per_second:.0f}",
                    f"{run.sent - run.frames} of {run.sent}",
                    f"{run.cpu / run.seconds:.2f}",
                    f"{per_gb:.2f}",
                    f"{per_gb / plain:.2f}",
                )
                print("|", " | ".join(map(str, row)), "|", flush=True)


if __name__ == "__main__":
    main()
