"""The program's log on /rosout."""

from __future__ import annotations

import logging
import math
import queue
import threading
from typing import Any

from typing_extensions import override

from grabbergui.net.ros2.runtime import sendable

_MOST_RECORDS = 100
"""Records that may wait to be published; further ones are only in the log."""


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
        self._records: queue.Queue[logging.LogRecord | None] = queue.Queue(_MOST_RECORDS)
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
            try:
                self._publisher.publish(self._log(record))
            except Exception:
                self.handleError(record)  # as every handler does; the next record is still wanted

    def _log(self, record: logging.LogRecord) -> Any:
        fraction, seconds = math.modf(record.created)
        message = self._message(
            level=min(record.levelno, logging.CRITICAL),  # ROS numbers them as Python does
            name=self._node.get_logger().name,
            msg=sendable(record.getMessage()),
            file=record.filename,
            function=record.funcName or "",
            line=record.lineno,
        )
        message.stamp.sec, message.stamp.nanosec = int(seconds), int(fraction * 1e9)
        return message
