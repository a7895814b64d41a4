"""The control board of the simulated TEO's head, as `controlBoard_nws_yarp` presents a real one, 3.x or 4.0.

It behaves as real drives do: a velocity holds until the next command, and each mode obeys one kind of
command: position mode moves, position direct mode streamed positions, velocity mode velocities.
"""

from __future__ import annotations

import struct
import threading
import time
from collections.abc import Callable

import numpy as np

from grabbergui.calibration.geometry import Vector
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.inputs import Reply, Request
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.ports import OutputPort, RpcServer
from grabbergui.net.yarp.os.stamp import Stamp
from grabbergui.net.yarp.os.values import Dialect, Item, Vocab, word
from grabbergui.servo.robots import teo_messages as messages
from grabbergui.servo.robots.simulated import STEP_SPEED, SimRobot

PROTOCOL = (1, 9, 0)
"Protocol version of remote_controlboard, 3.x."
VERSION_OF_4 = struct.pack("<2i4h", 256, 1, 0, 4, 0, 0)
"4.0's reply with its version, not a Bottle: a list of one element, then protocol, major, minor, patch."
INTERFACES = (
    *(
        "iAmplifierControl",
        "iAxisInfo",
        "iControlCalibration",
        "iControlLimits",
        "iControlMode",
        "iCurrentControl",
    ),
    *("iEncodersTimed", "iImpedanceControl", "iInteractionMode", "iJointBrake", "iJointFault", "iMotor"),
    *(
        "iMotorEncoders",
        "iPWMControl",
        "iPidControl",
        "iPositionControl",
        "iPositionDirect",
        "iPreciselyTimed",
    ),
    *("iRemoteCalibrator", "iRemoteVariables", "iTorqueControl", "iVelocityControl", "iVelocityDirect"),
)
"All interfaces that a board of 4.0 reports as implemented or not."
IMPLEMENTED = {
    *("iAxisInfo", "iControlLimits", "iControlMode", "iEncodersTimed", "iPositionControl", "iPositionDirect"),
    "iVelocityControl",
}
MODES = (messages.POSITION_MODE, messages.DIRECT_MODE, messages.VELOCITY_MODE)


