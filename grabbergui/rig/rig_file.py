"""A rig's file, `stereo.yaml`: read strictly, so that a key that is misspelled is named, and written.

Durations are written as `5ms`, rates of bytes as `125MB`. A camera is its source, or a mapping with more:

    cameras:
      left: gige:GV01
      right:
        source: gige:GV02
        settings: {ExposureTime: 5000}
    trigger: {by: action, rate: 10}
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, TypeVar

import yaml

from grabbergui.core.environment import write_whole
from grabbergui.core.errors import MissingFileError, UsageError
from grabbergui.core.features import FeatureValue
from grabbergui.core.regular_files import read_bounded
from grabbergui.core.uri import SourceUri

MAX_FILE_BYTES = 1 << 20
MOST_CAMERAS = 64
FORMAT = 1
"Version of the file, its key `rig`."
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,40}")
_TIME = re.compile(r"(\d+(?:\.\d+)?(?:e-?\d+)?) *(ns|us|µs|ms|s)?")
_BYTES = re.compile(r"(\d+(?:\.\d+)?(?:e\d+)?) *([kMG])?B?(?:/s)?")
_UNITS = {"ns": 1e-9, "us": 1e-6, "µs": 1e-6, "ms": 1e-3, "s": 1.0, None: 1.0}
_FACTORS = {None: 1.0, "k": 1e3, "M": 1e6, "G": 1e9}

CLOCKS = ("auto", "ptp", "fitted", "host")
"auto: PTP if every camera has it and finds a master, else fitted; host: times of arrival."
MATCHES = ("auto", "time", "counter", "action")
MISSING = ("deliver", "drop", "stop")
"Choices for a set with a missing camera: it is delivered, only counted, or ends the stream with an error."
OPENED_OFTEN = ("sim", "twin", "file")
"Kinds of source that may be opened more than once at the same time."
TRIGGERS = ("free", "software", "action", "line")
ALIGNMENTS = ("start", "middle", "end")
FOLLOWED = ("ExposureTime", "Gain", "BalanceRatio")

T = TypeVar("T")


@dataclass(frozen=True)
class CameraEntry:
    """A camera of a rig."""

    source: str
    settings: dict[str, FeatureValue] = field(default_factory=dict)
    "Written when the rig is opened: `ExposureTime: 5000`, `Gain[GainSelector=Red]: 2`."


@dataclass(frozen=True)
class TriggerEntry:
    """How frames of one moment are made."""

    by: str = "free"
    rate: float = 0.0
    "Triggers per second that the rig sends by itself; 0: only on request."
    align: str = "start"
    "Which moment of the exposures coincides."
    leader: str = ""
    "With `line`: the camera whose output triggers the others; empty for a signal from elsewhere."
    output: str = "Line2"
    "The leader's line that carries its exposure."
    input: str = "Line1"
    "The line that triggers the others."
    activation: str = "RisingEdge"
    inverted: bool = False
    "Whether the input's LineInverter is on."
    group_key: int = 1
    group_mask: int = 1
    device_key: int = 1
    ahead: float = 0.05
    "Seconds by which an action is scheduled ahead."

    @property
    def title(self) -> str:
        """The source of the cameras' trigger: `Software`, `Action`, a line; empty if they run freely."""
        return {"free": "", "line": self.input}.get(self.by, self.by.capitalize())


@dataclass(frozen=True)
class LinkEntry:
    """The link that all cameras share."""

    rate: float = 125e6
    "Bytes per second."
    share: float = 0.9
    "Part of it that may be used."
    buffer: float = 128e3
    "Bytes of the switch's buffer in front of this computer."


@dataclass(frozen=True)
class FollowEntry:
    """Settings of one camera that the others follow."""

    leader: str = ""
    features: tuple[str, ...] = FOLLOWED
    factors: dict[str, float] = field(default_factory=dict)
    "By camera: its exposure time is the leader's times this."
    limits: dict[str, tuple[float, float]] = field(default_factory=dict)
    "By camera: smallest and largest exposure time in microseconds."


