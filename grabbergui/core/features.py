"""Features as plain data: a feature's description, its state, and the checks of a value for it.

The vocabulary is GenApi's (GenICam standard, chapter 2): kinds, access modes, visibility, representation.
Values are Python's ``int``, ``float``, ``bool`` and ``str``: 64-bit integers and fractions keep their
precision.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum, IntEnum

from grabbergui.core.errors import FeatureAccessError, FeatureValueError

FeatureValue = int | float | bool | str


class FeatureKind(Enum):
    """The type of a feature's value."""

    INTEGER = "integer"
    FLOAT = "float"
    BOOLEAN = "boolean"
    ENUMERATION = "enumeration"
    COMMAND = "command"
    STRING = "string"


class AccessMode(Enum):
    """The access to a feature at the moment; it changes while a camera runs."""

    NOT_IMPLEMENTED = "NI"
    NOT_AVAILABLE = "NA"
    WRITE_ONLY = "WO"
    READ_ONLY = "RO"
    READ_WRITE = "RW"

    @property
    def readable(self) -> bool:
        """Whether a value can be read."""
        return self in (AccessMode.READ_ONLY, AccessMode.READ_WRITE)

    @property
    def writable(self) -> bool:
        """Whether a value can be written, or a command executed."""
        return self in (AccessMode.WRITE_ONLY, AccessMode.READ_WRITE)


class Visibility(IntEnum):
    """For whom a feature is meant; each level sees those below it."""

    BEGINNER = 0
    EXPERT = 1
    GURU = 2
    INVISIBLE = 3


class Representation(Enum):
    """How a number wants to be shown."""

    LINEAR = "linear"
    LOGARITHMIC = "logarithmic"
    PURE_NUMBER = "pure"
    HEX_NUMBER = "hex"
    IPV4_ADDRESS = "ipv4"
    MAC_ADDRESS = "mac"
    BOOLEAN = "boolean"


@dataclass(frozen=True)
class EnumEntry:
    """One choice of an enumeration."""

    name: str
    "The symbolic name that is written, e.g. `Continuous`."
    display_name: str = ""
    tooltip: str = ""
    available: bool = True
    "Whether the camera accepts it at the moment."


@dataclass(frozen=True, kw_only=True)
class FeatureDescription:
    """The properties of a feature that never change; known without asking the camera."""

    name: str
    "The camera's own name, unchanged: `ExposureTime`."
    kind: FeatureKind
    display_name: str = ""
    tooltip: str = ""
    description: str = ""
    visibility: Visibility = Visibility.BEGINNER
    category: str = ""
    "Name of the category that lists it first."
    streamable: bool = False
    "Whether it belongs into a saved set of settings."
    selectors: tuple[str, ...] = ()
    "Names of the features that select which instance of this one is seen."

    @property
    def title(self) -> str:
        """The display name."""
        return self.display_name or self.name


