"""YAML as OpenCV and ROS write it: read within bounds, and written."""

from __future__ import annotations

import itertools
import re
from pathlib import Path
from typing import Any

import yaml

from grabbergui.core.errors import UsageError
from grabbergui.core.regular_files import read_bounded

_TAG = "tag:yaml.org,2002:"
_OPENCV_DIRECTIVE = re.compile(r"\A\ufeff?%YAML:[\d.]+[ \t]*\r?\n")
"The first line of OpenCV's files, which in YAML would have a space instead of the colon."
_BRACKETS = {"[": 1, "{": 1, "]": -1, "}": -1}
_DEEPEST = 20
"Brackets within brackets that a file may have. PyYAML takes seconds for thousands, or recurses that deep."
_DASHES = re.compile(rf"^[ \t]*(?:[-?:][ \t]+){{{_DEEPEST}}}", re.MULTILINE)
"Lists within lists, begun on one line."
MOST_DOCUMENTS = 100


MAX_FILE_BYTES = 64 * 1024


def text_of(path: Path) -> str:
    """Return the text of a file of any kind of calibration. Raises UsageError, OSError."""
    return read_bounded(path, MAX_FILE_BYTES, "calibration").decode("utf-8", "replace")


class _Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]  # PyYAML has no types
    """Accepts the tags below, and resolves plain text to numbers as YAML 1.2 does.

    Some PyYAML come without libyaml, which is ten times as fast.
    """

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012, PyYAML's own name
    yaml_constructors = {  # noqa: RUF012
        tag: construct
        for tag, construct in yaml.SafeLoader.yaml_constructors.items()
        if tag is None or tag.removeprefix(_TAG) in ("map", "seq", "str", "int", "float", "null")
    }


class _Dumper(yaml.SafeDumper):  # type: ignore[misc]
    """Quotes text that YAML 1.1 or 1.2 would resolve to another type; writes lists in brackets."""


def _in_brackets(dumper: yaml.SafeDumper, values: list[Any]) -> yaml.Node:
    return dumper.represent_sequence(f"{_TAG}seq", values, flow_style=True)


for _name, _pattern, _first in (
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("int", r"[-+]?(0|[1-9][0-9]{0,17})", list("-+0123456789")),
    ("float", r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?", list("-+.0123456789")),
    ("float", r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)", list("-+.")),
):
    _Loader.add_implicit_resolver(f"{_TAG}{_name}", re.compile(rf"({_pattern})\Z"), _first)
    _Dumper.add_implicit_resolver(f"{_TAG}{_name}", re.compile(rf"({_pattern})\Z"), _first)
_Dumper.add_representer(list, _in_brackets)
_Loader.add_constructor(f"{_TAG}opencv-matrix", yaml.SafeLoader.construct_yaml_map)


def read_yaml(text: str, where: str) -> dict[str, Any]:
    """Return the mapping in a text, or an empty one. Raises UsageError with the line."""
    documents = read_documents(text, where)
    if len(documents) > 1:
        raise UsageError(f"{where} has {len(documents)} YAML documents; one is expected")
    return documents[0] if documents else {}


def read_documents(text: str, where: str) -> list[dict[str, Any]]:
    """Return the mappings of a text's YAML documents that are not empty. Raises UsageError with the line."""
    depth = max(itertools.accumulate(_BRACKETS.get(sign, 0) for sign in text), default=0)
    if depth > _DEEPEST or _DASHES.search(text):
        raise UsageError(f"{where} is no YAML of a calibration: lists or brackets are nested too deeply")
    try:
        loaded = list(
            itertools.islice(yaml.load_all(_OPENCV_DIRECTIVE.sub("", text), _Loader), MOST_DOCUMENTS)
        )
    except yaml.MarkedYAMLError as error:
        mark, last = error.problem_mark, text.count("\n")  # libyaml marks the end after the last line
        line = f", line {min(mark.line, last) + 1}" if mark is not None else ""
        problem = ", ".join(filter(None, (error.context, error.problem)))
        raise UsageError(f"{where}{line}: {problem}") from None
    except (yaml.YAMLError, ValueError, OverflowError, RecursionError) as error:
        raise UsageError(f"{where} is no YAML of a calibration: {str(error).splitlines()[0]}") from None
    documents = [each for each in loaded if each is not None]
    if not all(isinstance(each, dict) for each in documents):
        raise UsageError(f"{where} has no entries 'key: value'")
    return documents


def write_yaml(values: dict[str, Any]) -> str:
    """Return the text of a mapping, with lists in brackets."""
    text: str = yaml.dump(values, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=100)
    return text
