"""Receives with Aravis and records when its consumer got each frame.

Runs in the system's Python, which has PyGObject: /usr/bin/python3 _aravis_receiver.py ADDRESS SIZE SECONDS
"""

import json
import sys
import time

import gi

gi.require_version("Aravis", "0.8")
from gi.repository import Aravis  # noqa: E402 - only after the version is chosen

BUFFERS = 16


def main(address: str, packet_size: int, seconds: float) -> None:
    camera = Aravis.Camera.new(address)
    camera.gv_set_stream_options(Aravis.GvStreamOption.PACKET_SOCKET_DISABLED)
    camera.gv_set_packet_size(packet_size)
    stream = camera.create_stream(None, None)
    stream.set_property("socket-buffer", Aravis.GvStreamSocketBuffer.AUTO)
    for _ in range(BUFFERS):
        stream.push_buffer(Aravis.Buffer.new_allocate(camera.get_payload()))
    camera.start_acquisition()
    arrivals = {}
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        buffer = stream.timeout_pop_buffer(500_000)
        now = time.monotonic()
        if buffer is None:
            continue
        if buffer.get_status() == Aravis.BufferStatus.SUCCESS:
            arrivals[buffer.get_frame_id()] = now
        stream.push_buffer(buffer)
    camera.stop_acquisition()
    print(json.dumps(arrivals))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]))
