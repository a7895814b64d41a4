"""Every GenICam feature as a ROS parameter, answered by the camera itself; changes on `/parameter_events`."""

from __future__ import annotations

import copy
import logging
import math
import queue
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from typing import Any

from grabbergui.core.errors import FeatureAccessError, FeatureNotFoundError, FeatureValueError, GrabberError
from grabbergui.core.features import Feature, FeatureKind, FeatureValue, Visibility
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.settings import SettingKey
from grabbergui.core.sfnc import as_editable
from grabbergui.net.ros2.runtime import sendable

log = logging.getLogger(__name__)

# -- values and descriptors ----------------------------------------------------------------------
_NOT_SET, BOOL, INTEGER, DOUBLE, STRING = range(5)
"""Codes of `rcl_interfaces/msg/ParameterType`. The others are arrays, which no feature is."""

_TYPES = {
    FeatureKind.BOOLEAN: BOOL,
    FeatureKind.INTEGER: INTEGER,
    FeatureKind.FLOAT: DOUBLE,
    FeatureKind.STRING: STRING,
    FeatureKind.ENUMERATION: STRING,
}
"""Kinds of feature that are parameters, and the type of each. Commands are none."""

_FIELDS = {BOOL: "bool_value", INTEGER: "integer_value", DOUBLE: "double_value", STRING: "string_value"}
_NAMES = ("not set", "a boolean", "an integer", "a double", "a string")
_SWITCH_ENTRIES = {True: "On", False: "Off"}

_SLIDER = range(-(2**31), 2**31)
"""The largest range of the sliders of rqt_reconfigure, which crashes beyond it."""


def value_of(message: Any) -> FeatureValue | None:
    """Return the value of a ParameterValue; None if it is not set or an array."""
    field = _FIELDS.get(message.type)
    value: FeatureValue | None = getattr(message, field) if field else None
    return value


def message_of(kind: FeatureKind, value: FeatureValue | None) -> Any:
    """Return a ParameterValue; not set if the value is None."""
    from rcl_interfaces.msg import ParameterValue

    if value is None:
        return ParameterValue(type=_NOT_SET)
    field = _FIELDS[_TYPES[kind]]
    typed = float(value) if kind is FeatureKind.FLOAT else value
    if isinstance(typed, str):
        typed = sendable(typed)
    return ParameterValue(type=_TYPES[kind], **{field: typed})


def _accepted(feature: Feature, message: Any) -> FeatureValue:
    """Return the value in a ParameterValue, as the feature's kind takes it. Raises FeatureValueError.

    Undoes the conversions of `ros2 param set`, which takes `Off` as false and `8000` as an integer.
    """
    value = value_of(message)
    expected = _TYPES.get(feature.kind, _NOT_SET)
    if message.type == expected and value is not None:
        return value
    if message.type == INTEGER and expected == DOUBLE and value is not None:
        return float(value)
    if message.type in (INTEGER, DOUBLE) and expected == STRING:
        return str(value)
    if isinstance(value, bool) and feature.kind is FeatureKind.ENUMERATION:
        return _SWITCH_ENTRIES[value]
    if message.type == _NOT_SET:
        raise FeatureValueError(f"{feature.name} belongs to the camera and cannot be deleted", feature.name)
    given = _NAMES[message.type] if message.type < len(_NAMES) else "an array"
    raise FeatureValueError(f"{feature.name} is {_NAMES[expected]}, not {given}", feature.name)


def _type_of(feature: Feature) -> int:
    """Return the ParameterType of the current value; not set if it cannot be read."""
    return _TYPES[feature.kind] if feature.value is not None else _NOT_SET


def _descriptor_of(feature: Feature, *, settable: bool) -> Any:
    """Return a ParameterDescriptor: type, range, meaning, and whether it can be set at the moment.

    A range that fits no slider is given in words only: rqt_reconfigure stops showing a node that has one.
    """
    from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor

    descriptor = ParameterDescriptor(
        name=feature.name,
        type=_type_of(feature),
        description=sendable(_description(feature)),
        additional_constraints=sendable(feature.range_text() if settable else feature.access_problem()),
        read_only=not settable,
    )
    low, high, increment = feature.minimum, feature.maximum, feature.increment
    if low is None or high is None:
        return descriptor
    if feature.kind is FeatureKind.INTEGER and int(low) in _SLIDER and int(high) in _SLIDER:
        step = max(1, int(increment or 1))
        descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=step)]
    elif feature.kind is FeatureKind.FLOAT and _fits_a_slider(low, high):
        step_width = float(increment or 0)
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=float(low), to_value=float(high), step=step_width)
        ]
    return descriptor


def _description(feature: Feature) -> str:
    """Return the text for viewers, with the entries, as rqt_reconfigure has no list to choose from."""
    about = [feature.title, feature.tooltip or feature.description]
    if feature.unit:
        about.append(f"in {feature.unit}")
    if feature.kind is FeatureKind.ENUMERATION:
        about.append(feature.range_text())
    return "; ".join(filter(None, about))


