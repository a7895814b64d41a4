"""One-push exposure: the region's mean is brought to a target by exposure time, then gain."""

from __future__ import annotations

from operator import methodcaller

from grabbergui.core.errors import FeatureNotFoundError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.region import Region
from grabbergui.core.sfnc import Role
from grabbergui.models.features.text import value_text
from grabbergui.models.language import translate
from grabbergui.models.tuning.parameters import Knob, Law, hand_over, light_factor
from grabbergui.models.tuning.run import Light, TuningBench, TuningError

TARGET = 0.5
"Mean of the region, as a part of white."
TOLERANCE = 0.02
"Difference from the target that is good enough."
MOST_TURNS = 16

_MICROSECONDS = ("us", "µs", "usec", "")


def expose(bench: TuningBench, region: Region | None, target: float = TARGET) -> str:
    """Set exposure time and gain so that a region of the frame has the target's mean. What came of it.

    The time is lengthened before gain is raised, as far as the frame rate allows, and gain is lowered
    before the time is shortened. Automatic modes are switched off. Raises TuningError where it does not
    settle, FeatureError, FrameTimeoutError, TransportError.
    """
    knobs = bench.call(_knobs)
    if not knobs:
        raise FeatureNotFoundError(f"{bench.title} has neither exposure time nor gain to set", "ExposureTime")
    light = bench.light(region)
    for turn in range(MOST_TURNS):
        text = translate("Tuning", "{0:.0%} of white, aim {1:.0%} · {2}")
        bench.say(turn / MOST_TURNS, text.format(light.mean, target, _standing(knobs)))
        if abs(light.mean - target) <= TOLERANCE:
            text = translate("Tuning", "Exposed: {0:.0%} of white with {1}")
            return text.format(light.mean, _standing(knobs))
        if not _turn(bench, knobs, light_factor(light.mean, light.saturated, target)):
            return _at_the_end(light, target, knobs)
        light = bench.light(region)
    text = translate(
        "Tuning",
        "the light did not settle within {0} steps (it is at {1:.0%} of white);"
        " is the scene moving, or the lamp flickering?",
    )
    raise TuningError(text.format(MOST_TURNS, light.mean))


def _knobs(grabber: FrameGrabber) -> list[Knob]:
    """Exposure time and gain, as far as the camera has them."""
    found: list[Knob | None] = []
    if (name := Role.EXPOSURE.find(grabber.has_feature)) is not None:
        found.append(Knob.of(hand_over(grabber, name), Law.PROPORTIONAL, highest=_longest(grabber, name)))
    if (name := Role.GAIN.find(grabber.has_feature)) is not None:
        gain = hand_over(grabber, name)
        found.append(Knob.of(gain, Law.DECIBEL if gain.unit.lower() == "db" else Law.UNKNOWN))
    return [knob for knob in found if knob is not None]


def _longest(grabber: FrameGrabber, exposure: str) -> float | None:
    """The longest exposure time that the present frame rate has room for, where it can be told."""
    rate = Role.FRAME_RATE.find(grabber.has_feature)
    hertz = grabber.feature(rate).value if rate is not None and not rate.endswith("Raw") else None
    if not isinstance(hertz, int | float) or hertz <= 0:
        return None
    return 1e6 / hertz if grabber.feature(exposure).unit in _MICROSECONDS else None


def _turn(bench: TuningBench, knobs: list[Knob], factor: float) -> bool:
    """Turn the first knob that leads anywhere. Whether there was one."""
    for knob in knobs if factor > 1 else reversed(knobs):
        value = knob.proposed(factor)
        if value is None:
            continue
        knob.feature = bench.call(methodcaller("write_feature", knob.feature.name, value))
        if isinstance(knob.feature.value, int | float):
            knob.search.stood(knob.feature.value)
        return True
    return False


def _at_the_end(light: Light, target: float, knobs: list[Knob]) -> str:
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
    return text.format(light.mean, target, _standing(knobs))


def _standing(knobs: list[Knob]) -> str:
    return ", ".join(value_text(knob.feature) for knob in knobs)
