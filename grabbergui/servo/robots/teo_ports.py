"""The simulated TEO behind the YARP ports of the real one, for any client.

`teo_board` is the head's control board. The arm's Cartesian controller is here, as roboticslab's
CartesianControlServer presents it, and `TeoPorts`, which opens and steps both.
"""

from __future__ import annotations

import threading
import time

import numpy as np

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.inputs import Reply, Request
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.ports import OutputPort, RpcServer, open_all
from grabbergui.net.yarp.os.values import Dialect, Item, Vocab, word
from grabbergui.servo.kinematics import Chain
from grabbergui.servo.robots import cartesian_messages
from grabbergui.servo.robots import teo_messages as messages
from grabbergui.servo.robots.cartesian_messages import NOT_CONTROLLING, POSE_WORDS, read_cartesian_command
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.robots.teo_board import SimulatedBoard
from grabbergui.servo.robots.teo_messages import FAIL, OK, degrees, numbers
from grabbergui.servo.robots.teo_yarp import ARM, ARM_BOARD, HEAD

PERIOD = 0.01
"Seconds between two streamed readings."
MOVING = {"movj": Vocab("ccjc"), "relj": Vocab("ccjc"), "movl": Vocab("cclc"), "movv": Vocab("ccvc")}
"The controller's state for each kind of motion."
ARRIVED = (5e-4, 2e-3)
"Metres and radians from a target within which a move is done."
GAIN = 8.0
"1/s: velocity per distance to a target."
NEGLIGIBLE = 1e-5
"Singular value of the Jacobian, relative to the largest, that the solver takes for zero."
AT_END = np.radians(1e-5)
"Radians from a joint's limit within which it is at its end."
TURN = 0.6
"Highest rotational speed on the way to a target, rad/s."


def joint_velocities(arm: Chain, angles: Vector, twist: Vector) -> Vector:
    """Return the joint velocities, rad/s, with which BasicCartesianControl follows a streamed twist.

    They hold until the next command. Its solver is KDL's pseudo-inverse, which knows no limits. The whole arm
    stops if a joint would have to be faster than its limit, or if one is at its end and would move outwards.
    """
    velocities: Vector = np.linalg.pinv(arm.jacobian(angles), rcond=NEGLIGIBLE) @ twist
    low, high = angles < arm.low + AT_END, angles > arm.high - AT_END
    outwards = (low & (velocities < 0)) | (high & (velocities > 0))
    if outwards.any() or (np.abs(velocities) > arm.fastest).any():
        return np.zeros_like(velocities)
    return velocities