def _fits_a_slider(low: float, high: float) -> bool:
    """Return whether a range of floats does; rqt_reconfigure divides it into hundredths."""
    span = high - low
    return 0 < span < math.inf and max(abs(low), abs(high)) / span < _SLIDER.stop / 100


def setting_of(grabber: FrameGrabber, name: str) -> SettingKey:
    """Return the setting that a parameter means: `Gain`, or `BalanceRatio.Red` with its selectors' entries.

    Raises FeatureNotFoundError for a number of entries other than that of the selectors.
    """
    feature, *entries = name.split(".")
    selectors = grabber.selectors.of(feature)
    if not entries or not grabber.has_feature(feature):
        return SettingKey(name)
    if len(entries) != len(selectors):
        chosen = "".join(f".<{selector}>" for selector in selectors)
        raise FeatureNotFoundError(f"there is no parameter {name}; write {feature}{chosen}", feature)
    return SettingKey(feature, tuple(zip(selectors, entries, strict=True)))


# -- changes -------------------------------------------------------------------------------------
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


# -- services ------------------------------------------------------------------------------------
_QOS_OVERRIDES = "qos_overrides."
_NULL = "null"
"""The value in a parameter file for a parameter that was not set when the file was dumped."""


class FeatureParameters:
    """Serves a node's parameters: the camera's features, and what rclpy gives every node.

    The node is made with `start_parameter_services=False`. rclpy would keep a second copy of every value, and
    never let one that is marked read-only follow the camera. Services run on the node's thread.
    """

    def __init__(self, node: Any, grabber: FrameGrabber, *, read_only: bool = False) -> None:
        """With `read_only` the node's own parameters cannot be set either; the grabber refuses the rest."""
        from rcl_interfaces import srv
        from rclpy.qos import qos_profile_parameters

        self._read_only = read_only
        self._node = node
        self._grabber = grabber
        self._events = ParameterEvents(node, grabber)
        for service, kind, action in (
            ("list_parameters", srv.ListParameters, self._list),
            ("get_parameters", srv.GetParameters, self._get),
            ("get_parameter_types", srv.GetParameterTypes, self._get_types),
            ("describe_parameters", srv.DescribeParameters, self._describe),
            ("set_parameters", srv.SetParameters, self._set),
            ("set_parameters_atomically", srv.SetParametersAtomically, self._set_together),
        ):
            node.create_service(kind, f"~/{service}", action, qos_profile=qos_profile_parameters)

    def start(self) -> None:
        """Write what a parameter file gave, and follow the camera."""
        self._apply_overrides()
        self._events.start()

    def stop(self) -> None:
        """Release the grabber. May be called twice."""
        self._events.stop()

    # -- what there is ---------------------------------------------------------------------------
    def _list(self, request: Any, answer: Any) -> Any:
        """List all but hidden parameters; feature names have no dots, so each prefix is a whole name."""
        answer.result = self._node.list_parameters(list(request.prefixes), request.depth)
        wanted = frozenset(request.prefixes)
        try:
            tree = self._grabber.feature_tree()
        except GrabberError as error:  # a lost camera has no features
            log.info("list of parameters: %s", error)
            return answer
        features = (
            description.name
            for description in tree.descriptions()
            if description.kind in _TYPES
            and description.visibility is not Visibility.INVISIBLE
            and (not wanted or description.name in wanted)
        )
        answer.result.names = [*features, *answer.result.names]
        return answer

    def _get(self, request: Any, answer: Any) -> Any:
        answer.values = self._each(request.names, _value, self._own_value)
        return answer

    def _get_types(self, request: Any, answer: Any) -> Any:
        answer.types = self._each(request.names, _type_of, self._own_type)
        return answer

    def _describe(self, request: Any, answer: Any) -> Any:
        answer.descriptors = self._each(
            request.names,
            lambda feature: _descriptor_of(feature, settable=self._settable(feature)),
            self._own_descriptor,
        )
        for name, descriptor in zip(request.names, answer.descriptors, strict=False):
            descriptor.name = name
        return answer

    def _each(
        self, names: list[str], of_feature: Callable[[Feature], Any], of_own: Callable[[str], Any]
    ) -> list[Any]:
        """Return an answer for each name; none at all if one is unknown, as rclpy does."""
        answers: dict[str, Any] = {}  # each is read once, however often it is requested
        for name in dict.fromkeys(names):
            try:
                own = self._node.has_parameter(name)
                answers[name] = of_own(name) if own else of_feature(self._feature(name))
            except GrabberError as error:
                log.info("parameter %s: %s", name, error)
                return []
        return [answers[name] for name in names]

    def _own_value(self, name: str) -> Any:
        return self._node.get_parameter(name).get_parameter_value()

    def _own_descriptor(self, name: str) -> Any:
        descriptor = copy.copy(self._node.describe_parameter(name))
        descriptor.read_only = descriptor.read_only or self._read_only
        return descriptor

    def _own_type(self, name: str) -> int:
        return int(self._node.get_parameter(name).type_.value)

    def _feature(self, name: str) -> Feature:
        feature = self._grabber.read_setting(setting_of(self._grabber, name))
        if feature.kind not in _TYPES:
            raise FeatureNotFoundError(
                f"{name} is a command and no parameter; run it by the service `ask`", name
            )
        return feature

    def _settable(self, feature: Feature) -> bool:
        """Return whether it can be set; its automatic mode and the stream release their lock for a write."""
        if self._grabber.streaming and feature.access.readable and self._grabber.pauses_for(feature.name):
            return self._grabber.access is Access.CONTROL
        auto = self._grabber.feature(feature.auto) if feature.auto else None
        return as_editable(feature, auto).access.writable

    # -- from ROS to the camera ------------------------------------------------------------------
    def _set(self, request: Any, answer: Any) -> Any:
        with self._together():
            answer.results = [self._set_one(parameter) for parameter in request.parameters]
        return answer

    def _set_together(self, request: Any, answer: Any) -> Any:
        """Set all or none: if one is refused, restore those before it."""
        from rcl_interfaces.msg import SetParametersResult

        replaced: list[Any] = []
        answer.result = SetParametersResult(successful=True)
        with self._together():
            for parameter in request.parameters:
                current = self._current(parameter.name)
                answer.result = self._set_one(parameter)
                if not answer.result.successful:
                    self._restore(replaced)
                    break
                if current is not None:
                    replaced.append(current)
        return answer

    @contextmanager
    def _together(self) -> Iterator[None]:
        """Keep others from moving a selector between the parameters of one request."""
        with ExitStack() as stack:
            with suppress(GrabberError):  # each parameter reports the loss of the camera itself
                stack.enter_context(self._grabber.exclusive())
            yield

    def _set_one(self, parameter: Any) -> Any:
        from rcl_interfaces.msg import SetParametersResult

        if self._node.has_parameter(parameter.name):
            return self._set_own(parameter)
        try:
            self._write(parameter)
        except GrabberError as error:
            # Viewers show the requested value until an event corrects it.
            self._events.publish(frozenset({parameter.name}))
            return SetParametersResult(successful=False, reason=sendable(str(error)))
        return SetParametersResult(successful=True)

    def _write(self, parameter: Any) -> None:
        """Accept the current value for a locked parameter, so that `ros2 param dump` can be loaded again."""
        feature = self._feature(parameter.name)
        if not (feature.access.readable or feature.access.writable):
            raise FeatureAccessError(f"{feature.name} {feature.access_problem()}", feature.name)
        value = _accepted(feature, parameter.value)
        if feature.access.writable or value != feature.value:
            self._grabber.write_setting(setting_of(self._grabber, parameter.name), value)

    def _set_own(self, parameter: Any) -> Any:
        from rcl_interfaces.msg import SetParametersResult
        from rclpy.parameter import Parameter

        if self._read_only:  # `use_sim_time` would let any peer stop the clock of all stamps
            reason = f"{parameter.name} cannot be set: the camera is served read-only"
            return SetParametersResult(successful=False, reason=reason)
        try:
            return self._node.set_parameters_atomically([Parameter.from_parameter_msg(parameter)])
        except (RuntimeError, ValueError) as error:  # a type that ROS does not have
            return SetParametersResult(successful=False, reason=f"{parameter.name}: {error}")

    def _current(self, name: str) -> Any:
        """Return a parameter with its value, to be restored; None if it cannot be read."""
        from rcl_interfaces.msg import Parameter

        if self._node.has_parameter(name):
            return Parameter(name=name, value=self._own_value(name))
        try:
            feature = self._feature(name)
        except GrabberError:
            return None
        return None if feature.value is None else Parameter(name=name, value=_value(feature))

    def _restore(self, parameters: list[Any]) -> None:
        for parameter in reversed(parameters):
            result = self._set_one(parameter)
            if not result.successful:
                log.warning("parameter %s could not be restored: %s", parameter.name, result.reason)

    def _apply_overrides(self) -> None:
        """Write a parameter file's values in the file's order, like an operator's."""
        for name, parameter in getattr(self._node, "_parameter_overrides", {}).items():
            if self._node.has_parameter(name) or name.startswith(_QOS_OVERRIDES):
                continue  # rclpy has applied it
            if parameter.value == _NULL and self._current(name) is None:
                continue
            result = self._set_one(parameter.to_parameter_msg())
            if not result.successful:
                log.warning("parameter given at the start: %s", result.reason)


def _value(feature: Feature) -> Any:
    return message_of(feature.kind, feature.value)
