"""TEO on a YARP network: the head through its control board, the arm through its Cartesian controller."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from contextlib import suppress

import numpy as np

from grabbergui.calibration.geometry import Vector
from grabbergui.core.errors import FrameTimeoutError, GrabberError, ProtocolError, TransportError
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.names import Target
from grabbergui.net.yarp.os.ports import InputPort, OutputPort
from grabbergui.net.yarp.os.rpc_client import RpcClient
from grabbergui.net.yarp.os.values import Vocab
from grabbergui.servo.robots import teo
from grabbergui.servo.robots import teo_messages as messages
from grabbergui.servo.robots.robot import Robot, RobotState

log = logging.getLogger(__name__)

HEAD, ARM_BOARD = "/head", "/rightArm"
ARM = f"{ARM_BOARD}/CartesianControl"
_STOP_TIMEOUT = 0.3
_CARRIER = "fast_tcp"
_ARM_FRESH = 0.3
"Seconds that the arm's angles may be older than the head's."


class TeoOverYarp(Robot):
    """A TEO, real or simulated, whose ports begin with `remote`. Readings arrive on threads of their own.

    Its drives keep their velocity until the next command: the gate's watchdog ends it in time.
    """

    def __init__(
        self,
        names: NameClient,
        remote: str = "/teoSim",
        local: str = "/grabbergui/servo",
        *,
        listen_only: bool = False,
    ) -> None:
        """With `listen_only` no port for commands is opened and no request is made."""
        super().__init__(teo.MODEL)
        self._remote = remote
        self._listen_only = listen_only
        self._names = names
        self._head_commands = OutputPort(f"{local}{HEAD}/command:o", names)
        self._arm_commands = OutputPort(f"{local}{ARM}/command:o", names)
        self._head_state = InputPort(f"{local}{HEAD}/state:i", names)
        self._arm_state = InputPort(f"{local}{ARM}/state:i", names)
        self._arm_encoders = InputPort(f"{local}{ARM_BOARD}/state:i", names)
        self._head_rpc = RpcClient(f"{remote}{HEAD}/rpc:i", names)
        self._arm_rpc = RpcClient(f"{remote}{ARM}/rpc:s", names)
        # Connections of their own: a request that is still waited for must not hold up a stop.
        self._head_stop = RpcClient(self._head_rpc.target, names)
        self._arm_stop = RpcClient(self._arm_rpc.target, names)
        self._readings: dict[str, tuple[float, np.ndarray]] = {}
        self._mode: Vocab | None = None
        self._ready_for_twists = False
        self._stops = 0
        "How many there were; a command during which one came is not sent any more."
        self._sending = threading.Lock()
        "Held while a command is written, which never waits, so that a stop is the later of the two."
        self._running = threading.Event()
        self._threads: list[threading.Thread] = []

    def open(self) -> None:
        """See Robot. Opens our ports, connects them to the robot's, and starts to listen."""
        try:
            for port in self._ports:
                port.open()
            if not self._listen_only:
                self._connect_commands()
            self._head_state.connect(f"{self._remote}{HEAD}/state:o", _CARRIER)
            self._arm_state.connect(f"{self._remote}{ARM}/state:o", _CARRIER)
        except GrabberError:
            self.close()
            raise
        self._connect_arm_encoders()
        self._running.set()
        self._listen("head", self._head_state, lambda bottle: messages.read_encoders(bottle, 2))
        self._listen("hand", self._arm_state, messages.read_status)
        self._listen("arm", self._arm_encoders, lambda bottle: messages.read_encoders(bottle, 6))

    def close(self) -> None:
        """See Robot."""
        if self._running.is_set():
            self.stop()
        self._running.clear()
        for port in self._ports:
            port.close()
        for thread in self._threads:
            thread.join()
        self._threads = []
        for client in (self._head_rpc, self._arm_rpc, self._head_stop, self._arm_stop):
            client.close()

    def state(self) -> RobotState | None:
        """See Robot; as old as the older of head and hand. The arm's angles are for eyes and explanations."""
        head, hand, arm = (self._readings.get(part) for part in ("head", "hand", "arm"))
        if head is None or hand is None:
            return None
        fresh = arm is not None and head[0] - arm[0] < _ARM_FRESH
        return RobotState(min(head[0], hand[0]), head[1], hand[1], arm[1] if arm and fresh else None)

    def move_head(self, velocity: Vector) -> None:
        """See Robot."""
        if self._listen_only:
            return
        stops = self._stops
        self._set_mode(messages.VELOCITY_MODE, stops)
        self._send(self._head_commands, messages.velocity_moves(velocity), stops)

    def step_head(self, move: Vector) -> None:
        """See Robot."""
        if self._listen_only:
            return
        stops = self._stops
        self._set_mode(messages.POSITION_MODE, stops)
        self._ask(self._head_rpc, messages.relative_moves(move))

    def move_hand(self, twist: Vector) -> None:
        """See Robot. Getting the controller ready takes it 0.1 s: its drives change their mode."""
        if self._listen_only:
            return
        stops = self._stops
        if not self._ready_for_twists:
            # Another client may have left it obeying twists along the hand's axes.
            self._ask(self._arm_rpc, messages.base_frame())
            self._ask(self._arm_rpc, messages.expect_twists())
            with self._sending:
                self._check(stops)
                self._ready_for_twists = True
        self._send(self._arm_commands, messages.twist(twist), stops)

    def stop(self) -> bool:
        """See Robot. Says it on the streams, which do not wait, then asks for it and awaits the answers.

        The head first, as its board answers at once; drives of an arm take 0.1 s to change their mode.
        """
        if self._listen_only:
            return True
        with self._sending:
            self._stops += 1
            self._arm_commands.write_bottle(messages.twist(np.zeros(6)))
            if self._mode != messages.POSITION_MODE:
                self._head_commands.write_bottle(messages.velocity_moves(np.zeros(2)))
            self._ready_for_twists, self._mode = False, None
        delivered = True
        for client, request in (
            (self._head_stop, messages.stop_all()),
            (self._arm_stop, messages.stop_control()),
        ):
            try:
                self._ask(client, request, _STOP_TIMEOUT)
            except GrabberError as error:
                log.error("%s did not confirm the stop: %s", client.target, error)
                delivered = False
        return delivered

    def stop_channels(self) -> list[dict[str, str]]:
        """See Robot. As `stop` does: on the streams first, then by request."""
        head, arm = f"{self._remote}{HEAD}", f"{self._remote}{ARM}"
        rest = (
            (f"{arm}/command:i", messages.twist(np.zeros(6))),
            (f"{head}/command:i", messages.velocity_moves(np.zeros(2))),
        )
        requests = (
            (f"{head}/rpc:i", messages.stop_all(), messages.axes()),
            (f"{arm}/rpc:s", messages.stop_control(), messages.ask_status()),
        )
        channels = [{"kind": "yarp stream", "port": port, "stop": stop.to_text()} for port, stop in rest]
        channels += [
            {"kind": "yarp request", "port": port, "stop": stop.to_text(), "check": check.to_text()}
            for port, stop, check in requests
        ]
        server = self._names.server
        return [{**channel, "nameserver": f"{server.host}:{server.port}"} for channel in channels]

    @property
    def _ports(self) -> tuple[OutputPort | InputPort, ...]:
        inputs = self._head_state, self._arm_state, self._arm_encoders
        return inputs if self._listen_only else (self._head_commands, self._arm_commands, *inputs)

    def _connect_commands(self) -> None:
        self._head_commands.add(Target.parse(f"{self._remote}{HEAD}/command:i", _CARRIER))
        self._arm_commands.add(Target.parse(f"{self._remote}{ARM}/command:i", _CARRIER))

    def _connect_arm_encoders(self) -> None:
        """Nothing is moved by them, so a robot may do without."""
        try:
            self._arm_encoders.connect(f"{self._remote}{ARM_BOARD}/state:o", _CARRIER)
        except GrabberError as error:
            log.info("the arm's joints are not known: %s", error)

    def _set_mode(self, mode: Vocab, stops: int) -> None:
        if self._mode != mode:
            self._ask(self._head_rpc, messages.control_modes(mode, 2))
            with self._sending:
                self._check(stops)
                self._mode = mode

    def _send(self, port: OutputPort, command: Bottle, stops: int) -> None:
        """Write a command unless a stop came since `stops` was read, or nobody would hear it."""
        if not port.carriers(outgoing=True):
            raise TransportError(f"{self._remote} is not connected to {port.name} any more: start again")
        with self._sending:
            self._check(stops)
            port.write_bottle(command)

    def _check(self, stops: int) -> None:
        if stops != self._stops:
            raise TransportError(f"{self._remote} was stopped meanwhile")

    def _ask(self, client: RpcClient, request: Bottle, timeout: float = 1.0) -> None:
        reply = client.call(request, timeout)
        if not messages.succeeded(reply):
            raise TransportError(f"{client.target} refused {request.to_text()}: {reply}")

    def _listen(self, name: str, port: InputPort, read: Callable[[Bottle], np.ndarray]) -> None:
        thread = threading.Thread(target=self._receive, args=(name, port, read), name=port.name, daemon=True)
        thread.start()
        self._threads.append(thread)

    def _receive(self, name: str, port: InputPort, read: Callable[[Bottle], np.ndarray]) -> None:
        while self._running.is_set():
            with suppress(FrameTimeoutError):
                data, _ = port.read(0.2)
                try:
                    # The robot's clock may be another; a reading is as old as its arrival.
                    self._readings[name] = (time.monotonic(), read(Bottle.decode(data)))
                except ProtocolError as error:
                    log.warning("%s: %s", port.name, error)
