"""The features of other people's camera drivers: their node's parameters, with the ranges they declare."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from grabbergui.core.errors import FeatureValueError
from grabbergui.core.features import (
    AccessMode,
    Category,
    Feature,
    FeatureDescription,
    FeatureKind,
    FeatureValue,
)

_KINDS = {1: FeatureKind.BOOLEAN, 2: FeatureKind.INTEGER, 3: FeatureKind.FLOAT, 4: FeatureKind.STRING}
"""Of `rcl_interfaces/msg/ParameterType`; arrays are left out."""

Call = Callable[[str, Any], Any]
"""Calls a service of the node by its name with a request, and gives the response or raises."""


class ParameterFeatures:
    """A remote node's parameters as features. One thread at a time."""

    def __init__(self, call: Call) -> None:
        from rcl_interfaces import srv

        self._srv = srv
        self._call = call
        names = list(call("list_parameters", srv.ListParameters.Request()).result.names)
        self._descriptors = {}
        if names:
            answer = call("describe_parameters", srv.DescribeParameters.Request(names=names))
            # What ROS adds to every node is no business of the camera's operator.
            self._descriptors = {
                descriptor.name: descriptor
                for descriptor in answer.descriptors
                if descriptor.type in _KINDS
                and not descriptor.name.startswith(("qos_overrides.", "use_sim_time"))
            }
        members = tuple(self._describe(name) for name in self._descriptors)
        self.tree = Category("Root", members=(Category("Parameters", members=members),))

    def has(self, name: str) -> bool:
        """Whether there is such a parameter."""
        return name in self._descriptors

    def read(self, name: str) -> Feature:
        """The parameter as it is now."""
        answer = self._call("get_parameters", self._srv.GetParameters.Request(names=[name]))
        descriptor = self._descriptors[name]
        value = _value(answer.values[0]) if answer.values else None
        access = AccessMode.READ_ONLY if descriptor.read_only else AccessMode.READ_WRITE
        low, high, step = _range(descriptor)
        return Feature(
            **vars(self._describe(name)),
            access=AccessMode.NOT_AVAILABLE if value is None else access,
            value=value,
            minimum=low,
            maximum=high,
            increment=step or None,
        )

    def write(self, name: str, value: FeatureValue) -> Feature:
        """Set it; raises FeatureValueError with the node's reason where it refuses."""
        from rclpy.parameter import Parameter

        new = self.read(name).validated(value)
        request = self._srv.SetParameters.Request(parameters=[Parameter(name, value=new).to_parameter_msg()])
        result = self._call("set_parameters", request).results[0]
        if not result.successful:
            raise FeatureValueError(f"{name}={value}: the node answered: {result.reason}", name)
        return self.read(name)

    def execute(self, name: str) -> None:
        """Parameters cannot be executed."""
        raise FeatureValueError(f"{name} is a parameter and no command", name)

    def _describe(self, name: str) -> FeatureDescription:
        descriptor = self._descriptors[name]
        return FeatureDescription(
            name=name, kind=_KINDS[descriptor.type], tooltip=descriptor.description, category="Parameters"
        )


def _range(descriptor: Any) -> tuple[Any, Any, Any]:
    for found in (*descriptor.integer_range, *descriptor.floating_point_range):
        return found.from_value, found.to_value, found.step
    if descriptor.type == 2:
        return -(2**63), 2**63 - 1, 1
    return None, None, None


def _value(value: Any) -> FeatureValue | None:
    fields = {1: "bool_value", 2: "integer_value", 3: "double_value", 4: "string_value"}
    name = fields.get(value.type)
    found: FeatureValue | None = getattr(value, name) if name else None
    return found
