"""The public surface: whatever a program gets from it is public, typed and documented."""

from __future__ import annotations

import builtins
import inspect
import re
import sys
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import grabbergui
from every_case import every_case
from grabbergui.core.coord3d import Scan3d
from grabbergui.core.encoded_image import Encoding
from grabbergui.core.frame_queue import RateMeter
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.pfnc import Family, SampleLayout
from grabbergui.models.settings.feature_set import FeatureSet
from grabbergui.recording.kinds import RecordingKind
from grabbergui.recording.recorder import RecordingLimits

REFERENCE = Path(__file__).parents[3] / "docs" / "library-reference.md"
INTERNAL = {
    Encoding,
    Family,
    FeatureSet,
    FrameGrabber,
    RateMeter,
    RecordingKind,
    RecordingLimits,
    SampleLayout,
    Scan3d,
}
"Reached by members that the library itself uses; the reference says which these are."
NAMES = [name for name in grabbergui.__all__ if name != "__version__"]
CLASSES = [name for name in NAMES if inspect.isclass(getattr(grabbergui, name))]


def members(kind: type) -> Iterator[tuple[str, Any]]:
    """Yield the functions behind a class's public members, with their names."""
    for owner in kind.__mro__:
        if owner.__module__.startswith("grabbergui"):
            for name, member in vars(owner).items():
                function = (
                    member.fget if isinstance(member, property) else getattr(member, "__func__", member)
                )
                if inspect.isfunction(function) and (not name.startswith("_") or name == "__iter__"):
                    yield f"{owner.__name__}.{name}", function


def hints_of(name: str) -> Iterator[tuple[str, Any]]:
    """Yield every type in the signatures and fields of a public name, with the place."""
    value = getattr(grabbergui, name)
    if not inspect.isclass(value):
        functions = [(name, value)]
    else:
        functions = list(members(value))
        for owner in value.__mro__:
            if owner.__module__.startswith("grabbergui"):
                for field, hint in typing.get_type_hints(owner).items():
                    if not field.startswith("_"):
                        yield f"{owner.__name__}.{field}", hint
    for place, function in functions:
        for argument, hint in typing.get_type_hints(function).items():
            yield f"{place}: {argument}", hint


def classes_in(hint: Any) -> Iterator[type]:
    """Yield the package's own classes in a type."""
    if isinstance(hint, type) and hint.__module__.startswith("grabbergui"):
        yield hint
    for part in typing.get_args(hint):
        for each in part if isinstance(part, list) else [part]:
            yield from classes_in(each)


@every_case("name", [name for name in NAMES if name != "SettingValue"])
def test_what_a_program_gets_is_public(name: str) -> None:
    public = {getattr(grabbergui, each) for each in CLASSES} | INTERNAL
    others = {
        f"{place} -> {found.__name__}"
        for place, hint in hints_of(name)
        for found in classes_in(hint)
        if found not in public
    }
    assert not others


@every_case("name", NAMES)
def test_an_error_that_is_documented_can_be_caught(name: str) -> None:
    value = getattr(grabbergui, name)
    functions = [each for _, each in members(value)] if inspect.isclass(value) else [value]
    texts = [inspect.getdoc(each) or "" for each in [value, *functions]]
    named = {error for text in texts for error in re.findall(r"\b[A-Z]\w+Error\b", text)}
    assert not {error for error in named if error not in NAMES and not hasattr(builtins, error)}


@every_case("name", CLASSES)
def test_every_member_is_typed(name: str) -> None:
    for place, function in members(getattr(grabbergui, name)):
        signature = inspect.signature(function)
        untyped = [
            each.name for each in list(signature.parameters.values())[1:] if each.annotation is each.empty
        ]
        assert not untyped and signature.return_annotation is not signature.empty, place


def test_every_public_name_is_in_the_reference() -> None:
    listed = re.findall(r"^::: grabbergui\.(\w+)$", REFERENCE.read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(listed) == sorted(set(listed)) == sorted(NAMES)


def test_the_callbacks_are_typed() -> None:
    camera = sys.modules[grabbergui.Camera.__module__]
    overloads = typing.get_overloads(camera.Camera.on) if sys.version_info >= (3, 11) else ()
    for each in overloads:
        assert Any not in typing.get_args(typing.get_type_hints(each)["callback"])[0]
