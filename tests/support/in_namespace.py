"""A host that streams from a camera, to be run in a network namespace.

`python in_namespace.py URI` sets an exposure time, streams, and prints a JSON object a line: what became of
the connection, the first frame behind each, and that there were many. Closing its input makes it print its
statistics and end. Times are those of the monotonic clock, which all processes of a machine share.
"""

from __future__ import annotations

import json
import logging
import sys
import threading
import time
from typing import Any

from grabbergui import sources
from grabbergui.core.errors import FrameTimeoutError
from grabbergui.core.grabber import ConnectionState

EXPOSURE = 1234.0
MANY = 100
"""Frames after which it reports that they were many."""


def report(what: str, **more: Any) -> None:
    # One write a line: `print` writes the end of the line separately, and two threads report here.
    sys.stdout.write(json.dumps({"what": what, "at": time.monotonic(), **more}) + "\n")
    sys.stdout.flush()


def main(uri: str) -> None:
    awaiting, stopping = threading.Event(), threading.Event()

    def on_connection(state: ConnectionState, why: str) -> None:
        report(state.value, why=why)
        if state is ConnectionState.LOST:
            awaiting.set()

    def consume() -> None:
        frame_id = taken = 0
        while not stopping.is_set():
            try:
                frame = frames.get(0.2)
            except FrameTimeoutError:
                continue
            # After a loss frame ids start again; so a frame from before, still in the queue, is not taken.
            if awaiting.is_set() and (grabber.streaming or frame.frame_id < frame_id):
                awaiting.clear()
                report("frame", id=frame.frame_id)
            frame_id = frame.frame_id
            taken += 1
            if taken == MANY:
                report("many")

    logging.basicConfig(level="INFO", format="%(asctime)s %(name)s %(message)s")
    grabber = sources.create(uri)
    grabber.connection_changed.connect(on_connection)
    grabber.open()
    grabber.write_feature("ExposureTime", EXPOSURE)
    frames = grabber.open_queue(4)
    awaiting.set()
    consumer = threading.Thread(target=consume)
    consumer.start()
    grabber.start()
    sys.stdin.read()
    statistics = grabber.statistics().as_dict()
    exposure = grabber.feature("ExposureTime").value
    stopping.set()
    consumer.join()
    grabber.close()
    report("end", exposure=exposure, **statistics)


if __name__ == "__main__":
    main(sys.argv[1])
