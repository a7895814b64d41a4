"""What only some cameras can do: each is asked when it is opened, and the actions for it follow."""

from __future__ import annotations

from collections.abc import Callable

from PyQt5.QtCore import QObject, pyqtSignal
from PyQt5.QtWidgets import QAction

from grabbergui.core.grabber import FrameGrabber
from grabbergui.models.connection import Connection
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.ui.bridge import Bridge


class CameraAbility(QObject):
    """Enables actions while a camera is connected that can do it and may be changed."""

    ended = pyqtSignal()
    """The camera that was asked is gone, or another is being opened."""

    def __init__(
        self, owner: QObject, connection: Connection, ask: Callable[[FrameGrabber], bool], *actions: QAction
    ) -> None:
        """`ask` is called on the thread of the camera."""
        super().__init__(owner)
        self._connection = connection
        self._ask = ask
        self._actions = actions
        self._present = False
        self._bridge = bridge = Bridge(self)
        bridge.bind(connection.opened, self._on_connection_opened)
        bridge.bind(connection.state_changed, self._on_connection_state_changed)
        self._enable()

    def _on_connection_opened(self, source: OpenSource) -> None:
        grabber = source.grabber
        if grabber is None or source.read_only:
            return

        def told(present: bool) -> None:
            self._bridge.call(lambda: self._allow(source, present))

        source.worker.submit(lambda: self._ask(grabber), done=told)

    def _allow(self, source: OpenSource, present: bool) -> None:
        self._present = present and source is self._connection.source
        self._enable()

    def _on_connection_state_changed(self, state: LinkState, _: str) -> None:
        if state in (LinkState.CLOSED, LinkState.OPENING):
            self._present = False
            self.ended.emit()
        self._enable()

    def _enable(self) -> None:
        for action in self._actions:
            action.setEnabled(self._present and self._connection.state.connected)
