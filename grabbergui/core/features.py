"""Features as plain data: their descriptions and states, and the validation of values.

The vocabulary is GenApi's (GenICam standard, chapter 2): kinds, access modes, visibility, representation.
Values are Python's ``int``, ``float``, ``bool`` and ``str``, so 64-bit integers keep their precision.
"""

from __future__ import annotations

import ipaddress
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum, IntEnum

from grabbergui.core.errors import FeatureAccessError, FeatureValueError
from grabbergui.core.visible_text import shortened

FeatureValue = int | float | bool | str
MOST_TITLE = 200
"Characters of a display name; cameras write them, and the window lays them out."
_MAC = re.compile(r"[0-9A-Fa-f]{1,2}([:-][0-9A-Fa-f]{1,2}){5}")
SWITCH_WORDS = {
    "1": True, "true": True, "on": True, "yes": True, "0": False, "false": False, "off": False, "no": False,
}  # fmt: skip
"Spellings of a switch by users and in files, in lower case."
TRANSPORT_LOCK = "TLParamsLocked"
"1 while the stream runs (SFNC, Transport Layer Control), which locks others; only the driver writes it."


class FeatureKind(Enum):
    """The type of a feature's value."""

    INTEGER = "integer"
    FLOAT = "float"
    BOOLEAN = "boolean"
    ENUMERATION = "enumeration"
    COMMAND = "command"
    STRING = "string"


class AccessMode(Enum):
    """The current access to a feature, which may change at any time."""

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

    @property
    def without_writing(self) -> AccessMode:
        """The access that remains for those who may not write."""
        if not self.writable:
            return self
        return AccessMode.READ_ONLY if self.readable else AccessMode.NOT_AVAILABLE


class Visibility(IntEnum):
    """The level of users that a feature is meant for; each level includes those below it."""

    BEGINNER = 0
    EXPERT = 1
    GURU = 2
    INVISIBLE = 3


class Representation(Enum):
    """The recommended display of a number."""

    LINEAR = "linear"
    LOGARITHMIC = "logarithmic"
    PURE_NUMBER = "pure"
    HEX_NUMBER = "hex"
    IPV4_ADDRESS = "ipv4"
    MAC_ADDRESS = "mac"
    BOOLEAN = "boolean"


CODED = (Representation.HEX_NUMBER, Representation.IPV4_ADDRESS, Representation.MAC_ADDRESS)
"Representations in which an integer is not written as a decimal number."


@dataclass(frozen=True)
class EnumEntry:
    """An entry of an enumeration."""

    name: str
    "The symbolic name, which is the value, e.g. `Continuous`."
    display_name: str = ""
    tooltip: str = ""
    available: bool = True
    "Whether the camera currently accepts it."

    @property
    def title(self) -> str:
        """The display name."""
        return shortened(self.display_name or self.name, MOST_TITLE)


@dataclass(frozen=True, kw_only=True)
class FeatureDescription:
    """The constant properties of a feature, known without a request to the camera."""

    name: str
    "The camera's own name, unchanged: `ExposureTime`."
    kind: FeatureKind
    display_name: str = ""
    tooltip: str = ""
    description: str = ""
    visibility: Visibility = Visibility.BEGINNER
    category: str = ""
    "Name of the first category that contains it."
    streamable: bool = False
    "Whether it belongs in saved settings."
    selectors: tuple[str, ...] = ()
    "Names of the features that select an instance of this one."

    @property
    def title(self) -> str:
        """The display name."""
        return shortened(self.display_name or self.name, MOST_TITLE)


@dataclass(frozen=True)
class AccessCondition:
    """A feature whose value hides or locks another one."""

    feature: str
    "Its name."
    value: str
    "Its current value as text."
    wanted: tuple[str, ...] = ()
    "The values with which it would not; empty if they are unknown."


