"""Where the panels of the main window are, until the user moves one: what a size of window has room for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum

from PyQt5.QtCore import QEvent, QObject, QSize, Qt, QTimer
from PyQt5.QtGui import QResizeEvent
from PyQt5.QtWidgets import QDockWidget, QMainWindow, QWidget

LEAST_WIDTH = 1200
"Pixels of a window's width, below which sources and features are tabs instead of one above the other."
LEAST_PANEL, LEAST_TOOL = 300, 230
"Pixels of a window's height for sources and for features, and for a tool below them."
LEAST_COLUMN, MOST_COLUMN, COLUMN_SHARE = 280, 390, 0.22
"Width of the panels beside the image: pixels, and share of the window's width."
VAST_SHARE = 0.14
"Share of a window's width that they may have beyond `MOST_COLUMN`, on screens of 4K without scaling."
SOURCES_SHARE, TOOLS_SHARE = 0.5, 0.26
"Shares of the window's height: most for the sources, usual for the tools."
BELOW_SHARE = 0.4
"Share of a tall window's height for the panels below the image."
SLACK = 24
"Pixels by which Qt may miss the height that a panel is given; a user drags further."


class PanelArrangement(Enum):
    """Places of the panels; the values are kept in settings."""

    STACKED = "stacked"
    "Beside the image: sources, features below them, and the tools as tabs at the bottom."
    TABS = "tabs"
    "Beside the image: sources and features as tabs, and the tools as tabs at the bottom."
    ONE = "one"
    "Beside the image: all as tabs of one group."
    BELOW = "below"
    "Below the image, in a window higher than wide: sources and features as tabs, the tools as others."
    OWN = "own"
    "Where the user put them."


def arrangement_for(size: QSize, *, tool: bool) -> PanelArrangement:
    """Return the arrangement for a window of that size; `tool` is whether a panel of tools is shown."""
    if size.height() > size.width():
        return PanelArrangement.BELOW
    room = size.height() - LEAST_TOOL * tool
    if size.width() >= LEAST_WIDTH and room >= 2 * LEAST_PANEL:
        return PanelArrangement.STACKED
    return PanelArrangement.TABS if room >= LEAST_PANEL else PanelArrangement.ONE


def column_width(window: int) -> int:
    """Return the width of the panels beside the image for a window of that width, in pixels."""
    most = max(MOST_COLUMN, round(window * VAST_SHARE))
    return min(most, max(LEAST_COLUMN, round(window * COLUMN_SHARE)))


class PanelLayout(QObject):
    """Arranges the panels for the window's size, as long as the user has not moved any.

    Qt lays out all else: it keeps the widths that the user drags, and gives the image what is left.
    """

    _CAUSES = ((QEvent.Type.ShowToParent, QEvent.Type.HideToParent), (QEvent.Type.Resize, QEvent.Type.Show))
    "Events of a panel, and of the window, after which another arrangement may suit."

    def __init__(
        self,
        window: QMainWindow,
        sides: tuple[QDockWidget, QDockWidget],
        tools: Sequence[QDockWidget],
        cards_cut: Callable[[int], int],
    ) -> None:
        """`sides` are sources and features; of the `tools` below them, only one is seen at a time.

        `cards_cut` returns the height of the last cards of the sources that take at least so many pixels.
        """
        super().__init__(window)
        self._cards_cut = cards_cut
        self._window, self._sides, self._tools = window, sides, tuple(tools)
        self._docks = (*sides, *tools)
        self._shown: PanelArrangement | None = None
        self._busy = False
        "Whether docks move because of this class, not of the user."
        self._arranged_width = 0
        "Width of the window for which the column beside the image was last given its width."
        self._sources_height = 0
        "Height that the sources were last given."
        self._height = 0
        "Height of the window when the panels were last looked at."
        self._stretched = False
        "Whether a new height of the window has changed that of the sources, which the user had not."
        self._column = 0
        "Width that the column was given then."
        self._opened = False
        "Whether the panels need other heights than before, which Qt shares out as it likes."
        for dock in self._docks:
            dock.dockLocationChanged.connect(self._on_dock_moved)
            dock.installEventFilter(self)
        window.installEventFilter(self)

    @property
    def arrangement(self) -> PanelArrangement | None:
        """The present arrangement; None until the window was laid out for the first time."""
        return self._shown

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Follow the size of the window, and the panels that are opened and closed."""
        if event is not None and event.type() in self._CAUSES[watched is self._window]:
            self._opened |= watched in self._tools
            QTimer.singleShot(0, self.adapt)  # once it is laid out
        elif event is not None and event.type() == QEvent.Type.LayoutRequest and watched is self._sides[0]:
            self._follow_sources()
        elif isinstance(event, QResizeEvent) and watched is self._sides[0]:
            as_given = abs(event.oldSize().height() - self._sources_height) < SLACK
            self._stretched |= as_given and self._window.height() != self._height
        return False

    def adapt(self) -> None:
        """Arrange the panels for the window's size; not those that the user has moved."""
        wanted = self._wanted()
        if self._shown not in (wanted, PanelArrangement.OWN) and not self._window.isFullScreen():
            self._arrange(wanted)
        elif self._opened or self._sources_are_odd():
            self._size()
            self._fit_column()
        else:
            self._fit_column()
        self._opened = self._stretched = False
        self._height = self._window.height()

    def fit(self, *_: object) -> None:
        """Give the panels their heights again, as another number of sources is open."""
        self._opened = True
        QTimer.singleShot(0, self.adapt)  # once it is laid out

    def restored(self, name: str) -> None:
        """Take over an arrangement that Qt restored, by its name in the settings."""
        self._shown = PanelArrangement(name) if name in {each.value for each in PanelArrangement} else None
        self.adapt()

    def reset(self) -> None:
        """Forget how the user moved the panels: show sources and features in their places, and no tools."""
        self._arranged_width = 0
        for dock in self._docks:
            dock.setFloating(False)
            dock.setVisible(dock in self._sides)
        self._arrange(self._wanted())

    def moving(self, busy: bool) -> None:
        """Count the docks' next moves as the program's (`busy`), or as the user's again."""
        self._busy = busy

    def _wanted(self) -> PanelArrangement:
        return arrangement_for(self._window.size(), tool=self._shows_tool())

    def _shows_tool(self) -> bool:
        return any(not dock.isHidden() and not dock.isFloating() for dock in self._tools)

    def _arrange(self, wanted: PanelArrangement) -> None:
        window, (sources, features), (first, *others) = self._window, self._sides, self._tools
        in_front = [dock for dock in self._docks if not dock.visibleRegion().isEmpty()]
        column = features.width()
        self._shown, self._busy = wanted, True
        below = wanted is PanelArrangement.BELOW
        area = Qt.DockWidgetArea.BottomDockWidgetArea if below else Qt.DockWidgetArea.RightDockWidgetArea
        docked = [dock for dock in self._docks if not dock.isFloating()]
        across = Qt.Orientation.Horizontal if below else Qt.Orientation.Vertical
        for dock in docked:
            window.addDockWidget(area, dock, across)
        for dock in docked:
            if dock in others and first in docked:
                window.tabifyDockWidget(first, dock)
            elif wanted is not PanelArrangement.STACKED and dock is features and sources in docked:
                window.tabifyDockWidget(sources, features)
        if wanted is PanelArrangement.ONE and first in docked:
            for dock in (first, *others):
                window.tabifyDockWidget(features, dock)
        for dock in (features, *in_front):
            dock.raise_()
        self._busy = False
        if window.width() != self._arranged_width:  # or the user may have dragged it
            column = self._usual_column()
        window.resizeDocks([features], [column], Qt.Orientation.Horizontal)
        QTimer.singleShot(0, self._size)  # once they are laid out

    def _usual_column(self) -> int:
        """Return the width of the panels beside the image for the window's width, and note both."""
        self._arranged_width = self._window.width()
        self._column = column_width(self._arranged_width)
        return self._column

    def _fit_column(self) -> None:
        """Let the column follow the window's width, as after *maximise*, unless the user dragged it."""
        window, features = self._window, self._sides[1]
        if self._shown in (None, PanelArrangement.OWN, PanelArrangement.BELOW) or window.isFullScreen():
            return
        if window.width() != self._arranged_width and features.width() == self._column:
            window.resizeDocks([features], [self._usual_column()], Qt.Orientation.Horizontal)

    def _size(self) -> None:
        """Give the panels their first heights; the user may drag them."""
        window, (sources, features), centre = self._window, self._sides, self._window.centralWidget()
        if centre is None or self._shown in (None, PanelArrangement.OWN, PanelArrangement.ONE):
            return
        if self._shown is PanelArrangement.BELOW:
            below = round(window.height() * BELOW_SHARE)
            window.resizeDocks([features], [below], Qt.Orientation.Vertical)
            return
        heights = {features: centre.height()}
        if self._shown is PanelArrangement.STACKED:
            heights[sources] = self._sources_height = self._usual_sources(centre)
        for dock in self._tools:
            if not dock.visibleRegion().isEmpty():
                heights[dock] = self._usual_tool(centre)
        heights[features] -= sum(list(heights.values())[1:])
        window.resizeDocks(list(heights), list(heights.values()), Qt.Orientation.Vertical)

    def _follow_sources(self) -> None:
        """Give the sources another height when there are more or fewer; the user may have changed it."""
        centre = self._window.centralWidget()
        if centre is not None and self._usual_sources(centre) != self._sources_height:
            self.fit()

    def _usual_sources(self, centre: QWidget) -> int:
        """Return the height for all sources, or for as many whole ones as leave the features room."""
        rest = centre.height() - self._usual_tool(centre) * self._shows_tool() - LEAST_PANEL
        needed = self._sides[0].sizeHint().height()
        return needed - self._cards_cut(needed - min(rest, round(centre.height() * SOURCES_SHARE)))

    def _usual_tool(self, centre: QWidget) -> int:
        return max(LEAST_TOOL, round(centre.height() * TOOLS_SHARE))

    def _sources_are_odd(self) -> bool:
        """Return whether a change of the window's size left the sources another height than the usual one."""
        centre, sources = self._window.centralWidget(), self._sides[0]
        if centre is None or self._shown is not PanelArrangement.STACKED or sources.isHidden():
            return False
        usual, height = self._usual_sources(centre), sources.height()
        return height < usual or usual != self._sources_height or (self._stretched and height > usual + SLACK)

    def _on_dock_moved(self, area: Qt.DockWidgetArea) -> None:
        if not self._busy and area != Qt.DockWidgetArea.NoDockWidgetArea:
            self._shown = PanelArrangement.OWN
