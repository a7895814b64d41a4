"""Translation of the texts of models, drivers and networks, independent of the GUI toolkit.

Drivers and networks raise errors in English, with names and numbers in them. The window translates the
sentences listed here and shows all others as they are. The text at a placeholder may again be such a
sentence.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import cache
from typing import TypeVar

_Text = TypeVar("_Text", bound=str)
Translator = Callable[[str, str], str]
"""Maps context and text to the text in another language."""
_CONTEXT = "Drivers"
_LONGEST_SENTENCE = 500
"Longer texts, which only a faulty remote peer sends, would take long to match."


def _as_written(context: str, text: str) -> str:
    return text


_translator: Translator = _as_written
_decimal_point = "."

_POINT = re.compile(r"(?<=\d)\.(?=\d)")


def translate(context: str, text: str) -> str:
    """Return a text in the user's language, its placeholders not yet filled. Any thread."""
    return _translator(context, text)


def localized(text: _Text) -> _Text:
    """Return a text with the user's decimal separator in its numbers: `0,5` in Spanish. Any thread."""
    return text if _decimal_point == "." else type(text)(_POINT.sub(_decimal_point, text))


def counted(count: int, one: str, many: str, *values: object) -> str:
    """Return the singular or the plural text, with `count` for {0} and `values` for {1}, {2}, … Any thread.

    Both texts are translated already. Qt's numerus forms would need a translation file for English, too.
    """
    return (one if count == 1 else many).format(count, *values)


def set_translator(translator: Translator | None, decimal_point: str = ".") -> None:
    """Set the translator and the decimal separator; with None, texts stay as they are written."""
    global _translator, _decimal_point
    _translator = translator or _as_written
    _decimal_point = decimal_point


def is_translated() -> bool:
    """Return whether the user's language is not the one in which texts are written."""
    return _translator is not _as_written


def QT_TRANSLATE_NOOP(context: str, text: str) -> str:
    """Mark a text for `scripts/translations`, which looks for calls of this name. Returns it unchanged."""
    return text