@dataclass(frozen=True)
class RigEntry:
    """The content of a rig's file."""

    cameras: dict[str, CameraEntry]
    clock: str = "auto"
    match: str = "auto"
    tolerance: float = 0.0
    "Seconds between two frames of one set; 0: half of the frame period."
    deadline: float = 0.1
    "Seconds from the first frame of a set after which it is late."
    wait: float = 1.0
    "Seconds from the first frame of a set after which it is given up."
    missing: str = "deliver"
    trigger: TriggerEntry = TriggerEntry()
    link: LinkEntry = LinkEntry()
    follow: FollowEntry = FollowEntry()

    def __post_init__(self) -> None:
        """Raise UsageError for a name that no camera has."""
        if not self.cameras:
            raise UsageError("a rig needs at least one camera")
        if len(self.cameras) > MOST_CAMERAS:
            raise UsageError(f"a rig of {len(self.cameras)} cameras; at most {MOST_CAMERAS} are allowed")
        named = {"trigger.leader": self.trigger.leader, "follow.leader": self.follow.leader}
        named |= {f"follow.factors.{name}": name for name in self.follow.factors}
        named |= {f"follow.limits.{name}": name for name in self.follow.limits}
        for where, name in named.items():
            if name and name not in self.cameras:
                raise UsageError(f"{where}: there is no camera {name}; there are {', '.join(self.cameras)}")


def read(path: Path) -> RigEntry:
    """Read a rig's file. Raises UsageError that names a wrong key or value, MissingFileError."""
    try:
        content = read_bounded(path, MAX_FILE_BYTES, "file of a rig")
    except FileNotFoundError as error:
        raise MissingFileError(f"there is no rig {path}; `grabbergui rig new` makes one") from error
    except OSError as error:
        raise UsageError(f"{path} could not be read: {error.strerror or error}") from error
    return parse(content.decode("utf-8", "replace"), str(path))


def parse(text: str, where: str = "the rig") -> RigEntry:
    """Return the content of a file's text. Raises UsageError."""
    try:
        content = yaml.load(text, _NoDuplicates)
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        problem = getattr(error, "problem", None) or "nested too deeply"
        mark = getattr(error, "problem_mark", None)
        line = f", line {mark.line + 1}" if mark is not None else ""
        raise UsageError(f"{where}{line} is not YAML: {problem}") from None
    try:
        return _rig(_Section(content, ""))
    except UsageError as error:
        raise UsageError(f"{where}: {error}") from None


def write(path: Path, rig: RigEntry) -> None:
    """Write a rig's file as a whole. Raises UsageError if that fails, or if `read` would refuse it."""
    text = to_text(rig)
    parse(text, str(path))
    try:
        write_whole(path, text)
    except OSError as error:
        raise UsageError(f"{path} could not be written: {error.strerror or error}") from error


def to_text(rig: RigEntry) -> str:
    """Return the text of a rig's file, without what has its default."""
    content: dict[str, Any] = {"rig": FORMAT, "cameras": {}}
    for name, camera in rig.cameras.items():
        more = {"settings": dict(camera.settings)} if camera.settings else {}
        content["cameras"][name] = {"source": camera.source, **more} if more else camera.source
    content |= _changed(rig)
    text: str = yaml.safe_dump(content, sort_keys=False, allow_unicode=True)
    return text


def _changed(entry: Any) -> dict[str, Any]:
    """Return the fields of a dataclass that do not have their default, for YAML."""
    changed: dict[str, Any] = {}
    for each in fields(entry):
        value = getattr(entry, each.name)
        if each.name == "cameras" or value == each.default:
            continue
        if hasattr(value, "__dataclass_fields__"):
            value = _changed(value)
        elif isinstance(value, tuple):
            value = list(value)
        elif isinstance(value, dict):
            value = {key: list(one) if isinstance(one, tuple) else one for key, one in value.items()}
        if value not in ({}, []):
            changed[each.name] = value
    return changed


