"""Features as `rcl_interfaces` messages: values, types, and what a descriptor can say of one."""

from __future__ import annotations

from typing import Any

from grabbergui.core.errors import FeatureValueError
from grabbergui.core.features import Feature, FeatureKind, FeatureValue

NOT_SET, BOOL, INTEGER, DOUBLE, STRING = range(5)
"""Of `rcl_interfaces/msg/ParameterType`; arrays are left out."""

TYPES = {
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


def value_of(message: Any) -> FeatureValue | None:
    """What a ParameterValue holds; None where it is not set, or an array."""
    field = _FIELDS.get(message.type)
    value: FeatureValue | None = getattr(message, field) if field else None
    return value


def message_of(kind: FeatureKind, value: FeatureValue | None) -> Any:
    """A ParameterValue; not set where the value is None."""
    from rcl_interfaces.msg import ParameterValue

    if value is None:
        return ParameterValue(type=NOT_SET)
    field = _FIELDS[TYPES[kind]]
    typed = float(value) if kind is FeatureKind.FLOAT else value
    return ParameterValue(type=TYPES[kind], **{field: typed})


def accepted(feature: Feature, message: Any) -> FeatureValue:
    """The value in a ParameterValue, as the feature's kind takes it. Raises FeatureValueError.

    What `ros2 param set` makes of a plain word is put right: to it, `Off` is false and `8000` an integer.
    """
    value = value_of(message)
    expected = TYPES.get(feature.kind, NOT_SET)
    if message.type == expected and value is not None:
        return value
    if message.type == INTEGER and expected == DOUBLE and value is not None:
        return float(value)
    if message.type == INTEGER and expected == STRING:
        return str(value)
    if isinstance(value, bool) and feature.kind is FeatureKind.ENUMERATION:
        return _SWITCH_ENTRIES[value]
    given = _NAMES[message.type] if message.type < len(_NAMES) else "an array"
    raise FeatureValueError(f"{feature.name} is {_NAMES[expected]}, not {given}", feature.name)


def descriptor_of(feature: Feature, *, settable: bool) -> Any:
    """A ParameterDescriptor: type, range, meaning, and whether it can be set just now."""
    from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor

    about = [feature.title, feature.tooltip or feature.description]
    if feature.unit:
        about.append(f"in {feature.unit}")
    descriptor = ParameterDescriptor(
        name=feature.name,
        type=TYPES[feature.kind],
        description="; ".join(filter(None, about)),
        additional_constraints=feature.range_text() if settable else feature.access_problem(),
        read_only=not settable,
    )
    low, high = feature.minimum, feature.maximum
    if low is None or high is None:
        return descriptor
    if feature.kind is FeatureKind.INTEGER:
        step = max(1, int(feature.increment or 1))
        descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=step)]
    elif feature.kind is FeatureKind.FLOAT:
        step_width = float(feature.increment or 0)
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=float(low), to_value=float(high), step=step_width)
        ]
    return descriptor
