"""The main window: actions, docks, status bar."""

from __future__ import annotations

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QCloseEvent
from PyQt5.QtWidgets import (
    QAction,
    QActionGroup,
    QDockWidget,
    QMainWindow,
    QMenu,
    QStatusBar,
    QToolBar,
    QWidget,
)

from grabbergui.ui import icons
from grabbergui.ui.loader import load_form
from grabbergui.ui.theme import Theme
from grabbergui.ui.views.favourites import FavouritesStrip
from grabbergui.ui.views.feature_panel import FeaturePanel
from grabbergui.ui.views.picture_view import PictureView
from grabbergui.ui.views.source_list import SourceListView
from grabbergui.ui.widgets.message_stack import MessageStack
from grabbergui.ui.widgets.status_strip import StatusStrip


class MainWindow(QMainWindow):
    """Holds the views; its actions are joined to what they do by controllers."""

    closing = pyqtSignal()
    """The user closes the window; emitted once, before it goes."""
    themeChosen = pyqtSignal(Theme)

    messages: MessageStack
    favourites: FavouritesStrip
    picture: PictureView
    sources: SourceListView
    features: FeaturePanel
    sourcesDock: QDockWidget
    featuresDock: QDockWidget
    toolBar: QToolBar
    statusbar: QStatusBar
    menuView: QMenu
    actionConnect: QAction
    actionDisconnect: QAction
    actionStart: QAction
    actionStop: QAction
    actionSnapshot: QAction
    actionSnapshotFolder: QAction
    actionOpenSnapshotFolder: QAction
    actionQuit: QAction
    actionFit: QAction
    actionOneToOne: QAction
    actionZoomIn: QAction
    actionZoomOut: QAction
    actionFullScreen: QAction
    actionAddress: QAction
    actionSearch: QAction
    actionFindFeature: QAction
    actionShortcuts: QAction
    actionAbout: QAction
    actionThemeAuto: QAction
    actionThemeLight: QAction
    actionThemeDark: QAction

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("main_window", self)
        self.status = StatusStrip(self)
        self.statusbar.addWidget(self.status, 1)
        self.statusbar.setSizeGripEnabled(False)
        self.menuView.addAction(self.sourcesDock.toggleViewAction())
        self.menuView.addAction(self.featuresDock.toggleViewAction())
        self.resizeDocks([self.sourcesDock, self.featuresDock], [270, 360], Qt.Orientation.Horizontal)
        self._group_themes()
        self._join_own_actions()
        self._explain_shortcuts()
        self.setWindowIcon(icons.window_icon())
        icons.apply(self)

    def closeEvent(self, event: QCloseEvent | None) -> None:
        """Say that it goes; nothing here waits."""
        self.closing.emit()
        super().closeEvent(event)

    def setTheme(self, theme: Theme) -> None:
        """Show which look is chosen."""
        self._themes[theme].setChecked(True)

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
        canvas = self.picture.canvas
        self.actionFit.triggered.connect(canvas.fit)
        self.actionOneToOne.triggered.connect(canvas.oneToOne)
        self.actionZoomIn.triggered.connect(lambda: canvas.zoomBy(1.5))
        self.actionZoomOut.triggered.connect(lambda: canvas.zoomBy(1 / 1.5))
        self.actionAddress.triggered.connect(self._on_address)
        self.actionFindFeature.triggered.connect(self._on_find_feature)
        self.actionFullScreen.toggled.connect(self._on_full_screen_toggled)
        self.actionQuit.triggered.connect(self._on_quit)

    def _on_address(self) -> None:
        self.sourcesDock.show()
        self.sources.focusAddress()

    def _on_quit(self) -> None:
        self.close()

    def _on_find_feature(self) -> None:
        self.featuresDock.show()
        self.features.filterEdit.setFocus()
        self.features.filterEdit.selectAll()

    def _on_full_screen_toggled(self, full: bool) -> None:
        if full:
            self.showFullScreen()
        else:
            self.showNormal()

    def _explain_shortcuts(self) -> None:
        """Say each action's shortcut in its tooltip too."""
        for action in self.findChildren(QAction):
            if not action.shortcut().isEmpty():
                action.setToolTip(f"{action.toolTip()} ({action.shortcut().toString()})")
