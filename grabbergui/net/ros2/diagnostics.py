"""A served camera's reports: `/diagnostics` once a second, warnings and errors on `/rosout`."""

from __future__ import annotations

import logging
import math
import queue
import threading
from collections.abc import Callable
from typing import Any

from typing_extensions import override

from grabbergui.core.errors import GrabberError
from grabbergui.core.features import format_number
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.sfnc import Role

log = logging.getLogger(__name__)

PERIOD = 1.0
"""Seconds."""


class Diagnostics:
    """Publishes one status: an error without frames, a warning while frames are being lost.

    `of_the_network` gives further counters by name. Runs on the node's thread.
    """

    def __init__(
        self, node: Any, grabber: FrameGrabber, of_the_network: Callable[[], dict[str, int]]
    ) -> None:
        from diagnostic_msgs.msg import DiagnosticArray

        self._node = node
        self._grabber = grabber
        self._name = node.get_fully_qualified_name().strip("/")
        self._of_the_network = of_the_network
        self._lost = 0
        "Frames lost or incomplete, when last looked at."
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        node.create_timer(PERIOD, self._publish)

    def _publish(self) -> None:
        from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

        counters = self._grabber.statistics()
        lost = counters.incomplete + counters.lost
        newly, self._lost = max(0, lost - self._lost), lost
        level, message = DiagnosticStatus.OK, f"{counters.frame_rate:.1f} frames/s"
        if self._grabber.streaming and counters.frame_rate == 0:
            level, message = DiagnosticStatus.ERROR, "no frames"
        elif newly:
            level, message = DiagnosticStatus.WARN, f"{message}, {newly} lost in the last second"
        facts = {**counters.as_dict(), **self._of_the_network(), **self._temperature()}
        array = DiagnosticArray()
        array.header.stamp = self._node.get_clock().now().to_msg()
        array.status = [
            DiagnosticStatus(
                level=level,
                name=f"{self._name}: {self._grabber.info.title}",
                hardware_id=self._grabber.info.serial,
                message=message,
                values=[KeyValue(key=key, value=format_number(value)) for key, value in facts.items()],
            )
        ]
        self._publisher.publish(array)

    def _temperature(self) -> dict[str, float]:
        """Return where the camera measures it: degrees Celsius, or what an old camera counts in."""
        try:
            name = Role.TEMPERATURE.find(self._grabber.has_feature)
            value = self._grabber.feature(name).value if name else None
        except GrabberError as error:  # the camera is lost, or closed before its server
            log.debug("temperature: %s", error)
            return {}
        return {"temperature": float(value)} if isinstance(value, (int, float)) else {}


MOST_WAITING = 100
"""Records that wait to be published; more than that at once, and the rest is only in the log."""


class RosoutHandler(logging.Handler):
    """Publishes what the package logs, from warnings on, as long as it is open.

    Records come from any thread, which never waits for the network: a thread of the handler publishes them.
    """

    def __init__(self, node: Any) -> None:
        super().__init__(logging.WARNING)
        from rcl_interfaces.msg import Log
        from rclpy.qos import DurabilityPolicy, QoSProfile

        self._message = Log
        self._node = node
        # As rcl's own publisher for it: a console that is started later sees the last of them too.
        quality = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._publisher = node.create_publisher(Log, "/rosout", quality)
        self._records: queue.Queue[logging.LogRecord | None] = queue.Queue(MOST_WAITING)
        self._thread = threading.Thread(target=self._run, name="ros2 rosout", daemon=True)
        self._thread.start()
        logging.getLogger("grabbergui").addHandler(self)

    @override
    def emit(self, record: logging.LogRecord) -> None:
        try:
            self._records.put_nowait(record)
        except queue.Full:
            return

    def close(self) -> None:
        """Publish what waits, and stop. May be called twice."""
        logging.getLogger("grabbergui").removeHandler(self)
        if self._thread.is_alive():
            self._records.put(None)
            self._thread.join()
        super().close()

    def _run(self) -> None:
        while (record := self._records.get()) is not None:
            self._publisher.publish(self._log(record))

    def _log(self, record: logging.LogRecord) -> Any:
        fraction, seconds = math.modf(record.created)
        message = self._message(
            level=min(record.levelno, logging.CRITICAL),  # ROS numbers them as Python does
            name=self._node.get_logger().name,
            msg=record.getMessage(),
            file=record.filename,
            function=record.funcName or "",
            line=record.lineno,
        )
        message.stamp.sec, message.stamp.nanosec = int(seconds), int(fraction * 1e9)
        return message
