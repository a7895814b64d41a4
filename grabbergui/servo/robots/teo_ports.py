"""The simulated TEO behind the YARP ports that the real one has, for any client of them."""

from __future__ import annotations

import threading
import time

from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.ports import OutputPort
from grabbergui.net.yarp.os.values import Dialect, Vocab
from grabbergui.servo.robots import teo_messages
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.robots.teo_board import SimulatedBoard
from grabbergui.servo.robots.teo_cartesian import SimulatedCartesian
from grabbergui.servo.robots.teo_yarp import ARM, ARM_BOARD, HEAD

PERIOD = 0.01
"Seconds between two readings that are streamed."


class TeoPorts:
    """A control board for the head, a Cartesian controller for the right arm and its encoders. Any thread."""

    def __init__(
        self,
        robot: SimRobot,
        names: NameClient,
        prefix: str = "/teoSim",
        dialect: Dialect = Dialect.YARP3,
        pose_word: Vocab = teo_messages.POSE_WORDS[-1],
    ) -> None:
        """`dialect` is that of the YARP behind all ports, `pose_word` as for SimulatedCartesian."""
        self._robot = robot
        self._dialect = dialect
        self._head = SimulatedBoard(robot, names, f"{prefix}{HEAD}", dialect)
        self._arm = SimulatedCartesian(robot, names, f"{prefix}{ARM}", dialect, pose_word)
        self._arm_encoders = OutputPort(f"{prefix}{ARM_BOARD}/state:o", names)
        self._ports = (*self._head.ports, *self._arm.ports, self._arm_encoders)
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
        self._arm.stop()
        self._robot.stop()
        for port in self._ports:
            port.close()

    def _stream(self) -> None:
        while self._running.is_set():
            self._step()
            time.sleep(PERIOD)

    def _step(self) -> None:
        """Let the drives go on, and stream where they are."""
        self._head.step()
        self._arm.step()
        state = self._robot.state()
        if state.arm is not None:
            self._arm_encoders.write(teo_messages.encoders(state.arm).encode(self._dialect))
