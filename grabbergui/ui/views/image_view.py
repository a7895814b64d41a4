"""The live image with its readout, and work in progress and notes over it; the window of its points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PyQt5.QtCore import QPoint, QRect, QSignalBlocker, QSize, Qt, pyqtSignal
from PyQt5.QtGui import (
    QColor,
    QCursor,
    QHideEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QResizeEvent,
    QWheelEvent,
)
from PyQt5.QtWidgets import QCheckBox, QDialog, QFrame, QTabBar, QVBoxLayout, QWidget

from grabbergui.core.pixels import DisplayImage, Region
from grabbergui.models.diagnosis import Stage
from grabbergui.models.image.components import ShownImage
from grabbergui.models.image.orientation import Orientation
from grabbergui.models.image.pixel_text import TintedPart
from grabbergui.models.image.points import BACKGROUND
from grabbergui.models.image.quantities import ColourScale
from grabbergui.models.image.region_edit import RegionLimits
from grabbergui.models.messages import Offer
from grabbergui.ui.dialog_style import dress_dialog
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.shown_text import PlainLabel, set_tooltip
from grabbergui.ui.views.bases import NOTHING_BESIDE
from grabbergui.ui.views.recording_bars import PauseBar, PlaybackBar
from grabbergui.ui.views.trigger_bar import TriggerBar
from grabbergui.ui.widgets.drawing_tool import DrawingTool, Purpose
from grabbergui.ui.widgets.image_canvas import ImageCanvas
from grabbergui.ui.widgets.image_items import as_qimage
from grabbergui.ui.widgets.image_note import ImageNote
from grabbergui.ui.widgets.labels import ShrinkingLabel
from grabbergui.ui.widgets.pane_area import PaneArea
from grabbergui.ui.widgets.region_tool import RegionTool
from grabbergui.ui.widgets.scale_bar import SCALE_MARGIN, ScaleBar, place_scale
from grabbergui.ui.widgets.task_stack import TaskStack
from grabbergui.ui.widgets.tinted import TintedLabel

NOTE_WIDTH = 560
NOTE_MARGIN = 16
READOUT_GAP = 24
"Pixels between the mouse and the pixel's value, so that it never covers what is pointed at."
_DEGREES_PER_PIXEL = 0.4
_WHEEL_STEP = 1.15
_TEXT = QColor(220, 220, 220)


class ImageView(QWidget):
    """Setters for the image and its readout; signals for the visible part and the cursor."""

    viewChanged = pyqtSignal(object, object)
    """The visible Region of the frame, and (width, height) in screen pixels that it takes."""
    cursorMoved = pyqtSignal(int, int)
    """Column and line under the cursor."""
    cursorLeft = pyqtSignal()
    painted = pyqtSignal()
    """An image has reached the screen."""

    componentChosen = pyqtSignal(str)
    """The label of a component of the frame."""
    sideBySideToggled = pyqtSignal(bool)

    sourceChosen = pyqtSignal(str)
    """The name of an open source whose image was clicked on."""

    canvas: ImageCanvas
    componentBar: QWidget
    componentTabs: QTabBar
    sideBySideBox: QCheckBox
    paneArea: PaneArea
    triggerBar: TriggerBar
    pauseBar: PauseBar
    playbackBar: PlaybackBar
    readout: QFrame
    cursorLabel: TintedLabel
    hintLabel: ShrinkingLabel

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("image_view", self)
        self._labels: tuple[str, ...] = ()
        self._shown = ""
        "The component that is shown."
        self._asked = ""
        "The component that was chosen and is not shown yet."
        self._sources_beside = False
        "Whether the panes show other sources, not other components."
        self._separate_zoom = False
        self.note = ImageNote(self)
        self.tasks = TaskStack(self)
        """Work in progress, over the lower edge of the image, which does not move."""
        self.tasks.changed.connect(self._place_tasks)
        self.ageLabel = PlainLabel(parent=self)
        """The age of the last image of a lost source."""
        self.ageLabel.setProperty("age", True)
        self.ageLabel.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.ageLabel.hide()
        self.scaleBar = ScaleBar(self)
        """The scale of false colours, over the right edge of the image."""
        self.componentTabs.setDrawBase(False)
        self.componentTabs.setExpanding(False)
        self.componentTabs.currentChanged.connect(self._on_tab_changed)
        self.sideBySideBox.toggled.connect(self.sideBySideToggled)
        self.paneArea.take(self.canvas)
        self.paneArea.canvasPlaced.connect(self._place_scale)
        self.paneArea.paneChosen.connect(self._on_pane_chosen)
        self.drawing = DrawingTool(self.canvas)
        """Draws regions and lines with the mouse."""
        self.drawing.ended.connect(self._show_hint)
        self.regionTool = RegionTool(self.canvas)
        """Moves and resizes the camera's region."""
        self.regionTool.ended.connect(self.drawing.cancel)
        self.drawing.ended.connect(self.regionTool.end)
        self.canvas.viewChanged.connect(self.viewChanged)
        self.canvas.cursorMoved.connect(self.cursorMoved)
        self.canvas.cursorLeft.connect(self.cursorLeft)
        self.canvas.painted.connect(self.painted)
        self.readout.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self._place_readout()

    def setImage(self, image: DisplayImage, width: int, height: int) -> None:
        """Show an image of a frame of that size in pixels."""
        self.paneArea.setImage(image, width, height)

    def setComponents(self, labels: tuple[str, ...], shown: str) -> None:
        """Offer these components of the frame in tabs, or none, and mark the one that is shown."""
        tabs = self.componentTabs
        self._shown = shown
        if labels != self._labels:
            self._labels = labels
            with QSignalBlocker(tabs):
                while tabs.count():
                    tabs.removeTab(0)
                for label in labels:
                    tabs.addTab(label)
            self.componentBar.setVisible(bool(labels))
            self._asked = ""
        if self._asked in ("", shown) and shown in labels and tabs.currentIndex() != labels.index(shown):
            with QSignalBlocker(tabs):
                tabs.setCurrentIndex(labels.index(shown))
        if shown == self._asked:
            self._asked = ""

    def setScale(self, scale: ColourScale | None) -> None:
        """Show the scale of false colours; None for an intensity image."""
        if self.scaleBar.setScale(scale):
            self._place_scale()

    def setBeside(self, images: Sequence[ShownImage]) -> None:
        """Show these components beside the image, or none; not while there are other sources."""
        if self._sources_beside:
            return
        self.paneArea.setImages(self._labels, self._shown, images)

    def setSeparateZoom(self, separate: bool) -> None:
        """Give each source beside the current one a zoom of its own; components share theirs always."""
        self._separate_zoom = separate
        self.paneArea.forgetParts()
        self.paneArea.setSeparate(separate and self._sources_beside)

    def setSourcesBeside(self, order: Sequence[str], current: str, images: Sequence[ShownImage]) -> None:
        """Show images of other open sources beside the current one's, all in this order of their names.

        Their labels are the names. Without images, the current one is alone again.
        """
        if images or self._sources_beside:
            self._sources_beside = bool(images)
            self.paneArea.setSeparate(self._separate_zoom and self._sources_beside)
            self.paneArea.setImages(order, current, images)

    @property
    def empty(self) -> bool:
        """Whether no image is shown."""
        return self.canvas.empty

    @property
    def minimised(self) -> bool:
        """Whether the window is minimised, so that nobody sees the image."""
        window = self.window()
        return window is not None and window.isMinimized()

    def setAge(self, seconds: float | None) -> None:
        """Dim an image that nothing follows, and show its age; with None, show it as it is."""
        stale = seconds is not None and not self.empty
        self.canvas.setDimmed(stale)
        self.paneArea.setDimmed(stale)
        self.ageLabel.setVisible(stale)
        if stale and seconds is not None:
            self.ageLabel.setText(self.tr("Last image, {0} old").format(_age(seconds)))
            self.ageLabel.adjustSize()
            top = self.paneArea.caption.height() if self.paneArea.panes else 0
            self.ageLabel.move(self.paneArea.canvasPlace.topLeft() + QPoint(NOTE_MARGIN, NOTE_MARGIN + top))
            self.ageLabel.raise_()

    def clear(self) -> None:
        """Show nothing."""
        self.canvas.clear()
        self.setComponents((), "")
        self.setBeside(())
        self.setScale(None)
        self.setAge(None)
        self.setCursorText(())

    def setCursorText(self, text: Sequence[TintedPart], beside: Mapping[str, str] = NOTHING_BESIDE) -> None:
        """Show a text about the pixel under the cursor, and the values of all components there."""
        self.cursorLabel.setParts(text)
        self._place_readout()
        if self.paneArea.panes:
            self.paneArea.setValueTexts(beside)

    def draw(self, purpose: Purpose) -> None:
        """Use the next drag of the mouse for this purpose, and show a hint."""
        self._show_hint(*self._hints(purpose))
        self.drawing.begin(purpose)

    def editRegion(self, frame: Region, limits: RegionLimits, orientation: Orientation) -> None:
        """Show the camera's region with handles, and a hint. `frame` is the part of the sensor in view."""
        self._show_hint(
            self.tr("Draw a region, or drag the handles of this one; Esc ends."),
            self.tr("Draw, or drag handles; Esc ends."),
        )
        self.regionTool.begin(frame, limits, orientation)

    def _show_hint(self, text: str = "", shorter: str = "") -> None:
        """Show a hint, or none."""
        self.hintLabel.setTexts(text, shorter)
        self._place_readout()

    def _hints(self, purpose: Purpose) -> tuple[str, str]:
        """Return what to do, and the same for a narrow window."""
        text = {
            Purpose.SENSOR_REGION: self.tr("Draw the region that the camera should send; Esc cancels."),
            Purpose.FOCUS_REGION: self.tr("Draw the region to bring into focus; Esc cancels."),
            Purpose.PROFILE_LINE: self.tr("Draw the line whose values you want to see; Esc cancels."),
            Purpose.EXPOSURE_REGION: self.tr("Draw the region whose brightness counts; Esc cancels."),
            Purpose.BALANCE_REGION: self.tr("Draw a region that should be grey; Esc cancels."),
        }[purpose]
        if purpose is Purpose.PROFILE_LINE:
            return text, self.tr("Draw a line; Esc cancels.")
        return text, self.tr("Draw a region; Esc cancels.")

    def setNote(
        self, summary: str, advice: str = "", stage: Stage | None = None, offers: Sequence[Offer] = ()
    ) -> None:
        """Show a note in place of the image, with buttons for what it offers; with no summary, none."""
        self.note.setNote(summary, advice, stage, offers)
        self._place_note()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Keep note, tasks and readout in their places."""
        super().resizeEvent(event)
        self._place_note()
        self._place_tasks()
        self._place_readout()
        self._place_scale()

    def _place_note(self) -> None:
        if self.note.isHidden():
            return
        canvas = self.paneArea.geometry()
        width = min(NOTE_WIDTH, canvas.width() - 2 * NOTE_MARGIN)
        # Wrapped labels know their height only once they know their width.
        height = self.note.heightForWidth(width)
        x = canvas.x() + (canvas.width() - width) // 2
        # In a low window the end is cut off rather than the beginning.
        y = max(canvas.y(), canvas.center().y() - height // 2)
        self.note.setGeometry(x, y, width, height)
        self.note.raise_()

    def _place_tasks(self) -> None:
        canvas, height = self.paneArea.geometry(), self.tasks.sizeHint().height()
        width = min(NOTE_WIDTH, canvas.width() - 2 * NOTE_MARGIN)
        x = canvas.x() + (canvas.width() - width) // 2
        bottom = canvas.bottom() - self.readout.sizeHint().height() - NOTE_MARGIN
        self.tasks.setGeometry(x, bottom - height, width, height)
        self.tasks.raise_()

    def _place_readout(self) -> None:
        """Put hint and value over the lower edge of the image; over its upper edge if the mouse is there."""
        self.hintLabel.setVisible(bool(self.hintLabel.text()))
        self.cursorLabel.setVisible(bool(self.cursorLabel.text()))
        self.readout.setVisible(bool(self.hintLabel.text() or self.cursorLabel.text()))
        area, size = self.paneArea.geometry(), self.readout.sizeHint()
        place = QRect(area.topLeft(), size.boundedTo(area.size()))
        place.moveBottom(area.bottom())
        if place.adjusted(0, -READOUT_GAP, READOUT_GAP, 0).contains(self.mapFromGlobal(QCursor.pos())):
            place.moveTop(area.top())
        self.readout.setGeometry(place)
        self.readout.raise_()

    def _place_scale(self) -> None:
        place = self.paneArea.canvasPlace
        beside = bool(self.paneArea.panes)
        text = place_scale(self.scaleBar, place, SCALE_MARGIN if beside else NOTE_MARGIN, needed=not beside)
        self.paneArea.setScaleText(text)

    def _on_pane_chosen(self, label: str) -> None:
        if self._sources_beside:
            self.sourceChosen.emit(label)
        elif label in self._labels:
            self.componentTabs.setCurrentIndex(self._labels.index(label))

    def _on_tab_changed(self, index: int) -> None:
        if 0 <= index < len(self._labels):
            self._asked = self._labels[index]
            self.componentChosen.emit(self._asked)


def _age(seconds: float) -> str:
    minutes = round(seconds) // 60
    return f"{seconds:.0f} s" if minutes < 2 else f"{minutes} min" if minutes < 120 else f"{minutes // 60} h"


class PointCloudView(QWidget):
    """Paints an image as large as itself; signals for the actions of the mouse."""

    turned = pyqtSignal(float, float)
    """Degrees to the right and up."""
    zoomed = pyqtSignal(float)
    """A factor; above 1 is nearer."""
    resized = pyqtSignal(int, int)
    """Width and height in pixels of the screen."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._image: DisplayImage | None = None
        self._text = ""
        self._last = QPoint()
        self.setAccessibleName(self.tr("Point cloud"))
        set_tooltip(self, self.tr("Drag to turn, wheel to zoom"))
        self.setMinimumSize(240, 180)

    def setImage(self, image: DisplayImage) -> None:
        """Show an image."""
        self._image, self._text = image, ""
        self.update()

    def setProblem(self, text: str) -> None:
        """Show why there is no image."""
        self._image, self._text = None, text
        self.update()

    @property
    def problem(self) -> str:
        """Why there is no image; empty if there is one."""
        return self._text

    def sizeHint(self) -> QSize:
        """Return a size in which points can be seen."""
        return QSize(640, 480)

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Remember where the drag begins."""
        if event is not None:
            self._last = event.pos()

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Turn the cloud with the mouse."""
        if event is not None and event.buttons() & Qt.MouseButton.LeftButton:
            moved, self._last = event.pos() - self._last, event.pos()
            self.turned.emit(moved.x() * _DEGREES_PER_PIXEL, -moved.y() * _DEGREES_PER_PIXEL)

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Zoom with the wheel."""
        if event is not None and event.angleDelta().y():
            self.zoomed.emit(_WHEEL_STEP ** (event.angleDelta().y() / 120))

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Ask for an image of the new size."""
        super().resizeEvent(event)
        ratio = self.devicePixelRatioF()
        self.resized.emit(round(self.width() * ratio), round(self.height() * ratio))

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Draw the image, or the reason why there is none."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor(BACKGROUND, BACKGROUND, BACKGROUND))
        if self._image is not None:
            painter.drawImage(self.rect(), as_qimage(self._image))
        elif self._text:
            painter.setPen(_TEXT)
            flags = int(Qt.AlignmentFlag.AlignCenter) | int(Qt.TextFlag.TextWordWrap)
            painter.drawText(self.rect().adjusted(16, 16, -16, -16), flags, self._text)


class PointCloudDialog(QDialog):
    """The window of the point cloud; stays open beside the main window."""

    hidden = pyqtSignal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle(self.tr("Point cloud"))
        self.view = PointCloudView(self)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.view)
        dress_dialog(self)

    def hideEvent(self, event: QHideEvent | None) -> None:
        """Emit `hidden`."""
        super().hideEvent(event)
        self.hidden.emit()
