"""The main window: actions, docks, status bar."""

from __future__ import annotations

from collections.abc import Callable

from PyQt5.QtCore import QByteArray, QSize, Qt, pyqtSignal
from PyQt5.QtGui import QCloseEvent, QKeyEvent
from PyQt5.QtWidgets import (
    QAbstractButton,
    QAction,
    QActionGroup,
    QApplication,
    QDockWidget,
    QLayout,
    QMainWindow,
    QMenu,
    QMenuBar,
    QStatusBar,
    QToolBar,
    QToolButton,
    QWidget,
)

from grabbergui.models.image.quantities import COLOUR_MAPS, PolarisedView
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.actions import set_available
from grabbergui.ui.editors.feature_row import FeatureRow
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.keys import MenuKeys
from grabbergui.ui.preferences import LAYOUT_VERSION, PANES
from grabbergui.ui.screen import screen_room
from grabbergui.ui.shown_text import set_tooltip
from grabbergui.ui.tab_order import give_focus
from grabbergui.ui.theme import Theme, window_icon
from grabbergui.ui.views.changes_panel import ChangesPanel
from grabbergui.ui.views.favourites import FavouritesArea, FavouritesStrip
from grabbergui.ui.views.feature_panel import FeaturePanel
from grabbergui.ui.views.full_screen import FullScreen
from grabbergui.ui.views.header import WindowHeader
from grabbergui.ui.views.help_views import LogPanel
from grabbergui.ui.views.image_view import ImageView
from grabbergui.ui.views.measuring_panels import FocusPanel, HistogramPanel, ProfilePanel, ValuesPanel
from grabbergui.ui.views.panel_layout import PanelLayout
from grabbergui.ui.views.recording_bars import RecordingBar
from grabbergui.ui.views.source_list import SourceListView
from grabbergui.ui.widgets.status_strip import StatusStrip

FIRST_SHARE = 0.75
"Share of the screen's width and height for a window that was never moved."
ARRANGEMENT = b"\narrangement of the panels: "
"Separates Qt's state of the docks from the name of their arrangement."
LEAST_SIZE = QSize(640, 360)
"Least size of the window in pixels. Its panels are arranged for any larger size."

_DOCK_KEYS = ("F8", "F9", "F2", "F3", "F4", "Ctrl+T", "Ctrl+H", "F12")
"""Show and hide sources, features, histogram, focus aid, line profile, values over time, changes, log."""

_MODIFIERS = int(Qt.KeyboardModifier.KeyboardModifierMask)
_COMMAND_KEYS = _MODIFIERS & ~int(Qt.KeyboardModifier.ShiftModifier)
_FIRST_NAMED = int(Qt.Key.Key_Escape)
"""Keys below it are characters, the others have names: F1, Return."""


