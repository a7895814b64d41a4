"""Text on the screen: the one place that decides whether Qt takes a text as plain or as rich.

Qt guesses: a label, a message box and every tooltip render text that looks like HTML, and load the pictures
it names from the disk, a device or a pipe. Cameras, peers and folders write such text. So labels of this
window show plain text, and tooltips are escaped; only a `Markup`, which this program wrote, is rich.

A test finds calls that bypass this module, and another shows a camera whose every text is HTML.
"""

from __future__ import annotations

from typing import Protocol

import pyqtgraph as pg
from PyQt5.QtCore import QObject, QPoint, Qt
from PyQt5.QtWidgets import (
    QAction,
    QInputDialog,
    QLabel,
    QMessageBox,
    QToolTip,
    QTreeWidgetItem,
    QWhatsThis,
    QWidget,
)

from grabbergui.models.markup import Markup, joined, markup
from grabbergui.ui.theme import icon_pixmap

QUESTION_SIZE = 32
"Logical pixels of the icon beside a question."
MOST_TIP = 4000
"Characters of a tooltip; it would otherwise take seconds to lay out and cover the screen."


_RICH = "richToolTip"
"The property of a widget or action whose tooltip is rich text that this module made."


class _HasToolTip(Protocol):
    """A widget, an action or an item."""

    def setToolTip(self, text: str | None) -> None: ...

    def toolTip(self) -> str: ...


def looks_rich(text: str) -> bool:
    """Return whether Qt takes a text for rich text where it guesses."""
    return bool(Qt.mightBeRichText(text))  # type: ignore[attr-defined]  # PyQt5's types lack it


def plain(text: str) -> str:
    """Return text that Qt shows as this text where it guesses; unchanged unless it looks like rich text."""
    if len(text) > MOST_TIP:
        text = f"{text[:MOST_TIP]}…"
    return markup("<p>{0}</p>", text) if looks_rich(text) else str(text)


def set_tooltip(target: _HasToolTip, text: str) -> None:
    """Set the tooltip of a widget, an action or an item."""
    shown = text if isinstance(text, Markup) else plain(text)
    target.setToolTip(shown)
    if isinstance(target, QObject):
        target.setProperty(_RICH, isinstance(shown, Markup))


def tooltip_of(target: QAction | QWidget) -> str:
    """Return a tooltip for `add_to_tooltip`; a `Markup` if `set_tooltip` made it rich.

    That of an action to which none was given is the action's text, which may come from outside.
    """
    return Markup(target.toolTip()) if target.property(_RICH) else target.toolTip()


def add_to_tooltip(target: QAction | QWidget, tooltip: str, text: str) -> None:
    """Set a tooltip from `tooltip_of`, with a text below it."""
    if isinstance(tooltip, Markup):
        set_tooltip(target, joined(filter(None, (tooltip, text)), "<br>"))
    else:
        set_tooltip(target, f"{tooltip}\n{text}".strip())


def set_cell_tooltip(row: QTreeWidgetItem, column: int, text: str) -> None:
    """Set the tooltip of a cell."""
    row.setToolTip(column, plain(text))


def show_tooltip(place: QPoint, text: str, widget: QWidget) -> None:
    """Show a tooltip at a place of the screen."""
    QToolTip.showText(place, plain(text), widget)


def show_explanation(place: QPoint, tooltip: str, widget: QWidget) -> None:
    """Show at a place of the screen what a widget is for; `tooltip` was set before."""
    QWhatsThis.showText(place, tooltip, widget)


class PlainLabel(QLabel):
    """A label that shows its text as it is. `load_form` makes those of forms the same."""

    def __init__(self, text: str = "", parent: QWidget | None = None) -> None:
        super().__init__(text, parent)
        make_plain(self)


def make_plain(label: QLabel) -> None:
    """Let a label show its text as it is."""
    label.setTextFormat(Qt.TextFormat.PlainText)


def set_rich(label: QLabel, text: Markup) -> None:
    """Show rich text in a label."""
    label.setTextFormat(Qt.TextFormat.RichText)
    label.setText(text)


def question_box(parent: QWidget, text: str, detail: str) -> QMessageBox:
    """Return a box that asks, still without buttons; `detail` is below the question in smaller letters."""
    box = QMessageBox(parent)
    box.setIconPixmap(icon_pixmap("question", box, QUESTION_SIZE))
    box.setTextFormat(Qt.TextFormat.PlainText)
    box.setText(text)
    box.setInformativeText(plain(detail))  # this label guesses whatever the box's format is
    return box


def input_box(parent: QWidget | None, title: str, text: str) -> QInputDialog:
    """Return a box that asks for a value, still without its kind."""
    box = QInputDialog(parent)
    box.setWindowTitle(title)
    box.setLabelText(plain(text))
    return box


def about_box(parent: QWidget, title: str, text: Markup) -> None:
    """Show a box about the program."""
    QMessageBox.about(parent, title, text)


def name_axis(plot: pg.PlotWidget, side: str, name: str) -> None:
    """Name an axis, which pyqtgraph would take as HTML."""
    plot.setLabel(side, markup("{0}", name))


def set_plot_title(plot: pg.PlotWidget, title: Markup) -> None:
    """Set the title above a plot, in small letters at its left."""
    plot.setTitle(title, size="9pt", justify="left")
