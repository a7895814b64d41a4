"""Every GenICam feature as a ROS parameter with its range, in step with the camera both ways."""

from __future__ import annotations

import logging
import queue
import threading
from typing import Any

from grabbergui.core.errors import GrabberError
from grabbergui.core.features import Feature, FeatureKind, FeatureValue
from grabbergui.core.grabber import FrameGrabber

log = logging.getLogger(__name__)

_DEFAULTS: dict[FeatureKind, FeatureValue] = {
    FeatureKind.INTEGER: 0,
    FeatureKind.FLOAT: 0.0,
    FeatureKind.BOOLEAN: False,
    FeatureKind.ENUMERATION: "",
    FeatureKind.STRING: "",
}
"""Shown while a feature cannot be read."""


class FeatureParameters:
    """Declares the parameters and keeps them in step.

    A parameter that is set writes the feature, on the node's thread; a feature that changes anywhere else is
    set by a thread of ours.
    """

    def __init__(self, node: Any, grabber: FrameGrabber) -> None:
        self._node = node
        self._grabber = grabber
        self._changed: queue.SimpleQueue[frozenset[str] | None] = queue.SimpleQueue()
        self._shown: dict[str, FeatureValue] = {}
        "What each parameter stands at by our own hand."
        self._descriptors: dict[str, Any] = {}
        self._thread = threading.Thread(target=self._follow, name="ros2 parameters", daemon=True)

    def start(self) -> None:
        """Declare everything; may read hundreds of registers."""
        features = [feature for feature in self._grabber.features() if feature.kind in _DEFAULTS]
        for feature in features:
            value = _shown_value(feature)
            self._shown[feature.name] = value
            self._descriptors[feature.name] = descriptor = _descriptor(feature)
            self._node.declare_parameter(feature.name, value, descriptor, ignore_override=True)
        self._apply_overrides()
        self._node.add_on_set_parameters_callback(self._on_set)
        self._grabber.features_changed.connect(self._changed.put)
        self._thread.start()

    def stop(self) -> None:
        """Let go of the grabber. May be called twice."""
        self._grabber.features_changed.disconnect(self._changed.put, missing_ok=True)
        self._changed.put(None)
        if self._thread.is_alive():
            self._thread.join()

    # -- from ROS to the camera ----------------------------------------------------------------------
    def _on_set(self, parameters: list[Any]) -> Any:
        from rcl_interfaces.msg import SetParametersResult

        for parameter in parameters:
            name, value = parameter.name, parameter.value
            if name not in self._shown or value == self._shown[name]:
                continue  # not a feature, or our own word about the camera
            try:
                self._shown[name] = _shown_value(self._grabber.write_feature(name, value))
            except GrabberError as error:
                return SetParametersResult(successful=False, reason=str(error))
            if self._shown[name] != value:
                # The camera made something else of it; the parameter follows.
                self._changed.put(frozenset({name}))
        return SetParametersResult(successful=True)

    def _apply_overrides(self) -> None:
        """A parameter file's values are written in the file's order, like an operator's."""
        overrides = getattr(self._node, "_parameter_overrides", {})
        for name, parameter in overrides.items():
            if name in self._shown:
                try:
                    self._grabber.write_feature(name, parameter.value)
                except GrabberError as error:
                    log.warning("parameter file: %s", error)
                self._changed.put(frozenset({name}))

    # -- from the camera to ROS ----------------------------------------------------------------------
    def _follow(self) -> None:
        from rclpy.exceptions import ParameterException

        while (names := self._changed.get()) is not None:
            for name in sorted(names & self._shown.keys()):
                try:
                    self._show(self._grabber.feature(name))
                except (GrabberError, ParameterException) as error:
                    log.info("parameter %s: %s", name, error)

    def _show(self, feature: Feature) -> None:
        from rclpy.parameter import Parameter

        descriptor = _descriptor(feature)
        value = _shown_value(feature)
        known = self._node.get_parameter(feature.name).value
        if descriptor != self._descriptors[feature.name]:
            self._descriptors[feature.name] = descriptor
            # The value first goes along where the range moved away from it.
            self._node.set_descriptor(feature.name, descriptor, alternative_value=_message(value))
        self._shown[feature.name] = value
        if known != value:
            self._node.set_parameters([Parameter(feature.name, value=value)])


def _shown_value(feature: Feature) -> FeatureValue:
    return _DEFAULTS[feature.kind] if feature.value is None else feature.value


def _message(value: FeatureValue) -> Any:
    from rclpy.parameter import Parameter

    return Parameter("value", value=value).get_parameter_value()


def _descriptor(feature: Feature) -> Any:
    """Type, range and meaning. What can never be set is told in words: ROS would not let us update it."""
    from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
    from rclpy.parameter import Parameter

    about = [feature.title, feature.tooltip or feature.description]
    if feature.unit:
        about.append(f"in {feature.unit}")
    if feature.entries:
        about.append(feature.range_text())
    if not feature.access.writable:
        about.append(feature.access_problem())
    descriptor = ParameterDescriptor(name=feature.name, description="; ".join(filter(None, about)))
    descriptor.type = Parameter.Type.from_parameter_value(_DEFAULTS[feature.kind]).value
    descriptor.additional_constraints = feature.range_text()
    low, high = feature.minimum, feature.maximum
    if low is None or high is None or feature.value is None or not low <= float(feature.value) <= high:
        return descriptor
    if feature.kind is FeatureKind.INTEGER:
        step = max(0, int(feature.increment or 1))
        descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=step)]
    elif feature.kind is FeatureKind.FLOAT:
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=float(low), to_value=float(high), step=0.0)
        ]
    return descriptor
