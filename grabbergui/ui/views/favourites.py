"""The pinned controls above the image."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

from PyQt5.QtCore import QEvent, QLine, QMargins, QPoint, QSize, pyqtSignal
from PyQt5.QtGui import (
    QDragEnterEvent,
    QDragLeaveEvent,
    QDragMoveEvent,
    QDropEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QResizeEvent,
)
from PyQt5.QtWidgets import QGridLayout, QLabel, QScrollArea, QWidget

from grabbergui.core.features import Feature, FeatureDescription
from grabbergui.ui.editors.feature_row import CARD_WIDTH, FeatureRow, FeatureRows, dragged_feature
from grabbergui.ui.form_loader import load_form

LINE_HEIGHT = 36
"Height of a line of controls in pixels, with its margins."
MOST_WIDTH = 620
"Most width of a control in pixels; more is left free."


class FavouritesStrip(QWidget):
    """Some features side by side, larger than in the panel. Other features can be dropped among them."""

    dropped = pyqtSignal(str, int)
    """The name of a dropped feature, and the index of the card before which it was dropped."""

    cards: QGridLayout
    hintLabel: QLabel

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("favourites", self)
        self.rows = FeatureRows(self)
        """Every row; signals report what the user does in them."""
        self.shownCards: list[FeatureRow] = []
        "The cards of the current camera, in their order."
        self._camera: Hashable = None
        self._pages: dict[Hashable, tuple[tuple[FeatureDescription, ...], list[FeatureRow]]] = {}
        "Cards of cameras that may be shown again, and the features they are of."
        self._widths: list[int] = []
        "Least width of each column of cards."
        self._place: int | None = None
        "Index of the card before which the dragged feature would go."
        self._hint = self.hintLabel.text()
        "Text that explains the empty strip while no source is open."
        self.setAcceptDrops(True)

    def setFavourites(self, descriptions: Sequence[FeatureDescription], camera: Hashable = None) -> None:
        """Show these features, left to right. The cards of a `camera` are kept until `forget`."""
        for row in self.shownCards:
            self.cards.removeWidget(row)
            row.hide()
        if self._camera is None:
            self.forget(None)
        self._camera = camera
        known, self.shownCards = self._pages.get(camera, ((), []))
        if known != tuple(descriptions):
            self.forget(camera)
            self.rows.turnTo(camera)
            self.shownCards = [self._card(description) for description in descriptions]
            self._pages[camera] = tuple(descriptions), self.shownCards
        self.rows.turnTo(camera)
        self._arrange()
        for row in self.shownCards:
            row.show()
        pin = self.tr("Drag the name of a feature here to pin it above the image.")
        self.hintLabel.setText(self._hint if camera is None else pin)
        self.hintLabel.setVisible(not descriptions)

    def forget(self, camera: Hashable) -> None:
        """Delete the cards of a camera."""
        _, cards = self._pages.pop(camera, ((), []))
        self.rows.forget(camera)
        for card in cards:
            self.cards.removeWidget(card)
            card.hide()
            card.deleteLater()
        if cards is self.shownCards:
            self.shownCards = []

    def setFeature(self, feature: Feature) -> None:
        """Show a feature that is among the favourites, or the automatic mode of one."""
        self.rows.setFeature(feature)

    def minimumSizeHint(self) -> QSize:
        """Return the width of one card: the others go to further lines."""
        # As high as its cards or its hint, as is the area around it, which would scroll otherwise.
        return QSize(CARD_WIDTH, super().minimumSizeHint().height())

    def heightsOfLines(self, width: int) -> list[int]:
        """Pixels of height that the first line of cards needs in that width, the first two, … all of them."""
        margins, columns = self._margins(), len(self._fitting(width))
        cards = self.shownCards
        height, heights = margins.top() + margins.bottom(), []
        for index in range(0, len(cards), columns):
            height += max(card.sizeHint().height() for card in cards[index : index + columns])
            heights.append(height)
            height += self.cards.verticalSpacing()
        return heights or [self.sizeHint().height()]

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Fill the lines again for the new width."""
        super().resizeEvent(event)
        self._adapt()

    def event(self, event: QEvent | None) -> bool:
        """Fill the lines again when a card needs another width, as once its automatic mode is known."""
        if event is not None and event.type() == QEvent.Type.LayoutRequest:
            self._adapt()
        return super().event(event)

    def dragEnterEvent(self, event: QDragEnterEvent | None) -> None:
        """Accept features only."""
        if event is not None and dragged_feature(event):
            event.acceptProposedAction()

    def dragMoveEvent(self, event: QDragMoveEvent | None) -> None:
        """Show where the feature would be dropped."""
        if event is not None and dragged_feature(event):
            event.acceptProposedAction()
            self._show_place(self.place_at(event.pos()))

    def dragLeaveEvent(self, event: QDragLeaveEvent | None) -> None:
        """Remove the mark."""
        self._show_place(None)

    def dropEvent(self, event: QDropEvent | None) -> None:
        """Emit `dropped` with the name and the place."""
        self._show_place(None)
        if event is not None and (name := dragged_feature(event)):
            event.acceptProposedAction()
            self.dropped.emit(name, self.place_at(event.pos()))

    def place_at(self, position: QPoint) -> int:
        """Return the index of the card before which a position is; their number at the end."""
        for index, card in enumerate(self.shownCards):
            box = card.geometry()
            below = position.y() > box.bottom() + self.cards.verticalSpacing()
            if not below and position.x() < box.center().x():
                return index
            last_of_line = (index + 1) % len(self._widths) == 0
            if not below and last_of_line:
                return index + 1
        return len(self.shownCards)

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Draw the place where the feature would be dropped."""
        super().paintEvent(event)
        if self._place is None or not self.shownCards:
            return
        at_end = self._place >= len(self.shownCards)
        box = self.shownCards[-1 if at_end else self._place].geometry()
        gap = self.cards.horizontalSpacing() // 2
        x = box.right() + gap if at_end else max(1, box.left() - gap)
        painter = QPainter(self)
        painter.setPen(QPen(self.palette().highlight().color(), 2))
        painter.drawLine(QLine(x, box.top(), x, box.bottom()))
        painter.end()

    def _show_place(self, place: int | None) -> None:
        self._place = place
        self.update()

    def _margins(self) -> QMargins:
        layout = self.layout()
        return layout.contentsMargins() if layout is not None else self.contentsMargins()

    def _fitting(self, width: int) -> list[int]:
        """Return the least widths of as many columns of cards as fit beside each other in that width."""
        margins, gap = self._margins(), self.cards.horizontalSpacing()
        room = width - margins.left() - margins.right()
        least = [card.leastWidth() for card in self.shownCards]
        for columns in range(len(least), 1, -1):
            widths = [max(least[column::columns]) for column in range(columns)]
            if sum(widths) + gap * (columns - 1) <= room:
                return widths
        return [min(max(least, default=CARD_WIDTH), max(room, 0))]

    def _adapt(self) -> None:
        if self._fitting(self.width()) != self._widths:
            self._arrange()

    def _arrange(self) -> None:
        before, self._widths = len(self._widths), self._fitting(self.width())
        for column in range(max(before, len(self._widths)) + 1):
            # Sliders, which get what is left, are about as long as each other.
            self.cards.setColumnStretch(column, self._widths[column] if column < len(self._widths) else 0)
        self.cards.setColumnStretch(len(self._widths), 1)  # on a large screen, what no control may have
        for index, card in enumerate(self.shownCards):
            line, column = divmod(index, len(self._widths))
            card.setMinimumWidth(min(card.leastWidth(), self._widths[column]))
            self.cards.addWidget(card, line, column)
        self.updateGeometry()

    def _card(self, description: FeatureDescription) -> FeatureRow:
        row = self.rows.make(description, self)
        row.standBesideOthers()
        row.setMaximumWidth(MOST_WIDTH)
        row.move(0, self.height())  # not over the others, until the layout has a place for it
        row.show()
        return row


class FavouritesArea(QScrollArea):
    """As high as all lines of pinned controls; with little room it is lower, and scrolls."""

    def sizeHint(self) -> QSize:
        """Return the height of all lines."""
        return QSize(CARD_WIDTH, self._lines()[-1])

    def minimumSizeHint(self) -> QSize:
        """Return room for a card and the scroll bar."""
        bar = self.verticalScrollBar()
        return QSize(CARD_WIDTH + (bar.sizeHint().width() if bar is not None else 0), self._lines()[0])

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Adapt to the width, in which the controls may need another number of lines."""
        super().resizeEvent(event)
        if event is not None and event.size().width() != event.oldSize().width():
            self.updateGeometry()

    def viewportEvent(self, event: QEvent | None) -> bool:
        """Adapt to the controls, which may need another height."""
        if event is not None and event.type() == QEvent.Type.LayoutRequest:
            self.updateGeometry()
        return super().viewportEvent(event)

    def _lines(self) -> list[int]:
        strip = self.widget()
        # Without the scroll bar: whether it is needed must not depend on its width.
        return strip.heightsOfLines(self.width()) if isinstance(strip, FavouritesStrip) else [LINE_HEIGHT]
