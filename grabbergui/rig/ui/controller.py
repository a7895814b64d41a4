"""Rigs in the window: makes their files, and shows how an open one is doing."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from PyQt5.QtCore import QObject, QTimer
from PyQt5.QtWidgets import QAction

from grabbergui.core.errors import GrabberError, UsageError
from grabbergui.core.uri import SourceUri
from grabbergui.models.camera_events import CameraEvents
from grabbergui.models.error_text import error_text
from grabbergui.models.open_source import OpenSource
from grabbergui.models.sources import SourceListModel
from grabbergui.models.unavailable import Unavailable
from grabbergui.rig import rig_file
from grabbergui.rig.grabber import RigGrabber
from grabbergui.rig.overview import BudgetOverview, RigOverview, budget, overview, remove_budget, write_budget
from grabbergui.rig.rig_file import RigEntry
from grabbergui.rig.ui.new_rig_dialog import NewRigDialog
from grabbergui.rig.ui.rig_dialog import RigDialog
from grabbergui.ui.controllers.camera_ability import CameraAbility
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.gui_thread import Bridge

PERIOD_MS = 300
"Milliseconds between two looks at the rig."
MOST_EVENTS = 50
"Newest events of the cameras in the list."
CAMERAS = ("gige:", "u3v:", "sim:", "v4l2:", "gentl:", "aravis:")
"Sources that a rig may have."


class NewRigController(QObject):
    """*Camera → New rig…*."""

    def __init__(
        self,
        action: QAction,
        context: SourceContext,
        sources: SourceListModel,
        connect_to: Callable[[str], object],
    ) -> None:
        """`connect_to` opens the new rig."""
        super().__init__(context.window)
        self._window, self._files, self._sources = context.window, context.files, sources
        self._open_sources, self._connect_to = context.open_sources, connect_to
        self.dialog: NewRigDialog | None = None
        "While it is shown."
        action.triggered.connect(self.show)

    def show(self) -> None:
        """Show the dialog, with the open cameras ticked."""
        if self.dialog is not None:
            self.dialog.raise_()
            return
        self.dialog = dialog = NewRigDialog(self._window)
        dialog.setSources(self._cameras())
        dialog.saveRequested.connect(self._on_dialog_save_requested)
        dialog.finished.connect(self._on_dialog_finished)
        dialog.show()

    def _cameras(self) -> list[tuple[str, str, bool]]:
        found = {
            str(source.exact_uri): (source.title, True)
            for source in self._open_sources.all
            if source.state.connected
        }
        for line in self._sources.sources:
            if not line.connected:
                found.setdefault(line.info.uri, (line.info.title, False))
        return [(uri, *rest) for uri, rest in found.items() if uri.startswith(CAMERAS)]

    def _on_dialog_save_requested(self, entry: RigEntry) -> None:
        dialog = self.dialog
        path = self._files.to_save(self.tr("File of the rig"), "rig.yaml", self.tr("Rigs (*.yaml)"))
        if path is None or dialog is None:
            return
        path = path if path.suffix else path.with_suffix(".yaml")
        try:
            rig_file.write(path, entry)
        except UsageError as error:
            dialog.setProblem(error_text(error))
            return
        dialog.accept()
        self._release({camera.source for camera in entry.cameras.values()})
        self._connect_to(str(SourceUri("rig", str(path))))

    def _release(self, uris: set[str]) -> None:
        """Close those of the rig's cameras that this window has open, as the rig opens them itself."""
        for source in self._open_sources.all:
            if str(source.exact_uri) in uris:
                self._open_sources.close(source)

    def _on_dialog_finished(self, _: int) -> None:
        dialog, self.dialog = self.dialog, None
        if dialog is not None:
            dialog.deleteLater()


