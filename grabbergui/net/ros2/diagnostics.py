"""How a served camera is doing, on /diagnostics, once a second."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

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
        """Where the camera measures it: degrees Celsius, or what an old camera counts in."""
        try:
            name = Role.TEMPERATURE.find(self._grabber.has_feature)
            value = self._grabber.feature(name).value if name else None
        except GrabberError as error:  # the camera is lost, or closed before its server
            log.debug("temperature: %s", error)
            return {}
        return {"temperature": float(value)} if isinstance(value, (int, float)) else {}
