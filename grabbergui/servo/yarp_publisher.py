"""Publishes the loop's detections and state on YARP, and accepts a stop from any peer.

Ports below a prefix: `/heads:o` x y z in metres per image that shows a head (the camera's frame),
`/markers:o` one list of pairs per marker, `/state:o` state, reason and errors of every cycle, and `/rpc:s`,
which accepts `stop`, `resume` and `state`.
"""

from __future__ import annotations

import math
import threading
import time

from grabbergui.calibration.geometry import vector_from_pose
from grabbergui.core.frame import Frame
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.inputs import Request
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.ports import OutputPort, RpcServer, open_all
from grabbergui.net.yarp.os.stamp import Stamp
from grabbergui.net.yarp.os.values import Item, Vocab, word
from grabbergui.servo.detection import Sighting
from grabbergui.servo.loop import ControlCycle
from grabbergui.servo.measured_errors import errors
from grabbergui.servo.runner import Runner

CYCLE_S = 0.5
"Longest wait for a cycle that shows the effect of a command."


class YarpPublisher:
    """Publishes one runner. `open` and `close` from one thread; it publishes on the runner's."""

    def __init__(self, runner: Runner, names: NameClient, prefix: str = "/grabbergui/servo") -> None:
        self._runner = runner
        self._heads = OutputPort(f"{prefix}/heads:o", names)
        self._markers = OutputPort(f"{prefix}/markers:o", names)
        self._state = OutputPort(f"{prefix}/state:o", names)
        self._rpc = RpcServer(f"{prefix}/rpc:s", self._answer, names)
        self._count = 0
        self._cycle: ControlCycle | None = None
        self._commanded = -math.inf
        "When a peer last stopped or resumed."
        self._cycled = threading.Condition()

    def open(self) -> None:
        """Open the ports and start to publish. Raises SourceUnavailableError, TransportError."""
        open_all(self._ports)
        self._runner.cycle_done.connect(self._on_cycle)

    def close(self) -> None:
        """Close the ports. May be called twice; never raises."""
        self._runner.cycle_done.disconnect(self._on_cycle, missing_ok=True)
        for port in self._ports:
            port.close()

    @property
    def _ports(self) -> tuple[OutputPort | RpcServer, ...]:
        return self._heads, self._markers, self._state, self._rpc

    def _on_cycle(self, cycle: ControlCycle, frame: Frame | None) -> None:
        with self._cycled:
            self._cycle = cycle
            self._cycled.notify_all()
        self._count += 1
        envelope = Stamp(self._count, time.time()).encode()
        self._state.write_bottle(state_bottle(cycle), envelope)
        sighting = self._runner.loop.sighting
        if frame is None or sighting is None:
            return
        head = sighting.nearest_face
        if head is not None:
            self._heads.write_bottle(Bottle(map(float, head.position)), envelope)
        self._markers.write_bottle(markers_bottle(sighting), envelope)

    def _answer(self, request: Request) -> Bottle:
        verb = word(next(iter(request.bottle()), "")).lower()
        if verb == "stop":
            self._runner.emergency_stop(f"stopped by {request.info.peer}", "YARP")
            self._commanded = time.monotonic()
        elif verb == "resume":
            why_not = self._runner.resume(pressed="YARP")
            self._commanded = time.monotonic()
            if why_not:
                return Bottle([Vocab("fail"), why_not])
        elif verb == "state":
            cycle = self._newest()
            return state_bottle(cycle) if cycle else Bottle([Vocab("fail"), "no cycle yet"])
        else:
            return Bottle([Vocab("fail"), "there are stop, resume and state"])
        return Bottle([Vocab("ok")])

    def _newest(self) -> ControlCycle | None:
        """Return the newest cycle; wait for one that has followed the last command of a peer."""
        with self._cycled:
            self._cycled.wait_for(lambda: self._cycle and self._cycle.time > self._commanded, CYCLE_S)
            return self._cycle


def state_bottle(cycle: ControlCycle) -> Bottle:
    """Return state, reason, and `errors` as pairs."""
    pairs: list[Item] = [[name, value] for name, value in errors(cycle).items()]
    return Bottle([cycle.state.value, cycle.reason, *pairs])


def markers_bottle(sighting: Sighting) -> Bottle:
    """Return a list of pairs for each marker: id, and its pose or the reason for none.

    The pose is x y z in metres, the rotation vector in radians, and 36 numbers of its covariance, row by row:
    metres along, then radians about the camera's axes.
    """
    found: list[Item] = []
    for marker in sighting.markers:
        pairs: list[Item] = [["id", marker.marker_id]]
        if marker.pose is not None:
            values = map(float, vector_from_pose(marker.pose))
            pairs += [
                [key, value] for key, value in zip(("x", "y", "z", "rx", "ry", "rz"), values, strict=True)
            ]
            if marker.covariance is not None:
                pairs.append(["covariance", [float(value) for value in marker.covariance.ravel()]])
        else:
            pairs.append(["problem", marker.problem])
        found.append(pairs)
    return Bottle(found)
