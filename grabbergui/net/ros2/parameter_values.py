"""Features as ROS parameter values and descriptors, and back."""

from __future__ import annotations

import math
from typing import Any

from grabbergui.core.errors import FeatureNotFoundError, FeatureValueError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import Feature, FeatureKind, FeatureValue
from grabbergui.core.settings import SettingKey
from grabbergui.net.ros2.runtime import sendable

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

    A range that fits no slider is given as text only: rqt_reconfigure stops showing a node that has one.
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


def setting_of(grabber: FeatureSource, name: str) -> SettingKey:
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
