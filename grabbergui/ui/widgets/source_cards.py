"""The sources found as cards, in a list as high as all of them; what is around it scrolls."""

from __future__ import annotations

from PyQt5.QtCore import QModelIndex, QRect, QSize, Qt
from PyQt5.QtGui import QColor, QFont, QFontMetrics, QPainter, QPalette, QResizeEvent
from PyQt5.QtWidgets import (
    QAbstractItemView,
    QListWidget,
    QScrollArea,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QWidget,
)

from grabbergui.models.sources import ListedSource
from grabbergui.ui.widgets.labels import name_lines

SOURCE_ROLE = Qt.ItemDataRole.UserRole + 1
CURRENT_ROLE = Qt.ItemDataRole.UserRole + 2

PADDING = 9
LINE_GAP = 2
RADIUS = 6
_SIDES = 2 * PADDING + 5
"Pixels of a line's width that are not for text."


class SourceDelegate(QStyledItemDelegate):
    """Name, a line of details, and the reason a source cannot be opened; a bar marks the one that is open.

    The name is whole, on several lines where it is long, so that no two cameras seem the same. The details
    are one line, elided; the tooltip has all of them.
    """

    def sizeHint(self, option: QStyleOptionViewItem, index: QModelIndex) -> QSize:
        """Return the height of its lines."""
        title, small = _fonts(option.font)
        source: ListedSource = index.data(SOURCE_ROLE)
        view = option.widget
        viewport = view.viewport() if isinstance(view, QAbstractItemView) else None
        width = (viewport.width() if viewport is not None else 200) - _SIDES
        height = len(name_lines(source.info.short_title, title, width)) * QFontMetrics(title).height()
        height += QFontMetrics(small).height() + LINE_GAP
        if source.note:
            height += _wrapped(QFontMetrics(small), source.note, width) + LINE_GAP
        return QSize(120, height + 2 * PADDING)

    def paint(self, painter: QPainter | None, option: QStyleOptionViewItem, index: QModelIndex) -> None:
        """Draw one source."""
        if painter is None:
            return
        source: ListedSource = index.data(SOURCE_ROLE)
        palette = option.palette
        painter.save()
        painter.setRenderHint(QPainter.Antialiasing)
        card = option.rect.adjusted(1, 2, -1, -2)
        self._paint_back(painter, option, card, bool(index.data(CURRENT_ROLE)))
        title, small = _fonts(option.font)
        hindered = bool(source.note)
        ink = palette.color(QPalette.Disabled if hindered else QPalette.Active, QPalette.Text)
        line = QRect(card.x() + PADDING + 3, card.y() + PADDING - 2, card.width() - 2 * PADDING - 3, 0)
        for part in name_lines(source.info.short_title, title, line.width()):
            line = _text(painter, line, title, ink, part, gap=0)
        line.translate(0, LINE_GAP)
        muted = palette.color(QPalette.PlaceholderText)
        line = _text(painter, line, small, ink if hindered else muted, source.detail)
        if hindered:
            line.setBottom(card.bottom())
            painter.setPen(palette.color(QPalette.Active, QPalette.Text))
            painter.drawText(line, Qt.TextFlag.TextWordWrap, source.note)
        painter.restore()

    def _paint_back(
        self, painter: QPainter, option: QStyleOptionViewItem, card: QRect, current: bool
    ) -> None:
        accent = option.palette.color(QPalette.Highlight)
        if option.state & QStyle.StateFlag.State_Selected:
            fill = QColor(accent)
            fill.setAlphaF(0.18)
        else:
            fill = option.palette.color(QPalette.Base)
            if option.state & QStyle.StateFlag.State_MouseOver:
                fill = option.palette.color(QPalette.AlternateBase)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(fill)
        painter.drawRoundedRect(card, RADIUS, RADIUS)
        if current:
            painter.setBrush(accent)
            painter.drawRoundedRect(QRect(card.x(), card.y() + 6, 3, card.height() - 12), 1.5, 1.5)


def _wrapped(metrics: QFontMetrics, text: str, width: int) -> int:
    """Return the height of a text in lines of that width."""
    return metrics.boundingRect(QRect(0, 0, width, 1000), Qt.TextFlag.TextWordWrap, text).height()


def _fonts(font: QFont) -> tuple[QFont, QFont]:
    title, small = QFont(font), QFont(font)
    title.setWeight(QFont.DemiBold)
    small.setPointSizeF(font.pointSizeF() * 0.9)
    return title, small


def _text(painter: QPainter, line: QRect, font: QFont, ink: QColor, text: str, gap: int = LINE_GAP) -> QRect:
    """Draw one line and return where the next one begins."""
    metrics = QFontMetrics(font)
    painter.setFont(font)
    painter.setPen(ink)
    here = QRect(line.x(), line.y(), line.width(), metrics.height())
    painter.drawText(
        here,
        Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter,
        metrics.elidedText(text, Qt.TextElideMode.ElideRight, here.width()),
    )
    return here.translated(0, metrics.height() + gap)


class CardArea(QScrollArea):
    """Scrolls what is in it, and asks for as much height as that needs now: Qt's class asks once."""

    def sizeHint(self) -> QSize:
        """Return the size of its content."""
        content = self.widget()
        return content.sizeHint() if content is not None else super().sizeHint()


class SourceCards(QListWidget):
    """A list without a scroll bar of its own, as high as its cards."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setItemDelegate(SourceDelegate(self))
        self.setMouseTracking(True)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        if (viewport := self.viewport()) is not None:
            viewport.setAutoFillBackground(False)  # the cards lie on the window itself

    def sizeHint(self) -> QSize:
        """Return the height of all cards."""
        return QSize(super().sizeHint().width(), sum(self.heights()))

    def minimumSizeHint(self) -> QSize:
        """Return the same height: what is around the list scrolls."""
        return QSize(super().minimumSizeHint().width(), self.sizeHint().height())

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Ask for another height, as names wrap by the width."""
        super().resizeEvent(event)
        self.updateGeometry()

    def heights(self) -> list[int]:
        """Return the height of each card that is not hidden."""
        return [self.sizeHintForRow(row) for row in range(self.count()) if not self.isRowHidden(row)]
