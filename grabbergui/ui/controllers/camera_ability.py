"""Actions that only some cameras support."""

from __future__ import annotations

from collections.abc import Callable

from PyQt5.QtCore import QObject, pyqtSignal
from PyQt5.QtWidgets import QAction

from grabbergui.core.grabber import FrameGrabber
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.open_sources import OpenSources
from grabbergui.models.unavailable import Unavailable, why_unavailable
from grabbergui.ui.actions import set_available
from grabbergui.ui.gui_thread import Bridge


class CameraAbility(QObject):
    """Enables actions while the current camera supports them and may be changed."""

    changed = pyqtSignal()
    """`unavailable` may have changed."""
    ended = pyqtSignal()
    """The camera is gone, or another is being opened."""

    def __init__(
        self,
        owner: QObject,
        open_sources: OpenSources,
        ask: Callable[[FrameGrabber], bool],
        reason: Unavailable,
        *actions: QAction,
    ) -> None:
        """`ask` is called on the thread of the camera; `reason` is given if it returns False."""
        super().__init__(owner)
        self._open_sources = open_sources
        self._ask = ask
        self._reason = reason
        self._actions = actions
        self._present = False
        self._bridge = bridge = Bridge(self)
        bridge.bind(open_sources.opened, self._on_source_opened)
        bridge.bind(open_sources.state_changed, self._on_source_state_changed)
        self._enable()

    def unavailable(self, *, stream: bool = False) -> Unavailable | None:
        """Return why the actions are not available: the source, control of it, its stream, or the ability."""
        missing = why_unavailable(self._open_sources.current, stream=stream, control=True)
        return missing if missing is not None or self._present else self._reason

    def _on_source_opened(self, source: OpenSource) -> None:
        grabber = source.grabber
        if grabber is None or source.read_only:
            return

        def on_answer(present: bool) -> None:
            self._bridge.call(lambda: self._allow(source, present))

        source.worker.submit(lambda: self._ask(grabber), done=on_answer)

    def _allow(self, source: OpenSource, present: bool) -> None:
        self._present = present and source is self._open_sources.current
        self._enable()

    def _on_source_state_changed(self, state: LinkState, _: str) -> None:
        if state in (LinkState.CLOSED, LinkState.OPENING):
            self._present = False
            self.ended.emit()
        self._enable()

    def _enable(self) -> None:
        for action in self._actions:
            set_available(action, self.unavailable())
        self.changed.emit()
