"""TEO on a YARP network: the head through its control board, the arm through its Cartesian controller.

Both may be of YARP 3.x or 4.0; requests that move nothing find out which. In the mode `direct` both parts get
short positions, to which drives in position direct mode go, and where they rest.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Sequence

import numpy as np
from typing_extensions import override

from grabbergui.calibration.geometry import Vector
from grabbergui.core.errors import GrabberError, ProtocolError, TransportError
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.inputs import Reply, Request
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.ports import InputPort, OutputPort
from grabbergui.net.yarp.os.rpc_client import RpcClient
from grabbergui.net.yarp.os.target import Target
from grabbergui.net.yarp.os.values import Dialect, Vocab
from grabbergui.servo.robots import cartesian_messages, teo, teo_messages
from grabbergui.servo.robots.cartesian_messages import (
    POSE_WORDS,
    TWIST,
    announce,
    ask_status,
    base_frame,
    read_status,
    stop_control,
    streamed_pose,
)
from grabbergui.servo.robots.leading_target import leading_hand, leading_head
from grabbergui.servo.robots.robot import Robot, RobotState

log = logging.getLogger(__name__)

HEAD, ARM_BOARD = "/head", "/rightArm"
ARM = f"{ARM_BOARD}/CartesianControl"
_STOP_TIMEOUT = 0.3
_CARRIER = "fast_tcp"
_ARM_FRESH = 0.2
"Seconds between the readings of the hand and of its joints beyond which the joints do not count."


_LOCAL = "/grabbergui/servo"
"Beginning of our ports' names."


class TeoOverYarp(Robot):
    """A TEO, real or simulated, whose ports begin with `remote`. Readings arrive on the connections' threads.

    Its drives keep their velocity until the next command; the gate's watchdog ends it in time.
    """

    def __init__(
        self,
        names: NameClient,
        remote: str = "/teoSim",
        *,
        listen_only: bool = False,
    ) -> None:
        """With `listen_only` it opens no port for commands and makes no request."""
        super().__init__(teo.MODEL)
        self._remote = remote
        self._listen_only = listen_only
        self._names = names
        self._head_commands = OutputPort(f"{_LOCAL}{HEAD}/command:o", names)
        self._arm_commands = OutputPort(f"{_LOCAL}{ARM}/command:o", names)
        self._readings: dict[str, tuple[float, np.ndarray]] = {}

        def listener(part: str, port: str, read: Callable[[Bottle], np.ndarray]) -> InputPort:
            return _ReadingPort(f"{_LOCAL}{port}/state:i", names, part, self._readings, read)

        self._head_state = listener("head", HEAD, lambda bottle: teo_messages.read_encoders(bottle, 2))
        self._arm_state = listener("hand", ARM, read_status)
        self._arm_encoders = listener("arm", ARM_BOARD, lambda bottle: teo_messages.read_encoders(bottle, 6))
        self._head_rpc = RpcClient(f"{remote}{HEAD}/rpc:i", names)
        self._arm_rpc = RpcClient(f"{remote}{ARM}/rpc:s", names)
        # Separate connections: a request without its reply yet must not delay a stop.
        self._head_stop = RpcClient(self._head_rpc.target, names)
        self._arm_stop = RpcClient(self._arm_rpc.target, names)
        self._dialects: tuple[Dialect, Dialect] | None = None
        self._mode: Vocab | None = None
        self._announced: Vocab | None = None
        "The kind of command that was announced to the arm's controller."
        self._pose_words = POSE_WORDS
        self._leading_head, self._leading_hand = leading_head(), leading_hand()
        self._stops = 0
        "Number of stops so far; a command is not sent if one came while it was prepared."
        self._sending = threading.Lock()
        "Held while a command is written (which never waits), so that a stop is written after it."
        self._unconfirmed: set[str] = set()
        "What was logged since the last stop that both controllers confirmed."
        self._open = False

    def open(self) -> None:
        """See Robot. Opens ports, connects them to the robot's, and starts to listen."""
        try:
            for port in self._ports:
                port.open()
            if not self._listen_only:
                self._find_dialects()
                self._connect_commands()
            self._head_state.connect(f"{self._remote}{HEAD}/state:o", _CARRIER)
            self._arm_state.connect(f"{self._remote}{ARM}/state:o", _CARRIER)
        except GrabberError:
            self.close()
            raise
        self._connect_arm_encoders()
        self._open = True

    def close(self) -> None:
        """See Robot."""
        if self._open:
            self.stop()
        self._open = False
        for port in self._ports:
            port.close()
        for client in (self._head_rpc, self._arm_rpc, self._head_stop, self._arm_stop):
            client.close()

    def state(self) -> RobotState | None:
        """See Robot; as old as the older of head and hand."""
        head, hand, arm = (self._readings.get(part) for part in ("head", "hand", "arm"))
        if head is None or hand is None:
            return None
        angles, apart = None, 0.0
        if arm is not None and abs(hand[0] - arm[0]) < _ARM_FRESH:
            angles, apart = arm[1], abs(hand[0] - arm[0])
        return RobotState(min(head[0], hand[0]), head[1], hand[1], angles, apart)

    @override
    def silence(self) -> str:
        if all(port.carriers(outgoing=False) for port in (self._head_state, self._arm_state)):
            return ""
        return f"{self._remote} is no longer connected: start the program again once the robot is back"

    def move_head(self, velocity: Vector) -> None:
        """See Robot."""
        if self._listen_only:
            return
        stops = self._stops
        self._set_mode(teo_messages.VELOCITY_MODE, stops)
        command = teo_messages.velocity_moves(velocity, self._board)
        self._send(self._head_commands, command.encode(self._board), stops)

    def lead_head(self, velocity: Vector, seconds: float) -> None:
        """See Robot. Streams positions to drives in position direct mode."""
        if self._listen_only or not np.any(velocity):
            return
        stops = self._stops
        self._set_mode(teo_messages.DIRECT_MODE, stops)
        target = self._leading_head.advance(self._reading().head, velocity, seconds, time.monotonic())
        positions = teo_messages.direct_positions(self.model.head.clamped(target), self._board)
        self._send(self._head_commands, positions.encode(self._board), stops)

    def step_head(self, move: Vector) -> None:
        """See Robot."""
        if self._listen_only:
            return
        stops = self._stops
        self._set_mode(teo_messages.POSITION_MODE, stops)
        self._ask(self._head_rpc, teo_messages.relative_moves(move, self._board))

    def move_hand(self, twist: Vector) -> None:
        """See Robot. The first twist takes 0.1 s longer, as the drives change their mode."""
        if self._listen_only:
            return
        stops = self._stops
        self._announce((TWIST,), stops)
        self._send(self._arm_commands, cartesian_messages.twist(twist).encode(self._controller), stops)

    def lead_hand(self, twist: Vector, seconds: float) -> None:
        """See Robot. Streams poses to a controller whose drives are in position direct mode."""
        if self._listen_only or not np.any(twist):
            return
        stops = self._stops
        word = self._announce(self._pose_words, stops)
        target = self._leading_hand.advance(self._reading().hand, twist, seconds, time.monotonic())
        pose = streamed_pose(target, word)
        self._send(self._arm_commands, pose.encode(self._controller), stops)

    def stop(self) -> bool:
        """See Robot. Sends it on the streams, which do not wait, then requests it and awaits the replies.

        The head comes first, as its board replies immediately; the arm's drives take 0.1 s to change their
        mode. Drives that got positions rest by themselves and need nothing on a stream.
        """
        if self._listen_only:
            return True
        with self._sending:
            self._stops += 1
            if self._announced not in self._pose_words:
                still = cartesian_messages.twist(np.zeros(6))
                self._arm_commands.write(still.encode(self._controller))
            if self._mode in (None, teo_messages.VELOCITY_MODE):
                still = teo_messages.velocity_moves(np.zeros(2), self._board)
                self._head_commands.write(still.encode(self._board))
            self._announced = self._mode = None
            self._leading_head.forget()
            self._leading_hand.forget()
        delivered = True
        for client, request in (
            (self._head_stop, teo_messages.stop_all(self._board)),
            (self._arm_stop, stop_control()),
        ):
            try:
                self._ask(client, request, _STOP_TIMEOUT)
            except GrabberError as error:
                text = f"{client.target} did not confirm the stop: {error}"
                # A robot that is gone is stopped many times; once says it.
                log.log(logging.DEBUG if text in self._unconfirmed else logging.ERROR, "%s", text)
                self._unconfirmed.add(text)
                delivered = False
        if delivered:
            self._unconfirmed.clear()
        return delivered

    def stop_channels(self) -> list[dict[str, str]]:
        """See Robot. As `stop`: on the streams first, then by request.

        Finds the robot's dialects; raises SourceNotFoundError, SourceUnavailableError, TransportError.
        """
        board, controller = self._find_dialects()
        head, arm = f"{self._remote}{HEAD}", f"{self._remote}{ARM}"
        twist, velocity = (
            cartesian_messages.twist(np.zeros(6)),
            teo_messages.velocity_moves(np.zeros(2), board),
        )
        stop, axes = teo_messages.stop_all(board), teo_messages.axes(board)
        stop_arm, status = stop_control(), ask_status()
        server = self._names.server

        def channel(kind: str, port: str, dialect: Dialect, **messages: Bottle) -> dict[str, str]:
            declared = {"kind": f"yarp {kind}", "port": port, "dialect": dialect.value}
            declared["nameserver"] = f"{server.host}:{server.port}"
            return declared | {name: message.to_text() for name, message in messages.items()}

        return [
            channel("stream", f"{arm}/command:i", controller, stop=twist),
            channel("stream", f"{head}/command:i", board, stop=velocity),
            channel("request", self._head_rpc.target, board, stop=stop, check=axes),
            channel("request", f"{arm}/rpc:s", controller, stop=stop_arm, check=status),
        ]

    @property
    def _ports(self) -> tuple[OutputPort | InputPort, ...]:
        inputs = self._head_state, self._arm_state, self._arm_encoders
        return inputs if self._listen_only else (self._head_commands, self._arm_commands, *inputs)

    def _connect_commands(self) -> None:
        self._head_commands.add(Target.parse(f"{self._remote}{HEAD}/command:i", _CARRIER))
        self._arm_commands.add(Target.parse(f"{self._remote}{ARM}/command:i", _CARRIER))

    def _connect_arm_encoders(self) -> None:
        """Connect them if the robot has them; control does not need them."""
        try:
            self._arm_encoders.connect(f"{self._remote}{ARM_BOARD}/state:o", _CARRIER)
        except GrabberError as error:
            log.info("the arm's joint angles are not known: %s", error)

    @property
    def _board(self) -> Dialect:
        return self._dialects[0] if self._dialects else Dialect.YARP3

    @property
    def _controller(self) -> Dialect:
        return self._dialects[1] if self._dialects else Dialect.YARP3

    def _find_dialects(self) -> tuple[Dialect, Dialect]:
        """Return the dialects of the head's board and of the arm's controller."""
        if self._dialects is None:
            board = self._find_board()
            # The controller's words are the same in both dialects; its numbers' type codes differ.
            status = self._arm_rpc.call(ask_status())
            controller = Dialect.YARP3 if status is None or status.dialect is None else status.dialect
            self._dialects = board, controller
            for client in (self._arm_rpc, self._arm_stop):
                client.dialect = controller
            log.info("%s: its head speaks YARP %s, its arm %s", self._remote, board.value, controller.value)
        return self._dialects

    def _find_board(self) -> Dialect:
        """Return the dialect of the head's board, by the name of its port for requests.

        A name may still be registered although its port is gone, so the port must answer.
        """
        for dialect, suffix in teo_messages.RPC_PORTS.items():
            for client in (self._head_rpc, self._head_stop):
                client.close()
                client.target, client.dialect = f"{self._remote}{HEAD}{suffix}", dialect
            try:
                self._ask(self._head_rpc, teo_messages.axes(dialect))
                break
            except GrabberError:
                if dialect is Dialect.YARP3:
                    raise
        return self._head_rpc.dialect

    def _reading(self) -> RobotState:
        state = self.state()
        if state is None:
            raise TransportError(f"{self._remote} has not reported its position yet")
        return state

    def _set_mode(self, mode: Vocab, stops: int) -> None:
        if self._mode != mode:
            self._ask(self._head_rpc, teo_messages.control_modes(mode, 2, self._board))
            with self._sending:
                self._check(stops)
                self._mode = mode
                self._leading_head.forget()

    def _announce(self, commands: Sequence[Vocab], stops: int) -> Vocab:
        """Announce the first of these streamed commands that the controller knows; return it."""
        if self._announced in commands:
            return self._announced  # type: ignore[return-value]
        # Another client may have set motions along the hand's axes.
        self._ask(self._arm_rpc, base_frame())
        for command in commands:
            try:
                self._ask(self._arm_rpc, announce(command))
            except _RefusedError:
                if command == commands[-1]:
                    raise
                continue
            with self._sending:
                self._check(stops)
                self._announced = command
                self._leading_hand.forget()
            return command
        raise ValueError("no commands to choose from")

    def _send(self, port: OutputPort, command: bytes, stops: int) -> None:
        """Write a command. Raises TransportError after a stop since `stops` was read, or without a reader."""
        if not port.carriers(outgoing=True):
            raise TransportError(
                f"{self._remote} is no longer connected to {port.name}: start the program again"
            )
        with self._sending:
            self._check(stops)
            port.write(command)

    def _check(self, stops: int) -> None:
        if stops != self._stops:
            raise TransportError(f"{self._remote} was stopped before the command was sent")

    def _ask(self, client: RpcClient, request: Bottle, timeout: float = 1.0) -> None:
        reply = client.call(request.encode(client.dialect), timeout)
        if not teo_messages.succeeded(reply):
            raise _RefusedError(f"{client.target} refused {request.to_text()}: {reply}")


class _ReadingPort(InputPort):
    """Reads a robot's state on the connection's own thread.

    A thread of its own would add three hundred thread switches a second, each of which may delay the loop.
    """

    def __init__(
        self,
        name: str,
        names: NameClient,
        part: str,
        readings: dict[str, tuple[float, np.ndarray]],
        read: Callable[[Bottle], np.ndarray],
    ) -> None:
        super().__init__(name, names)
        self._part, self._readings, self._read = part, readings, read
        self._complained = False
        "Whether the last message could not be read; each is logged only after a readable one."

    @override
    def deliver(self, request: Request) -> Reply:
        try:
            # The robot's clock may differ, so a reading's time is its arrival.
            self._readings[self._part] = time.monotonic(), self._read(Bottle.decode(request.data))
            self._complained = False
        except ProtocolError as error:
            if not self._complained:
                log.warning("%s: %s", self.name, error)
            self._complained = True
        return None


class _RefusedError(TransportError):
    """The robot answered a request without carrying it out."""
