"""All settings of a camera at once: in files, and in the camera's own user sets."""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection, Sequence
from functools import partial
from pathlib import Path

from PyQt5.QtCore import QEvent, QObject, pyqtSignal
from PyQt5.QtGui import QDropEvent
from PyQt5.QtWidgets import QAction

from grabbergui.core.errors import GrabberError
from grabbergui.core.settings import SettingKey
from grabbergui.core.uri import SourceUri
from grabbergui.models.change_tracking import ChangeTrackingGrabber
from grabbergui.models.error_text import error_text
from grabbergui.models.language import counted
from grabbergui.models.open_source import OpenSource
from grabbergui.models.settings import files
from grabbergui.models.settings.feature_set import Difference, FeatureSet, Progress, capture, compare
from grabbergui.models.settings.loading import LoadReport, load_onto, roll_back
from grabbergui.models.settings.user_sets import (
    UserSet,
    has_user_sets,
    load_user_set,
    save_user_set,
    start_with_user_set,
    user_sets,
)
from grabbergui.models.unavailable import Unavailable
from grabbergui.recording.opening import VIDEO_SUFFIXES
from grabbergui.ui.controllers.camera_ability import CameraAbility
from grabbergui.ui.controllers.camera_work import CameraWork
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.views.settings_dialogs import SettingsDifference, SettingsReport
from grabbergui.ui.views.user_sets_dialog import UserSetsDialog


