"""What controllers know of the views, so that they can be tested without a window. Setters never emit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from grabbergui.models.diagnosis import Stage
from grabbergui.models.messages import Message
from grabbergui.models.status import Tone


class StatusView(Protocol):
    """The line that says how the current source is doing."""

    def setState(self, text: str, tone: Tone) -> None:
        """How the source is doing."""

    def setTitle(self, text: str) -> None:
        """The name of what is open."""

    def setMessages(self, messages: Sequence[Message]) -> None:
        """All messages, the newest first."""

    def setFormat(self, text: str) -> None:
        """Resolution and pixel format."""

    def setRates(self, camera: float, painted: float) -> None:
        """Frames per second from the camera, and pictures painted."""

    def setBandwidth(self, bytes_per_second: float) -> None:
        """Payload per second."""

    def setLosses(self, text: str, tone: Tone, detail: str) -> None:
        """What was lost, how bad that is, and every counter in words."""

    def clearFigures(self) -> None:
        """Nothing streams."""


class LivePictureView(Protocol):
    """Where the picture is."""

    @property
    def empty(self) -> bool:
        """Whether no picture is shown."""

    def setNote(self, summary: str, advice: str = "", stage: Stage | None = None) -> None:
        """Show a note in place of the picture; with no summary, none."""

    def setAge(self, seconds: float | None) -> None:
        """Dim a picture that nothing follows, and say how old it is; with None, show it as it is."""
