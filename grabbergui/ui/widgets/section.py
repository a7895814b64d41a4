"""Sections of a panel that fold, and are filled over several turns of the event loop."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator

from PyQt5.QtCore import QObject, Qt, QTimer, pyqtSignal
from PyQt5.QtGui import QResizeEvent
from PyQt5.QtWidgets import QSizePolicy, QToolButton, QVBoxLayout, QWidget

from grabbergui.core.features import Category, FeatureDescription
from grabbergui.ui.editors.feature_row import FeatureRow

TURN = 0.008
"""Seconds of work in one turn; half a frame of a 60 Hz screen."""


class Pacer(QObject):
    """Does jobs in order, a few milliseconds a turn, so that painting and the hand come between.

    A newer job of the same key takes the place of the waiting one.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._jobs: OrderedDict[Hashable, Callable[[], None]] = OrderedDict()
        self._timer = QTimer(self)
        self._timer.setInterval(0)
        self._timer.timeout.connect(self._on_timer_timeout)

    def add(self, key: Hashable, job: Callable[[], None]) -> None:
        """Do `job` in one of the next turns."""
        self._jobs[key] = job
        if not self._timer.isActive():
            self._timer.start()

    def clear(self) -> None:
        """Forget what waits."""
        self._jobs.clear()
        self._timer.stop()

    @property
    def idle(self) -> bool:
        """Whether nothing waits."""
        return not self._jobs

    def _on_timer_timeout(self) -> None:
        deadline = time.perf_counter() + TURN
        while self._jobs and time.perf_counter() < deadline:
            _, job = self._jobs.popitem(last=False)
            job()
        if not self._jobs:
            self._timer.stop()


MakeRow = Callable[[FeatureDescription, QWidget, bool], FeatureRow]
"""Makes a row from a description, its parent, and whether it stands below its selector."""


class _Header(QToolButton):
    """A category's title and whether it is open; shortened where there is no room for all of it."""

    def __init__(self, category: Category) -> None:
        super().__init__()
        self._title = category.title
        self.setAccessibleName(category.title)
        self.setToolTip("\n".join(text for text in (category.title, category.tooltip) if text))
        self.setAutoRaise(True)
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        font = self.font()
        font.setBold(True)
        self.setFont(font)
        self.setText(self._title)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Fit the title."""
        room = self.width() - 2 * self.iconSize().width()
        self.setText(self.fontMetrics().elidedText(self._title, Qt.TextElideMode.ElideRight, room))
        super().resizeEvent(event)


class Section(QWidget):
    """A header and, below it, rows and further sections.

    superqt's QCollapsible fixes the height of what it holds, to animate it; here the content grows.
    """

    toggled = pyqtSignal()
    """A person opened or closed this section or one below."""

    def __init__(
        self,
        category: Category,
        make_row: MakeRow,
        pacer: Pacer,
        opened: frozenset[str] = frozenset(),
        parent: QWidget | None = None,
    ) -> None:
        """Open at first where it holds a feature of `opened`."""
        super().__init__(parent)
        self.category = category
        self._opened = opened
        self.names = frozenset(description.name for description in category.descriptions())
        self._own = {m.name for m in category.members if not isinstance(m, Category)}
        self._make_row = make_row
        self._pacer = pacer
        self._parts: dict[int, Section | FeatureRow] = {}
        self._shown: frozenset[str] = frozenset()
        self._searching = False
        self.header = _Header(category)
        self.header.clicked.connect(self._on_header_clicked)
        self._open = bool(self.names & opened)
        self._body = QWidget()
        self._body_layout = QVBoxLayout(self._body)
        self._body_layout.setContentsMargins(10, 2, 0, 6)
        self._body_layout.setSpacing(2)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.header)
        layout.addWidget(self._body)
        self._update_open()

    def removeHeader(self) -> None:
        """Be open for ever, without header or margins: the root of a tree."""
        self.setOpen(True)
        self.header.hide()
        self._body_layout.setContentsMargins(0, 0, 0, 0)

    @property
    def open(self) -> bool:
        """Whether the rows can be seen: opened by a person, or because something below was searched for."""
        return self._searching or self._open

    def setOpen(self, opened: bool) -> None:
        """Open or close; `arrange` follows."""
        self._open = opened

    def arrange(self, shown: frozenset[str], searching: bool) -> None:
        """Show the features of these names, and no others; all open while somebody searches."""
        self._shown = shown & self.names
        self._searching = searching
        self.setVisible(bool(self._shown))
        self._update_open()
        if not self._shown:
            return
        for index, member in enumerate(self.category.members):
            if isinstance(member, Category):
                self._arrange_section(index, member)
            else:
                self._arrange_row(index, member)

    def names_on_show(self) -> Iterator[str]:
        """Names of the features whose rows can be seen, also those not made yet."""
        if not self.open:
            return
        for index, member in enumerate(self.category.members):
            part = self._parts.get(index)
            if isinstance(part, Section):
                yield from part.names_on_show()
            elif member.name in self._shown:
                yield member.name

    def _arrange_section(self, index: int, category: Category) -> None:
        part = self._parts.get(index)
        if part is None and self.open:
            part = Section(category, self._make_row, self._pacer, self._opened, self._body)
            part.toggled.connect(self.toggled)
            self._place(index, part)
        if isinstance(part, Section):
            part.arrange(self._shown, self._searching)

    def _arrange_row(self, index: int, description: FeatureDescription) -> None:
        shown = description.name in self._shown
        part = self._parts.get(index)
        if part is not None:
            part.setVisible(shown)
        elif shown and self.open:
            self._pacer.add((self, index), lambda: self._build_row(index, description))

    def _build_row(self, index: int, description: FeatureDescription) -> None:
        if index in self._parts or not self.open or description.name not in self._shown:
            return
        indented = any(selector in self._own for selector in description.selectors)
        self._place(index, self._make_row(description, self._body, indented))

    def _place(self, index: int, part: Section | FeatureRow) -> None:
        position = sum(1 for other in self._parts if other < index)
        self._parts[index] = part
        # Below what can be seen until the layout has a place for it: a window may be painted before that,
        # and new rows would be painted over each other.
        part.move(0, self._body.height())
        self._body_layout.insertWidget(position, part)
        part.show()

    def _update_open(self) -> None:
        self.header.setArrowType(Qt.ArrowType.DownArrow if self.open else Qt.ArrowType.RightArrow)
        self._body.setVisible(self.open)

    def _on_header_clicked(self) -> None:
        self.setOpen(not self._open)
        self.toggled.emit()
