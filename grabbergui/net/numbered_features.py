"""The numbered features that YARP's and ROS 2's frame grabbers share: numbers, modes, values from 0 to 1.

A feature may have an automatic mode (`ExposureAuto`) and a switch (`AcquisitionFrameRateEnable`), or be a
switch itself (`TriggerMode`: On, Off). Both networks use YARP's terms for them.
"""

from __future__ import annotations

from dataclasses import replace
from enum import IntEnum

from grabbergui.core.errors import (
    FeatureAccessError,
    FeatureError,
    FeatureNotFoundError,
    FeatureValueError,
)
from grabbergui.core.features import Feature, FeatureKind, FeatureValue
from grabbergui.core.frame_period import microseconds
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.settings import SettingKey
from grabbergui.core.sfnc import (
    AUTO_CONTINUOUS,
    AUTO_OFF,
    AUTO_ONCE,
    Role,
    automatic_mode_of,
    enabler_of,
    offers,
    regulating,
)

BALANCE_SELECTOR = "BalanceRatioSelector"
RED, BLUE = "Red", "Blue"
_NUMBERS = (FeatureKind.INTEGER, FeatureKind.FLOAT)
_ON, _OFF = "On", "Off"


class FeatureId(IntEnum):
    """The features of a camera, by YARP's numbers; the same in 3.x and 4.0."""

    BRIGHTNESS = 0
    EXPOSURE = 1
    SHARPNESS = 2
    WHITE_BALANCE = 3
    "Two values: red, blue."
    HUE = 4
    SATURATION = 5
    GAMMA = 6
    SHUTTER = 7
    GAIN = 8
    IRIS = 9
    FOCUS = 10
    TEMPERATURE = 11
    TRIGGER = 12
    TRIGGER_DELAY = 13
    WHITE_SHADING = 14
    FRAME_RATE = 15
    ZOOM = 16
    PAN = 17
    TILT = 18
    OPTICAL_FILTER = 19
    CAPTURE_SIZE = 20
    CAPTURE_QUALITY = 21
    MIRROR = 22


def label(number: int) -> str:
    """Return the name of a feature's number as display text."""
    try:
        return FeatureId(number).name.lower().replace("_", " ")
    except ValueError:
        return f"feature number {number}"


class FeatureMode(IntEnum):
    """Whether the camera or the user controls a feature."""

    UNKNOWN = 0
    MANUAL = 1
    AUTO = 2


class BusType(IntEnum):
    """Bus of a camera; YARP knows no Ethernet."""

    UNKNOWN = 0
    FIREWIRE = 1
    USB = 2


class CropType(IntEnum):
    """The meaning of the vertices of a crop request."""

    RECTANGLE = 0
    "Two opposite corners, both within the image cut out."
    LIST = 1


ROLES: dict[FeatureId, Role] = {
    FeatureId.BRIGHTNESS: Role.BLACK_LEVEL,
    FeatureId.EXPOSURE: Role.EXPOSURE,
    FeatureId.SHARPNESS: Role.SHARPNESS,
    FeatureId.WHITE_BALANCE: Role.BALANCE_RATIO,
    FeatureId.HUE: Role.HUE,
    FeatureId.SATURATION: Role.SATURATION,
    FeatureId.GAMMA: Role.GAMMA,
    # FireWire cameras had a shutter time and an exposure target; programs written for them set the shutter.
    FeatureId.SHUTTER: Role.EXPOSURE,
    FeatureId.GAIN: Role.GAIN,
    FeatureId.IRIS: Role.IRIS,
    FeatureId.FOCUS: Role.FOCUS,
    FeatureId.TEMPERATURE: Role.TEMPERATURE,
    FeatureId.TRIGGER: Role.TRIGGER,
    FeatureId.TRIGGER_DELAY: Role.TRIGGER_DELAY,
    FeatureId.WHITE_SHADING: Role.SHADING,
    FeatureId.FRAME_RATE: Role.FRAME_RATE,
    FeatureId.ZOOM: Role.ZOOM,
    FeatureId.PAN: Role.PAN,
    FeatureId.TILT: Role.TILT,
    FeatureId.OPTICAL_FILTER: Role.OPTICAL_FILTER,
    FeatureId.CAPTURE_SIZE: Role.CAPTURE_SIZE,
    FeatureId.CAPTURE_QUALITY: Role.CAPTURE_QUALITY,
    FeatureId.MIRROR: Role.MIRROR,
}

