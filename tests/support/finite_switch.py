"""A switch with a slow port and a finite buffer before it, in user space.

`python finite_switch.py IN OUT RATE BUFFER` carries Ethernet frames between two devices of its network
namespace, from IN to OUT at RATE bytes per second: what does not fit into BUFFER bytes is dropped. The kernel
stamps each frame on arrival, so that a late wake-up of this program neither drops nor saves one. Prints what
it did as a JSON object when its input is closed.
"""

from __future__ import annotations

import json
import select
import socket
import struct
import sys
import time
from collections import deque

ETH_P_ALL = 3
SO_TIMESTAMPNS, SO_RCVBUFFORCE = 35, 33
PACKET_OUTGOING = 4
ON_THE_WIRE = 24
"Bytes of preamble, checksum and gap beside what a socket shows of a frame."


def opened(device: str) -> socket.socket:
    made = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETH_P_ALL))
    made.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, 64 << 20)
    made.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
    made.bind((device, 0))
    made.setblocking(False)
    return made


def main(inner: str, outer: str, rate: float, buffer: float) -> None:
    cameras, host = opened(inner), opened(outer)
    waiting: deque[tuple[float, bytes]] = deque()
    free_at = 0.0
    "When the port has sent all that waits, on the clock of the stamps."
    counted = {"forwarded": 0, "dropped": 0, "bytes": 0, "fullest": 0.0}
    print("ready", flush=True)
    while True:
        wait = max(0.0, waiting[0][0] - time.time()) if waiting else 0.5
        readable, _, _ = select.select([cameras, host, sys.stdin], [], [], wait)
        if sys.stdin in readable:
            break
        for _ in range(256):
            try:
                frame, more, _, address = cameras.recvmsg(65536, 64)
            except BlockingIOError:
                break
            if address[2] == PACKET_OUTGOING:
                continue
            seconds, nanoseconds = struct.unpack("qq", more[0][2])
            arrived, size = seconds + nanoseconds / 1e9, len(frame) + ON_THE_WIRE
            backlog = max(0.0, free_at - arrived) * rate
            if backlog + size > buffer:
                counted["dropped"] += 1
                continue
            free_at = max(free_at, arrived) + size / rate
            counted["forwarded"] += 1
            counted["bytes"] += size
            counted["fullest"] = max(counted["fullest"], backlog + size)
            waiting.append((free_at, frame))
        while waiting and waiting[0][0] <= time.time():
            host.send(waiting.popleft()[1])
        for _ in range(256):
            try:
                frame, _, _, address = host.recvmsg(65536, 64)
            except BlockingIOError:
                break
            if address[2] != PACKET_OUTGOING:
                cameras.send(frame)
    print(json.dumps(counted), flush=True)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], float(sys.argv[3]), float(sys.argv[4]))
