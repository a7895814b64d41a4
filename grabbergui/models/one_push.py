"""One-push exposure and white balance, which restore the camera if they fail or are cancelled.

Exposure brings the mean of a region to a target by exposure time, then gain. White balance brings red and
blue to the level of green in a region that should be grey.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from operator import methodcaller

from psygnal import Signal

from grabbergui.core.errors import FeatureError, FeatureNotFoundError, GrabberError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.frame_period import microseconds
from grabbergui.core.pixels import Region
from grabbergui.core.settings import SettingKey
from grabbergui.core.sfnc import AUTO_ONCE, Role, regulating
from grabbergui.models.change_tracking import ChangeTrackingGrabber
from grabbergui.models.error_text import error_text
from grabbergui.models.features.feature_text import value_text
from grabbergui.models.features.number_text import number_text
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.models.language import localized, translate
from grabbergui.models.light import Light
from grabbergui.models.parameter_search import Law, light_factor
from grabbergui.models.tuning import TuningCancelledError, TuningError, TuningRun
from grabbergui.models.tuning_parameter import TuningParameter, automatic_once, switch_to_manual
from grabbergui.models.undo_steps import UndoStep

log = logging.getLogger(__name__)

Tuning = Callable[[TuningRun], str]
"Tunes a camera and returns its result as display text; raises GrabberError."
PATIENCE = 10.0
"Seconds that a camera's own mode may take, besides the time for its frames."
ONCE_FRAMES = 20
"Frames that such a mode may need."
LOOK = 0.1
"Seconds between two reads of the automatic mode."
EXPOSURE_TARGET = 0.5
"Mean of the region as a fraction of white."
EXPOSURE_TOLERANCE = 0.02
"Largest difference from the target that is good enough."
EXPOSURE_STEPS = 16
BALANCE_TOLERANCE = 0.01
"Largest difference of red and blue from green, as a fraction of green, that is good enough."
BALANCE_STEPS = 12
DARKEST = 0.03
"Fraction of white below which noise determines the colour."
MOST_SATURATED = 0.1
"Fraction of saturated pixels above which the colour is lost."
COLOURS = {"R": "Red", "B": "Blue"}
"Entry of BalanceRatioSelector for each adjusted channel; green stays."


class OnePush:
    """Runs one tuning at a time. Methods return immediately; signals come from the tuning's thread."""

    progressed = Signal(float, str)
    """Progress (0 … 1), and the state as display text."""
    succeeded = Signal(str)
    """The result, as display text."""
    failed = Signal(str)
    """The reason for the failure; everything is restored, or the text names the exceptions."""
    ended = Signal()
    """The tuning ended, with or without success."""

    def __init__(self) -> None:
        self._current: TuningRun | None = None
        self._thread: threading.Thread | None = None

    @property
    def running(self) -> bool:
        """Whether a tuning runs."""
        return self._current is not None

    def start(
        self, name: str, tuning: Tuning, grabber: ChangeTrackingGrabber, features: FeatureTreeModel
    ) -> bool:
        """Start a tuning; `name` labels its undo step. Return False if one is in progress already."""
        if self._current is not None:
            return False
        self._current = run = TuningRun(grabber, features, UndoStep(name), self.progressed.emit)
        thread = threading.Thread(target=self._run, args=(name, tuning, run), name="tuning", daemon=True)
        self._thread = thread
        thread.start()
        return True

    def cancel(self) -> None:
        """Cancel the tuning in progress; it restores its changes first."""
        if (run := self._current) is not None:
            run.cancelled.set()

    def wait(self, timeout: float) -> bool:
        """Wait up to `timeout` seconds; return whether the tuning has ended."""
        if (thread := self._thread) is not None:
            thread.join(timeout)
            return not thread.is_alive()
        return True

    def _run(self, name: str, tuning: Tuning, run: TuningRun) -> None:
        try:
            result = tuning(run)
        except Exception as error:
            self.failed.emit(self._restored(name, run, error))
        else:
            self.succeeded.emit(result)
        finally:
            run.close()
            self._current = None
            self.ended.emit()

    @staticmethod
    def _restored(name: str, run: TuningRun, error: Exception) -> str:
        """Restore the changes; return the reason for the failure as display text."""
        if not isinstance(error, GrabberError):
            log.exception("%s failed", name)
            error = GrabberError(f"internal error, see the log: {error}")
        cancelled = isinstance(error, TuningCancelledError)
        why = translate("Tuning", "cancelled") if cancelled else error_text(error)
        try:
            problems = run.restore()
        except GrabberError as failure:
            problems = [str(failure)]
        if not problems:
            return f"{name}: {why}"
        text = translate("Tuning", "{0}: {1}; not everything could be restored: {2}")
        return text.format(name, why, "; ".join(problems))