@dataclass(frozen=True, kw_only=True)
class Feature(FeatureDescription):
    """A feature as it was at one moment."""

    access: AccessMode
    value: FeatureValue | None = None
    "None where it cannot be read (a command, write-only, not available)."
    minimum: int | float | None = None
    maximum: int | float | None = None
    increment: int | float | None = None
    unit: str = ""
    representation: Representation = Representation.LINEAR
    entries: tuple[EnumEntry, ...] = ()
    auto: str | None = None
    "Name of the feature that is its automatic mode, e.g. `ExposureAuto`, where the camera has one."
    maximum_length: int | None = None
    "Of a string, in bytes."
    pauses_stream: bool = False
    "Whether a write stops the running stream for a moment, which is all that locks it."
    constant: bool = False
    "Whether it is never writable, whatever else is set; false where that is not known."
    problem: str = ""
    "Why the camera's own description of it fails, where it does; such a feature is not available."

    @property
    def logarithmic(self) -> bool:
        """Whether a slider should be logarithmic: as described, or for a range of more than two decades.

        An integer needs more than three: the pixels of a width are counted.
        """
        if self.minimum is None or self.maximum is None or self.minimum < 0 or self.maximum <= 0:
            return False
        if self.representation is Representation.LOGARITHMIC:
            return True
        return (
            self.representation is Representation.LINEAR
            and self.minimum > 0
            and self.maximum / self.minimum > (1000 if self.kind is FeatureKind.INTEGER else 100)
        )

    def validated(self, value: FeatureValue) -> FeatureValue:
        """The value in the feature's own type, or an error that says what would be accepted.

        Text is read as the command line's: `5`, `2.5e4`, `0x1F`, `on`, an entry's name. An integer
        off its increment is refused, as a camera would. Raises FeatureAccessError where nothing can be
        written at the moment, FeatureValueError otherwise.
        """
        if not self.access.writable:
            raise FeatureAccessError(f"{self.name} {self.access_problem()}", self.name)
        if self.kind is FeatureKind.COMMAND:
            raise FeatureValueError(f"{self.name} is a command and takes no value; run it instead", self.name)
        try:
            return self._converted(value)
        except ValueError as error:
            raise FeatureValueError(
                f"{self.name}={value}: {error}; allowed: {self.range_text()}", self.name
            ) from error

    def access_problem(self) -> str:
        """Why it cannot be written, as the end of a sentence."""
        if self.problem:
            return f"is not available: {self.problem}"
        if self.constant:
            return "is read-only"
        return {
            AccessMode.NOT_IMPLEMENTED: "is not implemented by this camera",
            AccessMode.NOT_AVAILABLE: "is not available at the moment; another feature's value hides it",
            AccessMode.READ_ONLY: "is read-only; streaming or another feature may lock it",
        }.get(self.access, "cannot be used at the moment")

    def range_text(self) -> str:
        """Return the allowed values as display text: `10 … 1000000 us, step 1`, `one of Off, Once`."""
        if self.kind is FeatureKind.ENUMERATION:
            return "one of " + ", ".join(entry.name for entry in self.entries if entry.available)
        if self.kind is FeatureKind.BOOLEAN:
            return "true or false"
        if self.kind is FeatureKind.STRING:
            return f"up to {self.maximum_length} bytes of text" if self.maximum_length else "text"
        if self.minimum is None or self.maximum is None:
            return "a number"
        step = f", step {format_number(self.increment)}" if self.increment and self.increment != 1 else ""
        unit = f" {self.unit}" if self.unit else ""
        return f"{format_number(self.minimum)} … {format_number(self.maximum)}{unit}{step}"

    def _converted(self, value: FeatureValue) -> FeatureValue:
        if self.kind is FeatureKind.BOOLEAN:
            return _to_bool(value)
        if self.kind is FeatureKind.ENUMERATION:
            return self._to_entry(str(value))
        if self.kind is FeatureKind.STRING:
            text = str(value)
            if self.maximum_length is not None and len(text.encode()) > self.maximum_length:
                raise ValueError("too long")
            return text
        number = _to_int(value) if self.kind is FeatureKind.INTEGER else _to_float(value)
        low, high = self.minimum, self.maximum
        if low is not None and number < low:
            number = _limit_as_shown(number, low)
        elif high is not None and number > high:
            number = _limit_as_shown(number, high)
        if self.kind is FeatureKind.INTEGER and self.increment and low is not None:
            below = (int(number) - int(low)) % int(self.increment)
            if below:
                lower = int(number) - below
                upper = lower + int(self.increment)
                nearest = f"{lower} or {upper}" if high is None or upper <= high else f"{lower}"
                raise ValueError(f"not on the step, the nearest is {nearest}")
        return number

    def _to_entry(self, text: str) -> str:
        for entry in self.entries:
            if entry.name == text:
                if not entry.available:
                    raise ValueError("not available at the moment")
                return entry.name
        raise ValueError("no such entry")


@dataclass(frozen=True)
class Category:
    """A branch of the feature tree. Its members are known without asking the camera for values."""

    name: str
    display_name: str = ""
    tooltip: str = ""
    visibility: Visibility = Visibility.BEGINNER
    members: tuple[Category | FeatureDescription, ...] = ()

    @property
    def title(self) -> str:
        """The display name."""
        return self.display_name or self.name

    def descriptions(self) -> Iterator[FeatureDescription]:
        """Every feature below, depth first, each name once."""
        seen: set[str] = set()
        for description in self._walk():
            if description.name not in seen:
                seen.add(description.name)
                yield description

    def _walk(self) -> Iterator[FeatureDescription]:
        for member in self.members:
            if isinstance(member, Category):
                yield from member._walk()
            else:
                yield member


def format_number(number: int | float | None) -> str:
    """A number as short as it can be without losing anything a person would miss."""
    if number is None:
        return ""
    if isinstance(number, int) or (math.isfinite(number) and number == int(number) and abs(number) < 1e15):
        return str(int(number))
    return f"{number:.10g}"


def format_value(value: FeatureValue | None) -> str:
    """A feature's value as text that `validated` reads back."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    # repr keeps every digit of a float; whole numbers are shown without a fraction.
    return repr(value).removesuffix(".0") if isinstance(value, float) else str(value)


def _limit_as_shown(number: int | float, limit: int | float) -> int | float:
    """The limit, for a number beyond it that people are shown for it; shown limits are rounded."""
    if isinstance(limit, float) and format_number(number) == format_number(limit):
        return limit
    raise ValueError("out of range")


def _to_bool(value: FeatureValue) -> bool:
    text = str(value).strip().lower()
    if text in ("1", "true", "on", "yes", "1.0"):
        return True
    if text in ("0", "false", "off", "no", "0.0"):
        return False
    raise ValueError("not a boolean")


def _to_int(value: FeatureValue) -> int:
    if isinstance(value, float):
        if not value.is_integer():
            raise ValueError("not a whole number")
        return int(value)
    try:
        return int(value) if not isinstance(value, str) else int(value.strip(), 0)
    except ValueError:
        pass
    try:
        as_float = float(value)
    except ValueError:
        raise ValueError("not a whole number") from None
    if not as_float.is_integer():
        raise ValueError("not a whole number")
    return int(as_float)


def _to_float(value: FeatureValue) -> float:
    try:
        number = float(value)
    except (ValueError, OverflowError):
        raise ValueError("not a number") from None
    if not math.isfinite(number):
        raise ValueError("not a finite number")
    return number
