"""*Camera → Events…*."""

from __future__ import annotations

from PyQt5.QtCore import QObject, QTimer
from PyQt5.QtGui import QGuiApplication
from PyQt5.QtWidgets import QAction

from grabbergui.core.errors import GrabberError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.models.camera_events import CameraEvents
from grabbergui.models.error_text import error_text
from grabbergui.models.open_source import OpenSource
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.controllers.camera_ability import CameraAbility
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.views.camera_events_dialog import CameraEventsDialog

PERIOD_MS = 200
"Milliseconds between two looks at the events."
MOST_ROWS = 200
"Newest events in the list."


class CameraEventsController(QObject):
    """Lets the events follow the current source, and shows them in a dialog."""

    def __init__(self, action: QAction, context: SourceContext, events: CameraEvents) -> None:
        super().__init__(context.window)
        self._window, self._open_sources, self._events = context.window, context.open_sources, events
        self._messages = context.messages
        self._shown = -1
        "`count` when the list was filled."
        self.dialog: CameraEventsDialog | None = None
        "While it is shown."
        bridge = Bridge(self)
        bridge.bind(context.open_sources.opened, self._on_source_opened)
        bridge.bind(events.switches_changed, self._on_switches_changed)
        bridge.bind(events.failed, self._on_events_failed)
        # Not over the bridge: the grabber is about to be closed.
        context.open_sources.closing.connect(self._on_source_closing, check_nargs=False)
        CameraAbility(self, context.open_sources, _has_events, Unavailable.EVENTS, action)
        self._timer = QTimer(self)
        self._timer.setInterval(PERIOD_MS)
        self._timer.timeout.connect(self._show_events)
        action.triggered.connect(self.show)

    def show(self) -> None:
        """Show the dialog."""
        if self.dialog is not None:
            self.dialog.raise_()
            return
        self.dialog = dialog = CameraEventsDialog(self._window)
        dialog.switched.connect(self._on_dialog_switched)
        dialog.clearRequested.connect(self._events.clear)
        dialog.copyRequested.connect(self._on_dialog_copy_requested)
        dialog.finished.connect(self._on_dialog_finished)
        self._shown = -1
        self._events.request_switches()
        self._show_events()
        self._timer.start()
        dialog.show()

    def _show_events(self) -> None:
        if self.dialog is not None and self._events.count != self._shown:
            self._shown = self._events.count
            self.dialog.setRows([event.row for event in self._events.events[: -MOST_ROWS - 1 : -1]])

    def _on_source_opened(self, source: OpenSource) -> None:
        if source is self._open_sources.current:
            self._events.attach(source)
            self._events.request_switches()

    def _on_source_closing(self, _: OpenSource) -> None:
        self._events.detach()

    def _on_switches_changed(self, switches: dict[str, bool]) -> None:
        if self.dialog is not None:
            self.dialog.setSwitches(switches)

    def _on_events_failed(self, error: GrabberError) -> None:
        self._messages.error(error_text(error))

    def _on_dialog_switched(self, name: str, on: bool) -> None:
        self._events.switch(name, on=on)

    def _on_dialog_copy_requested(self) -> None:
        if (clipboard := QGuiApplication.clipboard()) is not None:
            clipboard.setText("\n".join("\t".join(event.row) for event in self._events.events))

    def _on_dialog_finished(self, _: int) -> None:
        self._timer.stop()
        dialog, self.dialog = self.dialog, None
        if dialog is not None:
            dialog.deleteLater()


def _has_events(grabber: FeatureSource) -> bool:
    return grabber.has_feature("EventSelector") and grabber.has_feature("EventNotification")