class MainWindow(QMainWindow):
    """Holds the views; controllers connect its actions."""

    closing = pyqtSignal()
    """The user closes the window; emitted once, before it disappears."""
    themeChosen = pyqtSignal(Theme)
    colourMapChosen = pyqtSignal(str)
    """The name of a colour map for monochrome images; empty for grey."""
    panesChosen = pyqtSignal(int)
    """How many cameras to show side by side; 1 is the current one alone."""
    separateZoomToggled = pyqtSignal(bool)
    """Whether each of several cameras has a zoom of its own."""
    polarisedViewChosen = pyqtSignal(object)
    """The `PolarisedView` of a polarised mosaic."""

    favourites: FavouritesStrip
    favouritesArea: FavouritesArea
    image: ImageView
    recordingBar: RecordingBar
    sources: SourceListView
    features: FeaturePanel
    histogram: HistogramPanel
    focus: FocusPanel
    profile: ProfilePanel
    values: ValuesPanel
    changes: ChangesPanel
    log: LogPanel
    sourcesDock: QDockWidget
    featuresDock: QDockWidget
    histogramDock: QDockWidget
    focusDock: QDockWidget
    profileDock: QDockWidget
    valuesDock: QDockWidget
    changesDock: QDockWidget
    logDock: QDockWidget
    toolBar: QToolBar
    statusbar: QStatusBar
    menubar: QMenuBar
    menuView: QMenu
    menuColours: QMenu
    menuSnapshotKind: QMenu
    menuFramesToRecord: QMenu
    menuPolarised: QMenu
    menuPanes: QMenu
    menuOrientation: QMenu
    actionUndo: QAction
    actionRedo: QAction
    actionConnect: QAction
    actionConnectStill: QAction
    actionDisconnect: QAction
    actionBeside: QAction
    actionNextSource: QAction
    actionEvents: QAction
    actionNewRig: QAction
    actionRig: QAction
    actionStart: QAction
    actionStop: QAction
    actionShare: QAction
    actionSnapshot: QAction
    actionPointCloud: QAction
    actionPolarised: QAction
    actionShowPoints: QAction
    actionSnapshotFolder: QAction
    actionOpenSnapshotFolder: QAction
    actionFrameData: QAction
    actionSaveLastFrames: QAction
    actionRecord: QAction
    actionSaveSettings: QAction
    actionLoadSettings: QAction
    actionCompareSettings: QAction
    actionCompareFiles: QAction
    actionUserSets: QAction
    actionCameraFiles: QAction
    actionQuit: QAction
    actionPause: QAction
    actionStepBack: QAction
    actionStepForward: QAction
    actionRegion: QAction
    actionFullSensor: QAction
    actionExpose: QAction
    actionExposeRegion: QAction
    actionBalance: QAction
    actionBalanceRegion: QAction
    actionClipping: QAction
    actionCrosshair: QAction
    actionGrid: QAction
    actionTurnRight: QAction
    actionTurnLeft: QAction
    actionMirrorX: QAction
    actionMirrorY: QAction
    actionUpright: QAction
    actionFit: QAction
    actionOneToOne: QAction
    actionZoomIn: QAction
    actionZoomOut: QAction
    actionFullScreen: QAction
    actionResetLayout: QAction
    actionCopyImage: QAction
    actionAddress: QAction
    actionSearch: QAction
    actionFindFeature: QAction
    actionCalibrate: QAction
    actionLoadCalibration: QAction
    actionShowCalibration: QAction
    actionLookUpTable: QAction
    actionManual: QAction
    actionWhatsThis: QAction
    actionDoctor: QAction
    actionReport: QAction
    actionShortcuts: QAction
    actionAbout: QAction
    actionThemeAuto: QAction
    actionThemeLight: QAction
    actionThemeDark: QAction

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("main_window", self)
        self.mayClose: Callable[[], bool] = lambda: True
        """Called when the user closes the window; if it returns False, it may close the window later."""
        self._quitting = False
        self._geometry = self._state = QByteArray()
        "Places of the window and its docks before the image filled the screen."
        self.status = StatusStrip(self)
        self.messages = self.status.messages
        self.statusbar.addWidget(self.status, 1)
        self.statusbar.setSizeGripEnabled(False)
        if (line := self.statusbar.layout()) is not None:
            line.setContentsMargins(0, 0, 0, 0)
        self.removeToolBar(self.toolBar)
        self.gallery = self.sources.gallery
        self.header = WindowHeader(self.menubar, self.toolBar, self.recordingBar)
        self.setMenuWidget(self.header)
        self._tools = (self.histogramDock, self.focusDock, self.profileDock, self.valuesDock,
                       self.changesDock, self.logDock)  # fmt: skip
        sides = (self.sourcesDock, self.featuresDock)
        self._panels = PanelLayout(self, sides, self._tools, self.sources.cardsCut)
        around = (self.header, self.statusbar, self.sourcesDock, self.featuresDock, *self._tools)
        self._full_screen = FullScreen(self, self.image, self.favouritesArea, around, self.actionFullScreen)
        self._panel_actions: dict[QDockWidget, QAction] = {}
        self._list_panels()
        if (layout := self.layout()) is not None:
            # Qt would keep the window as large as the panels need until they are arranged for less.
            layout.setSizeConstraint(QLayout.SizeConstraint.SetNoConstraint)
        self.setMinimumSize(LEAST_SIZE)
        self._fill_status()
        self._fill_image_menu()
        self._group_themes()
        self._group_colours()
        self._group_polarised_views()
        self._group_panes()
        self._join_own_actions()
        self._keep_bare_keys_to_image()
        self._explain_shortcuts()
        self.setWindowIcon(window_icon())

    def closeEvent(self, event: QCloseEvent | None) -> None:
        """Stay open if `mayClose` says no; otherwise announce the end. Never waits."""
        if event is not None and (event.spontaneous() or self._quitting) and not self.mayClose():
            event.ignore()
            return
        self.closing.emit()
        super().closeEvent(event)

    def menuBar(self) -> QMenuBar:
        """Return the menus; Qt's own function would make others, as these are a part of the header."""
        return self.menubar

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Give the focus back to the image on an Enter or Escape that no control used."""
        if event is not None and event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Escape):
            self.image.canvas.setFocus(Qt.FocusReason.OtherFocusReason)
            return
        super().keyPressEvent(event)

    def restorePlace(self, geometry: QByteArray | None) -> None:
        """Restore position and size; use most of the screen at the first start, or if they do not fit.

        Qt refuses a geometry of a screen that is a quarter wider or narrower, as after a change of its scale,
        and restores one that is larger than the screen.
        """
        if geometry is None or not self.restoreGeometry(geometry) or self._exceeds_screen():
            self.takeRoom()

    def _exceeds_screen(self) -> bool:
        screen = self.screen()
        if screen is None or self.isMaximized() or self.isFullScreen():
            return False
        room = screen.availableGeometry()
        return self.width() > room.width() or self.height() > room.height()

    def takeRoom(self) -> None:
        """Resize to most of a large screen, and never to more than the screen."""
        room = screen_room(self)
        self.resize(self.size().expandedTo(room * FIRST_SHARE).boundedTo(room))

    def focusNextPrevChild(self, forward: bool) -> bool:
        """Follow the Tab key through the panels from left to right, in each as one reads.

        Qt also asks when the widget with the focus is hidden (a button of a message) or disabled (a lost
        camera's): the image gets it then, whose keys are letters, and not whichever field comes next.
        """
        focused = QApplication.focusWidget()
        if focused is not None and not (focused.isVisibleTo(self) and focused.isEnabled()):
            self.image.canvas.setFocus(Qt.FocusReason.OtherFocusReason)
            return True
        cards = sorted(self.favourites.findChildren(FeatureRow), key=lambda row: (row.y(), row.x()))
        # Qt reports all docks of a tabbed group as visible.
        docks = [dock for dock in (self.sourcesDock, self.featuresDock, *self._tools)
                 if not dock.visibleRegion().isEmpty()]  # fmt: skip
        docks.sort(key=lambda dock: (dock.x(), dock.y()))
        regions = [self.header, *cards, self.image, *docks, self.status]
        return give_focus(regions, focused, forward=forward)

    def saveGeometry(self) -> QByteArray:
        """Return where the window is, or was before it filled the screen."""
        return self._geometry if self._full_screen.active else super().saveGeometry()

    def saveState(self, version: int = 0) -> QByteArray:
        """Return where the docks are, and by which arrangement; in full screen, as before."""
        if self._full_screen.active:
            return self._state
        arrangement = self._panels.arrangement
        name = arrangement.value if arrangement is not None else ""
        return super().saveState(version) + ARRANGEMENT + name.encode()

    def restoreState(self, state: QByteArray | bytes | bytearray, version: int = 0) -> bool:
        """Show the docks as before; where the user moved none, in the places for this size of window."""
        places, _, name = bytes(state).partition(ARRANGEMENT)
        self._panels.moving(True)
        restored = super().restoreState(places, version)
        self._panels.moving(False)
        if restored:
            self._panels.restored(name.decode(errors="replace"))
        return restored

    def setTheme(self, theme: Theme) -> None:
        """Mark the chosen theme."""
        self._themes[theme].setChecked(True)

    def _list_panels(self) -> None:
        """Offer each panel in the menu; give those at the side the height of the window."""
        self.setCorner(Qt.Corner.BottomLeftCorner, Qt.DockWidgetArea.LeftDockWidgetArea)
        self.setCorner(Qt.Corner.BottomRightCorner, Qt.DockWidgetArea.RightDockWidgetArea)
        for dock, key in zip((self.sourcesDock, self.featuresDock, *self._tools), _DOCK_KEYS, strict=True):
            self._panel_actions[dock] = self._panel_action(dock, key)
        self.menuView.addActions(list(self._panel_actions.values()))
        self.actionResetLayout.triggered.connect(self._panels.reset)
        self.gallery.filled.connect(self._panels.fit)

    def _fill_image_menu(self) -> None:
        """Offer on the image itself, by the right mouse button, what concerns it most."""
        gap, canvas = QAction(self), self.image.canvas
        gap.setSeparator(True)
        canvas.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)
        canvas.addActions([self.actionFit, self.actionOneToOne, self.menuOrientation.menuAction(), gap])
        canvas.addActions(
            [self.actionSnapshot, self.actionCopyImage, self.actionRegion, self.actionFullSensor]
        )
        canvas.addAction(self._panel_actions[self.profileDock])
        self.actionCopyImage.triggered.connect(canvas.copyShown)

    def _fill_status(self) -> None:
        """Show the zoom in the status bar, with its buttons; its share of clipped pixels marks them."""
        zooming = (self.actionFit, self.actionOneToOne, self.actionZoomIn, self.actionZoomOut)
        self.status.addZoomActions((*zooming, self.actionTurnRight))
        self.image.canvas.zoomChanged.connect(self.status.setZoom)
        self.status.clippingButton.toggled.connect(self.actionClipping.setChecked)
        self.actionClipping.toggled.connect(self.status.clippingButton.setChecked)
        if isinstance(button := self.toolBar.widgetForAction(self.actionFullSensor), QToolButton):
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)

    def _panel_action(self, dock: QDockWidget, key: str) -> QAction:
        """Return an action that shows and raises a panel, or hides it; checked while the panel is seen."""
        action = QAction(dock.windowTitle(), self)
        action.setCheckable(True)
        action.setShortcut(key)
        if (button := dock.findChild(QAbstractButton, "qt_dockwidget_closebutton")) is not None:
            set_tooltip(button, self.tr("Close this panel; to open it again: {0}").format(key))
        # For Qt a panel behind another one is visible; its signal reports whether it can be seen.
        dock.visibilityChanged.connect(action.setChecked)

        def show(wanted: bool) -> None:
            dock.setVisible(wanted)
            if wanted:
                dock.raise_()

        action.triggered[bool].connect(show)
        return action

    def _group_colours(self) -> None:
        group = QActionGroup(self)
        self._colour_maps: dict[str, QAction] = {}
        for name in ("", *COLOUR_MAPS):
            action = QAction(name or self.tr("Grey"), group)
            action.setCheckable(True)
            action.setChecked(not name)
            action.setData(name)
            self._colour_maps[name] = action
        self.menuColours.addActions(group.actions())
        group.triggered.connect(lambda action: self.colourMapChosen.emit(action.data()))

    def _group_panes(self) -> None:
        group = QActionGroup(self)
        for count in PANES:
            action = QAction(self.tr("&{0}").format(count), group)
            action.setCheckable(True)
            action.setChecked(count == 1)
            action.setData(count)
        self._panes = {action.data(): action for action in group.actions()}
        self.menuPanes.addActions(group.actions())
        self.menuPanes.addSeparator()
        self._separate_zoom = QAction(self.tr("Separate &zoom"), self.menuPanes)
        self._separate_zoom.setCheckable(True)
        set_tooltip(self._separate_zoom, self.tr("Zoom and move each camera by itself, not all alike"))
        self.menuPanes.addAction(self._separate_zoom)
        group.triggered.connect(lambda action: self.panesChosen.emit(action.data()))
        self._separate_zoom.triggered[bool].connect(self.separateZoomToggled)

    def setPanes(self, count: int, separate_zoom: bool) -> None:
        """Mark how many cameras are shown side by side, and whether each has a zoom of its own."""
        self._panes[count].setChecked(True)
        self._separate_zoom.setChecked(separate_zoom)

    def setColourMap(self, name: str) -> None:
        """Mark the colours of the component that is shown."""
        self._colour_maps[name].setChecked(True)

    def setPolarisedView(self, view: PolarisedView) -> None:
        """Mark the view of a polarised mosaic that is shown."""
        self._polarised[view].setChecked(True)

    def _group_polarised_views(self) -> None:
        titles = {
            PolarisedView.MOSAIC: self.tr("As sent"),
            PolarisedView.INTENSITY: self.tr("Intensity"),
            PolarisedView.DEGREE: self.tr("Degree of polarisation"),
            PolarisedView.ANGLE: self.tr("Angle of polarisation"),
        }
        group = QActionGroup(self)
        self._polarised = {view: QAction(title, group) for view, title in titles.items()}
        for view, action in self._polarised.items():
            action.setCheckable(True)
            action.setData(view)
        self._polarised[PolarisedView.MOSAIC].setChecked(True)
        self.menuPolarised.addActions(group.actions())
        self.menuPolarised.addSeparator()
        self.menuPolarised.addAction(self.actionPolarised)
        self.actionPolarised.toggled.connect(self._on_polarised_toggled)
        self._on_polarised_toggled(False)
        group.triggered.connect(lambda action: self.polarisedViewChosen.emit(action.data()))

    def _on_polarised_toggled(self, polarised: bool) -> None:
        for view, action in self._polarised.items():
            offered = polarised or view is PolarisedView.MOSAIC
            set_available(action, None if offered else Unavailable.POLARISERS)

    def _group_themes(self) -> None:
        self._themes = {
            Theme.AUTO: self.actionThemeAuto,
            Theme.LIGHT: self.actionThemeLight,
            Theme.DARK: self.actionThemeDark,
        }
        group = QActionGroup(self)
        for action in self._themes.values():
            group.addAction(action)
        group.triggered.connect(self._on_theme_triggered)

    def _on_theme_triggered(self, action: QAction) -> None:
        chosen = next(theme for theme, known in self._themes.items() if known is action)
        self.themeChosen.emit(chosen)

    def _join_own_actions(self) -> None:
        canvas = self.image.canvas
        self.actionFit.triggered.connect(canvas.fit)
        self.actionOneToOne.triggered.connect(canvas.oneToOne)
        self.actionZoomIn.triggered.connect(lambda: canvas.zoomBy(1.5))
        self.actionZoomOut.triggered.connect(lambda: canvas.zoomBy(1 / 1.5))
        self.actionAddress.triggered.connect(self._on_address)
        self.actionFindFeature.triggered.connect(self._on_find_feature)
        self.actionFullScreen.toggled.connect(self._on_full_screen_toggled)
        self.actionQuit.triggered.connect(self._on_quit)

    def _keep_bare_keys_to_image(self) -> None:
        """Let shortcuts without Ctrl act only while the image has the focus: fields need their letters."""
        for action in self.findChildren(QAction):
            keys = action.shortcut()
            bare = not keys.isEmpty() and not keys[0] & _COMMAND_KEYS and keys[0] & ~_MODIFIERS < _FIRST_NAMED
            if bare:
                action.setShortcutContext(Qt.ShortcutContext.WidgetWithChildrenShortcut)
                self.image.addAction(action)
        menu_keys = MenuKeys(self)
        for menu in self.findChildren(QMenu):
            menu.installEventFilter(menu_keys)
        app = QApplication.instance()
        assert isinstance(app, QApplication)
        app.focusChanged.connect(self._on_application_focus_changed)
        self.image.canvas.setFocus(Qt.FocusReason.OtherFocusReason)

    def _on_application_focus_changed(self, before: QWidget | None, now: QWidget | None) -> None:
        """Give the image the focus that Qt takes from a field whose panel is disabled."""
        if before is None or now is not None or before.isEnabled():
            return
        if self.isActiveWindow() and self.isAncestorOf(before):
            self.image.canvas.setFocus(Qt.FocusReason.OtherFocusReason)

    def _on_address(self) -> None:
        self.sourcesDock.show()
        self.sourcesDock.raise_()
        self.sources.focusAddress()

    def _on_quit(self) -> None:
        self._quitting = True
        self.close()
        self._quitting = False

    def _on_find_feature(self) -> None:
        self.featuresDock.show()
        self.featuresDock.raise_()
        self.features.filterEdit.setFocus()
        self.features.filterEdit.selectAll()

    def _on_full_screen_toggled(self, full: bool) -> None:
        if full:
            self._geometry, self._state = self.saveGeometry(), self.saveState(LAYOUT_VERSION)
            self._full_screen.enter()
        else:
            self._full_screen.leave()

    def _explain_shortcuts(self) -> None:
        """Show tooltips in menus, too, and add each action's shortcut to its own."""
        for menu in self.findChildren(QMenu):
            menu.setToolTipsVisible(True)
        for action in self.findChildren(QAction):
            if not action.shortcut().isEmpty() and action.toolTip() != action.text().replace("&", ""):
                set_tooltip(action, f"{action.toolTip()} ({action.shortcut().toString()})")