class RigController(QObject):
    """*Camera → Rig…*, while the current source is one."""

    def __init__(self, action: QAction, context: SourceContext) -> None:
        super().__init__(context.window)
        self._window, self._open_sources = context.window, context.open_sources
        self._source: OpenSource | None = None
        self._planned: BudgetOverview | None = None
        self._bridge = Bridge(self)
        self.dialog: RigDialog | None = None
        "While it is shown."
        ability = CameraAbility(
            self,
            context.open_sources,
            lambda grabber: isinstance(grabber, RigGrabber),
            Unavailable.RIG,
            action,
        )
        ability.ended.connect(self._close)
        self._events = CameraEvents()
        self._bridge.bind(context.open_sources.opened, self._on_source_opened)
        # Not over the bridge: the grabber is about to be closed.
        context.open_sources.closing.connect(self._on_source_closing, check_nargs=False)
        self._timer = QTimer(self)
        self._timer.setInterval(PERIOD_MS)
        self._timer.timeout.connect(self._look)
        action.triggered.connect(self.show)

    def show(self) -> None:
        """Show the current rig."""
        source = self._open_sources.current
        if self.dialog is not None:
            self.dialog.raise_()
            return
        if source is None or not isinstance(source.grabber, RigGrabber):
            return
        self._source = source
        self.dialog = dialog = RigDialog(self._window)
        dialog.setTitle(source.title)
        dialog.leaderChosen.connect(self._lead)
        dialog.planRequested.connect(self._plan)
        dialog.applyRequested.connect(self._apply)
        dialog.removeRequested.connect(self._remove)
        dialog.finished.connect(self._on_dialog_finished)
        self._look()
        self._plan()
        self._timer.start()
        dialog.show()

    def _look(self) -> None:
        if (source := self._source) is not None and isinstance(rig := source.grabber, RigGrabber):
            source.worker.submit(lambda: overview(rig), key="rig", done=partial(self._answer, self._on_seen))

        if self.dialog is not None:
            self.dialog.setEvents([event.row for event in self._events.events[: -MOST_EVENTS - 1 : -1]])

    def _lead(self, camera: str) -> None:
        if (source := self._source) is not None and isinstance(rig := source.grabber, RigGrabber):
            source.worker.submit(
                lambda: rig.lead(camera),
                done=lambda _: self._bridge.call(self._look),
                failed=partial(self._answer, self._on_failed),
            )

    def _plan(self) -> None:
        if (source := self._source) is not None and isinstance(rig := source.grabber, RigGrabber):
            source.worker.submit(
                lambda: budget(rig),
                key="budget",
                done=partial(self._answer, self._on_planned),
                failed=partial(self._answer, self._on_failed),
            )

    def _apply(self) -> None:
        source, planned = self._source, self._planned
        if source is None or planned is None or source.features is None or source.tracked_grabber is None:
            return
        grabber, features = source.tracked_grabber, source.features
        path = Path(grabber.info.address)
        done = self.tr("Written to the cameras and into {0}.").format(path)

        def write() -> None:
            for key, value in planned.keys().items():
                grabber.write_setting(key, value)
            write_budget(path, planned)

        features.run(
            write,
            done=lambda _: self._answer(self._on_done, done),
            failed=partial(self._answer, self._on_failed),
        )

    def _remove(self) -> None:
        if (source := self._source) is not None and source.grabber is not None:
            path = Path(source.grabber.info.address)
            text = self.tr("{0} has no such values any more; the cameras keep theirs.").format(path)
            source.worker.submit(
                lambda: remove_budget(path),
                done=lambda _: self._answer(self._on_done, text),
                failed=partial(self._answer, self._on_failed),
            )

    def _on_source_opened(self, source: OpenSource) -> None:
        if source is self._open_sources.current and isinstance(source.grabber, RigGrabber):
            self._events.attach(source)

    def _on_source_closing(self, _: OpenSource) -> None:
        self._events.detach()

    def _answer(self, show: Callable[..., None], result: object) -> None:
        """Pass a result on to the GUI thread."""
        self._bridge.call(lambda: show(result) if self.dialog is not None else None)

    def _on_seen(self, seen: RigOverview) -> None:
        if self.dialog is not None:
            self.dialog.setOverview(seen)

    def _on_planned(self, planned: BudgetOverview) -> None:
        self._planned = planned
        if self.dialog is not None:
            self.dialog.setBudget(planned)

    def _on_done(self, text: str) -> None:
        if self.dialog is not None:
            self.dialog.setOutcome(text)

    def _on_failed(self, error: GrabberError) -> None:
        if self.dialog is not None:
            self.dialog.setOutcome(error_text(error), good=False)

    def _close(self) -> None:
        if self.dialog is not None:
            self.dialog.reject()

    def _on_dialog_finished(self, _: int) -> None:
        self._timer.stop()
        self._source = self._planned = None
        dialog, self.dialog = self.dialog, None
        if dialog is not None:
            dialog.deleteLater()