class SettingsFilesController(QObject):
    """Saves, loads and compares files of settings. Make it on the GUI thread; cameras work on theirs."""

    playRequested = pyqtSignal(str)
    """The URI of a recording to open in place of the camera."""

    def __init__(self, context: SourceContext, work: CameraWork) -> None:
        super().__init__(context.window)
        self._window = context.window
        self._files = context.files
        self._messages = context.messages
        self._open_sources = context.open_sources
        self._bridge = Bridge(self)
        self._kinds = self.tr("Settings (*.yaml *.yml *.pfs *.txt);;All files (*)")
        self._work = work
        self.report: SettingsReport | None = None
        "The dialog shown last."
        self.difference: SettingsDifference | None = None
        "The dialog that compares two files, while it is shown."

    def accept_drops(self) -> None:
        """Take settings (loaded) and recordings (played) that are dragged onto the window."""
        self._window.setAcceptDrops(True)
        self._window.installEventFilter(self)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Handle what is dragged onto the window."""
        if isinstance(event, QDropEvent) and (path := _dropped(event)) is not None:
            event.acceptProposedAction()
            if event.type() == QEvent.Type.Drop:
                self.open_file(path)
            return True
        return super().eventFilter(watched, event)

    def open_file(self, path: Path) -> None:
        """Play a recording, open a camera's report as its twin; load any other file as settings."""
        if path.is_dir() or path.suffix.lower() in (".mcap", *VIDEO_SUFFIXES):
            self.playRequested.emit(str(SourceUri("file", str(path))))
        elif path.suffix.lower() == ".zip":
            self.playRequested.emit(str(SourceUri("twin", str(path))))
        else:
            self.load(path)

    def ask_save(self) -> None:
        """Let the user choose a file and save there."""
        source = self._open_sources.current
        camera = source.grabber.info.file_name if source is not None and source.grabber is not None else ""
        name = f"{camera or 'settings'}.yaml"
        if path := self._files.to_save(self.tr("Save settings"), name, self._kinds):
            self.save(path)

    def ask_load(self) -> None:
        """Let the user choose a file and load it."""
        if path := self._asked(self.tr("Load settings")):
            self.load(path)

    def ask_compare(self) -> None:
        """Let the user choose a file and compare the camera with it."""
        if path := self._asked(self.tr("Compare the camera with settings")):
            self.compare(path)

    def ask_compare_files(self) -> None:
        """Let the user choose two files and compare them with each other."""
        if (first := self._asked(self.tr("First settings"))) and (
            second := self._asked(self.tr("Second settings"))
        ):
            self.compare_files(first, second)

    def _asked(self, title: str) -> Path | None:
        return self._files.to_open(title, self._kinds)

    def save(self, path: Path) -> None:
        """Save the camera's settings."""

        def work(grabber: ChangeTrackingGrabber, progress: Progress, cancelled: threading.Event) -> int:
            features = capture(grabber.plain, progress=progress, cancelled=cancelled)
            if cancelled.is_set():
                return 0  # a file with some of the settings looks complete
            files.save(features, path)
            return len(features)

        def saved(count: int) -> None:
            if count:
                settings = counted(count, self.tr("1 setting"), self.tr("{0} settings"))
                self._messages.notice(self.tr("Saved {0} to {1}").format(settings, path))

        self._work.run(self.tr("Saving settings"), work, saved, text=path.name)

    def load(
        self, path: Path, only: Collection[SettingKey] | None = None, source: OpenSource | None = None
    ) -> None:
        """Load settings, all or some of them, and show the outcome of each. `source`: the current one."""

        def read(grabber: ChangeTrackingGrabber) -> FeatureSet:
            return files.load(path, grabber.selectors.of)

        self._load(path.name, read, only, source, apply=path)

    def _load(
        self,
        name: str,
        read: Callable[[ChangeTrackingGrabber], FeatureSet],
        only: Collection[SettingKey] | None,
        source: OpenSource | None = None,
        apply: Path | None = None,
    ) -> None:
        def work(
            grabber: ChangeTrackingGrabber, progress: Progress, cancelled: threading.Event
        ) -> LoadReport:
            return load_onto(grabber, read(grabber).only(only), progress=progress, cancelled=cancelled)

        source = source or self._work.source
        title = self.tr("Loaded {0}").format(name)
        show = partial(self._show, title, source, apply=apply)
        self._work.run(self.tr("Loading settings"), work, show, undoable=title, text=name, source=source)

    def compare(self, path: Path) -> None:
        """Show what loading would change, and offer to load it."""

        def work(
            grabber: ChangeTrackingGrabber, progress: Progress, cancelled: threading.Event
        ) -> LoadReport:
            features = files.load(path, grabber.selectors.of)
            return load_onto(grabber.plain, features, dry_run=True, progress=progress, cancelled=cancelled)

        title = self.tr("Camera and {0}").format(path.name)
        show = partial(self._show, title, self._work.source, apply=path)
        self._work.run(self.tr("Comparing settings"), work, show, text=path.name)

    def _show(
        self, title: str, source: OpenSource | None, report: LoadReport, apply: Path | None = None
    ) -> None:
        # The user may have made another source current since; the buttons act on the source of the report.
        dialog = SettingsReport(self._window)
        if source is not None and source is not self._work.source:
            dialog.setReport(f"{title} · {source.title}", report)
        else:
            dialog.setReport(title, report)
        if apply is not None:
            dialog.applyRequested.connect(partial(self.load, apply, source=source))
        dialog.rollBackRequested.connect(lambda: self._roll_back(title, source, report))
        dialog.finished.connect(self._on_report_finished)
        self.report = dialog
        dialog.open()

    def _on_report_finished(self, _: int) -> None:
        self.report = None

    def _roll_back(self, title: str, source: OpenSource | None, report: LoadReport) -> None:
        def work(
            grabber: ChangeTrackingGrabber, progress: Progress, cancelled: threading.Event
        ) -> LoadReport:
            return roll_back(grabber, report, progress=progress, cancelled=cancelled)

        def done(after: LoadReport) -> None:
            if after.problem:
                self._messages.error(self.tr("Not rolled back: {0}").format(after.problem))
            else:
                self._messages.notice(self.tr("Rolled back: {0}").format(after.summary()))

        name = self.tr("Rolled back: {0}").format(title)
        self._work.run(self.tr("Rolling back"), work, done, undoable=name, text=title, source=source)

    def compare_files(self, first: Path, second: Path) -> None:
        """Read two files on a thread of its own, show their differences, and offer to load either."""
        source = self._open_sources.current
        selectors_of = (
            source.tracked_grabber.selectors_of
            if source is not None and source.tracked_grabber is not None
            else None
        )

        def read() -> None:
            try:
                one, other = (files.load(path, selectors_of) for path in (first, second))
                differences = compare(one, other)
            except GrabberError as error:
                self._bridge.call(partial(self._messages.error, error_text(error)))
            else:
                names = first.name, second.name
                self._bridge.call(partial(self._show_difference, names, one, other, differences))

        threading.Thread(target=read, name="compare settings", daemon=True).start()

    def _show_difference(
        self, names: tuple[str, str], one: FeatureSet, other: FeatureSet, differences: Sequence[Difference]
    ) -> None:
        dialog = SettingsDifference(self._window)
        lost_lines = (*one.lost_lines, *other.lost_lines)
        dialog.setDifferences(names, differences, self._open_sources.current is not None, lost_lines)
        dialog.firstRequested.connect(partial(self._load, names[0], lambda _: one))
        dialog.secondRequested.connect(partial(self._load, names[1], lambda _: other))
        dialog.finished.connect(self._on_difference_finished)
        self.difference = dialog
        dialog.open()

    def _on_difference_finished(self, _: int) -> None:
        self.difference = None


