"""*Camera → Files…*: the files in the camera, downloaded, uploaded and deleted."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path

from PyQt5.QtCore import QObject
from PyQt5.QtWidgets import QAction

from grabbergui.core import file_access
from grabbergui.core.environment import write_whole
from grabbergui.core.errors import GrabberError
from grabbergui.core.file_access import CameraFile
from grabbergui.core.grabber import FrameGrabber
from grabbergui.models.change_tracking import ChangeTrackingGrabber
from grabbergui.models.error_text import error_text
from grabbergui.models.settings.feature_set import Progress
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.controllers.camera_ability import CameraAbility
from grabbergui.ui.controllers.camera_work import CameraWork
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.views.camera_files_dialog import CameraFilesDialog

Listing = tuple[list[CameraFile], bool]
"The files, and whether they can be transferred."
Transfer = Callable[[FrameGrabber, Progress, threading.Event], str]
"Works on a file, and returns what came of it as display text."


class CameraFilesController(QObject):
    """Lists the files of the current camera, and moves one at a time on the camera's thread."""

    def __init__(self, action: QAction, context: SourceContext, work: CameraWork) -> None:
        super().__init__(context.window)
        self._window, self._files, self._work = context.window, context.files, work
        self._bridge = Bridge(self)
        self._cancelled: threading.Event | None = None
        "Set to end the transfer in progress."
        self.dialog: CameraFilesDialog | None = None
        "While it is shown."
        action.triggered.connect(self.show)
        ability = CameraAbility(
            self, context.open_sources, file_access.has_files, Unavailable.CAMERA_FILES, action
        )
        ability.ended.connect(self._on_camera_ended)

    def show(self) -> None:
        """List the files and open the window; raise the window if it is open already."""
        if self.dialog is not None:
            self.dialog.raise_()
            return
        self.dialog = dialog = CameraFilesDialog(self._window)
        dialog.downloadRequested.connect(self._on_download_requested)
        dialog.uploadRequested.connect(self._on_upload_requested)
        dialog.deleteRequested.connect(self._on_delete_requested)
        dialog.cancelRequested.connect(self._on_cancel_requested)
        dialog.finished.connect(self._on_dialog_finished)
        dialog.show()
        self._list()

    def _list(self) -> None:
        def work(grabber: ChangeTrackingGrabber, _: Progress, __: threading.Event) -> Listing:
            return file_access.list_files(grabber.plain), file_access.transfers_files(grabber.plain)

        def done(listing: Listing) -> None:
            if self.dialog is not None:
                self.dialog.setFiles(listing[0], reachable=listing[1])

        self._work.run(self.tr("Listing the camera's files"), work, self._work.if_current(done))

    def _on_download_requested(self, name: str) -> None:
        path = self._files.to_save(self.tr("Save {0}").format(name), name, self.tr("All files (*)"))
        if path is None:
            return
        text = self.tr("{0} ({1} B) saved as {2}")

        def transfer(grabber: FrameGrabber, progress: Progress, cancelled: threading.Event) -> str:
            content = file_access.read_file(grabber, name, progress=progress, cancelled=cancelled)
            write_whole(path, content)
            return text.format(name, len(content), path)

        self._run(self.tr("Downloading {0}").format(name), transfer)

    def _on_upload_requested(self, name: str) -> None:
        path = self._files.to_open(self.tr("File for {0}").format(name), self.tr("All files (*)"))
        if path is not None and self.dialog is not None:
            self.dialog.confirmUpload(name, str(path), partial(self._upload, name, path))

    def _upload(self, name: str, path: Path) -> None:
        checked = self.tr("{0} ({1} B) written and read back")
        unchecked = self.tr("{0} ({1} B) written; the camera does not let it be read back")

        def transfer(grabber: FrameGrabber, progress: Progress, cancelled: threading.Event) -> str:
            content = file_access.content_of(path)
            written = file_access.write_file(
                grabber, name, content, replace_firmware=True, progress=progress, cancelled=cancelled
            )
            return (checked if written.verified else unchecked).format(name, written.size)

        self._run(self.tr("Uploading {0}").format(name), transfer)

    def _on_delete_requested(self, name: str) -> None:
        text = self.tr("{0} is deleted")

        def transfer(grabber: FrameGrabber, _: Progress, __: threading.Event) -> str:
            file_access.delete_file(grabber, name)
            return text.format(name)

        self._run(self.tr("Deleting {0}").format(name), transfer)

    def _run(self, title: str, transfer: Transfer) -> None:
        def work(grabber: ChangeTrackingGrabber, progress: Progress, cancelled: threading.Event) -> str:
            self._cancelled = cancelled

            def both(done: int, of: int) -> None:
                progress(done, of)
                self._bridge.call(partial(self._show_share, done / max(of, done, 1)))

            try:
                return transfer(grabber.plain, both, cancelled)
            except GrabberError as error:
                self._fail(error_text(error))
                raise
            except OSError as error:
                self._fail(f"{error.filename}: {error.strerror}")
                raise

        if self.dialog is not None:
            self.dialog.setOutcome("")
            self.dialog.setBusy(True)
        self._work.run(title, work, self._end, failed=self._list)

    def _show_share(self, share: float) -> None:
        if self.dialog is not None:
            self.dialog.setShare(share)

    def _fail(self, text: str) -> None:
        """End the transfer with an error. Any thread."""
        self._bridge.call(partial(self._end, text, good=False))

    def _end(self, text: str, *, good: bool = True) -> None:
        self._cancelled = None
        if self.dialog is not None:
            self.dialog.setBusy(False)
            self.dialog.setOutcome(text, good=good)
            if good:
                self._list()

    def _on_cancel_requested(self) -> None:
        if self._cancelled is not None:
            self._cancelled.set()

    def _on_dialog_finished(self, _: int) -> None:
        dialog, self.dialog = self.dialog, None
        if dialog is not None:
            dialog.deleteLater()

    def _on_camera_ended(self) -> None:
        if self.dialog is not None:
            self.dialog.done(0)