_ROLE_OF_NUMBER: dict[int, Role] = {int(feature): role for feature, role in ROLES.items()}


class NumberedFeatures:
    """A grabber's features under YARP's numbers.

    Values are in SFNC's units (exposure times in microseconds, even if the camera counts seconds), or from 0
    at the camera's minimum to 1 at its maximum where `normalised`. Booleans count as 0 and 1, enumerations by
    the place of their entry. Any thread may call;
    errors are those of the grabber, and FeatureNotFoundError for a number without a feature.
    """

    def __init__(self, grabber: FrameGrabber, *, normalised: bool = False) -> None:
        self.normalised = normalised
        self._grabber = grabber
        self._modes = FeatureModes(grabber)

    def name(self, number: int) -> str | None:
        """Return the GenICam feature of a YARP number, or None."""
        role = _ROLE_OF_NUMBER.get(number)
        return self._grabber.role(role) if role else None

    def require(self, number: int) -> str:
        """Return the name of a feature that the camera has. Raises FeatureNotFoundError."""
        name = self.name(number) if self.has(number) else None
        if name is None:
            what = label(number)
            raise FeatureNotFoundError(f"{self._grabber.info.title} has no {what}", what)
        return name

    def has(self, number: int) -> bool:
        """Return whether the camera has the feature."""
        name = self.name(number)
        return name is not None and (number != FeatureId.WHITE_BALANCE or self._has_both_balances())

    def has_auto(self, number: int) -> bool:
        """Return whether the camera can regulate it by itself."""
        name = self.name(number)
        return name is not None and self._modes.has_auto(name)

    def has_manual(self, number: int) -> bool:
        """Return whether it can be set."""
        name = self.name(number)
        return name is not None and self.has(number) and self._modes.has_manual(name)

    def has_one_push(self, number: int) -> bool:
        """Return whether the camera can regulate it once and then keep it."""
        name = self.name(number)
        return name is not None and self._modes.has_one_push(name)

    def has_on_off(self, number: int) -> bool:
        """Return whether it can be switched on and off."""
        name = self.name(number)
        return name is not None and self._modes.has_on_off(name)

    def feature(self, number: int) -> Feature:
        """Return the feature, with value and limits in SFNC's unit."""
        own = self._own(number)
        scale = _scale(number, own)
        return own if scale == 1.0 else _scaled(own, scale)

    def value(self, number: int) -> float:
        """Return the value of a feature that has one."""
        self._refuse_two_values(number)
        return self._to_yarp(self.feature(number))

    def set_value(self, number: int, value: float) -> None:
        """Set a feature that has one value; this also switches its enabler on."""
        self._refuse_two_values(number)
        self._write(self.feature(number), value, scale=_scale(number, self._own(number)))

    def values(self, number: int) -> tuple[float, float]:
        """Return red and blue for white balance, the smallest and largest value for other features.

        Raises FeatureAccessError where a feature has no range, and for all but white balance where values
        are normalised: clients conclude from a range that values are in the camera's own units.
        """
        if number == FeatureId.WHITE_BALANCE:
            with self._grabber.exclusive([BALANCE_SELECTOR]):
                red, blue = (self._grabber.read_setting(self._balance(channel)) for channel in (RED, BLUE))
            return self._to_yarp(red), self._to_yarp(blue)
        feature = self.feature(number)
        span = _span(feature)
        if self.normalised or span is None:
            raise FeatureAccessError(f"{feature.name} has no second value to read", feature.name)
        return span

    def set_values(self, number: int, first: float, second: float) -> None:
        """Set white balance, red and blue. If the camera refuses blue, red is restored."""
        if number != FeatureId.WHITE_BALANCE:
            name = self._own(number).name
            raise FeatureAccessError(f"{name} has one value, set it with one", name)
        with self._grabber.exclusive([BALANCE_SELECTOR]):
            red, blue = self._balance(RED), self._balance(BLUE)
            before = self._grabber.read_setting(red)
            self._write(before, first, red)
            try:
                self._write(self._grabber.read_setting(blue), second, blue)
            except FeatureError:
                if before.value is not None:
                    self._grabber.write_setting(red, before.value)
                raise

    def mode(self, number: int) -> FeatureMode:
        """Return whether the camera regulates it at the moment."""
        return FeatureMode.AUTO if self._modes.automatic(self.require(number)) else FeatureMode.MANUAL

    def set_mode(self, number: int, mode: int) -> None:
        """Let the camera regulate it, or hold its current value."""
        name = self.require(number)
        if mode not in (FeatureMode.MANUAL, FeatureMode.AUTO):
            raise FeatureValueError(f"{name}: mode {mode} is neither 1 (manual) nor 2 (auto)", name)
        self._modes.set_automatic(name, mode == FeatureMode.AUTO)

    def one_push(self, number: int) -> None:
        """Regulate it once."""
        self._modes.regulate_once(self.require(number))

    def active(self, number: int) -> bool:
        """Return whether it is switched on; a feature without a switch is always on."""
        return self._modes.active(self.require(number))

    def set_active(self, number: int, on: bool) -> None:
        """Switch it on or off."""
        self._modes.set_active(self.require(number), on)

    def _own(self, number: int) -> Feature:
        """Return a feature in the camera's own unit."""
        return self._grabber.feature(self.require(number))

    def _has_both_balances(self) -> bool:
        if not self._grabber.has_feature(BALANCE_SELECTOR):
            return False
        selector = self._grabber.feature(BALANCE_SELECTOR)
        return offers(selector, RED) and offers(selector, BLUE)

    def _balance(self, channel: str) -> SettingKey:
        """Return the balance ratio of one channel."""
        name = self._own(FeatureId.WHITE_BALANCE).name
        return SettingKey(name, ((BALANCE_SELECTOR, channel),))

    def _refuse_two_values(self, number: int) -> None:
        if number == FeatureId.WHITE_BALANCE and self.has(number):
            raise FeatureAccessError(
                "white balance has two values, red and blue", Role.BALANCE_RATIO.names[0]
            )

    def _to_yarp(self, feature: Feature) -> float:
        number = number_of(feature)
        if number is None:
            why = "cannot be read at the moment" if feature.value is None else "is text and has no number"
            raise FeatureAccessError(f"{feature.name} {why}", feature.name)
        span = _span(feature)
        if not self.normalised or span is None:
            return number
        low, high = span
        return min(1.0, max(0.0, (number - low) / (high - low)))

    def _write(
        self, feature: Feature, value: float, key: SettingKey | None = None, scale: float = 1.0
    ) -> None:
        span = _span(feature)
        if self.normalised and span is not None:
            if not 0 <= value <= 1:
                raise FeatureValueError(
                    f"{feature.name}={value:g}: out of range, allowed: 0 … 1", feature.name
                )
            value = span[0] + value * (span[1] - span[0])
        if scale != 1.0:
            feature, value = self._grabber.feature(feature.name), value / scale
        self._grabber.write_setting(key or SettingKey(feature.name), _from_yarp(feature, value))


