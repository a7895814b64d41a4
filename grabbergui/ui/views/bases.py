"""The views as controllers know them: setters in, signals out, and no more than each controller needs.

The composition roots (`ui/run/`) pass the widgets that fit; a test passes whatever it likes. An action is a
view by itself: a signal, a name, enabled or not, checked or not. Setters never emit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Protocol

from PyQt5.QtCore import QByteArray, pyqtBoundSignal
from PyQt5.QtWidgets import QAction

from grabbergui.core.pixels import DisplayImage, Region
from grabbergui.models.diagnosis import Stage
from grabbergui.models.image.components import ShownImage
from grabbergui.models.image.orientation import Orientation
from grabbergui.models.image.pixel_text import TintedPart
from grabbergui.models.image.quantities import ColourScale, PolarisedView
from grabbergui.models.image.region_edit import RegionLimits
from grabbergui.models.messages import Offer, UserMessage
from grabbergui.models.status import Tone
from grabbergui.ui.widgets.drawing_tool import DrawingTool, Purpose
from grabbergui.ui.widgets.image_canvas import ImageCanvas
from grabbergui.ui.widgets.pane_area import PaneArea
from grabbergui.ui.widgets.region_tool import RegionTool

NOTHING_BESIDE: Mapping[str, str] = MappingProxyType({})


class FileQuestions(Protocol):
    """Asks for the path of a file or folder; None if the user cancels."""

    def to_open(self, title: str, kinds: str, folder: Path | None = None) -> Path | None:
        """Ask for a file that exists; `kinds` is a filter such as `Settings (*.yaml)`."""

    def to_save(self, title: str, name: str, kinds: str) -> Path | None:
        """Ask for a file to write; `name` is the suggestion."""

    def folder(self, title: str, before: Path) -> Path | None:
        """Ask for a folder; `before` is the one used so far."""


class StatusView(Protocol):
    """The line that shows how the current source is doing."""

    def setState(self, text: str, tone: Tone) -> None:
        """Show how the source is doing."""

    def setTitle(self, title: str, *shorter: str) -> None:
        """Show the name of the source, and shorter ones for little room."""

    def setMessages(self, messages: Sequence[UserMessage]) -> None:
        """Show these messages, the newest first."""

    def setFormat(self, text: str) -> None:
        """Show resolution and pixel format."""

    def setRates(self, camera: float, painted: float) -> None:
        """Show frames per second from the camera, and images painted per second."""

    def setBandwidth(self, bytes_per_second: float) -> None:
        """Show the payload per second."""

    def setLosses(self, text: str, tone: Tone, detail: str) -> None:
        """Show losses, their severity, and every counter as text."""

    def setClipping(self, text: str) -> None:
        """Show how much of the frame is saturated and black; empty while it is not measured."""

    def setSaturated(self, share: float | None) -> None:
        """Show about how much of the frame is saturated, while that is not measured; None if unknown."""

    def clearFigures(self) -> None:
        """Show that nothing streams."""


class LiveImageView(Protocol):
    """The place of the image."""

    @property
    def empty(self) -> bool:
        """Whether no image is shown."""

    @property
    def minimised(self) -> bool:
        """Whether the window is minimised, so that nobody sees the image."""

    def setNote(
        self, summary: str, advice: str = "", stage: Stage | None = None, offers: Sequence[Offer] = ()
    ) -> None:
        """Show a note in place of the image, with buttons for what it offers; with no summary, none."""

    def setAge(self, seconds: float | None) -> None:
        """Dim an image that nothing follows, and show its age; with None, show it as it is."""


class DrawableView(Protocol):
    """An image that regions and lines can be drawn on."""

    @property
    def canvas(self) -> ImageCanvas:
        """The image itself, zoomed and panned."""

    @property
    def drawing(self) -> DrawingTool:
        """The tool that draws regions and lines with the mouse."""

    def draw(self, purpose: Purpose) -> None:
        """Use the next drag of the mouse for this purpose, and show a hint."""


class RegionImageView(DrawableView, Protocol):
    """An image on which the camera's region can be drawn, moved and resized."""

    @property
    def regionTool(self) -> RegionTool:
        """The tool that moves and resizes the region."""

    @property
    def painted(self) -> pyqtBoundSignal:
        """An image has reached the screen."""

    def editRegion(self, frame: Region, limits: RegionLimits, orientation: Orientation) -> None:
        """Show the region with handles. `frame` is what the image shows, in pixels of the sensor."""