class _NoDuplicates(yaml.SafeLoader):  # type: ignore[misc]
    """Reads YAML without aliases, and refuses a key that is there twice."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):
            event = self.peek_event()
            raise yaml.composer.ComposerError(None, None, "aliases are not allowed", event.start_mark)
        return super().compose_node(parent, index)

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:
        seen = set()
        for key, _ in node.value:
            if key.value in seen:
                raise yaml.constructor.ConstructorError(
                    None, None, f"{key.value} is there twice", key.start_mark
                )
            seen.add(key.value)
        found: dict[Any, Any] = super().construct_mapping(node, deep)
        return found


class _Section:
    """A mapping of which every key must be taken."""

    def __init__(self, content: object, where: str) -> None:
        if not isinstance(content, dict):
            found = "nothing" if content is None else f"'{str(content)[:40]}'"
            raise UsageError(f"{where or 'the file'}: write a mapping (`key: value`), not {found}")
        self._content: dict[Any, Any] = dict(content)
        self._where = where
        self._known: list[str] = []

    def path(self, key: str) -> str:
        """Return the name of a key from the file's beginning."""
        return f"{self._where}.{key}" if self._where else key

    def take(self, key: str, convert: Callable[[object], T], default: T) -> T:
        """Return the value of a key. Raises UsageError that names the key and its allowed values."""
        self._known.append(key)
        if key not in self._content:
            return default
        value = self._content.pop(key)
        try:
            return convert(value)
        except ValueError as error:
            raise UsageError(f"{self.path(key)}: {value!r} is not allowed; write {error}") from None

    def section(self, key: str) -> _Section:
        """Return the mapping below a key; an empty one without the key."""
        self._known.append(key)
        return _Section(self._content.pop(key, {}), self.path(key))

    def rest(self) -> dict[Any, Any]:
        """Return all keys, for a mapping whose keys are names."""
        content, self._content = self._content, {}
        return content

    def end(self) -> None:
        """Raise UsageError for a key that was not taken."""
        for key in self._content:
            near = difflib.get_close_matches(str(key), self._known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(self._known)}"
            raise UsageError(f"there is no key {self.path(str(key)[:40])}; {hint}")


def _rig(section: _Section) -> RigEntry:
    section.take("rig", _number(FORMAT, FORMAT), float(FORMAT))
    cameras = {
        _camera_name(name): _camera(entry, f"cameras.{name}")
        for name, entry in section.section("cameras").rest().items()
    }
    _check_sources(cameras)
    rig = RigEntry(
        cameras,
        clock=section.take("clock", _one_of(*CLOCKS), "auto"),
        match=section.take("match", _one_of(*MATCHES), "auto"),
        tolerance=section.take("tolerance", _seconds, 0.0),
        deadline=section.take("deadline", _seconds, 0.1),
        wait=section.take("wait", _seconds, 1.0),
        missing=section.take("missing", _one_of(*MISSING), "deliver"),
        trigger=_trigger(section.section("trigger")),
        link=_link(section.section("link")),
        follow=_follow(section.section("follow")),
    )
    section.end()
    return rig


def _check_sources(cameras: Mapping[str, CameraEntry]) -> None:
    """Raise UsageError for a camera that is there twice, which can be opened only once."""
    names: dict[str, str] = {}
    for name, camera in cameras.items():
        uri = SourceUri.parse(camera.source)
        if uri.scheme in OPENED_OFTEN:
            continue
        if (other := names.setdefault(str(uri), name)) != name:
            raise UsageError(f"cameras.{name}: {uri} is {other} already; write another camera's source")


def _camera_name(name: object) -> str:
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise UsageError(
            f"cameras: {str(name)[:40]!r} cannot be a camera's name; write letters, digits, - and _"
        )
    return name


def _camera(entry: object, where: str) -> CameraEntry:
    if isinstance(entry, str):
        return CameraEntry(entry)
    section = _Section(entry, where)
    source = section.take("source", _text, "")
    settings = {str(name): _value(value, where) for name, value in section.section("settings").rest().items()}
    section.end()
    if not source:
        raise UsageError(f"{where}.source is missing; write a source such as gige:192.168.0.10")
    return CameraEntry(source, settings)


