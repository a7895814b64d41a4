"""Features as values, types and descriptions of parameters, arrays of names and values included."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
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
        return ParameterValue(type=NOT_SET)
    field = _FIELDS[TYPES[kind]]
    typed = float(value) if kind is FeatureKind.FLOAT else value
    return ParameterValue(type=TYPES[kind], **{field: typed})


def accepted(feature: Feature, message: Any) -> FeatureValue:
    """Return the value in a ParameterValue, as the feature's kind takes it. Raises FeatureValueError.

    Undoes the conversions of `ros2 param set`, which takes `Off` as false and `8000` as an integer.
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
    """Return the ParameterType of the current value; not set if it cannot be read."""
    return TYPES[feature.kind] if feature.value is not None else NOT_SET


def descriptor_of(feature: Feature, *, settable: bool) -> Any:
    """Return a ParameterDescriptor: type, range, meaning, and whether it can be set at the moment.

    A range that fits no slider is given in words only: rqt_reconfigure stops showing a node that has one.
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
    """Return the text for viewers, with the entries, as rqt_reconfigure has no list to choose from."""
    about = [feature.title, feature.tooltip or feature.description]
    if feature.unit:
        about.append(f"in {feature.unit}")
    if feature.kind is FeatureKind.ENUMERATION:
        about.append(feature.range_text())
    return "; ".join(filter(None, about))


def _fits_a_slider(low: float, high: float) -> bool:
    """Return whether a range of fractions does, which rqt_reconfigure counts in hundredths of its span."""
    span = high - low
    return 0 < span < math.inf and max(abs(low), abs(high)) / span < SLIDER.stop / 100


BYTE_ARRAY, BOOL_ARRAY, INTEGER_ARRAY, DOUBLE_ARRAY, STRING_ARRAY = range(5, 10)
"""Of `rcl_interfaces/msg/ParameterType`."""
_MOST_CHARACTERS = 1 << 20


@dataclass(frozen=True)
class _Array:
    field: str
    "Of the message."
    example: str
    accepts: Callable[[Any], bool]
    "Whether something may be an element."
    to_element: Callable[[Any], Any] = lambda value: value
    "The value as rclpy takes it."
    from_element: Callable[[Any], Any] = lambda value: value


def _is_integer(value: Any, low: int, high: int) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and low <= value <= high


def _is_double(value: Any) -> bool:
    try:
        return not isinstance(value, bool) and isinstance(value, (int, float)) and math.isfinite(value)
    except OverflowError:
        return False


_ARRAYS = {
    BYTE_ARRAY: _Array(
        "byte_array_value",
        "[0, 127, 255]",
        lambda value: _is_integer(value, 0, 255),
        lambda value: bytes([value]),
        lambda byte: byte[0],
    ),
    BOOL_ARRAY: _Array("bool_array_value", "[true, false]", lambda value: isinstance(value, bool)),
    INTEGER_ARRAY: _Array(
        "integer_array_value", "[1, -2, 3]", lambda value: _is_integer(value, -(2**63), 2**63 - 1)
    ),
    DOUBLE_ARRAY: _Array("double_array_value", "[0.5, 1e-3, 2]", _is_double, float),
    STRING_ARRAY: _Array("string_array_value", '["left", "right"]', lambda value: isinstance(value, str)),
}

ARRAYS = frozenset(_ARRAYS)
"""The types that are arrays."""


def text_of(message: Any) -> str:
    """Return the elements of a ParameterValue that is an array."""
    array = _ARRAYS[message.type]
    elements = getattr(message, array.field)
    return json.dumps([array.from_element(element) for element in elements], ensure_ascii=False)


def message_of_text(name: str, kind: int, text: str) -> Any:
    """Parse a ParameterValue of one of `ARRAYS`. Raises FeatureValueError with the syntax of the list."""
    from rcl_interfaces.msg import ParameterValue

    array = _ARRAYS[kind]
    elements = [array.to_element(element) for element in _elements(name, array, text)]
    return ParameterValue(type=kind, **{array.field: elements})


def _elements(name: str, array: _Array, text: str) -> list[Any]:
    text = text.strip()
    how = f"write a list as {array.example}"
    if len(text) > _MOST_CHARACTERS:
        raise FeatureValueError(f"{name}: {len(text)} characters are too many for a list", name)
    try:
        elements = json.loads(text if text.startswith("[") else f"[{text}]")
    except (ValueError, RecursionError):
        raise FeatureValueError(f"{name}={text[:60]}: that is no list; {how}", name) from None
    for place, element in enumerate(elements):
        if not array.accepts(element):
            shown = json.dumps(element, ensure_ascii=False)[:60]
            raise FeatureValueError(f"{name}: {shown}, at place {place + 1}, does not fit; {how}", name)
    return list(elements)
