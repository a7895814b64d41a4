"""What the camera changes, told on /parameter_events to those who show its parameters."""

from __future__ import annotations

import logging
import math
import queue
import threading
from typing import Any

from grabbergui.core.errors import GrabberError
from grabbergui.core.features import FeatureValue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.net.ros2.parameter_values import SLIDER, TYPES, message_of

log = logging.getLogger(__name__)


class ParameterEvents:
    """Follows a grabber's features, and publishes their values from a thread of its own.

    What can no longer be read is told as deleted. What comes back is told as changed: rqt_reconfigure asks
    about new parameters from within its own callback, and waits in vain.
    """

    def __init__(self, node: Any, grabber: FrameGrabber) -> None:
        from rcl_interfaces.msg import ParameterEvent
        from rclpy.qos import qos_profile_parameter_events

        self._node = node
        self._grabber = grabber
        self._names: queue.SimpleQueue[frozenset[str] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="ros2 parameter events", daemon=True)
        self._publisher = node.create_publisher(
            ParameterEvent, "/parameter_events", qos_profile_parameter_events
        )

    def start(self) -> None:
        """Follow the camera from now on."""
        self._grabber.features_changed.connect(self.tell)
        self._thread.start()

    def stop(self) -> None:
        """Let go of the grabber. May be called twice."""
        self._grabber.features_changed.disconnect(self.tell, missing_ok=True)
        self._names.put(None)
        if self._thread.is_alive():
            self._thread.join()

    def tell(self, names: frozenset[str]) -> None:
        """Have these told as they are now. Any thread; never waits."""
        self._names.put(names)

    def _run(self) -> None:
        while (names := self._names.get()) is not None:
            event = self._event(names)
            if event.changed_parameters or event.deleted_parameters:
                event.stamp = self._node.get_clock().now().to_msg()
                self._publisher.publish(event)

    def _event(self, names: frozenset[str]) -> Any:
        from rcl_interfaces.msg import Parameter, ParameterEvent

        event = ParameterEvent(node=self._node.get_fully_qualified_name())
        for name in sorted(names):
            try:
                feature = self._grabber.feature(name)
            except GrabberError as error:
                log.debug("parameter %s: %s", name, error)
                continue
            if feature.kind not in TYPES:
                continue
            parameter = Parameter(name=name, value=message_of(feature.kind, feature.value))
            if feature.value is None:
                event.deleted_parameters.append(parameter)
            elif _can_be_told(feature.value):
                event.changed_parameters.append(parameter)
        return event


def _can_be_told(value: FeatureValue) -> bool:
    """Not a timestamp, for one: it would end every rqt_reconfigure that shows this node."""
    if isinstance(value, float):
        return math.isfinite(value)
    return not isinstance(value, int) or value in SLIDER
