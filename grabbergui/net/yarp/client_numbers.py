"""The features of a remote frame grabber of YARP's own: numbers on the wire, SFNC names here."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

from grabbergui.core.errors import FeatureAccessError, FeatureError
from grabbergui.core.features import (
    AccessMode,
    Category,
    EnumEntry,
    Feature,
    FeatureDescription,
    FeatureKind,
    FeatureValue,
)
from grabbergui.core.sfnc import AUTO_CONTINUOUS, AUTO_OFF, AUTO_ONCE, automatic_mode_of, switched_off
from grabbergui.net.numbered_features import BALANCE_SELECTOR, BLUE, RED, ROLES, FeatureId, FeatureMode
from grabbergui.net.yarp.grabber_rpc import CallReply, Operation
from grabbergui.net.yarp.grabber_values import Value

Ask = Callable[..., CallReply]
"""Performs an operation with its arguments on the server and returns its reply."""

_NAMES = {
    **{feature: role.names[0] for feature, role in ROLES.items()},
    # Not SFNC's names: YARP's numbers define a feature's purpose, not its type.
    **{FeatureId.SHUTTER: "Shutter", FeatureId.TRIGGER: "Trigger"},
}
_UNITS = {FeatureId.EXPOSURE: "us", FeatureId.TRIGGER_DELAY: "us", FeatureId.FRAME_RATE: "Hz"}
"""SFNC's units, for values in the camera's own units."""

_SANE = 1e15
"""Limit of valid values: a 3.x server that fails to read one sends uninitialised memory."""

_MIRROR = ROLES[FeatureId.MIRROR].names[0]

CONTROLS, DEVICE = "RemoteControls", "RemoteDevice"


@dataclass(frozen=True)
class _Numbered:
    """One number the server knows, and the features made of it."""

    number: FeatureId
    name: str
    automatic: str = ""
    "Name of its automatic mode; empty where it has none."
    switch: str = ""
    "Name of its switch; empty where it has none."
    once: bool = False
    settable: bool = True

    @property
    def two_values(self) -> bool:
        return self.number is FeatureId.WHITE_BALANCE


@dataclass(frozen=True)
class _Entry:
    """Access functions of one feature."""

    read: Callable[[], Feature]
    write: Callable[[FeatureValue], None] | None = None
    "None where it is read-only."


class NumberFeatures:
    """Features of a server that knows YARP's interface only. One thread at a time.

    Where it answers with a range, values are in the camera's own units; where it does not, they go from
    0 to 1.
    """

    def __init__(self, ask: Ask) -> None:
        self._ask = ask
        self._channel = RED
        self._seen: dict[str, Feature] = {}
        self._numbered = [numbered for number in FeatureId if (numbered := self._explore(number)) is not None]
        self._entries = dict(self._make_entries())
        self.tree = self._make_tree()
        "The feature tree; requested from the server once."

    def has(self, name: str) -> bool:
        """Return whether there is such a feature."""
        return name in self._entries

    def read(self, name: str) -> Feature:
        """Return the feature as the server has it now."""
        return self._entries[name].read()

    def write(self, name: str, value: FeatureValue) -> Feature:
        """Set it and read it back; an automatic mode that is on is switched off first."""
        feature = self.read(name)
        write = self._entries[name].write
        if write is None:
            raise FeatureAccessError(f"{name} {feature.access_problem()}", name)
        accepted = feature.validated(value)
        if feature.auto is not None and (off := switched_off(self.read(feature.auto))) is not None:
            self.write(*off)
        write(accepted)
        return self.read(name)

    def execute(self, name: str) -> None:
        """Raise FeatureAccessError, as YARP's interface has no commands."""
        raise FeatureAccessError(f"{name} is no command; YARP's own servers have none", name)

    def changes(self) -> frozenset[str]:
        """Read all features that may change again, and return the names of those that others changed.

        The first call returns all names, since earlier changes are unknown.
        """
        now = {name: entry.read() for name, entry in self._entries.items() if entry.write is not None}
        before, self._seen = self._seen, now
        return frozenset(name for name, feature in now.items() if before.get(name) != feature)

    def _explore(self, number: FeatureId) -> _Numbered | None:
        if not self._flag(Operation.HAS_FEATURE, number):
            return None
        name = _NAMES[number]
        once = self._flag(Operation.HAS_ONE_PUSH, number)
        auto = once or self._flag(Operation.HAS_AUTO, number)
        return _Numbered(
            number,
            name,
            automatic=(automatic_mode_of(name, lambda _: True) or "") if auto else "",
            switch=f"{name}Enable" if self._flag(Operation.HAS_ON_OFF, number) else "",
            once=once,
            settable=self._flag(Operation.HAS_MANUAL, number),
        )

    def _make_entries(self) -> Iterator[tuple[str, _Entry]]:
        for numbered in self._numbered:
            write = partial(self._write_numbered, numbered) if numbered.settable else None
            yield numbered.name, _Entry(partial(self._read_numbered, numbered), write)
            if numbered.two_values:
                yield BALANCE_SELECTOR, _Entry(self._read_selector, self._write_selector)
            if numbered.automatic:
                yield (
                    numbered.automatic,
                    _Entry(partial(self._read_automatic, numbered), partial(self._write_automatic, numbered)),
                )
            if numbered.switch:
                yield (
                    numbered.switch,
                    _Entry(partial(self._read_switch, numbered), partial(self._write_switch, numbered)),
                )
        mirrored_by_number = any(numbered.number is FeatureId.MIRROR for numbered in self._numbered)
        if not mirrored_by_number and self._ask(Operation.GET_MIRROR).ok:
            yield _MIRROR, _Entry(self._read_mirror, self._write_mirror)
        for name, operation in (("Width", Operation.WIDTH), ("Height", Operation.HEIGHT)):
            if self._ask(operation).ok:
                yield name, _Entry(partial(self._read_size, name, operation))
        description = self._ask(Operation.DESCRIPTION)
        if description.ok and description.values[1]:
            yield "DeviceModelName", _Entry(partial(_model_name, str(description.values[1])))

    def _make_tree(self) -> Category:
        features = [entry.read() for entry in self._entries.values()]
        controls = tuple(_description(feature) for feature in features if feature.category == CONTROLS)
        device = tuple(_description(feature) for feature in features if feature.category == DEVICE)
        return Category(
            "Root",
            members=(
                Category(
                    CONTROLS,
                    "Controls",
                    "Settings that the remote camera lets others change",
                    members=controls,
                ),
                Category(DEVICE, "Device", "Properties that the remote camera reports", members=device),
            ),
        )

    def _read_numbered(self, numbered: _Numbered) -> Feature:
        if numbered.two_values:
            pair = self._numbers(Operation.GET_VALUES, numbered.number)
            value = None if pair is None else pair[0 if self._channel == RED else 1]
            span = (0.0, 1.0) if value is not None and 0 <= value <= 1 else None
            raw = False
        else:
            single = self._numbers(Operation.GET_VALUE, numbered.number)
            value = None if single is None else single[0]
            span, raw = self._span(numbered, value)
        readable = value is not None
        access = AccessMode.READ_WRITE if numbered.settable else AccessMode.READ_ONLY
        return Feature(
            name=numbered.name,
            kind=FeatureKind.FLOAT,
            category=CONTROLS,
            streamable=numbered.settable,
            selectors=(BALANCE_SELECTOR,) if numbered.two_values else (),
            access=access if readable else AccessMode.NOT_AVAILABLE,
            value=value,
            minimum=span[0] if span else None,
            maximum=span[1] if span else None,
            unit=_UNITS.get(numbered.number, "") if raw else "",
            auto=numbered.automatic or None,
            problem="" if readable else "the server gave no value",
        )

    def _span(self, numbered: _Numbered, value: float | None) -> tuple[tuple[float, float] | None, bool]:
        """Return the range and whether it is in the camera's own units."""
        span = self._numbers(Operation.GET_VALUES, numbered.number)
        if span is not None and value is not None and span[0] < span[1] and span[0] <= value <= span[1]:
            return (span[0], span[1]), True
        return ((0.0, 1.0) if value is not None and 0 <= value <= 1 else None), False

    def _read_automatic(self, numbered: _Numbered) -> Feature:
        reply = self._ask(Operation.GET_MODE, numbered.number)
        automatic = reply.ok and reply.values[0] == FeatureMode.AUTO
        entries = (AUTO_OFF, *((AUTO_ONCE,) if numbered.once else ()), AUTO_CONTINUOUS)
        return Feature(
            name=numbered.automatic,
            kind=FeatureKind.ENUMERATION,
            category=CONTROLS,
            access=AccessMode.READ_WRITE,
            value=AUTO_CONTINUOUS if automatic else AUTO_OFF,
            entries=tuple(EnumEntry(entry) for entry in entries),
        )

    def _read_switch(self, numbered: _Numbered) -> Feature:
        return _boolean(numbered.switch, self._flag(Operation.GET_ACTIVE, numbered.number))

    def _read_mirror(self) -> Feature:
        return _boolean(_MIRROR, self._ask(Operation.GET_MIRROR).values == (True,))

    def _read_selector(self) -> Feature:
        return Feature(
            name=BALANCE_SELECTOR,
            kind=FeatureKind.ENUMERATION,
            category=CONTROLS,
            access=AccessMode.READ_WRITE,
            value=self._channel,
            entries=(EnumEntry(RED), EnumEntry(BLUE)),
        )

    def _read_size(self, name: str, operation: Operation) -> Feature:
        reply = self._ask(operation)
        return Feature(
            name=name,
            kind=FeatureKind.INTEGER,
            category=DEVICE,
            access=AccessMode.READ_ONLY,
            value=int(_number(reply.values[0])) if reply.ok else None,
        )

    def _write_numbered(self, numbered: _Numbered, value: FeatureValue) -> None:
        if not numbered.two_values:
            self._do(numbered.name, Operation.SET_VALUE, numbered.number, float(value))
            return
        pair = self._numbers(Operation.GET_VALUES, numbered.number)
        if pair is None:  # the other channel's value goes with the new one
            name = numbered.name
            raise FeatureError(f"{name}: the remote camera does not report its values", name)
        red, blue = (value, pair[1]) if self._channel == RED else (pair[0], value)
        self._do(numbered.name, Operation.SET_VALUES, numbered.number, float(red), float(blue))

    def _write_automatic(self, numbered: _Numbered, value: FeatureValue) -> None:
        if value == AUTO_ONCE:
            self._do(numbered.automatic, Operation.SET_ONE_PUSH, numbered.number)
        else:
            mode = FeatureMode.AUTO if value == AUTO_CONTINUOUS else FeatureMode.MANUAL
            self._do(numbered.automatic, Operation.SET_MODE, numbered.number, mode)

    def _write_switch(self, numbered: _Numbered, value: FeatureValue) -> None:
        self._do(numbered.switch, Operation.SET_ACTIVE, numbered.number, bool(value))

    def _write_mirror(self, value: FeatureValue) -> None:
        self._do(_MIRROR, Operation.SET_MIRROR, bool(value))

    def _write_selector(self, value: FeatureValue) -> None:
        self._channel = str(value)

    def _flag(self, operation: Operation, number: FeatureId) -> bool:
        reply = self._ask(operation, number)
        return reply.ok and reply.values[0] is True

    def _numbers(self, operation: Operation, number: FeatureId) -> tuple[float, ...] | None:
        reply = self._ask(operation, number)
        numbers = tuple(_number(value) for value in reply.values)
        sane = all(math.isfinite(value) and abs(value) < _SANE for value in numbers)
        return numbers if reply.ok and sane else None

    def _do(self, name: str, operation: Operation, *arguments: Value) -> None:
        reply = self._ask(operation, *arguments)
        if not reply.ok:
            why = f" ({reply.text})" if reply.text else ""
            raise FeatureError(f"{name}: the remote camera refused {arguments[-1]}{why}", name)


def _number(value: Value) -> float:
    return float(value) if isinstance(value, (int, float)) else math.nan


def _boolean(name: str, value: bool) -> Feature:
    return Feature(
        name=name, kind=FeatureKind.BOOLEAN, category=CONTROLS, access=AccessMode.READ_WRITE, value=value
    )


def _model_name(text: str) -> Feature:
    return Feature(
        name="DeviceModelName",
        kind=FeatureKind.STRING,
        category=DEVICE,
        access=AccessMode.READ_ONLY,
        value=text,
    )


def _description(feature: Feature) -> FeatureDescription:
    return FeatureDescription(
        name=feature.name,
        kind=feature.kind,
        category=feature.category,
        streamable=feature.streamable,
        selectors=feature.selectors,
    )
