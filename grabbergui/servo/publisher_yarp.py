"""What the loop sees and does, on YARP; and a stop that anybody on the network can press.

Ports below a prefix: `/heads:o` x y z in metres per picture that shows a head (the camera's frame),
`/markers:o` one list of pairs per marker, `/state:o` state, reason and errors of every turn, and `/rpc:s`,
which understands `stop`, `resume` and `state`.
"""

from __future__ import annotations

import math
import time

from grabbergui.calibration.geometry import vector_from_pose
from grabbergui.core.frame import Frame
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.ports import OutputPort, RpcServer
from grabbergui.net.yarp.os.request import Request
from grabbergui.net.yarp.os.values import Item, Stamp, Vocab, word
from grabbergui.servo.detection import Sighting
from grabbergui.servo.loop import Turn
from grabbergui.servo.pilot import Pilot


class YarpPublisher:
    """Publishes one pilot. `open` and `close` from one thread; the rest happens on the pilot's."""

    def __init__(self, pilot: Pilot, names: NameClient, prefix: str = "/grabbergui/servo") -> None:
        self._pilot = pilot
        self._heads = OutputPort(f"{prefix}/heads:o", names)
        self._markers = OutputPort(f"{prefix}/markers:o", names)
        self._state = OutputPort(f"{prefix}/state:o", names)
        self._rpc = RpcServer(f"{prefix}/rpc:s", self._answer, names)
        self._count = 0
        self._turn: Turn | None = None

    def open(self) -> None:
        """Open the ports and follow the pilot. Raises SourceUnavailableError, TransportError."""
        try:
            for port in self._ports:
                port.open()
        except BaseException:
            self.close()
            raise
        self._pilot.turned.connect(self._on_turn)

    def close(self) -> None:
        """Drop the ports. May be called twice; never raises."""
        self._pilot.turned.disconnect(self._on_turn, missing_ok=True)
        for port in self._ports:
            port.close()

    @property
    def _ports(self) -> tuple[OutputPort | RpcServer, ...]:
        return self._heads, self._markers, self._state, self._rpc

    def _on_turn(self, turn: Turn, frame: Frame | None) -> None:
        self._turn = turn
        self._count += 1
        envelope = Stamp(self._count, time.time()).encode()
        self._state.write_bottle(state_bottle(turn), envelope)
        sighting = self._pilot.loop.sighting
        if frame is None or sighting is None:
            return
        head = sighting.nearest_head
        if head is not None:
            self._heads.write_bottle(Bottle(map(float, head.position)), envelope)
        self._markers.write_bottle(markers_bottle(sighting), envelope)

    def _answer(self, request: Request) -> Bottle:
        verb = word(next(iter(request.bottle()), "")).lower()
        if verb == "stop":
            self._pilot.emergency_stop(f"stopped by {request.info.peer}")
        elif verb == "resume":
            why_not = self._pilot.resume()
            if why_not:
                return Bottle([Vocab("fail"), why_not])
        elif verb == "state":
            return state_bottle(self._turn) if self._turn else Bottle([Vocab("fail"), "no turn yet"])
        else:
            return Bottle([Vocab("fail"), "there are stop, resume and state"])
        return Bottle([Vocab("ok")])


def state_bottle(turn: Turn) -> Bottle:
    """State, reason, and as pairs what is known of the errors: millimetres, degrees."""
    items: list[Item] = [turn.state.value, turn.reason]
    for name, value, factor in (
        ("distance_mm", turn.error[0], 1e3),
        ("angle_degrees", turn.error[1], 180 / math.pi),
        ("right_degrees", turn.off_centre[0], 180 / math.pi),
        ("down_degrees", turn.off_centre[1], 180 / math.pi),
    ):
        if math.isfinite(value):
            items.append([name, float(value * factor)])
    return Bottle(items)


def markers_bottle(sighting: Sighting) -> Bottle:
    """A list of pairs for each marker: id, and x y z with the rotation vector, or why there is no pose."""
    found: list[Item] = []
    for marker in sighting.markers:
        pairs: list[Item] = [["id", marker.marker_id]]
        if marker.pose is not None:
            values = map(float, vector_from_pose(marker.pose))
            pairs += [
                [key, value] for key, value in zip(("x", "y", "z", "rx", "ry", "rz"), values, strict=True)
            ]
        else:
            pairs.append(["problem", marker.problem])
        found.append(pairs)
    return Bottle(found)
