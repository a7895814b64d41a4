"""A cable between two network namespaces that loses, delays and reorders, for kernels without netem.

`python lossy_wire.py END END LOSS DELAY_MS JITTER_MS REORDER`, where an END is three words: NAMESPACE DEVICE
ADDRESS/BITS, makes a tap device at each end and carries Ethernet frames between them until its input is
closed. As netem does it: a part `REORDER` of the frames goes at once, ahead of those that wait.
"""

from __future__ import annotations

import ctypes
import fcntl
import heapq
import itertools
import os
import random
import select
import struct
import subprocess
import sys
import time
from pathlib import Path

TUNSETIFF = 0x400454CA
IFF_TAP, IFF_NO_PI = 0x0002, 0x1000
CLONE_NEWNET = 0x40000000
LARGEST_FRAME = 65536


def open_tap(namespace: str, device: str, address: str) -> int:
    """Make a device with an address in a namespace; its file descriptor carries Ethernet frames."""
    libc = ctypes.CDLL(None, use_errno=True)
    with Path(f"/run/netns/{namespace}").open() as target:
        if libc.setns(target.fileno(), CLONE_NEWNET):
            raise OSError(ctypes.get_errno(), f"entering {namespace}")
    tap = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(tap, TUNSETIFF, struct.pack("16sH22x", device.encode(), IFF_TAP | IFF_NO_PI))
    for command in (
        ["ip", "addr", "add", address, "dev", device],
        ["ip", "link", "set", device, "txqueuelen", "10000", "up"],
    ):
        subprocess.run(command, check=True)
    return tap


def carry(ends: list[int], loss: float, delay: float, jitter: float, reorder: float) -> None:
    """Until standard input is closed. Times in seconds, parts from 0 to 1."""
    chance = random.Random(1)
    order = itertools.count()
    waiting: list[tuple[float, int, int, bytes]] = []
    while True:
        wait = max(waiting[0][0] - time.monotonic(), 0) if waiting else 1.0
        readable, _, _ = select.select([*ends, sys.stdin], [], [], wait)
        if sys.stdin in readable:
            return
        now = time.monotonic()
        for end in readable:
            other = ends[1 - ends.index(end)]
            for _ in range(64):
                try:
                    frame = os.read(end, LARGEST_FRAME)
                except BlockingIOError:
                    break
                if chance.random() < loss:
                    continue
                late = 0.0 if chance.random() < reorder else delay + chance.uniform(-jitter, jitter)
                heapq.heappush(waiting, (now + late, next(order), other, frame))
        while waiting and waiting[0][0] <= now:
            _, _, end, frame = heapq.heappop(waiting)
            try:
                os.write(end, frame)
            except OSError:
                continue  # the device is down: a cable that is out


if __name__ == "__main__":
    first, second = sys.argv[1:4], sys.argv[4:7]
    loss, delay_ms, jitter_ms, reorder = map(float, sys.argv[7:])
    taps = [open_tap(*first), open_tap(*second)]
    print("ready", flush=True)
    carry(taps, loss, delay_ms / 1000, jitter_ms / 1000, reorder)
