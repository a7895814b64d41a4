"""The simulated TEO behind the YARP ports that the real one has, for any client of them."""

from __future__ import annotations

import logging
import threading
import time

import numpy as np

from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.ports import OutputPort, RpcServer
from grabbergui.net.yarp.os.request import Request
from grabbergui.net.yarp.os.values import word
from grabbergui.servo.robots import teo_messages as messages
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.robots.teo_yarp import ARM, ARM_BOARD, HEAD

log = logging.getLogger(__name__)

PERIOD = 0.01
"Seconds between two readings that are streamed."


class TeoPorts:
    """A control board for the head, a Cartesian controller for the right arm and its encoders. Any thread."""

    def __init__(self, robot: SimRobot, names: NameClient, prefix: str = "/teoSim") -> None:
        self._robot = robot
        self._expects_twists = False
        self._moving = False
        self._head_state = OutputPort(f"{prefix}{HEAD}/state:o", names)
        self._arm_state = OutputPort(f"{prefix}{ARM}/state:o", names)
        self._arm_encoders = OutputPort(f"{prefix}{ARM_BOARD}/state:o", names)
        self._ports = (
            RpcServer(f"{prefix}{HEAD}/rpc:i", self._head_request, names),
            RpcServer(f"{prefix}{HEAD}/command:i", self._head_command, names),
            self._head_state,
            RpcServer(f"{prefix}{ARM}/rpc:s", self._arm_request, names),
            RpcServer(f"{prefix}{ARM}/command:i", self._arm_command, names),
            self._arm_state,
            self._arm_encoders,
        )
        self._running = threading.Event()
        self._thread: threading.Thread | None = None

    def open(self) -> None:
        """Open all ports and stream. Raises SourceUnavailableError, TransportError."""
        try:
            for port in self._ports:
                port.open()
        except BaseException:
            self.close()
            raise
        self._running.set()
        self._thread = threading.Thread(target=self._stream, name="simulated TEO", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop the robot and drop the ports. May be called twice; never raises."""
        self._running.clear()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        self._robot.stop()
        for port in self._ports:
            port.close()

    def _stream(self) -> None:
        while self._running.is_set():
            state = self._robot.state()
            self._head_state.write_bottle(messages.encoders(state.head))
            self._arm_state.write_bottle(self._status())
            if state.arm is not None:
                self._arm_encoders.write_bottle(messages.encoders(state.arm))
            time.sleep(PERIOD)

    def _status(self) -> Bottle:
        state = messages.VELOCITY_CONTROLLING if self._moving else messages.NOT_CONTROLLING
        return messages.status(state, self._robot.state().hand, time.time())

    def _head_command(self, request: Request) -> None:
        velocity = messages.read_velocity_moves(request.bottle(), 2)
        if velocity is not None:
            self._robot.move_head(velocity)

    def _head_request(self, request: Request) -> Bottle:
        message = request.bottle()
        verbs = [word(item) for item in message[:3]]
        if verbs[:2] == ["set", "rels"] and len(message) == 3:
            self._robot.step_head(np.radians(messages.numbers(message[2], 2)))
        elif verbs[:2] == ["set", "stos"]:
            self._robot.move_head(np.zeros(2))
        elif verbs[:2] == ["get", "encs"]:
            angles: list[object] = list(messages.encoders(self._robot.state().head))
            return Bottle([*message[:2], angles, messages.OK])  # type: ignore[list-item]
        elif verbs[:2] == ["get", "axes"]:
            return Bottle([*message[:2], 2, messages.OK])
        elif verbs[:2] != ["set", "icmd"]:
            return Bottle([messages.FAIL])
        return Bottle([messages.OK])

    def _arm_command(self, request: Request) -> None:
        twist = messages.read_twist(request.bottle())
        # As the reference: a stream is obeyed only once it has been announced.
        if twist is not None and self._expects_twists:
            self._moving = bool(twist.any())
            self._robot.move_hand(twist)

    def _arm_request(self, request: Request) -> Bottle:
        message = request.bottle()
        verbs = [word(item) for item in message[:3]]
        if verbs[:1] == ["stat"]:
            return self._status()
        if verbs == ["set", "cpsc", "twst"]:
            self._expects_twists = True
        elif verbs[:1] == ["stop"]:
            self._expects_twists = self._moving = False
            self._robot.move_hand(np.zeros(6))
        else:
            return Bottle([messages.FAIL])
        return Bottle([messages.OK])
