"""Every GenICam feature as a ROS parameter, answered by the camera itself; changes on `/parameter_events`."""

from __future__ import annotations

import copy
import logging
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from typing import Any

from grabbergui.core.errors import FeatureAccessError, FeatureNotFoundError, GrabberError
from grabbergui.core.features import Feature, Visibility
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.sfnc import as_editable
from grabbergui.net.ros2.callers import create_service
from grabbergui.net.ros2.parameter_events import ParameterEvents
from grabbergui.net.ros2.parameter_values import (
    _TYPES,
    _accepted,
    _descriptor_of,
    _type_of,
    message_of,
    setting_of,
)
from grabbergui.net.ros2.runtime import sendable

log = logging.getLogger(__name__)


_WRITING = ("set_parameters", "set_parameters_atomically")
"Services whose callers are authors of changes."
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
            create = partial(create_service, node) if service in _WRITING else node.create_service
            create(kind, f"~/{service}", action, qos_profile=qos_profile_parameters)

    def start(self) -> None:
        """Write what a parameter file gave, and follow the camera."""
        self._apply_overrides()
        self._events.start()

    def stop(self) -> None:
        """Release the grabber. May be called twice."""
        self._events.stop()

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
            self._events.correct(parameter.name)
            return SetParametersResult(successful=False, reason=sendable(str(error)))
        return SetParametersResult(successful=True)

    def _write(self, parameter: Any) -> None:
        """Accept the current value for a locked parameter, so that `ros2 param dump` can be loaded again."""
        feature = self._feature(parameter.name)
        if not (feature.access.readable or feature.access.writable):
            raise FeatureAccessError(f"{feature.name} {feature.access_problem()}", feature.name)
        value = _accepted(feature, parameter.value)
        if feature.access.writable or value != feature.value:
            result = self._grabber.write_setting(setting_of(self._grabber, parameter.name), value)
            if result.feature.value != value:  # as a camera that rounds
                self._events.correct(parameter.name)

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
