"""The state of a served grabber on /diagnostics."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

from grabbergui.core.errors import GrabberError
from grabbergui.core.features import format_number
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.sfnc import Role
from grabbergui.net.ros2.runtime import (
    sendable,
    steady_timer,
)

log = logging.getLogger(__name__)

_DIAGNOSTICS_PERIOD = 1.0
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
        self._namesake = False
        "Whether another node had this node's name, when last looked at."
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        steady_timer(node, _DIAGNOSTICS_PERIOD, self._publish)

    def _publish(self) -> None:
        from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

        counters = self._grabber.statistics()
        lost = counters.incomplete + counters.lost
        newly, self._lost = max(0, lost - self._lost), lost
        level, message = DiagnosticStatus.OK, f"{counters.frame_rate:.1f} frames/s"
        if self._grabber.lost:
            level, message = DiagnosticStatus.ERROR, f"the camera is lost: {self._grabber.lost}"
        elif self._grabber.streaming and counters.frame_rate == 0:
            level, message = DiagnosticStatus.ERROR, "no frames"
        elif self._has_namesake():
            level, message = DiagnosticStatus.WARN, f"{message}, another node has this name"
        elif newly:
            level, message = DiagnosticStatus.WARN, f"{message}, {newly} lost in the last second"
        facts = {**counters.as_dict(), **self._of_the_network(), **self._temperature()}
        array = DiagnosticArray()
        array.header.stamp = self._node.get_clock().now().to_msg()
        array.status = [
            DiagnosticStatus(
                level=level,
                name=sendable(f"{self._name}: {self._grabber.info.title}"),
                hardware_id=sendable(self._grabber.info.serial),
                message=sendable(message),
                values=[KeyValue(key=key, value=format_number(value)) for key, value in facts.items()],
            )
        ]
        self._publisher.publish(array)

    def _has_namesake(self) -> bool:
        """Return whether another node has this node's name; log when one appears. ROS does not prevent it."""
        namespace, name = self._node.get_namespace(), self._node.get_name()
        found: bool = self._node.get_node_names_and_namespaces().count((name, namespace)) > 1
        if found and not self._namesake:
            log.warning(
                "another node is called /%s, or was killed in the last 20 s: if it runs, images of both mix, "
                "and either answers requests; end it, or choose another name (--ros2, -r __node:=NAME)",
                self._name,
            )
        self._namesake = found
        return found

    def _temperature(self) -> dict[str, float]:
        """Return where the camera measures it: degrees Celsius, or what an old camera counts in."""
        try:
            name = self._grabber.role(Role.TEMPERATURE)
            value = self._grabber.feature(name).value if name else None
        except GrabberError as error:  # the camera is lost, or closed before its server
            log.debug("temperature: %s", error)
            return {}
        return {"temperature": float(value)} if isinstance(value, (int, float)) else {}
