"""Arrays of parameters as text, and back."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from grabbergui.core.errors import FeatureValueError
from grabbergui.core.json_text import to_json

BYTE_ARRAY, BOOL_ARRAY, INTEGER_ARRAY, DOUBLE_ARRAY, STRING_ARRAY = ARRAYS = range(5, 10)
"""Kinds of arrays, numbered as in `rcl_interfaces/msg/ParameterType`."""
_MOST_CHARACTERS = 1 << 20


@dataclass(frozen=True)
class _Array:
    field: str
    "The field of the message that has the array."
    example: str
    accepts: Callable[[Any], bool]
    "Whether a value may be an element."
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


def text_of(message: Any) -> str:
    """Return the elements of a ParameterValue that is an array."""
    array = _ARRAYS[message.type]
    elements = getattr(message, array.field)
    return to_json([array.from_element(element) for element in elements], ascii_only=False)


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
            shown = str(element) if isinstance(element, float) else to_json(element, ascii_only=False)[:60]
            raise FeatureValueError(f"{name}: {shown}, at place {place + 1}, does not fit; {how}", name)
    return list(elements)
