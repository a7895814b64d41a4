"""The tiles of the open sources, each with its live image."""

from __future__ import annotations

from PyQt5.QtCore import QRectF, QSize, Qt, pyqtSignal
from PyQt5.QtGui import QImage, QKeyEvent, QMouseEvent, QPainter, QPaintEvent
from PyQt5.QtWidgets import (
    QFrame,
    QLabel,
    QStyle,
    QStyleOption,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from grabbergui.core.pixels import DisplayImage
from grabbergui.models.status import Tone
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.shown_text import set_tooltip
from grabbergui.ui.widgets.image_items import DIMMED, as_qimage
from grabbergui.ui.widgets.labels import ElidedLabel, restyle

TILE_HEIGHT = 62
"Height of a tile in pixels."
_CHOOSING = (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Space)
"Keys that make a tile's source current."


class Thumbnail(QWidget):
    """Paints one image in the middle, in its own proportions; without zoom or readout."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._image: QImage | None = None
        self._dimmed = False

    @property
    def image(self) -> QImage | None:
        """The image shown."""
        return self._image

    def setImage(self, image: DisplayImage | None) -> None:
        """Show an image, or none."""
        self._image = as_qimage(image) if image is not None else None
        self.update()

    def setDimmed(self, dimmed: bool) -> None:
        """Show the image darker."""
        if dimmed != self._dimmed:
            self._dimmed = dimmed
            self.update()

    def roomInPixels(self, width: int, height: int) -> tuple[int, int]:
        """Return the screen pixels that an image of that size takes here."""
        ratio = self.devicePixelRatioF()
        size = QSize(width, height).scaled(self.size() * ratio, Qt.AspectRatioMode.KeepAspectRatio)
        return max(1, size.width()), max(1, size.height())

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Draw the image, or an empty place."""
        painter, option = QPainter(self), QStyleOption()
        option.initFrom(self)
        if (style := self.style()) is not None:
            style.drawPrimitive(QStyle.PrimitiveElement.PE_Widget, option, painter, self)
        if self._image is None:
            return
        size = self._image.size().scaled(self.size(), Qt.AspectRatioMode.KeepAspectRatio)
        target = QRectF(0, 0, size.width(), size.height())
        target.moveCenter(QRectF(self.rect()).center())
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        painter.setOpacity(DIMMED if self._dimmed else 1.0)
        painter.drawImage(target, self._image)


class CameraTile(QFrame):
    """A click, Enter or Space makes the source current; Delete, or the button, closes it."""

    chosen = pyqtSignal()
    closeRequested = pyqtSignal()

    thumbnail: Thumbnail
    recordingLabel: QLabel
    titleLabel: ElidedLabel
    stateLabel: ElidedLabel
    closeButton: QToolButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("camera_tile", self)
        self.setFixedHeight(TILE_HEIGHT)
        self.titleLabel.elide_mode = Qt.TextElideMode.ElideMiddle
        self.closeButton.clicked.connect(self.closeRequested)
        self.recordingLabel.hide()
        self.setCursor(Qt.CursorShape.PointingHandCursor)

    def setNames(self, title: str, *shorter: str) -> None:
        """Show the source's name, or a shorter one in a narrow tile."""
        self.titleLabel.setTexts(title, *shorter)
        self.setAccessibleName(title)
        self.closeButton.setAccessibleName(self.tr("Close {0}").format(title))

    def setState(self, text: str, tone: Tone) -> None:
        """Show the source's state, in a word or a figure, and how good that is."""
        self.stateLabel.setTexts(text, text.partition(",")[0])  # the tone shows the rest
        restyle(self.stateLabel, "tone", (tone if tone is not Tone.GOOD else Tone.IDLE).value)

    def setRecording(self, recording: bool) -> None:
        """Show whether the source is being recorded."""
        self.recordingLabel.setVisible(recording)

    def setDimmed(self, dimmed: bool) -> None:
        """Dim the image, which is not current."""
        self.thumbnail.setDimmed(dimmed)

    def setCurrent(self, current: bool) -> None:
        """Mark the tile of the current source."""
        set_tooltip(
            self,
            self.tr("This is the current source") if current else self.tr("Make this the current source"),
        )
        restyle(self, "current", current)

    def setImage(self, image: DisplayImage | None) -> None:
        """Show an image, or none."""
        self.thumbnail.setImage(image)

    def mouseReleaseEvent(self, event: QMouseEvent | None) -> None:
        """Make the source current."""
        super().mouseReleaseEvent(event)
        left = event is not None and event.button() == Qt.MouseButton.LeftButton
        if left and event is not None and self.rect().contains(event.pos()):
            self.chosen.emit()

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Make the source current, or close it."""
        if event is not None and event.key() in _CHOOSING:
            self.chosen.emit()
        elif event is not None and event.key() == Qt.Key.Key_Delete:
            self.closeRequested.emit()
        else:
            super().keyPressEvent(event)


class Gallery(QWidget):
    """The tiles, one below the other, in the order they were added; hidden while there are none."""

    filled = pyqtSignal(bool)
    """Whether there are tiles, after a change."""

    tilesLayout: QVBoxLayout

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("gallery", self)
        self._tiles: list[CameraTile] = []
        self.hide()

    @property
    def tiles(self) -> list[CameraTile]:
        """The tiles from top to bottom."""
        return list(self._tiles)

    def addTile(self) -> CameraTile:
        """Add a tile at the end."""
        tile = CameraTile(self)
        self.tilesLayout.addWidget(tile)
        self._tiles.append(tile)
        self._arrange()
        return tile

    def removeTile(self, tile: CameraTile) -> None:
        """Remove a tile."""
        self._tiles.remove(tile)
        self.tilesLayout.removeWidget(tile)
        tile.hide()
        tile.deleteLater()
        self._arrange()

    def _arrange(self) -> None:
        self.setVisible(bool(self._tiles))
        self.filled.emit(bool(self._tiles))