def can_expose(grabber: FeatureSource) -> bool:
    """Return whether a source has an exposure time or a gain; a recording has neither."""
    return any(grabber.role(role) is not None for role in (Role.EXPOSURE, Role.GAIN))


def can_balance(grabber: FeatureSource) -> bool:
    """Return whether a source has balance ratios."""
    return grabber.role(Role.BALANCE_RATIO) is not None


def has_once(grabber: FeatureSource, role: Role) -> bool:
    """Return whether the camera has an automatic mode for this role that runs once."""
    return automatic_once(grabber, role) is not None


def let_camera(run: TuningRun, role: Role) -> str:
    """Let the camera regulate once, wait for the end, and return the result as display text.

    Raises TuningError if it does not end in time, FrameTimeoutError if no frame comes from which the camera
    could regulate, FeatureError, TransportError.
    """
    auto = run.call(lambda grabber: automatic_once(grabber, role))
    if auto is None:
        raise FeatureNotFoundError(f"{run.title} does not regulate this once by itself", role.names[0])
    run.call(lambda grabber: grabber.write_feature(auto, AUTO_ONCE))
    begun, longest = time.monotonic(), PATIENCE
    while regulating(run.call(lambda grabber: grabber.feature(auto))):
        seconds, patience = time.monotonic() - begun, run.patience()
        longest = max(longest, PATIENCE + ONCE_FRAMES * run.period)
        if seconds > longest:
            text = translate("Tuning", "{0} was not done within {1:g} s; does the camera send frames?")
            raise TuningError(text.format(auto, round(longest)))
        run.say(seconds / longest, translate("Tuning", "{0} at work").format(auto))
        run.wait(LOOK)
        run.frame(patience)
    if role is not Role.EXPOSURE:
        return translate("Tuning", "White balance set by the camera")
    name = run.call(lambda grabber: grabber.role(role)) or role.names[0]
    exposure = run.call(lambda grabber: grabber.feature(name))
    return translate("Tuning", "Exposure set by the camera: {0}").format(value_text(exposure))


def expose(run: TuningRun, region: Region | None) -> str:
    """Set exposure time and gain so that the mean of a region reaches `EXPOSURE_TARGET`; return the outcome.

    Lengthens the time before raising gain, as far as the frame rate allows, and lowers gain before shortening
    the time. Switches automatic modes off. Raises TuningError if the light does not settle, FeatureError,
    FrameTimeoutError, TransportError.
    """
    parameters = run.call(_exposure_parameters)
    if not parameters:
        raise FeatureNotFoundError(f"{run.title} has neither exposure time nor gain to set", "ExposureTime")
    light = run.light(region)
    for turn in range(EXPOSURE_STEPS):
        text = translate("Tuning", "{0:.0%} of white, aim {1:.0%} · {2}")
        run.say(turn / EXPOSURE_STEPS, text.format(light.mean, EXPOSURE_TARGET, _exposure_text(parameters)))
        if abs(light.mean - EXPOSURE_TARGET) <= EXPOSURE_TOLERANCE:
            text = translate("Tuning", "Exposed: {0:.0%} of white with {1}")
            return text.format(light.mean, _exposure_text(parameters))
        if not _adjust_light(run, parameters, light_factor(light.mean, light.saturated, EXPOSURE_TARGET)):
            return _at_the_end(light, parameters)
        light = run.light(region)
    text = translate(
        "Tuning",
        "the light did not settle within {0} steps (it is at {1:.0%} of white);"
        " is the scene moving, or the lamp flickering?",
    )
    raise TuningError(text.format(EXPOSURE_STEPS, light.mean))


def _exposure_parameters(grabber: FeatureSource) -> list[TuningParameter]:
    """Return exposure time and gain, if the camera has them."""
    found: list[TuningParameter | None] = []
    if (name := grabber.role(Role.EXPOSURE)) is not None:
        found.append(
            TuningParameter.of(
                switch_to_manual(grabber, name), Law.PROPORTIONAL, highest=_longest(grabber, name)
            )
        )
    if (name := grabber.role(Role.GAIN)) is not None:
        gain = switch_to_manual(grabber, name)
        found.append(TuningParameter.of(gain, Law.DECIBEL if gain.unit.lower() == "db" else Law.UNKNOWN))
    return [parameter for parameter in found if parameter is not None]