class ReadoutImageView(DrawableView, LiveImageView, Protocol):
    """The image with its readout."""

    @property
    def viewChanged(self) -> pyqtBoundSignal:
        """The visible Region of the frame, and (width, height) in screen pixels that it takes."""

    @property
    def cursorMoved(self) -> pyqtBoundSignal:
        """Column and line under the cursor."""

    @property
    def cursorLeft(self) -> pyqtBoundSignal:
        """The cursor is no longer over the image."""

    @property
    def painted(self) -> pyqtBoundSignal:
        """An image has reached the screen."""

    def setImage(self, image: DisplayImage, width: int, height: int) -> None:
        """Show an image of a frame of that size in pixels."""

    def setComponents(self, labels: tuple[str, ...], shown: str) -> None:
        """Offer these components of the frame, or none, and mark the one that is shown."""

    def setScale(self, scale: ColourScale | None) -> None:
        """Show the scale of false colours; None for an intensity image."""

    def setBeside(self, images: Sequence[ShownImage]) -> None:
        """Show these components beside the image, or none."""

    def setCursorText(self, text: Sequence[TintedPart], beside: Mapping[str, str] = NOTHING_BESIDE) -> None:
        """Describe the pixel under the cursor; `beside` has all components' values there by their labels."""

    def clear(self) -> None:
        """Show nothing."""


class SourcePanesView(Protocol):
    """The images of several open sources side by side."""

    @property
    def sourceChosen(self) -> pyqtBoundSignal:
        """The name of an open source whose image was clicked on."""

    @property
    def canvas(self) -> ImageCanvas:
        """The current source's image, whose zoom the others have."""

    @property
    def paneArea(self) -> PaneArea:
        """The panes, by the names of their sources."""

    def setSeparateZoom(self, separate: bool) -> None:
        """Give each source beside the current one a zoom of its own, or the same to all."""

    def setSourcesBeside(self, order: Sequence[str], current: str, images: Sequence[ShownImage]) -> None:
        """Show images of other sources, labelled with their names, beside the current one's; or none."""


class ComponentView(Protocol):
    """The choice among a frame's components."""

    @property
    def componentChosen(self) -> pyqtBoundSignal:
        """The label of the component that the user chose."""

    @property
    def sideBySideToggled(self) -> pyqtBoundSignal:
        """Whether the user wants to see all components at once."""


class Layout(Protocol):
    """The arrangement of a window's docks, as Qt stores it."""

    def saveState(self, version: int = 0) -> QByteArray:
        """Return the arrangement as bytes."""

    def restoreState(self, state: QByteArray, version: int = 0) -> bool:
        """Arrange the docks as before."""


class Dock(Protocol):
    """The dock of a panel."""

    @property
    def visibilityChanged(self) -> pyqtBoundSignal:
        """Whether the panel can be seen; one behind another cannot."""

    def show(self) -> None:
        """Open the dock."""

    def raise_(self) -> None:
        """Bring the dock in front of the others."""


@dataclass(frozen=True)
class AcquisitionActions:
    """Streaming and snapshots."""

    actionDisconnect: QAction
    actionStart: QAction
    actionStop: QAction
    actionSnapshot: QAction
    actionPointCloud: QAction


@dataclass(frozen=True)
class DisplayActions:
    """How the image is shown; none of them changes the camera."""

    actionCrosshair: QAction
    actionGrid: QAction
    actionClipping: QAction
    actionTurnRight: QAction
    actionTurnLeft: QAction
    actionMirrorX: QAction
    actionMirrorY: QAction
    actionUpright: QAction
    colourMapChosen: pyqtBoundSignal
    """The name of a colour map for monochrome images; empty for grey."""


@dataclass(frozen=True)
class ComponentActions:
    """The colours of a component, and the choice of a view of a polarised mosaic."""

    setColourMap: Callable[[str], None]
    """Mark the colour map of the component that is shown; empty for grey."""
    actionPolarised: QAction
    """Whether views of a polarised mosaic are offered, which the user may change."""
    polarisedViewChosen: pyqtBoundSignal
    """The `PolarisedView` that the user chose."""
    setPolarisedView: Callable[[PolarisedView], None]
    """Mark the view that is shown."""


@dataclass(frozen=True)
class PauseActions:
    """Pause, and steps through frames."""

    actionPause: QAction
    actionStepBack: QAction
    actionStepForward: QAction


@dataclass(frozen=True)
class TuningActions:
    """One-push exposure and white balance, on the whole image or a region."""

    actionExpose: QAction
    actionBalance: QAction
    actionExposeRegion: QAction
    actionBalanceRegion: QAction


@dataclass(frozen=True)
class RegionActions:
    """The region of interest."""

    actionRegion: QAction
    actionFullSensor: QAction


@dataclass(frozen=True)
class UndoActions:
    """Undo and redo."""

    actionUndo: QAction
    actionRedo: QAction


@dataclass(frozen=True)
class CalibrationActions:
    """Loading and showing a calibration."""

    actionLoadCalibration: QAction
    actionShowCalibration: QAction


@dataclass(frozen=True)
class HelpActions:
    """The *Help* menu."""

    actionManual: QAction
    actionDoctor: QAction
    actionShortcuts: QAction
    actionWhatsThis: QAction
