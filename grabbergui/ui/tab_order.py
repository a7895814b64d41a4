"""The order in which Tab visits controls: the reading order, also through controls that were made later.

Qt's own order is the order of creation, and `setTabOrder` does not handle compound widgets.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtWidgets import (
    QScrollArea,
    QWidget,
)

LINE_HEIGHT = 12
"Pixels of height within which controls stand on one line."


def reading_order(regions: Sequence[QWidget]) -> list[QWidget]:
    """Return the controls that take the Tab key: region by region, in each line by line from the left."""
    return [widget for region in regions if region.isVisible() for widget in _lines(region)]


def give_focus(regions: Sequence[QWidget], at: QWidget | None, *, forward: bool) -> bool:
    """Give the focus to the control after `at`, or before it. Return False if there is none."""
    order = reading_order(regions)
    if not order:
        return False
    known = at
    while known is not None and known not in order:
        known = known.parentWidget()
    step = 1 if forward else -1
    index = (order.index(known) + step) % len(order) if known is not None else 0
    reason = Qt.FocusReason.TabFocusReason if forward else Qt.FocusReason.BacktabFocusReason
    order[index].setFocus(reason)
    _bring_into_view(order[index])
    return True


def _lines(region: QWidget) -> list[QWidget]:
    places = []
    for widget in region.findChildren(QWidget):
        if _takes_tab(widget):
            middle = widget.mapTo(region, QPoint(0, widget.height() // 2))
            places.append((middle.y(), middle.x(), widget))
    places.sort(key=lambda place: place[:2])
    line, last = 0, None
    numbered = []
    for y, x, widget in places:
        if last is not None and y - last >= LINE_HEIGHT:
            line += 1
        if last is None or y - last >= LINE_HEIGHT:
            last = y
        numbered.append((line, x, widget))
    ordered: list[QWidget] = []
    for _, on_line in groupby(numbered, key=lambda place: place[0]):
        ordered += [widget for _, _, widget in sorted(on_line, key=lambda place: place[1])]
    return ordered


def _takes_tab(widget: QWidget) -> bool:
    takes = widget.focusPolicy() & Qt.FocusPolicy.TabFocus and widget.focusProxy() is None
    # A scroll area itself is of no use to the keyboard where its content takes the focus.
    return bool(takes) and widget.isVisible() and widget.isEnabled() and not isinstance(widget, QScrollArea)


def _bring_into_view(widget: QWidget) -> None:
    above = widget.parentWidget()
    while above is not None:
        if isinstance(above, QScrollArea):
            above.ensureWidgetVisible(widget)
        above = above.parentWidget()
