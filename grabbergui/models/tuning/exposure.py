"""One-push exposure: the region's mean is brought to a target by exposure time, then gain."""

from __future__ import annotations

from operator import methodcaller

from grabbergui.core.errors import FeatureNotFoundError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.region import Region
from grabbergui.core.sfnc import Role
from grabbergui.models.features.text import value_text
from grabbergui.models.language import translate
from grabbergui.models.tuning.parameters import Law, TuningParameter, light_factor, switch_to_manual
from grabbergui.models.tuning.run import Light, TuningError, TuningRun

TARGET = 0.5
"Mean of the region, as a part of white."
TOLERANCE = 0.02
"Difference from the target that is good enough."
MOST_STEPS = 16

_MICROSECONDS = ("us", "µs", "usec", "")


def expose(run: TuningRun, region: Region | None, target: float = TARGET) -> str:
    """Set exposure time and gain so that a region of the frame has the target's mean; return the outcome.

    The time is lengthened before gain is raised, as far as the frame rate allows, and gain is lowered
    before the time is shortened. Automatic modes are switched off. Raises TuningError where it does not
    settle, FeatureError, FrameTimeoutError, TransportError.
    """
    parameters = run.call(_parameters)
    if not parameters:
        raise FeatureNotFoundError(f"{run.title} has neither exposure time nor gain to set", "ExposureTime")
    light = run.light(region)
    for turn in range(MOST_STEPS):
        text = translate("Tuning", "{0:.0%} of white, aim {1:.0%} · {2}")
        run.say(turn / MOST_STEPS, text.format(light.mean, target, _values_text(parameters)))
        if abs(light.mean - target) <= TOLERANCE:
            text = translate("Tuning", "Exposed: {0:.0%} of white with {1}")
            return text.format(light.mean, _values_text(parameters))
        if not _adjust(run, parameters, light_factor(light.mean, light.saturated, target)):
            return _at_the_end(light, target, parameters)
        light = run.light(region)
    text = translate(
        "Tuning",
        "the light did not settle within {0} steps (it is at {1:.0%} of white);"
        " is the scene moving, or the lamp flickering?",
    )
    raise TuningError(text.format(MOST_STEPS, light.mean))


def _parameters(grabber: FrameGrabber) -> list[TuningParameter]:
    """Return exposure time and gain, as far as the camera has them."""
    found: list[TuningParameter | None] = []
    if (name := Role.EXPOSURE.find(grabber.has_feature)) is not None:
        found.append(
            TuningParameter.of(
                switch_to_manual(grabber, name), Law.PROPORTIONAL, highest=_longest(grabber, name)
            )
        )
    if (name := Role.GAIN.find(grabber.has_feature)) is not None:
        gain = switch_to_manual(grabber, name)
        found.append(TuningParameter.of(gain, Law.DECIBEL if gain.unit.lower() == "db" else Law.UNKNOWN))
    return [parameter for parameter in found if parameter is not None]


def _longest(grabber: FrameGrabber, exposure: str) -> float | None:
    """Return the longest exposure time that the current frame rate allows; None if it is not known."""
    rate = Role.FRAME_RATE.find(grabber.has_feature)
    hertz = grabber.feature(rate).value if rate is not None and not rate.endswith("Raw") else None
    if not isinstance(hertz, int | float) or hertz <= 0:
        return None
    return 1e6 / hertz if grabber.feature(exposure).unit in _MICROSECONDS else None


def _adjust(run: TuningRun, parameters: list[TuningParameter], factor: float) -> bool:
    """Turn the first parameter that leads anywhere. Whether there was one."""
    for parameter in parameters if factor > 1 else reversed(parameters):
        value = parameter.proposed(factor)
        if value is None:
            continue
        parameter.feature = run.call(methodcaller("write_feature", parameter.feature.name, value))
        if isinstance(parameter.feature.value, int | float):
            parameter.search.accept(parameter.feature.value)
        return True
    return False


def _at_the_end(light: Light, target: float, parameters: list[TuningParameter]) -> str:
    if light.mean < target:
        text = translate(
            "Tuning",
            "As bright as it gets: {0:.0%} of white instead of {1:.0%}, with {2};"
            " more light, or a lower frame rate, would help",
        )
    else:
        text = translate(
            "Tuning",
            "As dark as it gets: {0:.0%} of white instead of {1:.0%}, with {2}; less light would help",
        )
    return text.format(light.mean, target, _values_text(parameters))


def _values_text(parameters: list[TuningParameter]) -> str:
    return ", ".join(value_text(parameter.feature) for parameter in parameters)