def _longest(grabber: FeatureSource, exposure: str) -> float | None:
    """Return the longest exposure time that the current frame rate allows; None if unknown."""
    rate = grabber.role(Role.FRAME_RATE)
    hertz = grabber.feature(rate).value if rate is not None and not rate.endswith("Raw") else None
    factor = microseconds(grabber.feature(exposure).unit)
    if not isinstance(hertz, int | float) or hertz <= 0 or factor is None:
        return None
    return 1e6 / hertz / factor


def _adjust_light(run: TuningRun, parameters: list[TuningParameter], factor: float) -> bool:
    """Adjust the first parameter that can still change; return whether there is one."""
    for parameter in parameters if factor > 1 else reversed(parameters):
        value = parameter.proposed(factor)
        if value is None:
            continue
        parameter.feature = run.call(methodcaller("write_feature", parameter.feature.name, value))
        if isinstance(parameter.feature.value, int | float):
            parameter.search.accept(parameter.feature.value)
        return True
    return False


def _at_the_end(light: Light, parameters: list[TuningParameter]) -> str:
    if light.mean < EXPOSURE_TARGET:
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
    return text.format(light.mean, EXPOSURE_TARGET, _exposure_text(parameters))


def _exposure_text(parameters: list[TuningParameter]) -> str:
    return ", ".join(value_text(parameter.feature) for parameter in parameters)


def balance(run: TuningRun, region: Region | None) -> str:
    """Set the balance ratios of red and blue so that a region of the frame is grey; return the outcome.

    Switches the automatic mode off. Raises TuningError if the region cannot be measured or does not settle,
    FeatureError, FrameTimeoutError, TransportError.
    """
    parameters = run.call(_balance_parameters)
    light = _usable(run.light(region))
    for turn in range(BALANCE_STEPS):
        off = {channel: light.channels["G"] / max(light.channels[channel], 1e-6) for channel in COLOURS}
        text = translate("Tuning", "red {0:.0%}, blue {1:.0%} of green")
        run.say(turn / BALANCE_STEPS, text.format(1 / off["R"], 1 / off["B"]))
        wanted = {channel: factor for channel, factor in off.items() if abs(factor - 1) > BALANCE_TOLERANCE}
        if not wanted:
            return translate("Tuning", "Balanced: {0}").format(_balance_text(parameters))
        if not _adjust_colours(run, parameters, wanted):
            text = translate("Tuning", "As grey as it gets, with {0}; another light would help")
            return text.format(_balance_text(parameters))
        light = _usable(run.light(region))
    text = translate(
        "Tuning", "the colour did not settle within {0} steps; is the scene moving, or the lamp flickering?"
    )
    raise TuningError(text.format(BALANCE_STEPS))


def _balance_parameters(grabber: FeatureSource) -> dict[str, TuningParameter]:
    """Return the balance ratios to adjust, by channel."""
    name = grabber.role(Role.BALANCE_RATIO)
    if name is None:
        raise FeatureNotFoundError(f"{grabber.info.title} has no balance ratios to set", "BalanceRatio")
    switch_to_manual(grabber, name)
    path = grabber.selectors.of(name)
    found: dict[str, TuningParameter] = {}
    for channel, entry in COLOURS.items():
        key, parameter = SettingKey(name, tuple((selector, entry) for selector in path)), None
        if path:
            with suppress(FeatureError):
                parameter = TuningParameter.of(grabber.read_setting(key), Law.PROPORTIONAL, key=key)
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
    if light.channels["G"] < DARKEST:
        text = translate(
            "Tuning",
            "the region has hardly any green ({0:.1%} of white), to which red and blue are adjusted;"
            " choose a grey one, in another light",
        )
        raise TuningError(localized(text.format(light.channels["G"])))
    return light


def _adjust_colours(run: TuningRun, parameters: dict[str, TuningParameter], wanted: dict[str, float]) -> bool:
    """Adjust the ratios of these channels; return whether any of them can still change."""
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


def _balance_text(parameters: dict[str, TuningParameter]) -> str:
    red, blue = (number_text(parameters[channel].search.value, 4) for channel in COLOURS)
    return translate("Tuning", "red {0}, blue {1}").format(red, blue)