SENTENCES = (
    # A camera that is lost
    QT_TRANSLATE_NOOP("Drivers", "the camera is lost: {0}"),
    QT_TRANSLATE_NOOP("Drivers", "the camera did not answer for {0} s"),
    QT_TRANSLATE_NOOP("Drivers", "another application took exclusive control of the camera"),
    QT_TRANSLATE_NOOP("Drivers", "another application, at {0}, took control of the camera"),
    QT_TRANSLATE_NOOP(
        "Drivers", "the camera took our control back; its heartbeat may have expired, or it has restarted"
    ),
    QT_TRANSLATE_NOOP("Drivers", "{0} was lost while it was opened"),
    QT_TRANSLATE_NOOP("Drivers", "{0} is not open"),
    QT_TRANSLATE_NOOP("Drivers", "{0} was unplugged"),
    # A camera that does not answer
    QT_TRANSLATE_NOOP("Drivers", "{0} was not acknowledged within {1} s ({2} tries)"),
    QT_TRANSLATE_NOOP("Drivers", "{0} was not acknowledged within {1} s; the camera had asked for more time"),
    QT_TRANSLATE_NOOP("Drivers", "{0} did not answer in time"),
    QT_TRANSLATE_NOOP("Drivers", "{0} did not answer within {1} s"),
    QT_TRANSLATE_NOOP("Drivers", "the device takes no commands; unplug it and plug it in again"),
    # A camera that sends no frames
    QT_TRANSLATE_NOOP(
        "Drivers",
        "the camera sees this computer at {0}, not at {1}: a router between them translates addresses (NAT),"
        " so frames do not get through; give this computer an address in the camera's network",
    ),
    QT_TRANSLATE_NOOP(
        "Drivers",
        "no packet arrives; {0} and {1} are in one subnet, {2}; the system may use the wrong one for a"
        " camera: give {3} and its cameras addresses of another subnet",
    ),
    QT_TRANSLATE_NOOP("Drivers", "no packet arrives; a firewall may drop them: {0}"),
    # A trigger that makes other frames than expected
    QT_TRANSLATE_NOOP(
        "Drivers", "there is no edge on {0}, it is always low: check the cable, LineMode and the sender"
    ),
    QT_TRANSLATE_NOOP(
        "Drivers", "there is no edge on {0}, it is always high: check the cable, LineMode and the sender"
    ),
    QT_TRANSLATE_NOOP("Drivers", "there is no edge on {0}: check the cable, LineMode and the sender"),
    QT_TRANSLATE_NOOP("Drivers", "no trigger arrives on {0}; it is low"),
    QT_TRANSLATE_NOOP("Drivers", "no trigger arrives on {0}; it is high"),
    QT_TRANSLATE_NOOP("Drivers", "no trigger arrives on {0}"),
    QT_TRANSLATE_NOOP(
        "Drivers",
        "{0} has only edges of the other kind; set TriggerActivation to {1}, or switch LineInverter",
    ),
    QT_TRANSLATE_NOOP(
        "Drivers",
        "the camera triggers at the end of each pulse, {0} µs late; set TriggerActivation to {1}, or switch"
        " LineInverter",
    ),
    QT_TRANSLATE_NOOP(
        "Drivers",
        "edges within {0} µs of another: {1}; a contact bounces: use a debouncer (LineDebouncerTime) or a"
        " clean signal",
    ),
    QT_TRANSLATE_NOOP("Drivers", "double pulses, {0} ms apart: {1}; are there two senders on the line?"),
    QT_TRANSLATE_NOOP(
        "Drivers", "pulses missing between the others: {0}; the sender or the cable drops some"
    ),
    QT_TRANSLATE_NOOP(
        "Drivers",
        "triggers come at {0} Hz, but exposure and readout allow {1} Hz; {2} were missed (without overlap of"
        " exposure and readout; with it {3} Hz)",
    ),
    QT_TRANSLATE_NOOP(
        "Drivers", "triggers come at {0} Hz, but exposure and readout allow {1} Hz; {2} were missed"
    ),
    QT_TRANSLATE_NOOP(
        "Drivers",
        "a trigger makes {0} frames instead of {1}; each frame waits for a trigger of its own: set"
        " TriggerMode[TriggerSelector=FrameStart] to Off",
    ),
    QT_TRANSLATE_NOOP(
        "Drivers",
        "a trigger makes {0} frames instead of {1}; the acquisition ends before: check AcquisitionMode and"
        " AcquisitionFrameCount",
    ),
    QT_TRANSLATE_NOOP(
        "Drivers",
        "frames that were lost on the wire: {0}; every trigger was taken: plan the link's budget",
    ),
    QT_TRANSLATE_NOOP(
        "Drivers", "actions that did not reach the camera: {0} of {1}; they were lost on the network"
    ),
    QT_TRANSLATE_NOOP("Drivers", "the camera ignores the actions: {0}"),
    # A camera of a rig whose clock is not as wanted
    QT_TRANSLATE_NOOP("Drivers", "it has no PTP"),
    QT_TRANSLATE_NOOP("Drivers", "PTP is off"),
    QT_TRANSLATE_NOOP("Drivers", "not locked to a master (PtpStatus {0})"),
    QT_TRANSLATE_NOOP("Drivers", "it follows another PTP master {0} than {1}"),
    QT_TRANSLATE_NOOP("Drivers", "it follows another PTP master than {0}"),
    # Cameras that need more than their link carries
    QT_TRANSLATE_NOOP(
        "Drivers",
        "the cameras need {0} MB/s, but {1} of the link are {2} MB/s: lower every frame rate to {3} of it,"
        " reduce the images, or use a packed pixel format",
    ),
    QT_TRANSLATE_NOOP("Drivers", "{0} needs {1} MB/s, more than its own cable carries ({2} MB/s)"),
    QT_TRANSLATE_NOOP(
        "Drivers",
        "{0} cannot be paced: {1} kB of a frame would wait in the switch, whose buffer is {2} kB; trigger"
        " them one after the other",
    ),
    # A remote camera that sends no images
    QT_TRANSLATE_NOOP("Drivers", "{0} is not connected to this program at the moment"),
    QT_TRANSLATE_NOOP("Drivers", "{0} sends messages that are no images ({1})"),
    QT_TRANSLATE_NOOP("Drivers", "{0} is connected over {1} and sends nothing"),
    QT_TRANSLATE_NOOP("Drivers", "{0} is subscribed to, and {1} sends nothing that arrives here"),
    QT_TRANSLATE_NOOP("Drivers", "nobody publishes {0}"),
    # A camera that somebody else uses
    QT_TRANSLATE_NOOP("Drivers", "another application at {0} controls {1}; close it there"),
    QT_TRANSLATE_NOOP("Drivers", "another application controls {0}; close it there"),
    QT_TRANSLATE_NOOP(
        "Drivers", "another application has exclusive control of the camera at {0}; close it there"
    ),
    QT_TRANSLATE_NOOP("Drivers", "this program controls {0} already; close it first"),
    QT_TRANSLATE_NOOP("Drivers", "{0} is in use by another application; close it there"),
    QT_TRANSLATE_NOOP("Drivers", "{0} is in use by {1}; close it there"),
    QT_TRANSLATE_NOOP("Drivers", "another program"),
    QT_TRANSLATE_NOOP("Drivers", "a program at {0}"),
    QT_TRANSLATE_NOOP("Drivers", "in use by {0}"),
    QT_TRANSLATE_NOOP("Drivers", "the camera is open for reading only; another application may control it"),
    QT_TRANSLATE_NOOP(
        "Drivers", "the camera answers reads but not this write; another application may control it"
    ),
    QT_TRANSLATE_NOOP("Drivers", "the camera is served read-only"),
    # A webcam
    QT_TRANSLATE_NOOP(
        "Drivers",
        "{0}: its USB bus has too little bandwidth left; choose a smaller size, MJPG or a lower rate,"
        " or plug it in elsewhere",
    ),
    QT_TRANSLATE_NOOP("Drivers", "{0} is set to {1}, which cannot be shown; choose another PixelFormat"),
    # A file or an address
    QT_TRANSLATE_NOOP("Drivers", "{0} is there already; a recording overwrites nothing, choose another name"),
    QT_TRANSLATE_NOOP("Drivers", "{0} could not be created: {1}; choose another folder or name"),
    QT_TRANSLATE_NOOP("Drivers", "the snapshot could not be written to {0}: {1}; choose another folder"),
    QT_TRANSLATE_NOOP("Drivers", "{0} could not be written: {1}"),
    QT_TRANSLATE_NOOP("Drivers", "{0} could not be read: {1}"),
    QT_TRANSLATE_NOOP("Drivers", "'{0}' is no source; did you mean {1}?"),
    QT_TRANSLATE_NOOP("Drivers", "'{0}' is no source; write its kind first, as in sim: or gige:192.168.0.10"),
    QT_TRANSLATE_NOOP("Drivers", "'{0}' is of no known kind; there are {1}"),
    # A camera that returned with other settings
    QT_TRANSLATE_NOOP("Drivers", "{0} is not there any more"),
    QT_TRANSLATE_NOOP("Drivers", "{0} is {1} instead of {2}"),
    # A marker or a board
    QT_TRANSLATE_NOOP(
        "Drivers", "a pitch of {0} m must be more than the markers' size, {1} m, or they would overlap"
    ),
    QT_TRANSLATE_NOOP("Drivers", "two poses explain it"),
    QT_TRANSLATE_NOOP("Drivers", "it is seen edge-on"),
    QT_TRANSLATE_NOOP("Drivers", "its corners are no square's"),
)
"""From the special to the general."""
_guests_sentences: list[str] = []


def add_sentences(sentences: Sequence[str]) -> None:
    """Translate these, too: a guest's errors, each marked for the context `Drivers`."""
    _guests_sentences.extend(sentences)
    _patterns.cache_clear()


def driver_text(text: object) -> str:
    """Return a driver's sentence in the user's language; unchanged if it is not listed."""
    sentence = str(text)
    if not is_translated() or len(sentence) > _LONGEST_SENTENCE:
        return sentence
    for template, pattern in _patterns():
        if (found := pattern.fullmatch(sentence)) is not None:
            parts = (driver_text(part) for part in found.groups())
            return translate(_CONTEXT, template).format(*map(_number, parts))
    return sentence


@cache
def _patterns() -> tuple[tuple[str, re.Pattern[str]], ...]:
    return tuple(
        (text, re.compile(re.sub(r"\\{\d\\}", "(.+?)", re.escape(text)), re.DOTALL))
        for text in (*SENTENCES, *_guests_sentences)
    )


def _number(part: str) -> str:
    """Localize a number; names and addresses stay unchanged."""
    return localized(part) if re.fullmatch(r"[-+]?\d+\.\d+", part) else part
