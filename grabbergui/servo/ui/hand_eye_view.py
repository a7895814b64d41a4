"""The wizard of the hand–eye calibration as its controller knows it."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import TYPE_CHECKING, Protocol

from PyQt5.QtCore import pyqtBoundSignal

from grabbergui.models.markup import Markup

if TYPE_CHECKING:
    from grabbergui.servo.models.hand_eye import Happened, Setup, Solution, TargetPreview


class HandEyePage(Enum):
    """The pages of the hand–eye calibration, in order."""

    SETUP = 0
    PLAN = 1
    MOTION = 2
    RESULT = 3


class HandEyeView(Protocol):
    """The wizard of the hand–eye calibration."""

    setupChanged: pyqtBoundSignal
    nextRequested: pyqtBoundSignal
    backRequested: pyqtBoundSignal
    stopPressed: pyqtBoundSignal
    useToggled: pyqtBoundSignal
    publishToggled: pyqtBoundSignal
    viewChanged: pyqtBoundSignal
    closing: pyqtBoundSignal

    @property
    def page(self) -> HandEyePage:
        """The page that is shown."""

    @property
    def frames(self) -> tuple[str, str]:
        """The names of the frames of mount and camera."""

    def setPage(self, page: HandEyePage) -> None:
        """Show a page."""

    def setRobot(self, name: str, refused: Mapping[str, str]) -> None:
        """Show the robot, and for each place of the camera why it cannot be calibrated (empty: it can)."""

    def setSetup(self, setup: Setup) -> None:
        """Show eye, target, number of poses and speed."""

    def setPreview(self, preview: TargetPreview) -> None:
        """Show the newest frame, and whether the target is seen in it."""

    def setPlan(self, plan: Markup) -> None:
        """Show what the robot will do."""

    def setRunning(self, running: bool, *, enough: bool = False) -> None:
        """Show whether the robot moves; `enough` views of one that rests can be computed."""

    def addEvent(self, event: Happened) -> None:
        """Show an event of a run."""

    def setEnded(self, text: str, *, enough: bool) -> None:
        """Show how a run ended that has no result."""

    def setSolution(self, solution: Solution, unusable: str) -> None:
        """Show a result; `unusable` is why servoing cannot use it (empty: it can)."""

    def setInUse(self, in_use: bool) -> None:
        """Show whether servoing uses the result."""

    def setPublished(self, published: bool) -> None:
        """Show whether the camera's frame is on tf."""

    def showError(self, text: str) -> None:
        """Show an error message."""

    def showNotice(self, text: str) -> None:
        """Show a message that goes away by itself."""

    def dismissAll(self) -> None:
        """Remove every message."""
