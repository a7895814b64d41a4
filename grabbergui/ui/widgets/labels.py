"""Labels: elided where there is little room, styled by their state; columns, hints, tasks."""

from __future__ import annotations

import re
from collections.abc import Sequence

from PyQt5.QtCore import QEvent, QSize, Qt
from PyQt5.QtGui import (
    QFont,
    QFontMetrics,
    QHelpEvent,
    QPainter,
    QPaintEvent,
    QPalette,
    QResizeEvent,
    QTextLayout,
    QTextOption,
)
from PyQt5.QtWidgets import (
    QComboBox,
    QLabel,
    QStyle,
    QStyleOption,
    QStyleOptionComboBox,
    QStylePainter,
    QWidget,
)

from grabbergui.models.markup import Markup, joined, markup
from grabbergui.ui.shown_text import PlainLabel, set_tooltip, show_tooltip

TEXT_MARGIN = 1
"Pixels that styles leave before a combo box's text."
MOST_LINES = 3
"Most lines of a name; of a longer one the middle is left out."
_BREAKS = re.compile("(\\s+|\N{ZERO WIDTH SPACE})")
"Where Qt breaks a text into lines."


def restyle(widget: QWidget, name: str, value: object) -> None:
    """Set a property that the style sheet knows, such as `tone`, and apply the style sheet again."""
    if widget.property(name) != value:
        widget.setProperty(name, value)
        # A style sheet looks at properties only when a widget is polished.
        if (style := widget.style()) is not None:
            style.unpolish(widget)
            style.polish(widget)


def set_verdict(label: QLabel, text: str, tone: str) -> None:
    """Show the verdict on an image after a dot, in a tone of the style sheet: good, busy, bad or idle."""
    label.setText(f"● {text}")
    set_tooltip(label, text)
    restyle(label, "tone", tone)


def steps_markup(names: Sequence[str], current: int) -> Markup:
    """Return the numbered steps of a wizard in one line, the current one bold."""
    steps = [f"{number} {name}" for number, name in enumerate(names, 1)]
    steps[current] = markup("<b>{0}</b>", steps[current])
    return joined(steps, " &nbsp;→&nbsp; ")


def name_lines(name: str, font: QFont, width: int) -> list[str]:
    """Break a name into lines of at most `width` pixels, between words if possible."""
    text, room = name, MOST_LINES * width
    while len(lines := _broken_lines(text, font, width)) > MOST_LINES and room > width:
        text = QFontMetrics(font).elidedText(name, Qt.TextElideMode.ElideMiddle, room)
        room -= width // 8 + 1
    return lines


def _broken_lines(text: str, font: QFont, width: int) -> list[str]:
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


class ElidedLabel(PlainLabel):
    """One line of plain text; the whole of it is in the tooltip.

    Of a camera's name the middle is left out: the serial number at its end distinguishes it from the others.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent=parent)
        self._shorter: tuple[str, ...] = ()
        self.setMinimumWidth(24)
        self.elide_mode = Qt.TextElideMode.ElideRight

    def setText(self, text: str | None) -> None:
        """Show a text."""
        self.setTexts(text or "")

    def setTexts(self, text: str, *shorter: str) -> None:
        """Show a text, or the first of the shorter ones that fits."""
        self._shorter = shorter
        super().setText(text)
        set_tooltip(self, text)

    @property
    def shown(self) -> str:
        """The text that is painted, elided if none fits."""
        metrics, texts = self.fontMetrics(), (self.text(), *self._shorter)
        fitting = (text for text in texts if metrics.horizontalAdvance(text) <= self.width())
        return next(fitting, metrics.elidedText(texts[-1], self.elide_mode, self.width()))

    def sizeHint(self) -> QSize:
        """Return hardly any width: the label takes the room that there is."""
        return QSize(24, super().sizeHint().height())

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Draw as much as fits, with an ellipsis for the rest."""
        painter, option = QPainter(self), QStyleOption()
        option.initFrom(self)
        style = self.style()
        if style is not None:
            enabled = bool(option.state & QStyle.StateFlag.State_Enabled)
            flags = int(Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft)
            style.drawItemText(
                painter, self.rect(), flags, option.palette, enabled, self.shown, self.foregroundRole()
            )


class WrappedLabel(PlainLabel):
    """Several lines of plain text. A word that is wider than the label ends in an ellipsis."""

    def __init__(self, text: str = "", parent: QWidget | None = None) -> None:
        super().__init__(parent=parent)
        self._whole = text
        self.setWordWrap(True)
        super().setText(text)

    def setText(self, text: str | None) -> None:
        """Show a text."""
        self._whole = text or ""
        self._fit()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Shorten words for the new width."""
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        room, metrics = self.contentsRect().width(), self.fontMetrics()
        parts = _BREAKS.split(self._whole)
        if self.wordWrap() and room > 0:
            parts = [metrics.elidedText(part, Qt.TextElideMode.ElideRight, room) for part in parts]
        if (text := "".join(parts)) != self.text():
            super().setText(text)


class ShrinkingLabel(ElidedLabel):
    """A line as wide as its text, elided only where the window is too narrow. The tooltip is the form's."""

    def setText(self, text: str | None) -> None:
        """Show a text."""
        QLabel.setText(self, text)

    def sizeHint(self) -> QSize:
        """Return the size of the whole text."""
        return QLabel.sizeHint(self)


class ElidedComboBox(QComboBox):
    """A combo box whose current text is elided if it does not fit; the tooltip then is the whole text."""

    @property
    def shown(self) -> str:
        """The text that is painted."""
        option, style = QStyleOptionComboBox(), self.style()
        self.initStyleOption(option)
        if style is None:
            return self.currentText()
        field = QStyle.SubControl.SC_ComboBoxEditField
        room = style.subControlRect(QStyle.ComplexControl.CC_ComboBox, option, field, self).width()
        text, metrics = self.currentText(), self.fontMetrics()
        # Styles ask for as much room as the letters take, which is less than the advance that Qt elides by.
        if metrics.boundingRect(text).right() + TEXT_MARGIN < room:
            return text
        return metrics.elidedText(text, Qt.TextElideMode.ElideRight, room - TEXT_MARGIN)

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Draw as much of the text as fits."""
        if self.isEditable():
            super().paintEvent(event)
            return
        painter, option = QStylePainter(self), QStyleOptionComboBox()
        self.initStyleOption(option)
        if option.currentText:
            option.currentText = self.shown
        elif self.placeholderText():
            option.palette.setBrush(QPalette.ColorRole.ButtonText, option.palette.placeholderText())
            option.currentText = self.placeholderText()
        painter.drawComplexControl(QStyle.ComplexControl.CC_ComboBox, option)
        painter.drawControl(QStyle.ControlElement.CE_ComboBoxLabel, option)

    def event(self, event: QEvent | None) -> bool:
        """Show the whole text as the tooltip if it is elided."""
        hidden = not self.isEditable() and self.shown != self.currentText()
        if hidden and isinstance(event, QHelpEvent) and event.type() == QEvent.Type.ToolTip:
            show_tooltip(event.globalPos(), self.currentText(), self)
            return True
        return super().event(event)