class SimulatedCartesian:
    """Ports `NAME/rpc:s`, `/command:i` and `/state:o` of a robot's arm. Any thread.

    It follows BasicCartesianControl: it obeys streamed commands only after they were announced (`cpsc`) and
    while nothing is controlled; any other motion and any stop end that. A twist holds until the next command,
    as in velocity mode; the arm goes straight to a streamed pose, as in position direct mode. Joint moves are
    straight lines, too; it refuses forces and tools.

    By default the arm follows a twist as far as it can, which is worse for whoever has to keep limits. With
    `kdl` it follows streamed twists as BasicCartesianControl does (`joint_velocities`).
    """

    def __init__(
        self,
        robot: SimRobot,
        names: NameClient,
        name: str,
        dialect: Dialect = Dialect.YARP3,
        pose_word: Vocab = POSE_WORDS[-1],
        *,
        kdl: bool = False,
    ) -> None:
        """`pose_word` announces and starts streamed poses; it depends on the controller's version."""
        self._robot, self._kdl = robot, kdl
        self._dialect = dialect
        self._pose_word = str(pose_word)
        self._changed = threading.Condition(threading.RLock())
        self._state = NOT_CONTROLLING
        self._twist: Vector | None = None
        self._velocity: Vector | None = None
        "With `kdl` the joint velocities of the newest streamed twist, rad/s."
        self._target: Pose | None = None
        self._settings: dict[str, Item] = {
            **{"cpf": Vocab("cpfb"), "cpsc": Vocab("nset"), "cpcg": 0.05, "cptd": 0.0},
            **{"cpts": 0.05, "cpta": 0.02, "cpcp": 50.0, "cpwp": 30.0},
        }
        self._stream = OutputPort(f"{name}/state:o", names)
        self.ports = (
            RpcServer(f"{name}/rpc:s", self.answer, names),
            RpcServer(f"{name}/command:i", self._command, names),
            self._stream,
        )

    def step(self) -> None:
        """Move the arm, and stream its pose. Call it every few milliseconds."""
        with self._changed:
            if self._target is not None:
                self._approach(self._robot.truth().hand, self._target)
            elif self._twist is not None:
                self._robot.move_hand(self._in_base(self._twist))
            elif self._velocity is not None:
                self._robot.move_arm(self._velocity)
            status = self._status()
        if not self._robot.silent:
            self._stream.write(status.encode(self._dialect))

    def stop(self) -> None:
        """End the current motion, and the calls that wait for it."""
        with self._changed:
            self._rest()

    def answer(self, request: Request) -> Reply:
        """Return a Cartesian controller's reply to a request; `wait` returns after the motion."""
        message = request.bottle()
        with self._changed:
            try:
                reply = self._answer([word(item) for item in [*message[:3], "", "", ""]], message)
            except (IndexError, RemoteProtocolError):
                reply = Bottle([FAIL])
        return reply if self._dialect is Dialect.YARP3 else reply.encode(self._dialect)

    def _answer(self, verbs: list[str], message: Bottle) -> Bottle:
        if verbs[0] == "stat":
            return self._status()
        if verbs[0] == "inv":
            angles = self._joints_at(geometry.pose_from_vector(numbers(message[1:], 6)))
            return Bottle([FAIL] if angles is None else degrees(angles))
        if verbs[0] == "get":
            return self._get(verbs[1])
        return Bottle([OK if self._obey(verbs, message) else FAIL])

    def _obey(self, verbs: list[str], message: Bottle) -> bool:
        if verbs[0] in MOVING:
            return self._begin(verbs[0], numbers(message[1:], 6))
        if verbs[0] == "stop":
            self._rest()
        elif verbs[0] == "wait":
            seconds = float(numbers(message[1:], 1)[0]) if len(message) > 1 else 0.0
            return self._wait(min(seconds, threading.TIMEOUT_MAX) or None)
        elif verbs[:2] == ["set", "prms"]:
            pairs = [item if isinstance(item, list) else [] for item in message[2:]]
            return bool(pairs) and all(self._set(word(pair[0]), pair[1]) for pair in pairs)
        elif verbs[0] == "set":
            return self._set(verbs[1], message[2])
        else:
            return False
        return True

    def _command(self, request: Request) -> None:
        message = request.bottle()
        with self._changed:
            # As the reference: obey a stream only after it was announced.
            announced = word(self._settings["cpsc"])
            values = read_cartesian_command(message, announced)
            if values is None:
                return
            if announced == "twst":
                self._follow(self._in_base(values), values)
            else:
                angles = self._joints_at(self._absolute(values))
                if angles is not None:
                    self._robot.point_arm(angles)

    def _follow(self, in_base: Vector, twist: Vector) -> None:
        """Follow a streamed twist, which is given along the base's axes and along the configured ones."""
        if not self._kdl:
            self._twist = twist
            self._robot.move_hand(in_base)
            return
        arm = self._robot.truth().arm
        assert arm is not None
        self._velocity = joint_velocities(self._robot.model.arm, arm, in_base)
        self._robot.move_arm(self._velocity)

    def _get(self, what: str) -> Bottle:
        if what == "prms":
            return Bottle([[Vocab(key), value] for key, value in self._settings.items()])
        return Bottle([self._settings.get(what, FAIL)])

    def _set(self, what: str, value: Item) -> bool:
        """Change a setting; return False if it is unknown or out of range, or while the arm moves."""
        if self._state != NOT_CONTROLLING or what not in self._settings:
            return False
        if what == "cpsc":
            allowed = word(value) in ("twst", self._pose_word)
        elif what == "cpf":
            allowed = word(value) in ("cpfb", "cpft")
        else:
            least = float(numbers([value], 1)[0])
            allowed = least > 0 or (least == 0 and what in ("cpcg", "cptd"))
        if not allowed:
            return False
        if what == "cpsc":
            self._rest()
        self._settings[what] = Vocab(word(value)) if word(value) else value
        return True

    def _begin(self, how: str, values: Vector) -> bool:
        target = None
        if how != "movv":
            if how == "relj" and not self._in_hand:  # the reference adds the numbers, too
                values = values + geometry.vector_from_pose(self._robot.truth().hand)
            target = self._absolute(values)
            if self._joints_at(target) is None:
                return False
        self._rest()
        self._state, self._target = MOVING[how], target
        self._twist = values if how == "movv" else None
        return True

    def _approach(self, hand: Pose, target: Pose) -> None:
        off = geometry.diff(hand, target)
        if geometry.distance(hand, target) < ARRIVED[0] and np.linalg.norm(off[3:]) < ARRIVED[1]:
            if self._state != NOT_CONTROLLING:
                self._rest()
            return
        speed = float(self._settings["cpts"])  # type: ignore[arg-type]
        for part, fastest in ((off[:3], speed), (off[3:], TURN)):
            part *= min(GAIN, fastest / max(float(np.linalg.norm(part)), 1e-9))
        self._robot.move_hand(off)

    def _rest(self) -> None:
        self._state, self._settings["cpsc"] = NOT_CONTROLLING, Vocab("nset")
        self._target = self._twist = self._velocity = None
        self._robot.move_hand(np.zeros(6))
        self._changed.notify_all()

    def _wait(self, seconds: float | None) -> bool:
        """Wait until a move is done; stop it and return False after `seconds`."""

        def done() -> bool:
            return self._target is None or self._state == NOT_CONTROLLING

        if not self._changed.wait_for(done, seconds):
            self._rest()
            return False
        return True

    def _absolute(self, values: Vector) -> Pose:
        pose = geometry.pose_from_vector(values)
        return self._robot.truth().hand @ pose if self._in_hand else pose

    def _in_base(self, twist: Vector) -> Vector:
        """Return a twist, given along the configured axes, along the base's."""
        turn = self._robot.truth().hand[:3, :3] if self._in_hand else np.eye(3)
        return np.concatenate((turn @ twist[:3], turn @ twist[3:]))

    @property
    def _in_hand(self) -> bool:
        return self._settings["cpf"] == Vocab("cpft")

    def _joints_at(self, target: Pose) -> Vector | None:
        arm = self._robot.truth().arm
        return self._robot.model.arm.inverse(target, self._robot.model.home if arm is None else arm)

    def _status(self) -> Bottle:
        return cartesian_messages.status(self._state, self._robot.state().hand, time.time())


