"""A host that streams from several cameras, to be run in a network namespace.

`python ring_in_namespace.py URI...` prints a JSON object for each line of its input: for each camera the
frames so far, how many were incomplete, and whether they arrive through a packet ring.
"""

from __future__ import annotations

import json
import sys
from typing import Any

from grabbergui import sources
from grabbergui.core.grabber import FrameGrabber
from grabbergui.driver.gige.stream import channel
from grabbergui.driver.gige.stream.packet_ring import PacketRing


class KnownRing(PacketRing):
    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        rings.append(self)


rings: list[KnownRing] = []
"In the order of their cameras."


def report(grabber: FrameGrabber, ring: KnownRing) -> dict[str, object]:
    counters = grabber.statistics()
    return {"frames": counters.frames, "incomplete": counters.incomplete, "ring": not ring.failed}


def main(uris: list[str]) -> None:
    channel.PacketRing = KnownRing  # type: ignore[misc]
    grabbers = [sources.create(uri) for uri in uris]
    for grabber in grabbers:
        grabber.open()
        grabber.start()
    for _ in sys.stdin:
        found = [report(grabber, ring) for grabber, ring in zip(grabbers, rings, strict=True)]
        print(json.dumps(found), flush=True)
    for grabber in grabbers:
        grabber.close()


if __name__ == "__main__":
    main(sys.argv[1:])