def _trigger(section: _Section) -> TriggerEntry:
    default, key = TriggerEntry(), _number(0, 0xFFFFFFFF)
    entry = TriggerEntry(
        by=section.take("by", _one_of(*TRIGGERS), default.by),
        rate=section.take("rate", _number(0, 100_000), default.rate),
        align=section.take("align", _one_of(*ALIGNMENTS), default.align),
        leader=section.take("leader", _text, default.leader),
        output=section.take("output", _text, default.output),
        input=section.take("input", _text, default.input),
        activation=section.take("activation", _text, default.activation),
        inverted=section.take("inverted", _switch, default.inverted),
        group_key=int(section.take("group_key", key, float(default.group_key))),
        group_mask=int(section.take("group_mask", key, float(default.group_mask))),
        device_key=int(section.take("device_key", key, float(default.device_key))),
        ahead=section.take("ahead", _seconds, default.ahead),
    )
    section.end()
    return entry


def _link(section: _Section) -> LinkEntry:
    default = LinkEntry()
    entry = LinkEntry(
        rate=section.take("rate", byte_count, default.rate),
        share=section.take("share", _number(0.01, 1), default.share),
        buffer=section.take("buffer", byte_count, default.buffer),
    )
    section.end()
    return entry


def _follow(section: _Section) -> FollowEntry:
    entry = FollowEntry(
        leader=section.take("leader", _text, ""),
        features=section.take("features", _features, FOLLOWED),
        factors={
            str(name): _checked(_number(1e-3, 1e3), value, section.path(f"factors.{name}"))
            for name, value in section.section("factors").rest().items()
        },
        limits={
            str(name): _checked(_range, value, section.path(f"limits.{name}"))
            for name, value in section.section("limits").rest().items()
        },
    )
    section.end()
    return entry


def _checked(convert: Callable[[object], T], value: object, where: str) -> T:
    try:
        return convert(value)
    except ValueError as error:
        raise UsageError(f"{where}: {value!r} is not allowed; write {error}") from None


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise ValueError("a text")
    return value


def _switch(value: object) -> bool:
    if not isinstance(value, bool):
        raise ValueError("true or false")
    return value


def _value(value: object, where: str) -> FeatureValue:
    if not isinstance(value, int | float | bool | str):
        raise UsageError(f"{where}.settings: {str(value)[:40]!r} is no value of a feature")
    return value


def _one_of(*choices: str) -> Callable[[object], str]:
    def convert(value: object) -> str:
        if value not in choices:
            raise ValueError(" or ".join(choices))
        return str(value)

    return convert


def _number(low: float, high: float) -> Callable[[object], float]:
    def convert(value: object) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
            raise ValueError(f"a number from {low:g} to {high:g}")
        return value

    return convert


def _seconds(value: object) -> float:
    """Read a duration as `5ms`; a number alone is seconds."""
    match = _TIME.fullmatch(str(value)) if not isinstance(value, bool) else None
    seconds = float(match[1]) * _UNITS[match[2]] if match is not None else math.nan
    if not 0 <= seconds <= 3600:
        raise ValueError("a duration from 0 to 3600s, such as 5ms")
    return seconds


def byte_count(value: object) -> float:
    """Read bytes, or bytes per second, as `125MB`. Raises ValueError that says what is allowed."""
    match = _BYTES.fullmatch(str(value)) if not isinstance(value, bool) else None
    count = float(match[1]) * _FACTORS[match[2]] if match is not None else math.nan
    if not 1 <= count <= 1e12:
        raise ValueError("bytes from 1 to 1000GB, such as 125MB")
    return count


def _features(value: object) -> tuple[str, ...]:
    names = value if isinstance(value, list) else [value]
    if not names or not all(name in FOLLOWED for name in names):
        raise ValueError(f"a list of {', '.join(FOLLOWED)}")
    return tuple(names)


def _range(value: object) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError("[smallest, largest] in microseconds")
    low, high = (_number(0, 1e9)(each) for each in value)
    if low > high:
        raise ValueError("[smallest, largest] in microseconds")
    return low, high


def of_sources(sources: Mapping[str, str], **more: Any) -> RigEntry:
    """Return a rig of cameras by name."""
    return RigEntry({_camera_name(name): CameraEntry(uri) for name, uri in sources.items()}, **more)
