"""A set of settings: what a camera was told, instance by instance of what selectors select.

Plain data, taken from any frame grabber and compared with another set. How it lies in files is told by
`files`, how it comes back onto a camera by `loading`.
"""

from __future__ import annotations

import itertools
import logging
import math
import threading
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

from grabbergui.core.errors import FeatureError
from grabbergui.core.features import (
    AccessMode,
    Feature,
    FeatureDescription,
    FeatureKind,
    FeatureValue,
    format_value,
)
from grabbergui.core.grabber import Access, FrameGrabber

log = logging.getLogger(__name__)

MAX_INSTANCES = 4096
"Of one feature under its selectors: a look-up table of 12 bits. What has more is left out, and said so."
_TOLERANCE = 1e-6
"Relative: other programs print seven digits of a float, and a camera rounds to its register."

Progress = Callable[[int, int], None]
"Called with how much is done and of how much."
SelectorsOf = Callable[[str], Sequence[str]]
"The names of the features that select which instance of a feature is seen, outermost first."


@dataclass(frozen=True)
class SettingKey:
    """Which knob: a feature, and where its selectors stand."""

    name: str
    selected: tuple[tuple[str, str], ...] = ()
    "Pairs of selector and entry, outermost selector first."

    def __str__(self) -> str:
        """`Width`, `BalanceRatio[BalanceRatioSelector=Red]`."""
        if not self.selected:
            return self.name
        return f"{self.name}[{','.join(f'{selector}={entry}' for selector, entry in self.selected)}]"


@dataclass(frozen=True)
class FeatureSet:
    """Settings in the order in which they are set."""

    settings: Mapping[SettingKey, FeatureValue]
    device: str = ""
    "Vendor, model and serial number of the camera they are of, for people."
    left_out: tuple[str, ...] = ()
    "What could not be taken along and why, a sentence each."

    def __len__(self) -> int:
        return len(self.settings)

    def only(self, keys: Collection[SettingKey] | None) -> FeatureSet:
        """Of these settings alone; None leaves all of them."""
        if keys is None:
            return self
        settings = {key: value for key, value in self.settings.items() if key in keys}
        return FeatureSet(settings, self.device, self.left_out)

    def selectors_of(self, name: str) -> tuple[str, ...]:
        """What selects a feature, as far as this set tells."""
        for key in self.settings:
            if key.name == name:
                return tuple(selector for selector, _ in key.selected)
        return ()


@dataclass(frozen=True)
class Difference:
    """One setting that two sets do not agree on."""

    key: SettingKey
    first: FeatureValue | None
    "None where the first set does not have it."
    second: FeatureValue | None

    def __str__(self) -> str:
        return f"{self.key}: {_shown(self.first)} → {_shown(self.second)}"


def compare(first: FeatureSet, second: FeatureSet) -> list[Difference]:
    """What differs, in the second set's order; what only the first has comes last."""
    differences = [
        Difference(key, first.settings.get(key), value)
        for key, value in second.settings.items()
        if key not in first.settings or not same_value(first.settings[key], value)
    ]
    missing = [key for key in first.settings if key not in second.settings]
    return differences + [Difference(key, first.settings[key], None) for key in missing]


def same_value(first: FeatureValue, second: FeatureValue) -> bool:
    """Whether two values mean the same, also where one is text from a file."""
    if str(first) == str(second):
        return True
    one, other = _number(first), _number(second)
    if one is None or other is None:
        return False
    if isinstance(one, int) and isinstance(other, int):
        return one == other
    return math.isclose(one, other, rel_tol=_TOLERANCE)