_TIMES = (FeatureId.EXPOSURE, FeatureId.SHUTTER, FeatureId.TRIGGER_DELAY)


def _scale(number: int, feature: Feature) -> float:
    """Return the SFNC units in one of the camera's: microseconds, for times; 1 if its unit is unknown."""
    factor = microseconds(feature.unit) if number in _TIMES else None
    return 1.0 if factor is None else factor


def _scaled(feature: Feature, factor: float) -> Feature:
    """Return a time with value and limits in microseconds, of which its own unit has so many."""

    def converted(number: FeatureValue | None) -> float | None:
        return number * factor if isinstance(number, int | float) else None

    return replace(
        feature,
        value=converted(feature.value),
        minimum=converted(feature.minimum),
        maximum=converted(feature.maximum),
        increment=converted(feature.increment),
        unit="us",
    )


def number_of(feature: Feature) -> float | None:
    """Return a value as a number, an entry as its place (0 if it is none); None for text or no value."""
    value = feature.value
    if feature.kind is FeatureKind.ENUMERATION and value is not None:
        names = [entry.name for entry in feature.entries]
        return float(names.index(str(value))) if value in names else 0.0
    return None if value is None or isinstance(value, str) else float(value)


def entry_at(feature: Feature, place: float) -> str:
    """Return the name of the entry at a place, from 0 on. Raises FeatureValueError where there is none."""
    last = len(feature.entries) - 1
    if not place.is_integer() or not 0 <= place <= last:
        raise FeatureValueError(f"{feature.name}={place:g}: entries are counted 0 … {last}", feature.name)
    return feature.entries[int(place)].name


