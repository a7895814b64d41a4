"""One-push white balance: red and blue are brought to green in a region that should be grey."""

from __future__ import annotations

from contextlib import suppress

from grabbergui.core.errors import FeatureError, FeatureNotFoundError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.region import Region
from grabbergui.core.selection import SettingKey
from grabbergui.core.sfnc import Role
from grabbergui.models.changes.tracking import ChangeTrackingGrabber
from grabbergui.models.features.text import number_text
from grabbergui.models.language import localized, translate
from grabbergui.models.tuning.parameters import Law, TuningParameter, switch_to_manual
from grabbergui.models.tuning.run import Light, TuningError, TuningRun

TOLERANCE = 0.01
"Difference of red and blue from green, as a part of green, that is good enough."
MOST_STEPS = 12
DARKEST = 0.03
"Part of white below which noise decides on the colour."
MOST_SATURATED = 0.1
"Fraction of white pixels above which their colour is lost."

COLOURS = {"R": "Red", "B": "Blue"}
"Channel to the entry of BalanceRatioSelector; green stays."


def balance(run: TuningRun, region: Region | None) -> str:
    """Set the balance ratios of red and blue so that a region of the frame is grey; return the outcome.

    The automatic mode is switched off. Raises TuningError if the region is not measurable or does not settle,
    FeatureError, FrameTimeoutError, TransportError.
    """
    parameters = run.call(_parameters)
    light = _usable(run.light(region))
    for turn in range(MOST_STEPS):
        off = {channel: light.channels["G"] / max(light.channels[channel], 1e-6) for channel in COLOURS}
        text = translate("Tuning", "red {0:.0%}, blue {1:.0%} of green")
        run.say(turn / MOST_STEPS, text.format(1 / off["R"], 1 / off["B"]))
        wanted = {channel: factor for channel, factor in off.items() if abs(factor - 1) > TOLERANCE}
        if not wanted:
            return translate("Tuning", "Balanced: {0}").format(_values_text(parameters))
        if not _adjust(run, parameters, wanted):
            text = translate("Tuning", "As grey as it gets, with {0}; another light would help")
            return text.format(_values_text(parameters))
        light = _usable(run.light(region))
    text = translate(
        "Tuning", "the colour did not settle within {0} steps; is the scene moving, or the lamp flickering?"
    )
    raise TuningError(text.format(MOST_STEPS))


def _parameters(grabber: FrameGrabber) -> dict[str, TuningParameter]:
    """Return the ratio of each channel to be turned."""
    name = Role.BALANCE_RATIO.find(grabber.has_feature)
    if name is None:
        raise FeatureNotFoundError(f"{grabber.info.title} has no balance ratios to set", "BalanceRatio")
    switch_to_manual(grabber, name)
    path = grabber.selectors.of(name)
    found: dict[str, TuningParameter] = {}
    for channel, entry in COLOURS.items():
        key, parameter = SettingKey(name, tuple((selector, entry) for selector in path)), None
        with suppress(FeatureError):
            parameter = (
                TuningParameter.of(grabber.read_setting(key), Law.PROPORTIONAL, key=key) if path else None
            )
        if parameter is None:
            raise FeatureNotFoundError(f"{grabber.info.title} has no {name} for {entry.lower()}", name)
        found[channel] = parameter
    return found


def _usable(light: Light) -> Light:
    if not light.coloured:
        raise TuningError(
            translate(
                "Tuning", "there is no colour in this pixel format; choose an RGB or a Bayer format first"
            )
        )
    if light.saturated > MOST_SATURATED:
        text = translate(
            "Tuning", "{0:.0%} of the region is saturated and has lost its colour; set the exposure first"
        )
        raise TuningError(text.format(light.saturated))
    if light.mean < DARKEST:
        text = translate("Tuning", "the region is too dark ({0:.1%} of white); set the exposure first")
        raise TuningError(localized(text.format(light.mean)))
    return light


def _adjust(run: TuningRun, parameters: dict[str, TuningParameter], wanted: dict[str, float]) -> bool:
    """Turn the ratios of these channels. Whether any of them leads anywhere."""
    values = {channel: parameters[channel].proposed(factor) for channel, factor in wanted.items()}

    def write(grabber: ChangeTrackingGrabber) -> None:
        for channel, value in values.items():
            parameter = parameters[channel]
            if value is None:
                continue
            parameter.feature = grabber.write_setting(parameter.key, value).feature
            if isinstance(parameter.feature.value, int | float):
                parameter.search.accept(parameter.feature.value)

    if all(value is None for value in values.values()):
        return False
    run.call(write)
    return True


def _values_text(parameters: dict[str, TuningParameter]) -> str:
    red, blue = (number_text(parameters[channel].search.value, 4) for channel in COLOURS)
    return translate("Tuning", "red {0}, blue {1}").format(red, blue)
