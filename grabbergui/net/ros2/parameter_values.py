"""Features as `rcl_interfaces` messages: values, types, and what a descriptor can say of one."""

from __future__ import annotations

import math
from typing import Any

from grabbergui.core.errors import FeatureValueError
from grabbergui.core.features import Feature, FeatureKind, FeatureValue

NOT_SET, BOOL, INTEGER, DOUBLE, STRING = range(5)
"""Of `rcl_interfaces/msg/ParameterType`; `parameter_arrays` has the rest. No feature is an array."""

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

SLIDER = range(-(2**31), 2**31)
"""What fits on the sliders of rqt_reconfigure, which a value beyond ends."""


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
    if message.type in (INTEGER, DOUBLE) and expected == STRING:
        return str(value)
    if isinstance(value, bool) and feature.kind is FeatureKind.ENUMERATION:
        return _SWITCH_ENTRIES[value]
    if message.type == NOT_SET:
        raise FeatureValueError(f"{feature.name} belongs to the camera and cannot be deleted", feature.name)
    given = _NAMES[message.type] if message.type < len(_NAMES) else "an array"
    raise FeatureValueError(f"{feature.name} is {_NAMES[expected]}, not {given}", feature.name)


def type_of(feature: Feature) -> int:
    """The ParameterType of what it holds just now; not set where it cannot be read."""
    return TYPES[feature.kind] if feature.value is not None else NOT_SET


def descriptor_of(feature: Feature, *, settable: bool) -> Any:
    """A ParameterDescriptor: type, range, meaning, and whether it can be set just now.

    A range that fits no slider is told in words only: rqt_reconfigure shows nothing more of a node with one.
    """
    from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor

    descriptor = ParameterDescriptor(
        name=feature.name,
        type=type_of(feature),
        description=_description(feature),
        additional_constraints=feature.range_text() if settable else feature.access_problem(),
        read_only=not settable,
    )
    low, high, increment = feature.minimum, feature.maximum, feature.increment
    if low is None or high is None:
        return descriptor
    if feature.kind is FeatureKind.INTEGER and int(low) in SLIDER and int(high) in SLIDER:
        step = max(1, int(increment or 1))
        descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=step)]
    elif feature.kind is FeatureKind.FLOAT and _fits_a_slider(low, high):
        step_width = float(increment or 0)
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=float(low), to_value=float(high), step=step_width)
        ]
    return descriptor


def _description(feature: Feature) -> str:
    """What viewers show beside the value; its entries too, as rqt_reconfigure has no list to choose from."""
    about = [feature.title, feature.tooltip or feature.description]
    if feature.unit:
        about.append(f"in {feature.unit}")
    if feature.kind is FeatureKind.ENUMERATION:
        about.append(feature.range_text())
    return "; ".join(filter(None, about))


def _fits_a_slider(low: float, high: float) -> bool:
    """Whether a range of fractions does, which rqt_reconfigure counts in hundredths of its span."""
    span = high - low
    return 0 < span < math.inf and max(abs(low), abs(high)) / span < SLIDER.stop / 100
