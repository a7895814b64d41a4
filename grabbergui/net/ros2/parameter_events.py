"""Changes of features on /parameter_events."""

from __future__ import annotations

import logging
import math
import queue
import threading
from typing import Any

from grabbergui.core.errors import GrabberError
from grabbergui.core.features import Feature, FeatureValue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.net.ros2.parameter_values import (
    _SLIDER,
    _TYPES,
    message_of,
    setting_of,
)

log = logging.getLogger(__name__)


LOOK_PERIOD = 0.5
"""Seconds between checks whether anybody has subscribed."""
AT_ONCE = 10
"""Values that are read before changes are looked for again."""


class ParameterEvents:
    """Follows a grabber's features, and publishes changed values from a thread of its own.

    A grabber reports what *may* have changed. So all values are read once when somebody subscribes, and only
    differences are published.

    A parameter that can no longer be read is published as deleted, one that returns as changed:
    rqt_reconfigure asks about new parameters from within its own callback, and waits in vain.
    """

    def __init__(self, node: Any, grabber: FrameGrabber) -> None:
        from rcl_interfaces.msg import ParameterEvent
        from rclpy.qos import qos_profile_parameter_events

        self._node = node
        self._grabber = grabber
        self._names: queue.SimpleQueue[frozenset[str] | None] = queue.SimpleQueue()
        self._known: dict[str, FeatureValue | None] = {}
        "Values as last read, while anybody subscribes."
        self._unread: list[str] = []
        "Parameters to be read for `_known`, last first."
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
        """Publish the current values of these soon, where they changed. Any thread; never waits."""
        self._names.put(names)

    def correct(self, name: str) -> None:
        """Publish a value soon even if it did not change, for viewers that show another. Any thread."""
        self._known.pop(name, None)
        self._names.put(frozenset({name}))

    def _run(self) -> None:
        listening = False
        while (names := self._changed()) is not None:
            before, listening = listening, bool(self._publisher.get_subscription_count())
            if not listening:  # spare the camera the reads
                self._known.clear()
                self._unread.clear()
                continue
            event = self._event(names)
            if event.changed_parameters or event.deleted_parameters:
                event.stamp = self._node.get_clock().now().to_msg()
                self._publisher.publish(event)
            if not before:
                self._unread = self._parameters()
            self._read_some()

    def _parameters(self) -> list[str]:
        try:
            descriptions = list(self._grabber.feature_tree().descriptions())
        except GrabberError as error:
            log.debug("no parameters to follow: %s", error)
            return []
        return [each.name for each in reversed(descriptions) if each.kind in _TYPES]

    def _read_some(self) -> None:
        for _ in range(min(AT_ONCE, len(self._unread))):
            name = self._unread[-1]
            feature = None if name in self._known else self._read(name)
            if not self._names.empty():
                return  # a report may be of this one: then the value is no earlier one to compare with
            self._unread.pop()
            if feature is not None:
                self._known[name] = feature.value

    def _changed(self) -> frozenset[str] | None:
        """Wait for changes; return all that were reported meanwhile, each to be read once.

        Returns none, but not None, when there is something else to do.
        """
        try:
            names = self._names.get(timeout=0 if self._unread else LOOK_PERIOD)
        except queue.Empty:
            return frozenset()
        while names is not None and not self._names.empty():
            more = self._names.get()
            names = None if more is None else names | more
        return names

    def _event(self, names: frozenset[str]) -> Any:
        from rcl_interfaces.msg import Parameter, ParameterEvent

        event = ParameterEvent(node=self._node.get_fully_qualified_name())
        for name in sorted(names):
            feature = self._read(name)
            if feature is None or feature.kind not in _TYPES:
                continue
            if name in self._known and same(self._known[name], feature.value):
                continue
            self._known[name] = feature.value
            parameter = Parameter(name=name, value=message_of(feature.kind, feature.value))
            if feature.value is None:
                event.deleted_parameters.append(parameter)
            elif _is_publishable(feature.value):
                event.changed_parameters.append(parameter)
        return event

    def _read(self, name: str) -> Feature | None:
        try:
            return self._grabber.read_setting(setting_of(self._grabber, name))
        except GrabberError as error:
            log.debug("parameter %s: %s", name, error)
            return None


def same(one: FeatureValue | None, other: FeatureValue | None) -> bool:
    """Return whether two values are equal; two that are no number are, too."""
    return one == other or (one != one and other != other)


def _is_publishable(value: FeatureValue) -> bool:
    """Return whether rqt_reconfigure can show a value; others, such as timestamps, would crash it."""
    if isinstance(value, float):
        return math.isfinite(value)
    return not isinstance(value, int) or value in _SLIDER