def capture(
    grabber: FrameGrabber,
    *,
    progress: Progress = lambda done, of: None,
    cancelled: threading.Event | None = None,
) -> FeatureSet:
    """Every streamable setting as it stands, selectors stepped through and then put back.

    Selectors are written where the grabber is open for control; for reading only, what they happen to
    select is taken. A source that marks nothing as streamable gives all that can be read and written.
    Raises TransportError; with `cancelled` set, what was read by then is returned.
    """
    selectors = Selectors(grabber)
    wanted = _wanted(grabber, selectors)
    settings: dict[SettingKey, FeatureValue] = {}
    left_out: list[str] = []
    groups = [(path, names, *_instances(grabber, path)) for path, names in _grouped(wanted, selectors)]
    done, total = 0, sum(len(names) * len(instances) for _, names, instances, _ in groups)
    for path, names, instances, problem in groups:
        if problem:
            left_out.append(f"{', '.join(names)}: {problem}")
        with selectors.kept(path):
            for selected in instances:
                for name in names if selectors.select(selected) else ():
                    if cancelled is not None and cancelled.is_set():
                        return FeatureSet(settings, describe(grabber), tuple(left_out))
                    settings.update(_value_of(grabber, name, selected, left_out))
                    done += 1
                    progress(done, total)
    return FeatureSet(_in_tree_order(settings, wanted), describe(grabber), tuple(left_out))


def every_instance(grabber: FrameGrabber, selectors: Selectors, name: str) -> dict[SettingKey, FeatureValue]:
    """Where a feature stands under each combination of its selectors, which end where they stood."""
    path = selectors.of(name)
    instances, _ = _instances(grabber, path)
    found: dict[SettingKey, FeatureValue] = {}
    with selectors.kept(path):
        for selected in instances:
            if selectors.select(selected) and (value := _value(grabber, name)) is not None:
                found[SettingKey(name, selected)] = value
    return found


def describe(grabber: FrameGrabber) -> str:
    """A camera by vendor, model and serial number."""
    info = grabber.info
    return " ".join(part for part in (info.vendor, info.model, info.serial) if part) or info.uri


@dataclass
class Selectors:
    """The selectors of one open grabber: what they select, and where they stand."""

    grabber: FrameGrabber
    _descriptions: dict[str, FeatureDescription] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._descriptions = {d.name: d for d in self.grabber.feature_tree().descriptions()}

    @property
    def descriptions(self) -> dict[str, FeatureDescription]:
        """Every feature of the tree by name, in the tree's order."""
        return self._descriptions

    def of(self, name: str) -> tuple[str, ...]:
        """What selects a feature, and what selects that: outermost first, each once."""
        found: list[str] = []
        self._collect(name, found)
        return tuple(found)

    def all_names(self) -> frozenset[str]:
        """Every feature that selects another."""
        return frozenset(selector for d in self._descriptions.values() for selector in d.selectors)

    def select(self, selected: Sequence[tuple[str, str]]) -> bool:
        """Let the selectors stand at these entries, writing what is elsewhere. False where one refuses."""
        for selector, entry in selected:
            try:
                if not same_value(str(_value(self.grabber, selector)), entry):
                    self.grabber.write_feature(selector, entry)
            except FeatureError as error:
                log.debug("%s=%s: %s", selector, entry, error)
                return False
        return True

    @contextmanager
    def kept(self, names: Sequence[str]) -> Iterator[None]:
        """Put selectors back behind the block to where they stood before it."""
        before = [
            (name, format_value(value)) for name in names if (value := _value(self.grabber, name)) is not None
        ]
        try:
            yield
        finally:
            self.select(before)

    def _collect(self, name: str, found: list[str]) -> None:
        description = self._descriptions.get(name)
        for selector in description.selectors if description is not None else ():
            # A description that selects itself in a circle must not be followed for ever.
            if selector not in found and selector != name and selector in self._descriptions:
                found.append(selector)
                inner: list[str] = []
                self._collect_above(selector, inner, {name, *found})
                found[-1:-1] = inner

    def _collect_above(self, name: str, above: list[str], seen: set[str]) -> None:
        for selector in self._descriptions[name].selectors:
            if selector not in seen and selector in self._descriptions:
                seen.add(selector)
                self._collect_above(selector, above, seen)
                above.append(selector)