@dataclass(frozen=True, kw_only=True)
class Feature(FeatureDescription):
    """A snapshot of a feature."""

    access: AccessMode
    value: FeatureValue | None = None
    """None if it cannot be read (a command, write-only, not available). Of an enumeration an entry's name,
    or the digits of a number that no entry has."""
    minimum: int | float | None = None
    maximum: int | float | None = None
    increment: int | float | None = None
    unit: str = ""
    representation: Representation = Representation.LINEAR
    entries: tuple[EnumEntry, ...] = ()
    auto: str | None = None
    "Name of its automatic mode, e.g. `ExposureAuto`; None without one."
    maximum_length: int | None = None
    "Largest size of a string, in bytes."
    pauses_stream: bool = False
    "Whether only the running stream locks it, so that a write must pause the stream."
    constant: bool = False
    "Whether it is never writable, whatever else is set; false if that is unknown."
    problem: str = ""
    "Why the camera's description of it fails; empty if it does not. A failing feature is not available."
    conditions: tuple[AccessCondition, ...] = ()
    "What hides or locks it, once `FeatureSource.conditions` was asked; empty before."

    def __post_init__(self) -> None:
        """Drop limits that contradict each other: no number is between them, and the camera decides."""
        if self.minimum is not None and self.maximum is not None and not self.minimum <= self.maximum:
            object.__setattr__(self, "minimum", None)
            object.__setattr__(self, "maximum", None)

    @property
    def logarithmic(self) -> bool:
        """Whether a slider should be logarithmic: as described, or if the range exceeds two decades.

        For integers it must exceed three, as a width in pixels is better shown linearly.
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

    @property
    def coded(self) -> bool:
        """Whether it is an integer that is written as hexadecimal number, IPv4 or MAC address."""
        return self.kind is FeatureKind.INTEGER and self.representation in CODED

    def spelled(self, value: FeatureValue | None) -> FeatureValue | None:
        """Return a value as files have it: text if the feature is `coded`, else the value itself."""
        if self.coded and isinstance(value, int) and not isinstance(value, bool):
            return coded_text(value, self.representation)
        return value

    @property
    def text(self) -> str:
        """The value in its own spelling, which `validated` reads back; empty without a value."""
        return format_value(self.spelled(self.value))

    def validated(self, value: FeatureValue) -> FeatureValue:
        """Return the value in the feature's own type.

        Text is read as on the command line: `5`, `2.5e4`, `0x1F`, `on`, `192.168.0.5`, an entry's name. An
        integer off the increment is refused, as the camera would. Raises FeatureAccessError if the feature
        cannot be written at the moment, FeatureValueError naming the allowed values for any other.
        """
        if not self.access.writable:
            raise FeatureAccessError(f"{self.name} {self.access_problem()}", self.name)
        if self.kind is FeatureKind.COMMAND:
            raise FeatureValueError(f"{self.name} is a command and takes no value; run it instead", self.name)
        try:
            return self._converted(value)
        except ValueError as error:
            raise FeatureValueError(
                f"{self.name}={format_value(value)[:60]}: {error}; allowed: {self.range_text()}", self.name
            ) from error

    def access_problem(self) -> str:
        """Return why it cannot be written, as the end of a sentence."""
        if self.problem:
            return f"is not available: {self.problem}"
        if self.constant:
            return "is read-only"
        if self.conditions and self.access in (AccessMode.NOT_AVAILABLE, AccessMode.READ_ONLY):
            return self._condition_text()
        return {
            AccessMode.NOT_IMPLEMENTED: "is not implemented by this camera",
            AccessMode.NOT_AVAILABLE: "is not available at the moment; another feature's value hides it",
            AccessMode.READ_ONLY: "is read-only; streaming or another feature may lock it",
        }.get(self.access, "cannot be used at the moment")

    def _condition_text(self) -> str:
        state = "not available" if self.access is AccessMode.NOT_AVAILABLE else "read-only"
        if any(each.feature == TRANSPORT_LOCK for each in self.conditions):
            return f"is {state} while the camera streams; stop it first"
        held = " and ".join(f"{each.feature} is {each.value}" for each in self.conditions)
        if not all(each.wanted for each in self.conditions):
            return f"is {state} at the moment; it depends on other features: {held}"
        remedy = " and ".join(f"{each.feature} to {' or '.join(each.wanted)}" for each in self.conditions)
        return f"is {state} while {held}; set {remedy}"

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
        if self.coded:
            return f"{self.spelled(self.minimum)} … {self.spelled(self.maximum)}"
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
        if self.coded and isinstance(value, str):
            value = parse_coded(value, self.representation)
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
    """A branch of the feature tree. Its members are known without a request to the camera."""

    name: str
    display_name: str = ""
    tooltip: str = ""
    visibility: Visibility = Visibility.BEGINNER
    members: tuple[Category | FeatureDescription, ...] = ()

    @property
    def title(self) -> str:
        """The display name."""
        return shortened(self.display_name or self.name, MOST_TITLE)

    def descriptions(self) -> Iterator[FeatureDescription]:
        """Yield every feature below, depth first, each name once."""
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
    """Return a number as short display text; fractions are rounded to ten digits."""
    if number is None:
        return ""
    if isinstance(number, int) or (math.isfinite(number) and number == int(number) and abs(number) < 1e15):
        return str(int(number))
    return f"{number:.10g}"


def format_value(value: FeatureValue | None) -> str:
    """Return a feature's value as text that `validated` reads back."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    # repr keeps every digit of a float; whole numbers are shown without a fraction.
    return repr(value).removesuffix(".0") if isinstance(value, float) else str(value)


