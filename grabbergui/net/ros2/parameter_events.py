"""Changes of features on /parameter_events."""

from __future__ import annotations

import logging
import math
import queue
import threading
from typing import Any

from grabbergui.core.errors import GrabberError
from grabbergui.core.features import FeatureValue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.net.ros2.parameter_values import (
    _SLIDER,
    _TYPES,
    message_of,
    setting_of,
)

log = logging.getLogger(__name__)


class ParameterEvents:
    """Follows a grabber's features, and publishes their values from a thread of its own.

    A parameter that can no longer be read is published as deleted, one that returns as changed:
    rqt_reconfigure asks about new parameters from within its own callback, and waits in vain.
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
        self._grabber.features_changed.connect(self.publish)
        self._thread.start()

    def stop(self) -> None:
        """Release the grabber. May be called twice."""
        self._grabber.features_changed.disconnect(self.publish, missing_ok=True)
        self._names.put(None)
        if self._thread.is_alive():
            self._thread.join()

    def publish(self, names: frozenset[str]) -> None:
        """Publish the current values of these soon. Any thread; never waits."""
        self._names.put(names)

    def _run(self) -> None:
        while (names := self._changed()) is not None:
            if not self._publisher.get_subscription_count():
                continue  # spare the camera the reads
            event = self._event(names)
            if event.changed_parameters or event.deleted_parameters:
                event.stamp = self._node.get_clock().now().to_msg()
                self._publisher.publish(event)

    def _changed(self) -> frozenset[str] | None:
        """Wait for changes; return all that were reported meanwhile, each to be read once."""
        names = self._names.get()
        while names is not None and not self._names.empty():
            more = self._names.get()
            names = None if more is None else names | more
        return names

    def _event(self, names: frozenset[str]) -> Any:
        from rcl_interfaces.msg import Parameter, ParameterEvent

        event = ParameterEvent(node=self._node.get_fully_qualified_name())
        for name in sorted(names):
            try:
                feature = self._grabber.read_setting(setting_of(self._grabber, name))
            except GrabberError as error:
                log.debug("parameter %s: %s", name, error)
                continue
            if feature.kind not in _TYPES:
                continue
            parameter = Parameter(name=name, value=message_of(feature.kind, feature.value))
            if feature.value is None:
                event.deleted_parameters.append(parameter)
            elif _is_publishable(feature.value):
                event.changed_parameters.append(parameter)
        return event


def _is_publishable(value: FeatureValue) -> bool:
    """Return whether rqt_reconfigure can show a value; others, such as timestamps, would crash it."""
    if isinstance(value, float):
        return math.isfinite(value)
    return not isinstance(value, int) or value in _SLIDER
