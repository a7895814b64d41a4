"""JSON is JSON: no NaN, no Infinity, from one place."""

import json
import math
import re
from dataclasses import asdict, dataclass
from pathlib import Path

import pytest

import grabbergui
from grabbergui.core.json_text import to_json

PACKAGE = Path(grabbergui.__file__).parent


def strictly(text: str) -> object:
    def refuse(name: str) -> None:
        raise AssertionError(f"{name} is not JSON")

    return json.loads(text, parse_constant=refuse)


@dataclass
class Point:
    x: float


@pytest.mark.parametrize("odd", [math.nan, math.inf, -math.inf])
def test_numbers_that_json_does_not_have_are_null(odd):
    content = {"a": odd, "b": [1.5, odd, {"c": (odd, 0.1)}], "d": "NaN", "e": Point(odd)}
    expected = {"a": None, "b": [1.5, None, {"c": [None, 0.1]}], "d": "NaN", "e": {"x": None}}

    assert strictly(to_json(content, default=asdict)) == expected
    assert strictly(to_json(content, default=asdict, indent=2)) == expected


def test_everything_else_is_as_it_was():
    content = {"ü": [True, None, 2**63, 0.1, 1e-300], "b": {}}
    assert json.loads(to_json(content)) == content
    assert to_json(content, compact=True, ascii_only=False).startswith('{"ü":[true,null,9223372036854775808,')


def test_what_is_not_plain_data_is_refused():
    with pytest.raises(TypeError):
        to_json({"a": object()})


def test_json_is_written_in_one_place():
    writing = re.compile(r"\bjson\.dumps?\(|JSONEncoder")
    found = [path for path in PACKAGE.rglob("*.py") if writing.search(path.read_text("utf-8"))]
    assert [path.relative_to(PACKAGE).as_posix() for path in found] == ["core/json_text.py"]


def test_what_is_not_plain_may_be_made_plain():
    assert to_json({"a": {1}}, default=sorted, compact=True) == '{"a":[1]}'