def coded_text(number: int, representation: Representation) -> str:
    """Return an integer as hexadecimal, IPv4 or MAC address; the first octet is the highest byte."""
    if representation is Representation.IPV4_ADDRESS and 0 <= number < 1 << 32:
        return str(ipaddress.IPv4Address(number))
    if representation is Representation.MAC_ADDRESS and 0 <= number < 1 << 48:
        return ":".join(f"{byte:02X}" for byte in number.to_bytes(6, "big"))
    return f"-0x{-number:X}" if number < 0 else f"0x{number:X}"


def parse_coded(text: str, representation: Representation) -> int:
    """Parse a typed integer, in the representation or as plain or hexadecimal digits. Raises ValueError."""
    bare = text.strip()
    if representation is Representation.IPV4_ADDRESS and "." in bare:
        return int(ipaddress.IPv4Address(bare))
    if representation is Representation.MAC_ADDRESS and _MAC.fullmatch(bare):
        return int.from_bytes(bytes(int(octet, 16) for octet in re.split("[:-]", bare)), "big")
    try:
        return int(bare, 0)
    except ValueError:
        if representation is not Representation.HEX_NUMBER:
            raise ValueError("not a whole number, nor an address") from None
    try:
        return int(bare, 16)
    except ValueError:
        raise ValueError("not a whole number") from None


def _limit_as_shown(number: int | float, limit: int | float) -> int | float:
    """Return the limit for a number slightly beyond it that displays the same; shown limits are rounded."""
    if isinstance(limit, float) and format_number(number) == format_number(limit):
        return limit
    raise ValueError("out of range")


def parse_switch(text: str) -> bool:
    """Read a switch: 1, true, on, yes, or 0, false, off, no. Raises ValueError."""
    try:
        return SWITCH_WORDS[text.lower()]
    except KeyError:
        raise ValueError("not a boolean") from None


def _to_bool(value: FeatureValue) -> bool:
    return parse_switch(str(value).strip().removesuffix(".0"))


def _to_int(value: FeatureValue) -> int:
    if isinstance(value, bool):  # which is an int to Python
        raise ValueError("not a number")
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
    if isinstance(value, bool):
        raise ValueError("not a number")
    try:
        number = float(value)
    except (ValueError, OverflowError):
        raise ValueError("not a number") from None
    if not math.isfinite(number):
        raise ValueError("not a finite number")
    return number