def _wanted(grabber: FrameGrabber, selectors: Selectors) -> list[str]:
    known = selectors.descriptions
    streamable = [name for name, d in known.items() if d.streamable and d.kind is not FeatureKind.COMMAND]
    if streamable:
        return streamable
    choosing = selectors.all_names()
    return [n for n, d in known.items() if d.kind is not FeatureKind.COMMAND and n not in choosing]


def _grouped(names: Sequence[str], selectors: Selectors) -> list[tuple[tuple[str, ...], list[str]]]:
    """Features by what selects them, so that each selector is stepped through once."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for name in names:
        groups.setdefault(selectors.of(name), []).append(name)
    return list(groups.items())


def _instances(grabber: FrameGrabber, path: Sequence[str]) -> tuple[list[tuple[tuple[str, str], ...]], str]:
    """Every combination of the selectors' entries, and why only some are taken where that is so."""
    features = [grabber.feature(name) for name in path]
    standing = tuple((f.name, format_value(f.value)) for f in features if f.value is not None)
    if len(standing) < len(features):
        return [], ""  # the camera hides its selector just now, and it with it
    if grabber.access is not Access.CONTROL or not all(
        f.access.writable for f in features if len(_entries(f)) > 1
    ):
        return [standing], "only what its selector stands at, which cannot be moved" if path else ""
    choices = [_entries(feature) for feature in features]
    if math.prod(len(entries) for entries in choices) > MAX_INSTANCES:
        return [standing], f"more than {MAX_INSTANCES} instances; only the selected one is kept"
    return [tuple(zip(path, entries, strict=True)) for entries in itertools.product(*choices)], ""


def _entries(selector: Feature) -> Sequence[str]:
    if selector.kind is FeatureKind.ENUMERATION:
        return [entry.name for entry in selector.entries if entry.available]
    if selector.kind is FeatureKind.BOOLEAN:
        return ["false", "true"]
    low, high = selector.minimum, selector.maximum
    if selector.kind is FeatureKind.INTEGER and isinstance(low, int) and isinstance(high, int):
        numbers = range(low, high + 1, int(selector.increment or 1))
        # Only the beginning is made, enough to tell that it is too many.
        return [str(number) for number in itertools.islice(numbers, MAX_INSTANCES + 1)]
    return [format_value(selector.value)]


def _value_of(
    grabber: FrameGrabber, name: str, selected: tuple[tuple[str, str], ...], left_out: list[str]
) -> Iterator[tuple[SettingKey, FeatureValue]]:
    """What a feature stands at, where that is a setting."""
    feature = grabber.feature(name)
    if feature.problem:
        left_out.append(f"{SettingKey(name, selected)}: {feature.problem}")
    reading = grabber.access is not Access.CONTROL and feature.access is AccessMode.READ_ONLY
    if feature.value is not None and (feature.access.writable or reading):
        yield SettingKey(name, selected), feature.value


def _in_tree_order(
    settings: dict[SettingKey, FeatureValue], names: Sequence[str]
) -> dict[SettingKey, FeatureValue]:
    place = {name: index for index, name in enumerate(names)}
    return dict(sorted(settings.items(), key=lambda item: place[item[0].name]))


def _value(grabber: FrameGrabber, name: str) -> FeatureValue | None:
    return grabber.feature(name).value


def _number(value: FeatureValue) -> int | float | None:
    if isinstance(value, int | float):
        return int(value) if isinstance(value, bool) else value
    text = value.strip().lower()
    if text in ("true", "false"):
        return int(text == "true")
    try:
        return int(text, 0)
    except ValueError:
        pass
    try:
        return float(text)
    except ValueError:
        return None


def _shown(value: FeatureValue | None) -> str:
    return "(not in it)" if value is None else format_value(value)
