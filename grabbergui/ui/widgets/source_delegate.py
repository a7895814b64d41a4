"""Paints a source in the list: its name, kind and address, and why it cannot be opened."""

from __future__ import annotations

from PyQt5.QtCore import QCoreApplication, QModelIndex, QRect, QSize, Qt
from PyQt5.QtGui import QColor, QFont, QFontMetrics, QPainter, QPalette, QTextLayout, QTextOption
from PyQt5.QtWidgets import QAbstractItemView, QStyle, QStyledItemDelegate, QStyleOptionViewItem

from grabbergui.models.sources import ListedSource

translate = QCoreApplication.translate

SOURCE_ROLE = Qt.ItemDataRole.UserRole + 1
CURRENT_ROLE = Qt.ItemDataRole.UserRole + 2

PADDING = 9
LINE_GAP = 2
RADIUS = 6
_SIDES = 2 * PADDING + 5
"Pixels of a line's width that text does not have."
MOST_LINES = 3
"Of a name; of a longer one the middle is left out."


class SourceDelegate(QStyledItemDelegate):
    """Name, details, and the reason a source cannot be opened; a bar marks the one that is open.

    The name is whole, on several lines where it is long, so that no two cameras seem the same.
    """

    def sizeHint(self, option: QStyleOptionViewItem, index: QModelIndex) -> QSize:
        """As high as its lines."""
        title, small = _fonts(option.font)
        source: ListedSource = index.data(SOURCE_ROLE)
        view = option.widget
        viewport = view.viewport() if isinstance(view, QAbstractItemView) else None
        width = (viewport.width() if viewport is not None else 200) - _SIDES
        height = len(name_lines(_title(source), title, width)) * QFontMetrics(title).height()
        height += len(_details(source)) * (QFontMetrics(small).height() + LINE_GAP)
        if source.info.note:
            height += _wrapped(QFontMetrics(small), source.info.note, width) + LINE_GAP
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
        hindered = bool(source.info.note)
        ink = palette.color(QPalette.Disabled if hindered else QPalette.Active, QPalette.Text)
        line = QRect(card.x() + PADDING + 3, card.y() + PADDING - 2, card.width() - 2 * PADDING - 3, 0)
        for part in name_lines(_title(source), title, line.width()):
            line = _text(painter, line, title, ink, part, gap=0)
        line.translate(0, LINE_GAP)
        muted = palette.color(QPalette.PlaceholderText)
        for detail in _details(source):
            line = _text(painter, line, small, ink if hindered else muted, detail)
        if hindered:
            line.setBottom(card.bottom())
            painter.setPen(palette.color(QPalette.Active, QPalette.Text))
            painter.drawText(line, Qt.TextFlag.TextWordWrap, source.info.note)
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


def _title(source: ListedSource) -> str:
    """The vendor stands below, so that there is space for the serial number."""
    return source.info.short_title


def _details(source: ListedSource) -> list[str]:
    info = source.info
    named = info.model if info.user_name else ""
    maker = " ".join(part for part in (info.vendor, named) if part)
    shown_above = not info.serial or info.serial in _title(source)
    serial = "" if shown_above else translate("SourceDelegate", "serial {0}").format(info.serial)
    place = " · ".join(part for part in (_bus(info.bus), info.address) if part)
    options = info.uri.partition("?")[2]
    state = ""
    if source.lost:
        state = translate("SourceDelegate", "lost, reconnecting")
    elif source.connected:
        state = translate("SourceDelegate", "connected")
    elif source.manual:
        state = translate("SourceDelegate", "named by hand")
    lines = [" · ".join(part for part in (maker, serial) if part), place, options, state]
    return [line for line in lines if line and line != _title(source)]


def _bus(name: str) -> str:
    """Names of standards stay; words are in the user's language."""
    words = {
        "Simulated": translate("SourceDelegate", "Simulated"),
        "File": translate("SourceDelegate", "File"),
    }
    return words.get(name, name)


def _wrapped(metrics: QFontMetrics, text: str, width: int) -> int:
    """How high a text is in lines of that width."""
    return metrics.boundingRect(QRect(0, 0, width, 1000), Qt.TextFlag.TextWordWrap, text).height()


def _fonts(font: QFont) -> tuple[QFont, QFont]:
    title, small = QFont(font), QFont(font)
    title.setWeight(QFont.DemiBold)
    small.setPointSizeF(font.pointSizeF() * 0.9)
    return title, small


def name_lines(name: str, font: QFont, width: int) -> list[str]:
    """Break a name into lines of that many pixels at most, between words where there are any."""
    text, room = name, MOST_LINES * width
    while len(lines := _broken(text, font, width)) > MOST_LINES and room > width:
        text = QFontMetrics(font).elidedText(name, Qt.TextElideMode.ElideMiddle, room)
        room -= width // 8 + 1
    return lines


def _broken(text: str, font: QFont, width: int) -> list[str]:
    layout = QTextLayout(text, font)
    option = QTextOption()
    option.setWrapMode(QTextOption.WrapMode.WrapAtWordBoundaryOrAnywhere)
    layout.setTextOption(option)
    lines = []
    layout.beginLayout()
    while (line := layout.createLine()).isValid():
        line.setLineWidth(max(width, 1))
        lines.append(text[line.textStart() : line.textStart() + line.textLength()].strip())
    layout.endLayout()
    return lines


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
