"""Joins the dialog of the camera's own sets to the camera."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial

from PyQt5.QtCore import QObject, pyqtSignal

from grabbergui.models.changes.tracking import ChangeTrackingGrabber
from grabbergui.models.connection import Connection
from grabbergui.models.settings import user_sets
from grabbergui.models.settings.feature_set import Progress
from grabbergui.models.settings.user_sets import UserSet
from grabbergui.ui.controllers.camera_ability import CameraAbility
from grabbergui.ui.controllers.camera_work import CameraWork
from grabbergui.ui.views.main_window import MainWindow
from grabbergui.ui.views.user_sets_dialog import UserSetsDialog


class UserSetsController(QObject):
    """Its action can be used where the camera keeps sets."""

    noticed = pyqtSignal(str)

    def __init__(self, window: MainWindow, connection: Connection, work: CameraWork) -> None:
        super().__init__(window)
        self._window = window
        self._work = work
        self.dialog: UserSetsDialog | None = None
        "While it is shown."
        window.actionUserSets.triggered.connect(self.show)
        ability = CameraAbility(self, connection, user_sets.has_user_sets, window.actionUserSets)
        ability.ended.connect(self._on_camera_ended)

    def show(self) -> None:
        """Ask the camera for its sets, and show them."""
        self._work.run(self.tr("Settings kept in the camera"), _read, self._show)

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
            return user_sets.load(grabber, name, progress=progress, cancelled=cancelled)

        def done(changed: int) -> None:
            self.noticed.emit(self.tr("Loaded {0}: {1} settings are other than before").format(name, changed))

        if self.dialog is not None:
            self.dialog.accept()
        self._work.run(self.tr("Loading a set of the camera"), work, done, text=name)

    def _save(self, name: str) -> None:
        text = self.tr("Saved the present settings in the camera as {0}").format(name)
        self._change(self.tr("Saving in the camera"), partial(user_sets.save, name=name), text)

    def _start_with(self, name: str) -> None:
        text = self.tr("The camera starts with {0} from its next power-on").format(name)
        self._change(self.tr("Telling the camera"), partial(user_sets.start_with, name=name), text)

    def _change(self, title: str, change: Callable[[ChangeTrackingGrabber], None], text: str) -> None:
        """Do something with a set, and show the sets as they are then."""

        def work(
            grabber: ChangeTrackingGrabber, progress: Progress, cancelled: threading.Event
        ) -> list[UserSet]:
            change(grabber)
            return user_sets.user_sets(grabber.plain)

        def done(sets: list[UserSet]) -> None:
            self.noticed.emit(text)
            if self.dialog is not None:
                self.dialog.setSets(sets)

        self._work.run(title, work, done)


def _read(grabber: ChangeTrackingGrabber, _: Progress, __: threading.Event) -> list[UserSet]:
    return user_sets.user_sets(grabber.plain)
