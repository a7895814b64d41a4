"""Joins everything: the models, the window, and the controllers between them."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path

from PyQt5.QtCore import QObject, QTimer, QUrl
from PyQt5.QtGui import QDesktopServices
from PyQt5.QtWidgets import QApplication

from grabbergui import __version__, sources
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.uri import SourceUri
from grabbergui.models.frame_history import FrameHistory
from grabbergui.models.image.live_image import ImageModel
from grabbergui.models.log_book import LogBook
from grabbergui.models.markup import markup
from grabbergui.models.measuring import MeasuringModel
from grabbergui.models.messages import MessageModel, Severity, UserMessage
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.recording import Recordings
from grabbergui.models.sharing import Sharing
from grabbergui.models.source_messages import CurrentMessages
from grabbergui.models.source_opener import SourceOpener
from grabbergui.models.sources import GalleryModel, SourceListModel
from grabbergui.models.status import StatusModel
from grabbergui.models.triggers import Triggers
from grabbergui.recording.snapshot import SnapshotWriter
from grabbergui.terminal import remote_terminal
from grabbergui.ui.actions import set_available
from grabbergui.ui.controllers.calibration import CalibrationOpener, CalibrationViewController
from grabbergui.ui.controllers.camera_work import CameraWork
from grabbergui.ui.controllers.changes import ChangesController
from grabbergui.ui.controllers.features import FavouritesController, FeatureController, FeatureMenuController
from grabbergui.ui.controllers.frame_data import FrameDataController
from grabbergui.ui.controllers.gallery import GalleryController
from grabbergui.ui.controllers.help import HelpController, LogController
from grabbergui.ui.controllers.image import (
    AcquisitionController,
    ComponentController,
    DisplayController,
    PointCloudController,
)
from grabbergui.ui.controllers.ip_address import IpAddressController
from grabbergui.ui.controllers.last_frames import LastFramesController
from grabbergui.ui.controllers.lut import LutController
from grabbergui.ui.controllers.measuring import MeasuringController, ValuesController
from grabbergui.ui.controllers.recording import PauseController, PlaybackController, RecordingController
from grabbergui.ui.controllers.report import ReportController
from grabbergui.ui.controllers.settings import SettingsFilesController, UserSetsController
from grabbergui.ui.controllers.sharing import SharingController
from grabbergui.ui.controllers.snapshot_kind import SnapshotKindController
from grabbergui.ui.controllers.sources import SourcesController
from grabbergui.ui.controllers.status import StatusController
from grabbergui.ui.controllers.triggers import TriggerController
from grabbergui.ui.controllers.tuning import RegionController, TuningController
from grabbergui.ui.file_dialogs import FileDialogs
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.preferences import LAYOUT_VERSION, Preferences
from grabbergui.ui.screen import has_screen
from grabbergui.ui.shown_text import about_box
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.views.main_window import MainWindow
from grabbergui.ui.widgets.share_chip import ShareChip

log = logging.getLogger(__name__)

SEARCH_AFTER_MS = 2000
"When the search begins even if the named source has shown no image yet."
CLOSE_TIME = 0.8
"Seconds that closing the window waits for sources and files; the program waits longer once it is closed."


class Program(QObject):
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
        self.named_source = ""
        "The source with which the program began; empty if the command line named none."
        self.source_list = SourceListModel()
        self.messages = MessageModel()
        self.opener = SourceOpener(create, self.messages)
        self.open_sources = self.opener.open_sources
        self.status = StatusModel(self.open_sources)
        self.gallery = GalleryModel(self.open_sources)
        self.image = ImageModel()
        self.snapshots = SnapshotWriter()
        self.history = FrameHistory()
        self.measuring = MeasuringModel(lambda: self.image.shown)
        self.log_book = LogBook()
        self.log_book.open()
        self.recordings = Recordings(self.open_sources, self.messages)
        self.status.recorded = self.recordings.runs
        self.sharing = Sharing(self.open_sources, self.opener.stream, remote_terminal)
        messages = CurrentMessages(self.messages, lambda: self.open_sources.current)
        self.files = files = FileDialogs(window)
        image, tasks = window.image, window.image.tasks
        rows = (window.features.rows, window.favourites.rows)
        open_sources = self.open_sources
        self.recording = RecordingController(
            window.actionRecord, window.recordingBar, open_sources, self.recordings, preferences, files
        )
        self.share_chip = ShareChip(window)
        window.statusbar.addPermanentWidget(self.share_chip)
        self.sharer = SharingController(
            window.actionShare, self.share_chip, window, open_sources, self.sharing, self.image, preferences
        )
        self.sources = SourcesController(
            window.sources,
            self.source_list,
            self.opener,
            preferences,
            tasks,
            self._confirm_closing,
            self.messages,
            files,
        )
        self.address = IpAddressController(window.sources, window, self.source_list)
        self.tiles = GalleryController(
            window.gallery, image, self.gallery, open_sources, self.status, self._confirm_closing
        )
        self.acquisition = AcquisitionController(
            window,
            image,
            open_sources,
            self.opener.stream,
            self.gallery,
            self.image,
            self.snapshots,
            preferences,
            messages,
            self,
        )
        self.status_bar = StatusController(
            window.status, image, open_sources, self.image, self.status, self.messages, self
        )
        self.triggers = TriggerController(
            image.triggerBar, open_sources, Triggers(open_sources, self.status, self.messages), self
        )
        self.features = FeatureController(window.features, window.favourites, self)
        self.work = CameraWork(tasks, open_sources, messages)
        self.settings_files = SettingsFilesController(window, files, open_sources, self.work, messages)
        self.user_sets = UserSetsController(window.actionUserSets, window, open_sources, self.work, messages)
        self.lut = LutController(window.actionLookUpTable, window, files, open_sources, self.work, messages)
        self.display = DisplayController(window, image, window.histogram, open_sources, self.image, self)
        self.components = ComponentController(window, image, window.histogram, open_sources, self.image, self)
        self.snapshot_kind = SnapshotKindController(window.menuSnapshotKind, preferences)
        self.frame_data = FrameDataController(window.actionFrameData, window, self.image)
        self.points = PointCloudController(window.actionShowPoints, window, self.image, self)
        self.measures = MeasuringController(
            image,
            window,
            window.status,
            window.actionClipping,
            open_sources,
            self.image,
            self.measuring,
            self,
        )
        self.pausing = PauseController(
            window, image.pauseBar, open_sources, self.image, self.history, messages, self
        )
        self.last_frames = LastFramesController(
            window.actionSaveLastFrames,
            self.open_sources,
            self.history,
            self.snapshots,
            preferences,
            messages,
            self,
        )
        self.playback = PlaybackController(window, image.playbackBar, open_sources, messages, self)
        self.region = RegionController(window, image, open_sources, self.image, messages, self)
        self.tuning = TuningController(window, image, tasks, open_sources, self.image, messages, self)
        self.changes = ChangesController(window, window.changes, rows, files, open_sources, messages, self)
        self.values = ValuesController(window.values, window.valuesDock, files, open_sources, messages, self)
        self.favourites = FavouritesController(
            window, window.favourites, open_sources, self.features, preferences, messages, self
        )
        self.feature_menu = FeatureMenuController(window, rows, open_sources, self.favourites)
        self.feature_menu.plotRequested.connect(self.values.plot)
        self.calibrating = CalibrationOpener(window.actionCalibrate, window, open_sources)
        self.calibration = CalibrationViewController(window, files, open_sources, self.image, messages, self)
        self.calibrating.saved.connect(self.calibration.load)
        self.help = HelpController(window, window.menubar, window)
        self.log = LogController(window.log, self.log_book)
        self.report = ReportController(
            window.actionReport, window, files, open_sources, self.log_book, messages
        )
        self._settings_to_compare: Path | None = None
        self._down = False
        self._join()
        self._restore()
        if file := preferences.unwritable:
            text = self.tr("{0} cannot be written: the window will forget its arrangement and your choices")
            self.messages.post(UserMessage(text.format(file), Severity.WARNING))

    def begin(self, uri: str | None, *others: str) -> None:
        """Connect to a source where one is named, and to `others` in tiles; then look for more.

        A search imports every kind of source, which would delay the first image. It begins after
        `SEARCH_AFTER_MS` at the latest.
        """
        self.named_source = uri or ""
        if uri is None:
            self.source_list.start()
            return
        self.window.image.painted.connect(self._search)
        QTimer.singleShot(SEARCH_AFTER_MS, self._search)
        self.sources.connect_to(uri)
        for other in others:
            self.sources.open_additional(other)

    def compare_once_open(self, settings: Path) -> None:
        """Compare the first camera that opens with a settings file, and offer to load it."""
        self._settings_to_compare = settings

    def _search(self) -> None:
        if not self._down:
            self.source_list.start()
            with suppress(TypeError):  # by the clock, after the image
                self.window.image.painted.disconnect(self._search)

    def shut_down(self, timeout: float) -> list[str]:
        """Release everything; return the names of what did not end in `timeout` seconds. Can be repeated."""
        if not self._down:
            self._down = True
            self.preferences.keep_window(self.window.saveGeometry(), self.window.saveState(LAYOUT_VERSION))
            self.favourites.keep_layout()
            self.preferences.left_open = self._left_open()
            self.window.hide()  # at once: what follows may take CLOSE_TIME
            self.features.set_model(None)
            self.source_list.stop(0)  # a search in progress ends while the rest is closed
            self.open_sources.close_all()
        deadline = time.monotonic() + timeout
        waits: tuple[tuple[str, Callable[[float], bool]], ...] = (
            ("the thumbnails", self.gallery.close),
            ("the image", self.image.detach),
            ("the last images", self.history.detach),
            ("the measurements", self.measuring.close),
            ("the point cloud", self.points.shut_down),
            ("a recording", self.recordings.close),
            ("the one-push tuning", self.tuning.shut_down),
            ("a shared camera", self.sharing.close),
            ("a camera", self.open_sources.wait_closed),
            ("a snapshot", self.snapshots.wait),
            ("the search for sources", self.source_list.stop),
        )
        late = [name for name, wait in waits if not wait(max(0.0, deadline - time.monotonic()))]
        self.status.close()
        self.log_book.close()
        return late

    def _left_open(self) -> list[str]:
        """Return the URIs of the cameras that the next start opens again, the current one first."""
        current = self.open_sources.current
        cameras = [source for source in self.open_sources.all
                   if (source.state.connected or source.state is LinkState.LOST)
                   and source.uri.scheme != sources.SourceKind.FILE.value]  # fmt: skip
        return [str(source.uri) for source in sorted(cameras, key=lambda source: source is not current)]

    def _join(self) -> None:
        window = self.window
        self._bridge = Bridge(self)
        self._bridge.bind(self.open_sources.opened, self._on_source_opened)
        self._bridge.bind(self.open_sources.closing, lambda _: self.features.set_model(None))
        self._bridge.bind(self.open_sources.ending, self._on_source_ending)
        self.display.orientationChanged.connect(self.measures.show_marks)
        self.status_bar.titleChanged.connect(self._on_title_changed)
        self.status_bar.lockChanged.connect(self.features.set_locked)
        window.messages.dismissed.connect(self.messages.dismiss)
        window.actionPause.toggled.connect(self._on_pause_toggled)
        for player in (self.settings_files, self.recording):
            player.playRequested.connect(self.sources.play)
        self.settings_files.accept_drops()
        window.actionSaveSettings.triggered.connect(self.settings_files.ask_save)
        window.actionLoadSettings.triggered.connect(self.settings_files.ask_load)
        window.actionCompareSettings.triggered.connect(self.settings_files.ask_compare)
        window.actionCompareFiles.triggered.connect(self.settings_files.ask_compare_files)
        window.mayClose = self._may_close
        window.closing.connect(self.calibrating.close)
        window.closing.connect(self._on_window_closing)
        window.themeChosen.connect(self._on_theme_chosen)
        for action in (window.actionConnect, window.actionConnectStill):
            set_available(action, window.sources.unavailable)
            window.sources.connectableChanged.connect(partial(set_available, action))
        window.actionConnect.triggered.connect(window.sources.requestConnect)
        window.actionConnectStill.triggered.connect(window.sources.requestStill)
        window.actionDisconnect.triggered.connect(self.sources.disconnect_current)
        window.actionBeside.triggered.connect(window.sources.requestBeside)
        window.actionNextSource.triggered.connect(self.tiles.take_next)
        window.panesChosen.connect(self.tiles.show_panes)
        window.actionSearch.triggered.connect(self.source_list.refresh)
        window.actionSnapshotFolder.triggered.connect(self._choose_snapshot_folder)
        window.actionOpenSnapshotFolder.triggered.connect(self._open_snapshot_folder)
        window.actionAbout.triggered.connect(self._show_about)

    def _restore(self) -> None:
        window, preferences = self.window, self.preferences
        if preferences.geometry is not None or has_screen():
            window.restorePlace(preferences.geometry)
        if preferences.layout is not None:
            window.restoreState(preferences.layout, LAYOUT_VERSION)
        window.setTheme(preferences.theme)

    def _on_source_opened(self, source: OpenSource) -> None:
        if source is self.open_sources.current and source.grabber is not None:
            self.features.set_model(source.features)
            self.favourites.restore(source.grabber.info)
            if self._settings_to_compare is not None:
                path, self._settings_to_compare = self._settings_to_compare, None
                self.settings_files.compare(path)

    def _on_source_ending(self, source: OpenSource) -> None:
        if source.features is not None:
            self.features.forget(source.features)

    def _on_title_changed(self, title: str) -> None:
        self.window.setWindowTitle(f"{title} — grabbergui" if title else "grabbergui")

    def _on_pause_toggled(self, _: bool) -> None:
        # Not the signal's value: a pause without frames was undone by a slot before this one.
        self.status.held = self.window.actionPause.isChecked()
        self.status_bar.refresh()

    def _may_close(self) -> bool:
        """Return whether the window may be closed now; ask if something is recorded or read by others."""
        recorded, readers = self.recordings.running, self.sharing.all_readers
        if not (recorded or readers or self.calibrating.unsaved):
            return True

        def ask_readers() -> None:
            self.sharer.confirm_for(readers, lambda: self.calibrating.confirm(self._close_window))

        self.recording.confirm(recorded, ask_readers)
        return False

    def _confirm_closing(self, closing: Sequence[OpenSource | None], proceed: Callable[[], None]) -> None:
        """Call `proceed`, which closes these sources; ask first if one is recorded or read by others."""
        self.recording.confirm(closing, lambda: self.sharer.confirm(closing, proceed))

    def _close_window(self) -> None:
        self.window.close()

    def _on_window_closing(self) -> None:
        self.shut_down(CLOSE_TIME)

    def _on_theme_chosen(self, chosen: Theme) -> None:
        self.preferences.theme = chosen
        app = QApplication.instance()
        if isinstance(app, QApplication):
            dress(app, chosen)

    def _choose_snapshot_folder(self) -> None:
        before = self.preferences.snapshot_folder
        if chosen := self.files.folder(self.tr("Folder for snapshots"), before):
            self.preferences.snapshot_folder = chosen

    def _open_snapshot_folder(self) -> None:
        folder = self.preferences.snapshot_folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            self.messages.error(self.tr("{0} could not be opened: {1}").format(folder, error.strerror))
            return
        if not QDesktopServices.openUrl(QUrl.fromLocalFile(str(folder))):
            self.messages.notice(
                self.tr("Snapshots are in {0}; no file manager could be started").format(folder)
            )

    def _show_about(self) -> None:
        about_box(
            self.window,
            self.tr("About grabbergui"),
            markup(
                self.tr(
                    "<h3>grabbergui {0}</h3>"
                    "<p>Tune GenICam cameras live, and share them on YARP and ROS 2 networks.</p>"
                    "<p>Free software under the GNU General Public License, version 3 or later,"
                    " with an additional permission to combine it with the GenICam runtime.</p>"
                ),
                __version__,
            ),
        )