class TeoPorts:
    """The head's control board, the right arm's Cartesian controller and its encoders. Any thread."""

    def __init__(
        self,
        robot: SimRobot,
        names: NameClient,
        prefix: str = "/teoSim",
        dialect: Dialect = Dialect.YARP3,
        pose_word: Vocab = POSE_WORDS[-1],
        *,
        kdl: bool = False,
    ) -> None:
        """All ports speak `dialect`; for `pose_word` and `kdl` see SimulatedCartesian."""
        self._robot = robot
        self._dialect = dialect
        self._head = SimulatedBoard(robot, names, f"{prefix}{HEAD}", dialect)
        self._arm = SimulatedCartesian(robot, names, f"{prefix}{ARM}", dialect, pose_word, kdl=kdl)
        self._arm_encoders = OutputPort(f"{prefix}{ARM_BOARD}/state:o", names)
        self._ports = (*self._head.ports, *self._arm.ports, self._arm_encoders)
        self._running = threading.Event()
        self._thread: threading.Thread | None = None

    def open(self) -> None:
        """Open all ports and stream. Raises SourceUnavailableError, TransportError."""
        open_all(self._ports)
        self._running.set()
        self._thread = threading.Thread(target=self._stream, name="simulated TEO", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop the robot and drop the ports. May be called twice; never raises."""
        self._running.clear()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        self._arm.stop()
        self._robot.stop()
        for port in self._ports:
            port.close()

    def _stream(self) -> None:
        while self._running.is_set():
            self._step()
            time.sleep(PERIOD)

    def _step(self) -> None:
        """Move the drives, and stream their positions."""
        self._head.step()
        self._arm.step()
        state = self._robot.state()
        if state.arm is not None and not self._robot.silent:
            self._arm_encoders.write(messages.encoders(state.arm).encode(self._dialect))
