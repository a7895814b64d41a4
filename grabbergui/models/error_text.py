"""Errors in the user's language.

In English, an error's own text is used. In other languages, the most common errors are worded here by their
class and the source or feature concerned; for others, only the sentence around the English text is
translated.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from grabbergui.core.errors import (
    AccessDeniedError,
    AckTimeoutError,
    DeviceLostError,
    DeviceStatusError,
    FeatureAccessError,
    FeatureError,
    FeatureNotFoundError,
    FeatureValueError,
    GrabberError,
    OtherCameraError,
    SourceNotFoundError,
    SourceUnavailableError,
    TransportError,
    UsageError,
)
from grabbergui.core.features import Feature
from grabbergui.models.features.feature_text import access_text, range_text
from grabbergui.models.language import driver_text, is_translated, translate

MOST_PROBLEMS = 3
"Most problems listed in one line; the log has them all."


def error_text(error: Exception, source: object = "", feature: Feature | None = None) -> str:
    """Return an error as display text.

    `source` is the URI or title of the source concerned, `feature` the last known state of the feature.
    """
    if not is_translated():
        return str(error)
    if isinstance(error, FeatureError):
        return _about_feature(error, feature)
    sentence = _about_source(error, str(source)) if source else ""
    return sentence or _by_kind(error)


def lost_text(title: str, reason: str) -> str:
    """Return the message that a source was lost; `reason` is the driver's text, if it has one."""
    if reason and not is_translated():
        return reason
    text = translate("Errors", "the connection to {0} was lost").format(title)
    return f"{text}: {driver_text(reason)}" if reason else text


def returned_text(problems: Sequence[str], changed: Sequence[str] = ()) -> str:
    """Return whether a source that is back is set as before.

    `problems` are the settings that could not be restored, `changed` those that others changed during the
    loss; a sentence each.
    """
    text = translate("Errors", "set as before")
    if problems:
        text = translate("Errors", "but not as before: {0}").format(_listed(problems))
    if changed:
        text += translate("Errors", "; changed meanwhile, not by us: {0}").format(_listed(changed))
    return text


def _listed(sentences: Sequence[str]) -> str:
    shown = "; ".join(map(driver_text, sentences[:MOST_PROBLEMS]))
    if len(sentences) > MOST_PROBLEMS:
        shown += translate("Errors", "; and {0} more").format(len(sentences) - MOST_PROBLEMS)
    return shown


def held_text(denied: AccessDeniedError | None = None) -> str:
    """Return that another program controls a source, with its name if the driver knows it."""
    if denied is not None and not is_translated():
        return str(denied)
    return translate("Errors", "another application controls it")


def free_text() -> str:
    """Return that the program which controlled a source does so no more."""
    return translate("Errors", "no other application controls it any more")


def _about_feature(error: FeatureError, feature: Feature | None) -> str:
    name = error.feature
    if isinstance(error, FeatureNotFoundError):
        return translate("Errors", "the camera has no {0}").format(name)
    if isinstance(error, FeatureAccessError) and feature is not None and not feature.access.writable:
        return f"{name} {access_text(feature)}"
    if isinstance(error, FeatureValueError) and feature is not None:
        text = translate("Errors", "{0} does not take this value; allowed: {1}")
        return text.format(name, range_text(feature))
    return translate("Errors", "{0} was refused: {1}").format(name, driver_text(error))


def _about_source(error: Exception, source: str) -> str:
    """Return a sentence that names the source; empty for errors of other kinds."""
    if isinstance(error, OtherCameraError):
        text = translate("Errors", "{0} may be another camera than the one you named: {1}")
        return text.format(source, driver_text(error))
    if isinstance(error, SourceNotFoundError):
        return translate("Errors", "{0} was not found; check address, power and cable").format(source)
    if isinstance(error, AckTimeoutError):
        return translate("Errors", "{0} does not answer; check address, power and cable").format(source)
    if isinstance(error, AccessDeniedError):
        return translate("Errors", "no access to {0}: {1}").format(source, driver_text(error))
    if isinstance(error, SourceUnavailableError):
        return translate("Errors", "{0} cannot be used on this computer: {1}").format(
            source, driver_text(error)
        )
    return ""


_KINDS: tuple[tuple[type[GrabberError], Callable[[], str]], ...] = (
    (AckTimeoutError, lambda: translate("Errors", "the camera does not answer: {0}")),
    (DeviceLostError, lambda: translate("Errors", "the connection to the camera was lost: {0}")),
    (TransportError, lambda: translate("Errors", "the camera cannot be reached: {0}")),
    (DeviceStatusError, lambda: translate("Errors", "the camera refused it: {0}")),
    (AccessDeniedError, lambda: translate("Errors", "access denied: {0}")),
    (SourceNotFoundError, lambda: translate("Errors", "not found: {0}")),
    (UsageError, lambda: translate("Errors", "this cannot be understood: {0}")),
)
"""From the special to the general; functions, as the language may change."""


def _by_kind(error: Exception) -> str:
    for kind, sentence in _KINDS:
        if isinstance(error, kind):
            return sentence().format(driver_text(error))
    return driver_text(error)