def _dropped(event: QDropEvent) -> Path | None:
    data = event.mimeData()
    urls = data.urls() if data is not None else []
    return Path(urls[0].toLocalFile()) if len(urls) == 1 and urls[0].isLocalFile() else None


class UserSetsController(QObject):
    """The camera's own sets; the action is enabled if the camera keeps any."""

    def __init__(self, action: QAction, context: SourceContext, work: CameraWork) -> None:
        super().__init__(context.window)
        self._window = context.window
        self._work = work
        self._messages = context.messages
        self.dialog: UserSetsDialog | None = None
        "While it is shown."
        action.triggered.connect(self.show)
        ability = CameraAbility(self, context.open_sources, has_user_sets, Unavailable.USER_SETS, action)
        ability.ended.connect(self._on_camera_ended)

    def show(self) -> None:
        """Ask the camera for its sets, and show them."""
        self._work.run(self.tr("Settings kept in the camera"), _read, self._work.if_current(self._show))

    def _show(self, sets: list[UserSet]) -> None:
        if self.dialog is None:
            self.dialog = dialog = UserSetsDialog(self._window)
            dialog.loadRequested.connect(self._load)
            dialog.saveRequested.connect(self._save)
            dialog.startRequested.connect(self._start_with)
            dialog.finished.connect(self._on_dialog_finished)
            dialog.open()
        self.dialog.setSets(sets)

    def _on_dialog_finished(self, _: int) -> None:
        self.dialog = None

    def _on_camera_ended(self) -> None:
        if self.dialog is not None:
            self.dialog.reject()

    def _load(self, name: str) -> None:
        def work(grabber: ChangeTrackingGrabber, progress: Progress, cancelled: threading.Event) -> int:
            return load_user_set(grabber, name, progress=progress, cancelled=cancelled)

        def done(changed: int) -> None:
            settings = counted(changed, self.tr("1 setting"), self.tr("{0} settings"))
            self._messages.notice(self.tr("Loaded {0}: changed {1}").format(name, settings))

        if self.dialog is not None:
            self.dialog.accept()
        title = self.tr("Loading a set of the camera")
        self._work.run(title, work, self._work.if_current(done), text=name)

    def _save(self, name: str) -> None:
        text = self.tr("Saved the current settings in the camera as {0}").format(name)
        self._change(self.tr("Saving in the camera"), partial(save_user_set, name=name), text)

    def _start_with(self, name: str) -> None:
        text = self.tr("The camera starts with {0} from its next power-on").format(name)
        self._change(self.tr("Writing to the camera"), partial(start_with_user_set, name=name), text)

    def _change(self, title: str, change: Callable[[ChangeTrackingGrabber], None], text: str) -> None:
        """Do something with a set, and show the sets afterwards."""

        def work(
            grabber: ChangeTrackingGrabber, progress: Progress, cancelled: threading.Event
        ) -> list[UserSet]:
            change(grabber)
            return user_sets(grabber.plain)

        def done(sets: list[UserSet]) -> None:
            self._messages.notice(text)
            if self.dialog is not None:
                self.dialog.setSets(sets)

        self._work.run(title, work, self._work.if_current(done))


def _read(grabber: ChangeTrackingGrabber, _: Progress, __: threading.Event) -> list[UserSet]:
    return user_sets(grabber.plain)
