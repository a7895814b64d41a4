"""The program behind the window: what all of it shares, and the groups of controls that each have a file.

`ui/run/window.py` makes the window and this; the groups make the models and controllers of their subject.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from PyQt5.QtCore import QObject, QTimer, QUrl
from PyQt5.QtGui import QDesktopServices
from PyQt5.QtWidgets import QApplication

from grabbergui import __version__, sources
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.uri import SourceUri
from grabbergui.models.image.live_image import ImageModel
from grabbergui.models.markup import markup
from grabbergui.models.messages import MessageModel, Severity, UserMessage
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.source_messages import CurrentMessages
from grabbergui.models.source_opener import SourceOpener
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.file_dialogs import FileDialogs
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.preferences import LAYOUT_VERSION, Preferences
from grabbergui.ui.run.feature_controls import FeatureControls
from grabbergui.ui.run.help_controls import HelpControls
from grabbergui.ui.run.image_controls import ImageControls
from grabbergui.ui.run.shut_down import wait_for_all
from grabbergui.ui.run.source_controls import SourceControls
from grabbergui.ui.screen import has_screen
from grabbergui.ui.shown_text import about_box
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.views.main_window import MainWindow

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
        self.messages = MessageModel()
        self.opener = SourceOpener(create, self.messages)
        self.open_sources = self.opener.open_sources
        self.image = ImageModel()
        self.files = FileDialogs(window)
        current = CurrentMessages(self.messages, lambda: self.open_sources.current)
        context = SourceContext(self.open_sources, self.image, current, preferences, self.files, window)
        self.source_controls = SourceControls(window, context, self.opener, self.messages)
        self.image_controls = ImageControls(window, context, self.opener.stream, self.source_controls.gallery)
        self.feature_controls = FeatureControls(window, context)
        self.help_controls = HelpControls(window, context)
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
            self.source_controls.source_list.start()
            return
        self.window.image.painted.connect(self._search)
        QTimer.singleShot(SEARCH_AFTER_MS, self._search)
        self.source_controls.sources.connect_to(uri)
        for other in others:
            self.source_controls.sources.open_additional(other)

    def compare_once_open(self, settings: Path) -> None:
        """Compare the first camera that opens with a settings file, and offer to load it."""
        self._settings_to_compare = settings

    def _search(self) -> None:
        if not self._down:
            self.source_controls.source_list.start()
            with suppress(TypeError):  # by the clock, after the image
                self.window.image.painted.disconnect(self._search)

    def shut_down(self, timeout: float) -> list[str]:
        """Release everything; return the names of what did not end in `timeout` seconds. Can be repeated."""
        if not self._down:
            self._down = True
            self.preferences.keep_window(self.window.saveGeometry(), self.window.saveState(LAYOUT_VERSION))
            self.feature_controls.favourites.keep_layout()
            self.preferences.left_open = self._left_open()
            self.window.hide()  # at once: what follows may take CLOSE_TIME
            self.feature_controls.show(None)
            self.source_controls.source_list.stop(0)  # a search in progress ends while the rest is closed
            self.open_sources.close_all()
        late = wait_for_all(
            (
                *self.image_controls.waits(),
                *self.source_controls.waits(),
                ("a camera", self.open_sources.wait_closed),
            ),
            timeout,
        )
        self.source_controls.status.close()
        self.help_controls.log_book.close()
        return late

    def _left_open(self) -> list[str]:
        """Return the URIs of the cameras that the next start opens again, the current one first."""
        current = self.open_sources.current
        cameras = [source for source in self.open_sources.all
                   if (source.state.connected or source.state is LinkState.LOST)
                   and source.uri.scheme != sources.SourceKind.FILE.value]  # fmt: skip
        return [str(source.uri) for source in sorted(cameras, key=lambda source: source is not current)]

    def _join(self) -> None:
        """Connect what concerns several groups of controls, or the window as a whole."""
        window, features, status_bar = self.window, self.feature_controls, self.source_controls.status_bar
        self._bridge = Bridge(self)
        self._bridge.bind(self.open_sources.opened, self._on_source_opened)
        self._bridge.bind(self.open_sources.closing, lambda _: features.show(None))
        self._bridge.bind(self.open_sources.ending, features.forget)
        features.settings_files.playRequested.connect(self.source_controls.sources.play)
        status_bar.titleChanged.connect(self._on_title_changed)
        status_bar.lockChanged.connect(features.features.set_locked)
        window.messages.dismissed.connect(self.messages.dismiss)
        window.actionPause.toggled.connect(self._on_pause_toggled)
        window.mayClose = self._may_close
        window.closing.connect(self._on_window_closing)
        window.themeChosen.connect(self._on_theme_chosen)
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
            self.feature_controls.show(source)
            if self._settings_to_compare is not None:
                path, self._settings_to_compare = self._settings_to_compare, None
                self.feature_controls.settings_files.compare(path)

    def _on_title_changed(self, title: str) -> None:
        self.window.setWindowTitle(f"{title} — grabbergui" if title else "grabbergui")

    def _on_pause_toggled(self, _: bool) -> None:
        # Not the signal's value: a pause without frames was undone by a slot before this one.
        self.source_controls.status.held = self.window.actionPause.isChecked()
        self.source_controls.status_bar.refresh()

    def _may_close(self) -> bool:
        """Return whether the window may be closed now; ask if something is recorded or read by others."""
        controls, calibrating = self.source_controls, self.image_controls.calibrating
        recorded, readers = controls.recordings.running, controls.sharing.all_readers
        if not (recorded or readers or calibrating.unsaved):
            return True

        def ask_readers() -> None:
            controls.sharer.confirm_for(readers, lambda: calibrating.confirm(self._close_window))

        controls.recording.confirm(recorded, ask_readers)
        return False

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
