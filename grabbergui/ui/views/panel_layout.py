"""Shares the room of the main window between the image, the parts above and below it, and the panels."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol, TypeVar

from PyQt5.QtCore import QByteArray, QEvent, QObject, QSize, Qt, QTimer
from PyQt5.QtGui import QResizeEvent
from PyQt5.QtWidgets import QWIDGETSIZE_MAX, QDockWidget, QMainWindow, QStyle, QTabBar, QToolBar, QWidget

from grabbergui.ui.screen import has_screen, screen_room
from grabbergui.ui.views.favourites import FavouritesArea
from grabbergui.ui.views.gallery import Gallery
from grabbergui.ui.views.image_view import ImageView

LEAST_IMAGE = 240
"Pixels of the image's height below which the tiles take less of it."
LOW_IMAGE = 150
"Pixels of the image's height below which pinned controls scroll."
LEAST_CENTRE = 380
"Width of the centre in pixels, below which the panels at the sides become narrower."
LEAST_TOOL = 150
"Pixels of the width to which the window may squeeze two panels beside each other."
Part = TypeVar("Part", bound=QWidget)
SETTLING_MS = 300
"Milliseconds until all panels are laid out again, with Qt's animations."


class Arranged(Protocol):
    """The parts of the main window that share its room."""

    centre: QWidget
    favouritesArea: FavouritesArea
    image: ImageView
    gallery: Gallery
    sourcesDock: QDockWidget
    featuresDock: QDockWidget
    histogramDock: QDockWidget
    focusDock: QDockWidget


class PanelLayout(QObject):
    """Watches the sizes of the window's parts, and adapts the others.

    In a low window tiles become compact and pinned controls scroll, so that the image keeps some height. In a
    narrow one the panels at the sides become narrower until it is wide again, and the focus aid moves behind
    the histogram. On a screen with too little room for all, the panels are tabs at the right side; on one
    that is too low even then, there are no tiles.
    """

    def __init__(self, window: QMainWindow, parts: Arranged) -> None:
        super().__init__(window)
        self._window = window
        self._parts = parts
        self._sides = (parts.sourcesDock, parts.featuresDock)
        self._tools = (parts.focusDock, parts.histogramDock)
        self._widths: dict[QDockWidget, int] = {}
        "Widths of the panels at the sides, as the user left them."
        self._restored: dict[QDockWidget, int] = {}
        "Such widths of a saved arrangement, until the window is laid out."
        self._settled_width = -1
        "Of the window, once its panels are laid out in it."
        self._squeezed: list[QWidget] = []
        "Panels that may become narrower than their controls, as the window does."
        self._places: QByteArray | None = None
        "Where the panels would be on a larger screen, while they are gathered at the right side."
        self._judging = QTimer(self)
        self._judging.setSingleShot(True)
        self._judging.timeout.connect(self.fit_screen)
        self._settling = QTimer(self)
        self._settling.setSingleShot(True)
        self._settling.timeout.connect(self._on_settling_timeout)
        for watched in (window, parts.centre, *self._sides, *self._tools):
            watched.installEventFilter(self)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Follow the sizes of the window's parts; remember how wide the sides are made by hand."""
        if event is None or event.type() not in (QEvent.Type.Resize, QEvent.Type.LayoutRequest):
            return False
        if watched is self._window:
            self._judging.start(0)  # once it is laid out
        centre = self._parts.centre
        if watched is centre:
            self._share_height()
        if not isinstance(event, QResizeEvent) or event.size().width() == event.oldSize().width():
            return False
        rests = self._places is None and self._window.width() == self._settled_width
        if watched is self._window:
            self._follow_window(event.oldSize(), event.size())
        elif watched is centre or watched in self._tools:
            QTimer.singleShot(0, self._keep_tools_usable)
        elif isinstance(watched, QDockWidget) and rests and not watched.isFloating():
            self._widths[watched] = watched.width()
        return False

    def _follow_window(self, before: QSize, now: QSize) -> None:
        """Give the panels at the sides back the width that a narrow window took from them."""
        # Once the window has laid itself out.
        if now.width() > before.width():
            self._settled_width = now.width()
            QTimer.singleShot(0, self._widen_sides)
        else:
            self._unsettle()
        QTimer.singleShot(0, self.make_room_for_image)

    @property
    def side_widths(self) -> list[int]:
        """Widths of the panels at the sides where there is room for them; 0 is unknown."""
        return [self._widths.get(dock, 0) for dock in self._sides]

    @side_widths.setter
    def side_widths(self, widths: list[int]) -> None:
        known = zip(self._sides, widths, strict=False)
        self._restored = {dock: width for dock, width in known if 0 < width < QWIDGETSIZE_MAX}
        if self._window.isVisible():
            self._unsettle()
            QTimer.singleShot(0, self._widen_sides)
            QTimer.singleShot(0, self.make_room_for_image)

    def _widen_sides(self) -> None:
        self._widths |= self._restored
        self._restored = {}
        narrow = {dock: width for dock, width in self._widths.items() if dock.width() < width}
        self._resize_sides(narrow)  # it may still be too narrow

    def make_room_for_image(self) -> None:
        """Let the panels give the image the room that they can spare."""
        gathered = self._places is not None
        sides = [dock for dock in self._sides if dock.isVisible() and not dock.isFloating()][gathered:]
        spare = {dock: max(0, dock.width() - dock.minimumSizeHint().width()) for dock in sides}
        missing = min(LEAST_CENTRE - self._parts.centre.width(), sum(spare.values()))
        if missing > 0:
            share = missing / sum(spare.values())
            self._resize_sides({dock: dock.width() - round(spare[dock] * share) for dock in sides})
        low = LOW_IMAGE - self._parts.image.height()
        tools = [dock for dock in self._docks_below() if not dock.visibleRegion().isEmpty()]
        if low > 0 and tools:
            heights = [max(dock.minimumSizeHint().height(), dock.height() - low) for dock in tools]
            self._window.resizeDocks(tools, heights, Qt.Orientation.Vertical)

    def _docks_below(self) -> list[QDockWidget]:
        """The panels below the image, also those behind others."""
        shown = [dock for dock in self._all(QDockWidget) if dock.isVisible() and not dock.isFloating()]
        bottom = Qt.DockWidgetArea.BottomDockWidgetArea
        return [dock for dock in shown if self._window.dockWidgetArea(dock) == bottom]

    def _all(self, kind: type[Part]) -> list[Part]:
        """Return the window's own parts of a kind; to search all rows of features takes 10 ms and more."""
        return self._window.findChildren(kind, options=Qt.FindChildOption.FindDirectChildrenOnly)

    def _resize_sides(self, widths: dict[QDockWidget, int]) -> None:
        settled, self._settled_width = self._settled_width, -1  # this change is not the user's
        self._window.resizeDocks(list(widths), list(widths.values()), Qt.Orientation.Horizontal)
        self._settled_width = settled

    def _share_height(self) -> None:
        """Give the image more of little height than tiles and controls; let the window become low."""
        parts, layout = self._parts, self._parts.centre.layout()
        if layout is None:
            return
        gallery, controls = parts.gallery, parts.favouritesArea
        tiles = not gallery.isHidden()
        others = layout.minimumSize().height() - controls.height_taken - tiles * gallery.minimumHeight()
        least_tiles, most_tiles = (tiles * gallery.heightAs(compact=compact) for compact in (True, False))
        parts.centre.setMinimumHeight(others + controls.least_height + least_tiles)
        # The image's own least height is among the others.
        room = parts.centre.height() - others + parts.image.minimumSizeHint().height()
        compact = room - controls.most_height - most_tiles < LEAST_IMAGE
        gallery.setCompact(compact)
        controls.setRoom(room - (least_tiles if compact else most_tiles) - LOW_IMAGE)

    def fit_screen(self) -> None:
        """Gather all panels at the right side if the screen has no room for them, and spread them again.

        Show tiles only if there is room for them beside gathered panels.
        """
        if not has_screen() or not self._window.isVisible():
            return
        room, gallery = screen_room(self._window), self._parts.gallery
        tiles = gallery.isHidden() * gallery.heightAs(compact=True)
        least = self._parts.centre.minimumHeight() + tiles + self._height_of_bars()
        if (roomy := least <= room.height()) is not gallery.roomy:
            gallery.setRoomy(roomy)
            self._keep_on_screen()
        least_size = self._least_size()
        fits = least_size == least_size.boundedTo(room)
        if fits and self._places is not None:
            self._spread()
        elif not fits and self._places is not None:
            self._hide_old_tabs()
        elif not fits:
            self._gather()
            self._keep_on_screen()

    def _keep_on_screen(self) -> None:
        """Make a window smaller that is larger than the screen."""
        self._apply_least_height()
        if not self._window.isMaximized() and not self._window.isFullScreen():
            self._window.resize(self._window.size().boundedTo(screen_room(self._window)))

    def _apply_least_height(self) -> None:
        """Let the window become smaller now, not in a later turn of the event loop."""
        self._share_height()
        if (layout := self._window.layout()) is not None:
            layout.activate()

    @contextmanager
    def in_their_places(self) -> Iterator[None]:
        """Spread gathered panels, to save where they are or to change it, and gather them again."""
        if self._places is None:
            yield
            return
        size = self._window.size()
        self._window.setUpdatesEnabled(False)
        self._spread()
        yield
        self._gather()
        self._window.setUpdatesEnabled(True)
        if not self._window.isMaximized() and not self._window.isFullScreen():
            self._window.resize(size)  # the spread panels may have made it larger

    def _least_size(self) -> QSize:
        """Return the least size of the window with panels at both sides of the image and below it."""
        centre = self._parts.centre
        docks = [dock for dock in self._all(QDockWidget) if not dock.isHidden()]
        docked = {dock: dock.minimumSizeHint() for dock in docks if not dock.isFloating()}
        sides = [docked.pop(dock) for dock in self._sides if dock in docked]
        tools = list(docked.values())
        width = max([centre.minimumSizeHint().width(), *(tool.width() for tool in tools)])
        width += sum(side.width() + self._separator for side in sides)
        height = max(centre.minimumHeight(), centre.minimumSizeHint().height())
        if tools:
            height += max(tool.height() for tool in tools) + self._separator
        if len(tools) > 1:
            height += max((bar.sizeHint().height() for bar in self._all(QTabBar)), default=0)
        return QSize(width, height + self._height_of_bars())

    def _height_of_bars(self) -> int:
        """Return the least height of menu, tool bar and status bar."""
        window = self._window
        bars = (window.menuBar(), window.statusBar(), *self._all(QToolBar))
        return sum(bar.minimumSizeHint().height() for bar in bars if bar is not None)

    def _gather(self) -> None:
        window, first = self._window, self._parts.featuresDock
        self._places = QMainWindow.saveState(window)
        docks = [dock for dock in self._all(QDockWidget) if not dock.isFloating()]
        tools = [dock for dock in docks if dock not in self._sides]
        front = next((dock for dock in tools if not dock.visibleRegion().isEmpty()), first)
        window.addDockWidget(Qt.DockWidgetArea.RightDockWidgetArea, first)
        for dock in docks:
            if dock is not first:
                window.tabifyDockWidget(first, dock)
        front.raise_()
        self._apply_least_height()

    def _hide_old_tabs(self) -> None:
        """Hide the tabs that Qt leaves of an arrangement that was never painted."""
        front = next((d for d in self._all(QDockWidget) if not d.visibleRegion().isEmpty()), None)
        for bar in self._all(QTabBar):
            if front is not None and bar.isVisible() and bar.x() != front.x():
                bar.hide()

    def _spread(self) -> None:
        docks = self._all(QDockWidget)
        hidden = [dock.isHidden() for dock in docks]
        if self._places is not None:
            QMainWindow.restoreState(self._window, self._places)
        self._places = None
        for dock, is_hidden in zip(docks, hidden, strict=True):
            dock.setHidden(is_hidden)
        self._unsettle()
        QTimer.singleShot(0, self._widen_sides)  # they were narrow when they were gathered

    def place_focus(self, *, beside: bool) -> None:
        """Put the focus aid beside the histogram where there is room for both, else behind it."""
        if self._places is not None:
            return
        shown = any(dock.isVisible() for dock in self._tools)
        if beside and shown and self._parts.centre.width() >= self._width_of_tools():
            area = Qt.DockWidgetArea.BottomDockWidgetArea
            self._window.addDockWidget(area, self._parts.focusDock, Qt.Orientation.Horizontal)
            self._claim_least_widths()
            QTimer.singleShot(0, self._keep_tools_usable)  # once it is shown
        elif not beside or not shown:
            self._put_focus_behind()

    def _keep_tools_usable(self) -> None:
        """Give the focus aid and the panels beside it what both need, or put it behind them."""
        focus, histogram = self._parts.focusDock, self._parts.histogramDock
        if self._places is not None or not self._is_beside():
            self._claim_widths()
            return
        self._claim_least_widths()
        room, least = self._parts.centre.width(), _needed_width(focus)
        others = self._width_of_tools() - least - self._separator
        if room < self._width_of_tools():
            self._unsettle()
            self._put_focus_behind()
            return
        wanted = max(least, min(focus.width(), room - self._separator - others))
        if wanted != focus.width():
            widths = [room - self._separator - wanted, wanted]
            self._window.resizeDocks([histogram, focus], widths, Qt.Orientation.Horizontal)

    def _is_beside(self) -> bool:
        """Whether the focus aid is beside the histogram or the panel over it, below the image."""
        focus = self._parts.focusDock
        group = {self._parts.histogramDock, *self._window.tabifiedDockWidgets(self._parts.histogramDock)}
        below = self._docks_below()
        others = [dock for dock in below if dock in group]
        if focus in group or focus not in below or not others:
            return False
        above = [dock for dock in others if not dock.visibleRegion().isEmpty() and dock.x() == focus.x()]
        return not above

    def _unsettle(self) -> None:
        """Count the following changes of the panels' widths as Qt's, not as the user's."""
        self._settled_width = -1
        self._settling.start(SETTLING_MS)

    def _on_settling_timeout(self) -> None:
        self._settled_width = self._window.width()

    def _put_focus_behind(self) -> None:
        histogram, focus = self._parts.histogramDock, self._parts.focusDock
        group = [histogram, *self._window.tabifiedDockWidgets(histogram)]
        front = next((dock for dock in group if not dock.visibleRegion().isEmpty()), None)
        self._window.tabifyDockWidget(histogram, focus)
        if front is not None and front is not focus:
            front.raise_()  # Qt brings another one of the group to the front
        self._claim_widths()

    def _claim_least_widths(self) -> None:
        """Let the window become narrower than the panels beside each other need."""
        histogram = self._parts.histogramDock
        docks = {*self._tools, *self._window.tabifiedDockWidgets(histogram)}
        for panel in (dock.widget() for dock in docks):
            if panel is not None and panel not in self._squeezed:
                self._squeezed.append(panel)
                panel.setMinimumWidth(LEAST_TOOL)

    def _claim_widths(self) -> None:
        """Let these panels become as narrow as their controls are, and no narrower."""
        while self._squeezed:
            self._squeezed.pop().setMinimumWidth(0)

    @property
    def _separator(self) -> int:
        """Pixels between two panels."""
        style, extent = self._window.style(), QStyle.PixelMetric.PM_DockWidgetSeparatorExtent
        return style.pixelMetric(extent, None, self._window) if style is not None else 0

    def _width_of_tools(self) -> int:
        """Pixels that the focus aid and the panels beside it need."""
        focus, histogram = self._parts.focusDock, self._parts.histogramDock
        group = [histogram, *self._window.tabifiedDockWidgets(histogram)]
        return (
            max(_needed_width(dock) for dock in group if dock is not focus)
            + _needed_width(focus)
            + self._separator
        )


def _needed_width(dock: QDockWidget) -> int:
    """Pixels that a panel needs for all of its controls."""
    panel = dock.widget()
    layout = panel.layout() if panel is not None else None
    return layout.minimumSize().width() if layout is not None else dock.minimumSizeHint().width()
