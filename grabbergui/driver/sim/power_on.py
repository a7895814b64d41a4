"""The registers of the simulated camera after power-on, as the options of its URI and its scene have them."""

from __future__ import annotations

from collections.abc import Callable

from grabbergui.core import pfnc
from grabbergui.core.errors import UsageError
from grabbergui.core.uri import SimulatedOptions, SourceUri, read_options
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import TestPattern
from grabbergui.driver.sim.memory import Register, RegisterRefusedError, RegisterValue

_Show = Callable[[float], str]
"Returns a register's number as a URI has it."
_RAW_GAIN = 100
"The register's value for 1 dB."


def _pixel_format(text: str) -> int:
    try:
        return pfnc.by_name(text).code
    except KeyError:
        raise ValueError("no such pixel format") from None


REGISTERS: dict[str, tuple[Register, Callable[[str], RegisterValue], _Show]] = {
    "width": (reg.WIDTH, int, "{:g}".format),
    "height": (reg.HEIGHT, int, "{:g}".format),
    "fps": (reg.FRAME_RATE, float, "{:g}".format),
    "pixel_format": (reg.PIXEL_FORMAT, _pixel_format, lambda code: pfnc.by_code(int(code)).name),
    "exposure": (reg.EXPOSURE_TIME, float, "{:.0f}".format),
    "gain": (
        reg.GAIN_RAW,
        lambda text: round(float(text) * _RAW_GAIN),
        lambda raw: f"{raw / _RAW_GAIN:g}",
    ),
    "setting_latency": (reg.SETTING_LATENCY, int, "{:g}".format),
    "test_pattern": (
        reg.TEST_PATTERN,
        lambda text: TestPattern[_upper(text)],
        lambda number: _camel(TestPattern(int(number)).name),
    ),
    "serial": (reg.DEVICE_SERIAL_NUMBER, str, str),
    "user_id": (reg.DEVICE_USER_ID, str, str),
}


def _upper(camel: str) -> str:
    """Convert `GreyHorizontalRamp` to `GREY_HORIZONTAL_RAMP`."""
    return "".join(f"_{letter}" if letter.isupper() else letter for letter in camel).strip("_").upper()


def _camel(upper: str) -> str:
    """Convert `GREY_HORIZONTAL_RAMP` to `GreyHorizontalRamp`."""
    return "".join(word.capitalize() for word in upper.split("_"))


def power_on_values(uri: SourceUri) -> dict[Register, RegisterValue]:
    """Return the register values that a URI's options ask for. Raises UsageError with the allowed ones."""
    read_options(SimulatedOptions, uri)  # refuses an unknown option; the registers check the values
    values: dict[Register, RegisterValue] = {}
    for name, text in uri.options.items():
        register, convert, show = REGISTERS[name]
        try:
            value = convert(text)
            register.check(value)
        except (ValueError, OverflowError, KeyError, RegisterRefusedError):
            raise UsageError(f"sim: cannot start with {name}={text}{_allowed(register, show)}") from None
        values[register] = value
    if reg.FRAME_RATE in values:
        # The default exposure time must not limit the requested rate.
        longest = 1e6 / float(values[reg.FRAME_RATE]) - reg.EXPOSURE_OVERHEAD_US
        values.setdefault(reg.EXPOSURE_TIME, min(float(reg.EXPOSURE_TIME.default), max(longest, 10.0)))
    return values


def _allowed(register: Register, show: _Show) -> str:
    if register.choices is not None:
        return f"; allowed: {', '.join(show(choice) for choice in sorted(register.choices))}"
    if register.minimum is None or register.maximum is None:
        return ""
    step = f" in steps of {register.step}" if register.step > 1 else ""
    return f"; allowed: {show(register.minimum)} to {show(register.maximum)}{step}"
