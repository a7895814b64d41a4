"""Joins everything: the models, the window, and the controllers between them."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from pathlib import Path

from PyQt5.QtCore import QObject, Qt, QUrl
from PyQt5.QtGui import QDesktopServices
from PyQt5.QtWidgets import QApplication, QFileDialog, QMessageBox

from grabbergui import __version__, sources
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.uri import SourceUri
from grabbergui.models.connection import Connection
from grabbergui.models.gallery import GalleryModel
from grabbergui.models.log_book import LogBook
from grabbergui.models.measuring.measurement import MeasuringModel
from grabbergui.models.open_source import OpenSource
from grabbergui.models.picture.frame_history import FrameHistory
from grabbergui.models.picture.picture import PictureModel
from grabbergui.models.recording.snapshot import SnapshotWriter
from grabbergui.models.source_list import SourceListModel
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.controllers.acquisition import AcquisitionController
from grabbergui.ui.controllers.calibrating import CalibrationOpener
from grabbergui.ui.controllers.camera_work import CameraWork
from grabbergui.ui.controllers.changes import ChangesController
from grabbergui.ui.controllers.favourites import FavouritesController
from grabbergui.ui.controllers.feature_menu import FeatureMenuController
from grabbergui.ui.controllers.features import FeatureController
from grabbergui.ui.controllers.gallery import GalleryController
from grabbergui.ui.controllers.keeping import KeepingController
from grabbergui.ui.controllers.log import LogController
from grabbergui.ui.controllers.looking import LookingController
from grabbergui.ui.controllers.measuring import MeasuringController
from grabbergui.ui.controllers.pausing import PauseController
from grabbergui.ui.controllers.playback import PlaybackController
from grabbergui.ui.controllers.recording import RecordingController
from grabbergui.ui.controllers.region import RegionController
from grabbergui.ui.controllers.sources import SourcesController
from grabbergui.ui.controllers.tuning import TuningController
from grabbergui.ui.controllers.user_sets import UserSetsController
from grabbergui.ui.controllers.values import ValuesController
from grabbergui.ui.preferences import LAYOUT_VERSION, Preferences
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.views.main_window import MainWindow
from grabbergui.ui.views.shortcuts_dialog import ShortcutsDialog
from grabbergui.ui.widgets.message_stack import MessageBar

log = logging.getLogger(__name__)

CLOSE_TIME = 0.8
"Seconds that closing the window waits for sources and files; the program waits for the rest without it."


class MainController(QObject):
    """The program behind the window. Make it on the GUI thread; `shut_down` ends every thread it began."""

    def __init__(
        self,
        window: MainWindow,
        preferences: Preferences,
        create: Callable[[SourceUri], FrameGrabber] = sources.create,
    ) -> None:
        super().__init__(window)
        self.window = window
        self.preferences = preferences
        self.source_list = SourceListModel()
        self.connection = Connection(create)
        self.gallery = GalleryModel(self.connection)
        self.picture = PictureModel()
        self.snapshots = SnapshotWriter()
        self.history = FrameHistory()
        self.measuring = MeasuringModel(lambda: self.picture.frame)
        self.log_book = LogBook()
        self.log_book.open()
        self.sources = SourcesController(
            window.sources, self.source_list, self.connection, preferences, window.tasks
        )
        self.tiles = GalleryController(window.gallery, self.gallery, self.connection)
        self.acquisition = AcquisitionController(
            window, self.connection, self.picture, self.snapshots, preferences
        )
        self.features = FeatureController(window.features, window.favourites, self)
        self.work = CameraWork(window.tasks, self.connection)
        self.keeping = KeepingController(window, self.connection, self.work)
        self.user_sets = UserSetsController(window, self.connection, self.work)
        self.recording = RecordingController(window.recordingBar, self.connection, preferences)
        self.looking = LookingController(window, self.connection, self.picture)
        self.measures = MeasuringController(window, self.connection, self.picture, self.measuring)
        self.pausing = PauseController(window, self.connection, self.picture, self.history)
        self.playback = PlaybackController(window, self.connection)
        self.region = RegionController(window, self.connection, self.picture)
        self.tuning = TuningController(window, self.connection, self.picture)
        self.changes = ChangesController(window, self.connection)
        self.values = ValuesController(window, self.connection)
        self.favourites = FavouritesController(window, self.connection, self.features, preferences)
        self.feature_menu = FeatureMenuController(window, self.connection, self.favourites)
        self.feature_menu.plotRequested.connect(self.values.plot)
        self.calibrating = CalibrationOpener(window, self.connection)
        self.log = LogController(window.log, self.log_book)
        self._read_only_bar: MessageBar | None = None
        self._down = False
        self._join()
        self._restore()

    def begin(self, uri: str | None) -> None:
        """Look for sources, and connect to one where it is named."""
        self.source_list.start()
        if uri is not None:
            self.sources.connect_to(uri)

    def shut_down(self, timeout: float) -> list[str]:
        """Let everything go. What did not end within `timeout` seconds, for people; may be asked again."""
        if not self._down:
            self._down = True
            self.preferences.keep_window(self.window.saveGeometry(), self.window.saveState(LAYOUT_VERSION))
            self.favourites.keep_layout()
            self.features.set_model(None)
            self.source_list.stop(0)  # a search under way ends while the rest is closed
            self.connection.close_all()
        deadline = time.monotonic() + timeout
        waits: tuple[tuple[str, Callable[[float], bool]], ...] = (
            ("the small pictures", self.gallery.close),
            ("the picture", self.picture.detach),
            ("the last pictures", self.history.detach),
            ("the measurements", self.measuring.close),
            ("the recording", self.recording.shut_down),
            ("the one-push tuning", self.tuning.shut_down),
            ("a camera", self.connection.wait_closed),
            ("a snapshot", self.snapshots.wait),
            ("the search for sources", self.source_list.stop),
        )
        late = [name for name, wait in waits if not wait(max(0.0, deadline - time.monotonic()))]
        self.log_book.close()
        return late

    def _join(self) -> None:
        window = self.window
        self._bridge = Bridge(self)
        self._bridge.bind(self.connection.failed, window.messages.showError)
        self._bridge.bind(self.connection.noticed, window.messages.showNotice)
        self._bridge.bind(self.connection.opened, self._on_connection_opened)
        self._bridge.bind(self.connection.closing, self._on_connection_closing)
        self._bridge.bind(self.connection.read_only, self._on_connection_read_only)
        self.looking.orientationChanged.connect(self.measures.show_marks)
        for controller in (self.sources, self.acquisition, self.features, self.pausing, self.region):
            controller.failed.connect(window.messages.showError)
        self.keeping.failed.connect(window.messages.showError)
        for teller in (self.keeping, self.user_sets, self.changes, self.values, self.tuning):
            teller.noticed.connect(window.messages.showNotice)
        for tuning in (self.work, self.changes, self.values, self.tuning, self.favourites):
            tuning.failed.connect(window.messages.showError)
        for player in (self.keeping, self.recording):
            player.playRequested.connect(self.sources.connect_to)
        self.recording.failed.connect(window.messages.showError)
        self.playback.failed.connect(window.messages.showError)
        self.recording.noticed.connect(window.messages.showNotice)
        self.keeping.accept_drops()
        window.actionRecord.triggered.connect(window.recordingBar.recordButton.click)
        window.actionSaveSettings.triggered.connect(self.keeping.ask_save)
        window.actionLoadSettings.triggered.connect(self.keeping.ask_load)
        window.actionCompareSettings.triggered.connect(self.keeping.ask_compare)
        window.actionCompareFiles.triggered.connect(self.keeping.ask_compare_files)
        window.closing.connect(self._on_window_closing)
        window.themeChosen.connect(self._on_theme_chosen)
        window.actionConnect.triggered.connect(window.sources.requestConnect)
        window.actionDisconnect.triggered.connect(self.connection.disconnect)
        window.actionBeside.triggered.connect(window.sources.requestBeside)
        window.actionNextSource.triggered.connect(self.tiles.take_next)
        window.actionSearch.triggered.connect(self.source_list.refresh)
        window.actionSnapshotFolder.triggered.connect(self._choose_snapshot_folder)
        window.actionOpenSnapshotFolder.triggered.connect(self._open_snapshot_folder)
        window.actionShortcuts.triggered.connect(self._show_shortcuts)
        window.actionAbout.triggered.connect(self._show_about)

    def _restore(self) -> None:
        window, preferences = self.window, self.preferences
        if preferences.geometry is not None:
            window.restoreGeometry(preferences.geometry)
        if preferences.layout is not None:
            window.restoreState(preferences.layout, LAYOUT_VERSION)
        window.setTheme(preferences.theme)

    def _on_connection_opened(self, source: OpenSource) -> None:
        if source is self.connection.source and source.grabber is not None:
            self.features.set_model(source.features)
            self.favourites.restore(source.grabber.info)
            self.window.setWindowTitle(f"{source.title} — grabbergui")

    def _on_connection_closing(self, _: OpenSource) -> None:
        self.features.set_model(None)
        self.window.setWindowTitle("grabbergui")
        if self._read_only_bar is not None:
            self.window.messages.dismiss(self._read_only_bar)
            self._read_only_bar = None

    def _on_connection_read_only(self, source: OpenSource) -> None:
        if source is self.connection.source:
            reason, _, _ = source.read_only.partition(";")  # what to do about it is on the button
            self._read_only_bar = self.window.messages.showOffer(
                self.tr("For reading only: {0}. Values follow here but cannot be changed.").format(reason),
                self.tr("Take control"),
                self.connection.take_control,
            )

    def _on_window_closing(self) -> None:
        self.shut_down(CLOSE_TIME)

    def _on_theme_chosen(self, chosen: Theme) -> None:
        self.preferences.theme = chosen
        app = QApplication.instance()
        if isinstance(app, QApplication):
            dress(app, chosen)

    def _choose_snapshot_folder(self) -> None:
        before = str(self.preferences.snapshot_folder)
        chosen = QFileDialog.getExistingDirectory(self.window, self.tr("Folder for snapshots"), before)
        if chosen:
            self.preferences.snapshot_folder = Path(chosen)

    def _open_snapshot_folder(self) -> None:
        folder = self.preferences.snapshot_folder
        folder.mkdir(parents=True, exist_ok=True)
        QDesktopServices.openUrl(QUrl.fromLocalFile(str(folder)))

    def _show_shortcuts(self) -> None:
        menubar = self.window.menuBar()
        if menubar is not None:
            dialog = ShortcutsDialog(menubar, self.window)
            dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
            dialog.open()

    def _show_about(self) -> None:
        QMessageBox.about(
            self.window,
            self.tr("About grabbergui"),
            self.tr(
                "<h3>grabbergui {0}</h3>"
                "<p>Tune GenICam cameras live, and share them on YARP and ROS 2 networks.</p>"
                "<p>Free software under the GNU General Public License, version 3 or later,"
                " with an additional permission to combine it with the GenICam runtime.</p>"
            ).format(__version__),
        )
