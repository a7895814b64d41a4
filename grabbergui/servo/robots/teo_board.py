"""The control board of the simulated TEO's head, as `controlBoard_nws_yarp` of YARP 3.x presents a real one.

It behaves as drives do: a velocity goes on until another command, moves are obeyed in position mode only and
velocities in velocity mode only.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import numpy as np

from grabbergui.calibration.geometry import Vector
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.ports import OutputPort, RpcServer
from grabbergui.net.yarp.os.request import Request
from grabbergui.net.yarp.os.values import Item, Stamp, Vocab, word
from grabbergui.servo.robots import teo_messages as messages
from grabbergui.servo.robots.simulated import STEP_SPEED, SimRobot

PROTOCOL = (1, 9, 0)
"Of remote_controlboard."


class SimulatedBoard:
    """Ports `NAME/rpc:i`, `/command:i`, `/state:o` and `/stateExt:o` of a robot's head. Any thread."""

    def __init__(self, robot: SimRobot, names: NameClient, name: str) -> None:
        self._robot = robot
        self._chain = robot.model.head
        self._lock = threading.RLock()
        self._modes = [messages.POSITION_MODE] * self._joints
        self._speeds = np.full(self._joints, STEP_SPEED)
        "Of moves, rad/s."
        self._velocity = np.zeros(self._joints)
        self._count = 0
        self._state = OutputPort(f"{name}/state:o", names)
        self._extended_state = OutputPort(f"{name}/stateExt:o", names)
        self.ports = (
            RpcServer(f"{name}/rpc:i", self.answer, names),
            RpcServer(f"{name}/command:i", self._command, names),
            self._state,
            self._extended_state,
        )

    def step(self) -> None:
        """Let the drives go on, and stream where they are. To be called every few milliseconds."""
        with self._lock:
            if self._velocity.any():
                self._robot.move_head(self._velocity)
            angles, modes, stamp = self._robot.state().head, list(self._modes), self._stamp().encode()
        self._state.write_bottle(messages.encoders(angles), stamp)
        self._extended_state.write_bottle(messages.extended_state(angles, modes), stamp)

    def answer(self, request: Request) -> Bottle:
        """Return a control board's reply to a request."""
        message = request.bottle()
        verb, what = (word(item) for item in [*message[:2], "", ""][:2])
        with self._lock:
            try:
                if verb == "get":
                    return self._tell(what, message[2:])
                if verb == "set" and self._obey(what, message[2:]):
                    return Bottle([messages.OK])
            except (IndexError, TypeError, RemoteProtocolError):
                pass
        return Bottle([messages.FAIL])

    def _command(self, request: Request) -> None:
        velocity = messages.read_velocity_moves(request.bottle(), self._velocity)
        with self._lock:
            if velocity is not None:
                moving = [mode == messages.VELOCITY_MODE for mode in self._modes]
                self._go(np.where(moving, velocity, 0.0))

    def _tell(self, what: str, rest: list[Item]) -> Bottle:
        if what == "prot":
            return Bottle([Vocab("prot"), *PROTOCOL, messages.OK])
        chain, angles = self._chain, self._robot.state().head
        tell: dict[str, Callable[[], list[Item]]] = {
            "axes": lambda: [self._joints],
            "encs": lambda: [messages.degrees(angles)],
            "enc": lambda: [messages.degrees(angles)[self._joint(rest)]],
            "llim": lambda: [messages.degrees(limit)[self._joint(rest)] for limit in (chain.low, chain.high)],
            "vlim": lambda: [0.0, messages.degrees(chain.fastest)[self._joint(rest)]],
            "name": lambda: [chain.joint_names[self._joint(rest)]],
            "vels": lambda: [messages.degrees(self._speeds)],
            "vel": lambda: [messages.degrees(self._speeds)[self._joint(rest)]],
            "dons": lambda: [int(self._robot.speed < 1e-3)],
        }
        if what in tell:
            answer = [Vocab(what), *tell[what]()]
        elif what == "icmd" and word(rest[0]) == "cmds":
            answer = [Vocab("cmds"), list(self._modes)]
        elif what == "icmd" and word(rest[0]) == "cmod":
            joint = self._joint(rest[1:])
            answer = [joint, self._modes[joint]]
        else:
            return Bottle([messages.FAIL])
        stamp = self._stamp()
        return Bottle([Vocab("is"), *answer, Vocab("tsta"), stamp.count, stamp.time, messages.OK])

    def _obey(self, what: str, rest: list[Item]) -> bool:
        """Carry out a request; False for one that is unknown or out of place."""
        angles = self._robot.state().head
        if what in ("rels", "poss"):
            target = np.radians(messages.numbers(rest[0], self._joints))
            return self._move(target + angles if what == "rels" else target)
        if what in ("rel", "pos"):
            joint, target = self._joint(rest), angles.copy()
            value = float(np.radians(messages.numbers(rest[1:], 1)[0]))
            target[joint] = value + angles[joint] if what == "rel" else value
            return self._move(target)
        if what == "stos":
            self._go(np.zeros(self._joints))
        elif what == "sto":
            self._go(np.where(np.arange(self._joints) == self._joint(rest), 0.0, self._velocity))
        elif what == "vels":
            self._speeds = np.radians(messages.numbers(rest[0], self._joints))
        elif what == "vel":
            self._speeds[self._joint(rest)] = np.radians(messages.numbers(rest[1:], 1)[0])
        elif what == "icmd" and word(rest[0]) == "cmds":
            return self._set_modes(range(self._joints), list(rest[1]))  # type: ignore[arg-type]
        elif what == "icmd" and word(rest[0]) == "cmod":
            return self._set_modes([self._joint(rest[1:])], rest[2:3])
        else:
            return False
        return True

    def _move(self, target: Vector) -> bool:
        if any(mode != messages.POSITION_MODE for mode in self._modes):
            return False
        self._velocity = np.zeros(self._joints)
        self._robot.point_head(target, np.minimum(np.abs(self._speeds), self._chain.fastest))
        return True

    def _go(self, velocity: Vector) -> None:
        self._velocity = velocity
        self._robot.move_head(velocity)

    def _set_modes(self, joints: range | list[int], modes: list[Item]) -> bool:
        known = {str(mode): mode for mode in (messages.POSITION_MODE, messages.VELOCITY_MODE)}
        if len(modes) != len(joints) or any(word(mode) not in known for mode in modes):
            return False
        for joint, mode in zip(joints, modes, strict=True):
            self._modes[joint] = known[word(mode)]
        self._go(np.zeros(self._joints))
        return True

    def _joint(self, rest: list[Item]) -> int:
        """The joint that a request names first. Raises RemoteProtocolError."""
        return messages.joints(rest[:1], self._joints)[0]

    @property
    def _joints(self) -> int:
        return len(self._chain.joint_names)

    def _stamp(self) -> Stamp:
        self._count += 1
        return Stamp(self._count, time.time())