def _from_yarp(feature: Feature, value: float) -> FeatureValue:
    """Return a number of YARP's, which knows only doubles, in the feature's own type and on its step."""
    if feature.kind is FeatureKind.FLOAT or value != value or abs(value) == float("inf"):
        return value
    if feature.kind is FeatureKind.ENUMERATION:
        return entry_at(feature, float(round(value)))
    if feature.kind is FeatureKind.BOOLEAN:
        return value != 0
    low, step = int(feature.minimum or 0), int(feature.increment or 1)
    return low + round((value - low) / step) * step


def _span(feature: Feature) -> tuple[float, float] | None:
    """Return the smallest and the largest number; None without a range."""
    if feature.kind is FeatureKind.BOOLEAN:
        return 0.0, 1.0
    if feature.kind is FeatureKind.ENUMERATION and len(feature.entries) > 1:
        return 0.0, float(len(feature.entries) - 1)
    if feature.kind not in _NUMBERS or feature.minimum is None or feature.maximum is None:
        return None
    low, high = float(feature.minimum), float(feature.maximum)
    return (low, high) if low < high else None


class FeatureModes:
    """A grabber's features by GenICam name. Any thread; calls may ask the camera, and raise its errors."""

    def __init__(self, grabber: FrameGrabber) -> None:
        self._grabber = grabber

    def has_auto(self, name: str) -> bool:
        """Return whether the camera can regulate it by itself."""
        auto = self._automatic(name)
        return auto is not None and (auto.kind is FeatureKind.BOOLEAN or offers(auto, AUTO_CONTINUOUS))

    def has_manual(self, name: str) -> bool:
        """Return whether it can be set, if necessary after its automatic mode was switched off."""
        return self._grabber.feature(name).access.writable or self.has_auto(name)

    def has_one_push(self, name: str) -> bool:
        """Return whether the camera can regulate it once and then keep it."""
        auto = self._automatic(name)
        return auto is not None and offers(auto, AUTO_ONCE)

    def has_on_off(self, name: str) -> bool:
        """Return whether it can be switched on and off."""
        return self._switch(name) is not None

    def automatic(self, name: str) -> bool:
        """Return whether the camera regulates it at the moment."""
        return regulating(self._automatic(name))

    def set_automatic(self, name: str, on: bool) -> None:
        """Let the camera regulate it, or hold its current value."""
        auto = self._automatic(name)
        if auto is None:
            if on:
                raise FeatureAccessError(f"{name} has no automatic mode on this camera", name)
            return
        value = on if auto.kind is FeatureKind.BOOLEAN else AUTO_CONTINUOUS if on else AUTO_OFF
        self._grabber.write_feature(auto.name, value)

    def regulate_once(self, name: str) -> None:
        """Let the camera regulate it once, and then keep it."""
        auto = self._automatic(name)
        if auto is None or not offers(auto, AUTO_ONCE):
            raise FeatureAccessError(f"{name} cannot be regulated once on this camera", name)
        self._grabber.write_feature(auto.name, AUTO_ONCE)

    def active(self, name: str) -> bool:
        """Return whether it is switched on; a feature without a switch is always on."""
        switch = self._switch(name)
        return switch is None or switch.value not in (False, _OFF, None)

    def set_active(self, name: str, on: bool) -> None:
        """Switch it on or off."""
        switch = self._switch(name)
        if switch is None:
            raise FeatureAccessError(f"{name} cannot be switched on and off on this camera", name)
        value: FeatureValue = on if switch.kind is FeatureKind.BOOLEAN else _ON if on else _OFF
        self._grabber.write_feature(switch.name, value)

    def _automatic(self, name: str) -> Feature | None:
        return self._feature(automatic_mode_of(name, self._grabber.has_feature))

    def _switch(self, name: str) -> Feature | None:
        """Return the feature that switches it: its enabler, or itself if it is On or Off."""
        feature = self._feature(enabler_of(name, self._grabber.has_feature)) or self._grabber.feature(name)
        if feature.kind is FeatureKind.BOOLEAN:
            return feature
        return feature if offers(feature, _ON) and offers(feature, _OFF) else None

    def _feature(self, name: str | None) -> Feature | None:
        return self._grabber.feature(name) if name is not None else None
