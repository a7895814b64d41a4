"""The top of the main window: menus, tools and recording in one line, or in two where that is too narrow."""

from __future__ import annotations

from PyQt5.QtCore import QEvent, Qt
from PyQt5.QtGui import QResizeEvent
from PyQt5.QtWidgets import QGridLayout, QMenuBar, QToolBar, QWidget

from grabbergui.ui.views.recording_bars import NARROW, RecordingBar

ARROW = 6
"Pixels at the end of the tool bar that Qt does not reserve for its whole arrow."


class WindowHeader(QWidget):
    """Gives the tool bar a line of its own only if the window is too narrow for one line of everything."""

    def __init__(self, menus: QMenuBar, tools: QToolBar, recording: RecordingBar) -> None:
        super().__init__()
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self._menus, self._tools = menus, tools
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setSpacing(0)
        self._grid.setColumnStretch(2, 1)
        self._grid.addWidget(menus, 0, 0, Qt.AlignmentFlag.AlignVCenter)
        self._grid.addWidget(recording, 0, 2)
        self._lines = 0
        self._arrange(1)
        tools.setContentsMargins(0, 0, ARROW, 0)
        tools.show()

    @property
    def lines(self) -> int:
        """The number of lines, 1 or 2."""
        return self._lines

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Choose one line or two for the new width."""
        super().resizeEvent(event)
        self._choose()

    def event(self, event: QEvent | None) -> bool:
        """Choose again when a part needs another width, as in another language or style."""
        if event is not None and event.type() == QEvent.Type.LayoutRequest:
            self._choose()
        return super().event(event)

    def _choose(self) -> None:
        needed = self._menus.sizeHint().width() + self._tools.sizeHint().width()
        self._arrange(1 if needed + NARROW <= self.width() else 2)

    def _arrange(self, lines: int) -> None:
        if lines != self._lines:
            self._lines = lines
            self._grid.removeWidget(self._tools)
            if lines == 1:
                self._grid.addWidget(self._tools, 0, 1, Qt.AlignmentFlag.AlignVCenter)
            else:
                self._grid.addWidget(self._tools, 1, 0, 1, 3)
