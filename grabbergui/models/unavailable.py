"""Reasons why actions are not available, as their tooltips show them."""

from __future__ import annotations

from enum import Enum

from grabbergui.models.language import QT_TRANSLATE_NOOP, translate
from grabbergui.models.open_source import LinkState, OpenSource


class Unavailable(Enum):
    """Why an action is not available: the reason, and what to do about it."""

    SOURCE = QT_TRANSLATE_NOOP("Unavailable", "No source is open: choose one in the list and connect to it.")
    OPENING = QT_TRANSLATE_NOOP("Unavailable", "The source is still being opened.")
    LOST = QT_TRANSLATE_NOOP("Unavailable", "The source does not answer: wait until it is back.")
    STREAM = QT_TRANSLATE_NOOP("Unavailable", "The source is stopped: start it first.")
    CONTROL = QT_TRANSLATE_NOOP(
        "Unavailable", "The source is open for reading only: another program controls it."
    )
    RUN = QT_TRANSLATE_NOOP("Unavailable", "The source is stopped already.")
    PRESENT = QT_TRANSLATE_NOOP(
        "Unavailable", "A source is open: disconnect it first, or double-click another one in the list."
    )
    SHOWN = QT_TRANSLATE_NOOP("Unavailable", "The source is open already: press “Show”, or click its tile.")
    REST = QT_TRANSLATE_NOOP("Unavailable", "The source streams already.")
    FRAME = QT_TRANSLATE_NOOP("Unavailable", "There is no frame yet: start the camera first.")
    RANGE = QT_TRANSLATE_NOOP(
        "Unavailable", "The frame has no range image: enable the component Range, if there is one."
    )
    POLARISERS = QT_TRANSLATE_NOOP(
        "Unavailable", "The camera reports no polarisers: if it has some, tick “Sensor has polarisers” below."
    )
    EXPOSURE = QT_TRANSLATE_NOOP("Unavailable", "The source has neither exposure time nor gain.")
    BALANCE = QT_TRANSLATE_NOOP("Unavailable", "The source has no white balance.")
    REGION = QT_TRANSLATE_NOOP("Unavailable", "The source has no region of interest that can be changed.")
    USER_SETS = QT_TRANSLATE_NOOP(
        "Unavailable", "The source keeps no user sets: save its settings in a file."
    )
    TABLE = QT_TRANSLATE_NOOP("Unavailable", "The source has no look-up table that can be read.")
    CAMERA_FILES = QT_TRANSLATE_NOOP("Unavailable", "The source has no files.")
    CAMERA_FILE = QT_TRANSLATE_NOOP("Unavailable", "Choose a file in the list.")
    FILE_TRANSFER = QT_TRANSLATE_NOOP(
        "Unavailable", "Files are transferred only by a computer that has the camera itself."
    )
    FILE_READING = QT_TRANSLATE_NOOP("Unavailable", "The camera does not let this file be read.")
    FILE_WRITING = QT_TRANSLATE_NOOP("Unavailable", "The camera does not let this file be written.")
    FIRMWARE = QT_TRANSLATE_NOOP("Unavailable", "Firmware is never deleted.")
    CALIBRATION = QT_TRANSLATE_NOOP(
        "Unavailable", "The source has no calibration: load one, or calibrate the camera."
    )
    RIG = QT_TRANSLATE_NOOP("Unavailable", "The source is no rig: “New rig…” makes one of several cameras.")
    EVENTS = QT_TRANSLATE_NOOP("Unavailable", "The source reports no events. Those of a rig are in “Rig…”.")
    CHANGE = QT_TRANSLATE_NOOP("Unavailable", "Nothing was changed since the source was opened.")
    UNDONE = QT_TRANSLATE_NOOP("Unavailable", "Nothing was undone.")
    ENTRIES = QT_TRANSLATE_NOOP("Unavailable", "The list is empty.")
    PATIENCE = QT_TRANSLATE_NOOP("Unavailable", "Wait until the present run has ended.")
    SEARCH = QT_TRANSLATE_NOOP("Unavailable", "A search is in progress.")
    CHOICE = QT_TRANSLATE_NOOP("Unavailable", "Choose a source in the list, or type its address above.")
    WHOLE = QT_TRANSLATE_NOOP("Unavailable", "The whole image is measured already.")
    USER_SET = QT_TRANSLATE_NOOP("Unavailable", "Choose a set in the list.")
    SAVABLE = QT_TRANSLATE_NOOP("Unavailable", "This set cannot be changed: choose another one.")
    STARTABLE = QT_TRANSLATE_NOOP(
        "Unavailable", "The camera starts with this set already, or cannot start with it."
    )
    EDIT = QT_TRANSLATE_NOOP("Unavailable", "Nothing was edited.")
    FIRST = QT_TRANSLATE_NOOP("Unavailable", "This control is the first one already.")
    LAST = QT_TRANSLATE_NOOP("Unavailable", "This control is the last one already.")
    PAGE = QT_TRANSLATE_NOOP("Unavailable", "This is the first page.")
    VIEWS = QT_TRANSLATE_NOOP("Unavailable", "There are too few views yet.")
    MARKERS = QT_TRANSLATE_NOOP("Unavailable", "A chessboard has no markers.")
    OFFER = QT_TRANSLATE_NOOP("Unavailable", "The camera does not offer this now.")

    @property
    def text(self) -> str:
        """The reason in the user's language."""
        return translate("Unavailable", self.value)


def why_unavailable(
    source: OpenSource | None, *, stream: bool = False, control: bool = False
) -> Unavailable | None:
    """Return why an action that may need a source, its stream or control of it is unavailable; else None."""
    if source is None:
        return Unavailable.SOURCE
    if not source.state.connected:
        return Unavailable.LOST if source.state is LinkState.LOST else Unavailable.OPENING
    if stream and source.state is not LinkState.STREAMING:
        return Unavailable.STREAM
    return Unavailable.CONTROL if control and source.read_only else None