class SimulatedBoard:
    """Ports `NAME/rpc:i`, or `/nws/rpc:i`, `/command:i`, `/state:o`, `/stateExt:o` of a head. Any thread."""

    def __init__(
        self, robot: SimRobot, names: NameClient, name: str, dialect: Dialect = Dialect.YARP3
    ) -> None:
        self._robot = robot
        self._dialect = dialect
        self._chain = robot.model.head
        self._lock = threading.RLock()
        self._modes = [messages.POSITION_MODE] * self._joints
        self._speeds = np.full(self._joints, STEP_SPEED)
        "Speeds of moves, rad/s."
        self._velocity = np.zeros(self._joints)
        self._target: Vector | None = None
        "Target of the joints' moves, radians; None while they obey velocities or rest."
        self._count = 0
        self._state = OutputPort(f"{name}/state:o", names)
        self._extended_state = OutputPort(f"{name}/stateExt:o", names)
        self.ports = (
            RpcServer(f"{name}{messages.RPC_PORTS[dialect]}", self.answer, names),
            RpcServer(f"{name}/command:i", self._command, names),
            self._state,
            self._extended_state,
        )

    def step(self) -> None:
        """Move the drives, and stream their positions. Call it every few milliseconds."""
        with self._lock:
            if self._velocity.any():
                self._robot.move_head(self._velocity)
            angles, modes, stamp = self._robot.state().head, list(self._modes), self._stamp().encode()
        if self._robot.silent:
            return
        state = messages.extended_state(angles, modes, self._dialect)
        self._state.write(messages.encoders(angles).encode(self._dialect), envelope=stamp)
        self._extended_state.write(state.encode(self._dialect), envelope=stamp)

    def answer(self, request: Request) -> Reply:
        """Return a control board's reply to a request."""
        message = request.bottle()
        with self._lock:
            return self._answer_of_4(message) if self._dialect is Dialect.YARP4 else self._answer(message)

    def _answer(self, message: Bottle) -> Bottle:
        verb, what = (word(item) for item in [*message[:2], "", ""][:2])
        try:
            if (verb, what) == ("get", "prot"):
                return Bottle([Vocab("prot"), *PROTOCOL, messages.OK])
            if verb == "get":
                stamp = self._stamp()
                found = self._get(what, message[2:])
                return Bottle([Vocab("is"), *found, Vocab("tsta"), stamp.count, stamp.time, messages.OK])
            if verb == "set" and self._obey(what, message[2:]):
                return Bottle([messages.OK])
        except (IndexError, TypeError, RemoteProtocolError):
            pass
        return Bottle([messages.FAIL])

    def _answer_of_4(self, message: Bottle) -> Reply:
        method = word(message[0]) if message else ""
        if method == "getRemoteProtocolVersion":
            return VERSION_OF_4
        if method == "getDeviceInterfacesRPC":
            flags = (messages.OK if name in IMPLEMENTED else messages.FAIL for name in INTERFACES)
            can: list[Item] = [[name, flag] for name, flag in zip(INTERFACES, flags, strict=True)]
            return self._reply_of_4([messages.OK], can)
        verb, _, words = messages.METHODS.get(method, "").partition(" ")
        what, _, more = words.partition(" ")
        arguments = [*map(Vocab, more.split()), *message[1:]]
        try:
            if verb == "get":
                found = self._get(what, arguments)[1:]  # without the name, which only 3.x repeats
                if what == "dons":
                    found = [messages.OK if done else messages.FAIL for done in found]
                return self._reply_of_4([messages.OK], *found)
            if verb == "set":
                done = self._obey(what, arguments)
                return Bottle([messages.OK if done else messages.METHOD_FAILED], specialised=False)
        except (IndexError, TypeError, RemoteProtocolError):
            return Bottle([messages.METHOD_FAILED], specialised=False)
        return Bottle([messages.FAIL])

    @staticmethod
    def _reply_of_4(status: list[Item], *values: Item) -> bytes:
        return Bottle([Bottle(status, specialised=False), *values]).encode(Dialect.YARP4)

    def _command(self, request: Request) -> None:
        command = messages.read_board_command(request.bottle(), self._joints)
        with self._lock:
            if command is None:
                return
            wanted = np.zeros(self._joints)
            wanted[command.joints] = command.values
            obeying = np.zeros(self._joints, bool)
            obeying[command.joints] = True
            obeying &= [mode == command.mode for mode in self._modes]
            if command.mode == messages.VELOCITY_MODE:
                moving = [mode == messages.VELOCITY_MODE for mode in self._modes]
                self._go(np.where(obeying, wanted, np.where(moving, self._velocity, 0.0)))
            elif obeying.any():
                self._point(np.where(obeying, wanted, self._goal()), self._chain.fastest)

    def _get(self, what: str, rest: list[Item]) -> list[Item]:
        """Return the name of a value, then the value. Raises IndexError, RemoteProtocolError."""
        chain, angles = self._chain, self._robot.state().head
        values: dict[str, Callable[[], list[Item]]] = {
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
        if what in values:
            return [Vocab(what), *values[what]()]
        if what == "icmd" and word(rest[0]) == "cmds":
            return [Vocab("cmds"), list(self._modes)]
        if what == "icmd" and word(rest[0]) == "cmod":
            joint = self._joint(rest[1:])
            return [joint, self._modes[joint]]
        raise RemoteProtocolError(f"a control board has no '{what}'")

    def _obey(self, what: str, rest: list[Item]) -> bool:
        """Carry out a request; return False if it is unknown or not allowed in this mode."""
        angles = self._robot.truth().head
        if what in ("rels", "poss"):
            target = np.radians(messages.numbers(rest[0], self._joints))
            return self._move(target + angles if what == "rels" else target)
        if what in ("rel", "pos"):
            joint, target = self._joint(rest), self._goal()
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
        self._point(target, np.minimum(np.abs(self._speeds), self._chain.fastest))
        return True

    def _goal(self) -> Vector:
        """Return the joints' target, or their position without one."""
        return np.array(self._robot.truth().head if self._target is None else self._target)

    def _point(self, target: Vector, fastest: Vector) -> None:
        self._velocity, self._target = np.zeros(self._joints), target
        self._robot.point_head(target, fastest)

    def _go(self, velocity: Vector) -> None:
        self._velocity, self._target = velocity, None
        self._robot.move_head(velocity)

    def _set_modes(self, joints: range | list[int], modes: list[Item]) -> bool:
        known = {int(mode): mode for mode in MODES}
        wanted = [int(Vocab(item)) if isinstance(item, (str, int)) else 0 for item in modes]
        if len(modes) != len(joints) or not known.keys() >= set(wanted):
            return False
        for joint, mode in zip(joints, wanted, strict=True):
            self._modes[joint] = known[mode]
        self._go(np.zeros(self._joints))
        return True

    def _joint(self, rest: list[Item]) -> int:
        """Return the first joint in a request. Raises RemoteProtocolError."""
        return messages.joints(rest[:1], self._joints)[0]

    @property
    def _joints(self) -> int:
        return len(self._chain.joint_names)

    def _stamp(self) -> Stamp:
        self._count += 1
        return Stamp(self._count, time.time())
